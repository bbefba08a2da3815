use object_dictionary::Values;

use crate::cob_id::CobId;
use crate::parameter::{number, parameter};

/// The communication parameter of a PDO, whichever way it goes (CiA 301, sections 7.5.2.35 and
/// 7.5.2.37). What the product does not have of it is 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Communication {
    pub(super) cob_id: CobId,
    pub(super) transmission_type: u32,
    /// In steps of the product's own length.
    pub(super) inhibit_time: u32,
    pub(super) event_time_ms: u32,
    pub(super) sync_start: u32,
}

impl Communication {
    /// The one with this index. `None` when the product has no such PDO.
    pub(super) fn read<const LEN: usize>(values: &Values<LEN>, index: u16) -> Option<Self> {
        let cob_id = CobId::from_raw(parameter(values, index, 1)?);
        let value = |sub| number(values, index, sub);
        Some(Self {
            cob_id,
            transmission_type: value(2),
            inhibit_time: value(3),
            event_time_ms: value(5),
            sync_start: value(6),
        })
    }
}
