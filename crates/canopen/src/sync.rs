use crate::cob_id::CobId;
use crate::frame::{CanId, Frame};

/// The SYNC consumer (CiA 301, section 7.2.5; object 0x1005).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Consumer {
    id: CanId,
}

impl Consumer {
    /// Listens to the identifier in bits 10 to 0 of 0x1005. Bit 31 means nothing there.
    pub(crate) const fn new(cob_id: u32) -> Self {
        Self { id: CobId::from_raw(cob_id).can_id() }
    }

    pub(crate) const fn id(self) -> CanId {
        self.id
    }

    /// Whether the data frame is a SYNC. Producers send it without data or with a counter of one byte;
    /// both count, the byte itself means nothing here.
    pub(crate) fn recognises(self, frame: &Frame) -> bool {
        frame.id() == self.id && frame.dlc() <= 1
    }
}
