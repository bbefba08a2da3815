use heapless::Vec;
use object_dictionary::Values;
use units::Instant;

use super::rpdo::{Outcome, Rpdo};
use super::target::Target;
use crate::application::Application;
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};

/// Receive PDOs of a device.
pub(crate) const RPDO_MAX: usize = 4;

/// The receive PDOs of a device.
#[derive(Debug)]
pub(crate) struct Rpdos {
    rpdos: Vec<Rpdo, RPDO_MAX, u8>,
    /// Whether any received bytes wait for a SYNC.
    wait: bool,
    expires_at: Deadline,
}

impl Rpdos {
    /// Those that the dictionary describes.
    pub(crate) fn new<const LEN: usize>(values: &Values<LEN>) -> Self {
        let mut rpdos = Vec::new();
        for rpdo in (0..).take(RPDO_MAX).filter_map(|number| Rpdo::new(number, values)) {
            let _ = rpdos.push(rpdo);
        }
        Self { rpdos, wait: false, expires_at: Deadline::NEVER }
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.rpdos.iter_mut().for_each(Rpdo::stop);
        self.wait = false;
        self.expires_at = Deadline::NEVER;
    }

    /// Takes the PDO over again that the object with `index` describes. Whether it then listens to
    /// another identifier.
    pub(crate) fn reread<const LEN: usize>(&mut self, index: u16, values: &Values<LEN>) -> bool {
        let mut moved = false;
        for rpdo in self.rpdos.iter_mut().filter(|rpdo| rpdo.is_described_by(index)) {
            let before = rpdo.id();
            rpdo.reread(values);
            moved |= before != rpdo.id();
        }
        self.survey();
        moved
    }

    /// The identifiers they listen to.
    pub(crate) fn ids(&self) -> impl Iterator<Item = CanId> {
        self.rpdos.iter().filter_map(Rpdo::id)
    }

    /// The place of the first one that listens to this identifier.
    pub(crate) fn position(&self, id: CanId) -> Option<usize> {
        self.rpdos.iter().position(|rpdo| rpdo.listens_to(id))
    }

    /// Whether data frames for the one at `position` wait for a SYNC.
    pub(crate) fn waits_for_sync(&self, position: usize) -> bool {
        self.rpdos.get(position).is_some_and(Rpdo::waits_for_sync)
    }

    /// Takes a data frame for the one at `position`.
    pub(crate) fn handle_frame<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        position: usize,
        frame: &Frame,
        target: &mut Target<'_, A, LEN>,
    ) -> Outcome {
        let Some(rpdo) = self.rpdos.get_mut(position) else { return Outcome::default() };
        let outcome = rpdo.handle(now, frame, target);
        if outcome.goes_on {
            self.survey();
        }
        outcome
    }

    /// Whether one waits for a SYNC.
    #[inline]
    pub(crate) const fn wait(&self) -> bool {
        self.wait
    }

    /// Takes a SYNC: what waited for it is taken over.
    pub(crate) fn handle_sync<A: Application, const LEN: usize>(
        &mut self,
        target: &mut Target<'_, A, LEN>,
    ) {
        self.wait = false;
        self.rpdos.iter_mut().for_each(|rpdo| rpdo.handle_sync(target));
    }

    /// When the next one is overdue.
    pub(crate) const fn due_at(&self) -> Deadline {
        self.expires_at
    }

    /// The number of one that is overdue; it then is no more.
    pub(crate) fn take_due(&mut self, now: Instant) -> Option<u16> {
        if !self.expires_at.is_due(now) {
            return None;
        }
        let overdue = self.rpdos.iter_mut().find_map(|rpdo| rpdo.take_expired(now));
        self.survey();
        overdue
    }

    fn survey(&mut self) {
        self.wait = self.rpdos.iter().any(Rpdo::waits);
        let due = self.rpdos.iter().map(Rpdo::expires_at).min();
        self.expires_at = due.unwrap_or(Deadline::NEVER);
    }
}
