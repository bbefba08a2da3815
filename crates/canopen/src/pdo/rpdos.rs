use heapless::Vec;
use object_dictionary::Values;
use units::Instant;

use super::rpdo::{Outcome, Rpdo};
use super::target::Target;
use super::{MAPPING, PDO_MAX, RECEIVE};
use crate::application::Application;
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};
use crate::parameter::parameter;

/// The receive PDOs of a device, each at the place that its number says.
#[derive(Debug, Default)]
pub(crate) struct Rpdos {
    rpdos: Vec<Rpdo, PDO_MAX, u8>,
    /// Whether any received bytes wait for a SYNC.
    wait: bool,
}

impl Rpdos {
    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.rpdos.iter_mut().for_each(Rpdo::stop);
        self.wait = false;
    }

    /// Takes the PDO over that the object with `index` describes, if the product has it. Whether it
    /// then listens to another identifier.
    pub(crate) fn reread<const LEN: usize>(&mut self, index: u16, values: &Values<LEN>) -> bool {
        let number = index % MAPPING;
        let index = RECEIVE + number;
        if parameter(values, index, 1).is_none() {
            return false;
        }
        while self.rpdos.len() <= number.into() && self.rpdos.push(Rpdo::off()).is_ok() {}
        let Some(rpdo) = self.rpdos.get_mut(usize::from(number)) else { return false };
        let before = rpdo.id();
        rpdo.reread(values, index);
        before != rpdo.id()
    }

    /// The identifiers they listen to.
    pub(crate) fn ids(&self) -> impl Iterator<Item = CanId> {
        self.rpdos.iter().map(Rpdo::id).filter(|&id| id != CanId::NONE)
    }

    /// The place of the first one that listens to this identifier.
    pub(crate) fn position(&self, id: CanId) -> Option<u16> {
        let mut numbered = (0..).zip(&self.rpdos);
        numbered.find_map(|(number, rpdo)| (rpdo.id() == id).then_some(number))
    }

    /// Whether data frames for the one with this number wait for a SYNC.
    pub(crate) fn waits_for_sync(&self, number: u16) -> bool {
        self.rpdos.get(usize::from(number)).is_some_and(Rpdo::waits_for_sync)
    }

    /// Takes a data frame for the one with this number.
    pub(crate) fn handle_frame<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        number: u16,
        frame: &Frame,
        target: &mut Target<'_, A, LEN>,
    ) -> Outcome {
        let rpdo = self.rpdos.get_mut(usize::from(number));
        let Some(rpdo) = rpdo else { return Outcome::default() };
        let outcome = rpdo.handle(now, number, frame, target);
        self.wait |= rpdo.waits();
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
        for (number, rpdo) in (0..).zip(&mut self.rpdos) {
            rpdo.handle_sync(number, target);
        }
    }

    /// When the next one is overdue.
    pub(crate) fn due_at(&self) -> Deadline {
        self.rpdos.iter().map(Rpdo::expires_at).fold(Deadline::NEVER, Deadline::min)
    }

    /// The number of one that is overdue; it then is no more.
    pub(crate) fn take_due(&mut self, now: Instant) -> Option<u16> {
        let mut numbered = (0..).zip(&mut self.rpdos);
        numbered.find_map(|(number, rpdo)| rpdo.take_expired(now).then_some(number))
    }
}
