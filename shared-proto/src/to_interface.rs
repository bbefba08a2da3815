use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::Hello;
use crate::limits::SNAPSHOT_VALUES_MAX;

/// From the application controller. Append only, like [`ToApplication`](crate::ToApplication).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToInterface {
    /// Start, restart or loss of either side; instead of process data while out of service.
    Hello(Hello),
    /// Every 10 ms.
    Process(ProcessData),
    /// Values of consecutive rows of the dictionary: asked for, changed without being written from
    /// outside, or repeated in turn so that no copy stays wrong.
    Snapshot {
        /// Position of the first row.
        from: u16,
        /// Values, 32 bits each.
        values: Vec<u32, SNAPSHOT_VALUES_MAX>,
    },
    /// The user touched the device while it showed an offer. Sent again every cycle until the offer
    /// is withdrawn.
    Touched {
        /// The number of the offer.
        offer: u8,
    },
}

/// The state of the application, sent in a fixed cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProcessData {
    /// Counts the cycles.
    pub cycle: u8,
    /// Sequence number of the last write executed; 0 before the first.
    pub acknowledged: u8,
    /// Number of the last urgent order executed; 0 before the first.
    pub urgent_acknowledged: u8,
    /// Object 0x6004.
    pub position_hundredths_mm: i32,
    /// Object 0x204E:01.
    pub status: u16,
    /// Object 0x204E:02.
    pub errors: u16,
}
