use heapless::Vec;
use object_dictionary::Values;

use super::communication::Communication;
use super::rpdo::{Outcome, Rpdo};
use super::target::Target;
use super::{MAPPING, PDO_MAX, RECEIVE};
use crate::application::Application;
use crate::deadline::{Deadline, Moment};
use crate::frame::{CanId, Frame};

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
        let Some(communication) = Communication::read(values, index) else { return false };
        while self.rpdos.len() <= number.into() && self.rpdos.push(Rpdo::off()).is_ok() {}
        let Some(rpdo) = self.rpdos.get_mut(usize::from(number)) else { return false };
        let before = rpdo.id();
        rpdo.reread(index, values, &communication);
        before != rpdo.id()
    }

    /// The identifiers they listen to.
    pub(crate) fn ids(&self) -> impl Iterator<Item = CanId> {
        self.rpdos.iter().map(Rpdo::id).filter(|&id| id != CanId::NONE)
    }

    /// Takes a data frame, if one listens to its identifier.
    #[inline]
    pub(crate) fn handle_frame<A: Application, const LEN: usize>(
        &mut self,
        now: Moment,
        frame: &Frame,
        target: &mut Target<'_, A, LEN>,
    ) -> Option<Outcome> {
        let mut numbered = (0..).zip(&mut self.rpdos);
        let (number, rpdo) = numbered.find(|(_, rpdo)| rpdo.id() == frame.id())?;
        let outcome = rpdo.handle(now, number, frame, target);
        self.wait |= rpdo.waits();
        Some(outcome)
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
    pub(crate) fn due_at(&self, now: Moment) -> Deadline {
        let expiries = self.rpdos.iter().map(Rpdo::expires_at);
        expiries.fold(Deadline::NEVER, |first, next| first.or_earlier(next, now))
    }

    /// The number of one that is overdue; it then is no more.
    pub(crate) fn take_due(&mut self, now: Moment) -> Option<u16> {
        let mut numbered = (0..).zip(&mut self.rpdos);
        numbered.find_map(|(number, rpdo)| rpdo.take_expired(now).then_some(number))
    }
}
