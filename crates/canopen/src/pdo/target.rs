use object_dictionary::Values;

use super::mapping::Mapped;
use super::tpdos::Tpdos;
use crate::application::{Application, Written};

/// What the numbers of a receive PDO meet.
pub(crate) struct Target<'a, A, const LEN: usize> {
    pub(crate) values: &'a mut Values<LEN>,
    pub(crate) tpdos: &'a mut Tpdos,
    pub(crate) application: &'a mut A,
    /// Whether what waits for a SYNC comes too late for this one.
    pub(crate) is_late: bool,
}

impl<A: Application, const LEN: usize> Target<'_, A, LEN> {
    /// Takes the numbers of a PDO over, all or none. Only those that a transmit PDO may follow are
    /// compared with what they were. Whether there are any.
    pub(super) fn take_over(&mut self, number: u16, mapped: Mapped<'_>) -> bool {
        match self.application.receive(number, &mapped) {
            Written::Taken => {
                let watched = self.tpdos.may_watch(mapped.slots());
                for (slot, raw) in mapped.iter() {
                    let changed = watched && self.values.raw(slot) != raw;
                    self.values.set_raw(slot, raw);
                    if changed {
                        self.tpdos.note_change(slot);
                    }
                }
                watched
            }
            Written::Ignored => false,
        }
    }
}
