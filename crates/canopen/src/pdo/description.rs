use object_dictionary::Values;
use units::Duration;

use super::MAPPING;
use super::mapping::Mapping;
use crate::cob_id::CobId;
use crate::frame::CanId;
use crate::parameter::parameter;

/// What the objects of a PDO say, whichever way it goes (CiA 301, sections 7.5.2.35 to 7.5.2.38).
/// What the product does not have is 0.
#[derive(Debug)]
pub(super) struct Description {
    /// None while the PDO is switched off or carries nothing.
    pub(super) id: CanId,
    pub(super) allows_remote: bool,
    pub(super) transmission_type: u32,
    /// In steps of the product's own length.
    pub(super) inhibit_time: u32,
    event_time_ms: u32,
    pub(super) sync_start: u32,
    pub(super) mapping: Mapping,
}

impl Description {
    /// That of a PDO that is switched off.
    pub(super) fn off() -> Self {
        Self {
            id: CanId::NONE,
            allows_remote: false,
            transmission_type: 0,
            inhibit_time: 0,
            event_time_ms: 0,
            sync_start: 0,
            mapping: Mapping::default(),
        }
    }

    /// Takes the objects of the PDO with this communication parameter over. It carries what comes
    /// before the first entry that it cannot.
    pub(super) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>, index: u16) {
        let value = |index, sub| parameter(values, index, sub).unwrap_or(0);
        let cob_id = CobId::from_raw(value(index, 1));
        self.allows_remote = cob_id.allows_remote();
        self.transmission_type = value(index, 2);
        self.inhibit_time = value(index, 3);
        self.event_time_ms = value(index, 5);
        self.sync_start = value(index, 6);
        let _ = self.mapping.read(values, index + MAPPING, value(index + MAPPING, 0));
        let id = cob_id.valid().filter(|_| self.mapping.byte_len() > 0);
        self.id = id.unwrap_or(CanId::NONE);
    }

    /// No time at all where the product has no event timer.
    pub(super) fn event_time(&self) -> Duration {
        Duration::from_millis(u64::from(self.event_time_ms))
    }
}
