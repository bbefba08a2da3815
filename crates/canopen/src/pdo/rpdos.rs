use heapless::Vec;
use object_dictionary::Values;
use units::Instant;

use super::mapping::Mapped;
use super::rpdo::{Reception, Rpdo};
use super::tpdos::Tpdos;
use crate::application::{Application, Written};
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};
use crate::settings::{Emergency, ReceiveErrors};

/// Receive PDOs of a device.
pub(crate) const RPDO_MAX: usize = 4;

/// The receive PDOs of a device.
#[derive(Debug)]
pub(crate) struct Rpdos {
    rpdos: Vec<Rpdo, RPDO_MAX, u8>,
    expires_at: Deadline,
}

/// What the values of a receive PDO meet.
pub(crate) struct Target<'a, A, const LEN: usize> {
    pub(crate) values: &'a mut Values<LEN>,
    pub(crate) tpdos: &'a mut Tpdos,
    pub(crate) application: &'a mut A,
}

impl Rpdos {
    /// Those that the dictionary describes.
    pub(crate) fn new<const LEN: usize>(values: &Values<LEN>) -> Self {
        let mut rpdos = Vec::new();
        for rpdo in (0..).take(RPDO_MAX).filter_map(|number| Rpdo::new(number, values)) {
            let _ = rpdos.push(rpdo);
        }
        Self { rpdos, expires_at: Deadline::NEVER }
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.rpdos.iter_mut().for_each(Rpdo::stop);
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
        self.schedule();
        moved
    }

    /// The identifiers they listen to.
    pub(crate) fn ids(&self) -> impl Iterator<Item = CanId> {
        self.rpdos.iter().filter_map(Rpdo::id)
    }

    /// Whether a data frame with this identifier is one of them.
    pub(crate) fn listen_to(&self, id: CanId) -> bool {
        self.rpdos.iter().any(|rpdo| rpdo.listens_to(id))
    }

    /// Whether data frames with this identifier wait for a SYNC.
    pub(crate) fn wait_for_sync(&self, id: CanId) -> bool {
        self.rpdos.iter().any(|rpdo| rpdo.listens_to(id) && rpdo.waits_for_sync())
    }

    /// Takes a data frame that is one of them. Comes back with what is to be said about it.
    pub(crate) fn handle_frame<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        frame: &Frame,
        errors: &ReceiveErrors,
        target: &mut Target<'_, A, LEN>,
    ) -> Option<Emergency> {
        let mut error = None;
        for rpdo in self.rpdos.iter_mut().filter(|rpdo| rpdo.listens_to(frame.id())) {
            error = rpdo.handle(now, frame, target.values.dictionary(), errors);
            let number = rpdo.number();
            if let Some(mapped) = rpdo.take(Reception::AtOnce) {
                target.take_over(number, mapped);
            }
        }
        self.schedule();
        error
    }

    /// Takes a SYNC.
    pub(crate) fn handle_sync<A: Application, const LEN: usize>(
        &mut self,
        target: &mut Target<'_, A, LEN>,
    ) {
        for rpdo in &mut self.rpdos {
            let number = rpdo.number();
            if let Some(mapped) = rpdo.take(Reception::WithSync) {
                target.take_over(number, mapped);
            }
        }
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
        self.schedule();
        overdue
    }

    fn schedule(&mut self) {
        let due = self.rpdos.iter().map(Rpdo::expires_at).min();
        self.expires_at = due.unwrap_or(Deadline::NEVER);
    }
}

impl<A: Application, const LEN: usize> Target<'_, A, LEN> {
    /// Takes the values of a PDO over, all or none.
    fn take_over(&mut self, number: u16, mapped: Mapped<'_>) {
        match self.application.receive(number, &mapped) {
            Written::Taken => {
                for (slot, raw) in mapped.iter() {
                    if self.values.raw(slot) != raw {
                        self.values.set_raw(slot, raw);
                        self.tpdos.note_change(slot);
                    }
                }
            }
            Written::Ignored => {}
        }
    }
}
