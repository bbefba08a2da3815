use object_dictionary::Values;

use crate::cob_id::CobId;
use crate::frame::{CanId, Frame};
use crate::parameter::number;

/// The object with the identifier of TIME.
pub(crate) const COB_ID: u16 = 0x1012;

/// A point in time as the network tells it: TIME_OF_DAY (CiA 301, section 7.1.6.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TimeOfDay {
    /// Milliseconds since midnight, 28 bits.
    pub milliseconds: u32,
    /// Days since 1 January 1984.
    pub days: u16,
}

/// The identifier that a TIME consumer listens to (CiA 301, section 7.2.6; object 0x1012): none
/// unless bit 31 is set.
pub(crate) fn consumed<const LEN: usize>(values: &Values<LEN>) -> CanId {
    CobId::from_raw(number(values, COB_ID, 0)).consumed()
}

impl TimeOfDay {
    /// The time in a TIME frame. `None` for another length.
    pub(crate) fn parse(frame: &Frame) -> Option<Self> {
        const MILLISECONDS: u32 = 0x0FFF_FFFF;
        let &[a, b, c, d, low, high] = frame.data() else { return None };
        Some(Self {
            milliseconds: u32::from_le_bytes([a, b, c, d]) & MILLISECONDS,
            days: u16::from_le_bytes([low, high]),
        })
    }
}
