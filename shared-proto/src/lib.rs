//! What the two controllers say to each other, and how it travels over the serial line.
//!
//! The application controller is the clock: every 10 ms it sends [`ProcessData`]. In the gap that
//! follows the CAN interface controller sends one [`ToApplication`]. A message travels as postcard
//! bytes with a CRC-16 behind them, COBS encoded and ended by a zero byte, so a receiver that lost
//! its place finds it again at the next zero. A frame that is damaged is counted and dropped whole.
//!
//! Messages are only ever added at the end of their enum. The bytes of a protocol version are
//! frozen by the tests in `tests/`.
#![no_std]

mod frame;
pub mod limits;
mod to_application;
mod to_interface;

pub use frame::{Encoded, Receiver, encode};
use serde::{Deserialize, Serialize};
pub use to_application::{NodeState, Supervision, ToApplication, Urgency, Urgent, Write};
pub use to_interface::{ProcessData, ToInterface};

/// The version of the messages in this crate. A partner with another one is not served.
pub const PROTOCOL: u16 = 1;

/// Who is at the other end. Exchanged at the start and whenever either side restarts or loses the
/// other.
///
/// The rules, the same on both sides:
/// - A side is in service from the first fitting `Hello` whose `heard` is its own nonce until it
///   loses the other or meets a nonce it has not seen. A new nonce also ends what was numbered: no
///   write and no urgent order of the partner has been executed yet.
/// - A `Hello` that is not yet `in_service` is answered with a `Hello`; one that is, is not.
/// - Out of service a side says nothing but `Hello`: the application controller in every cycle, the
///   interface controller in answer to whatever it receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL`] of the sender.
    pub protocol: u16,
    /// Product code, the low word of object 0x1018:02.
    pub product: u16,
    /// Firmware version in hundredths: 105 is V1.05.
    pub firmware: u16,
    /// Fingerprint of the object dictionary.
    pub dictionary: u32,
    /// Differs from one start of the sender to the next. Never 0.
    pub nonce: u32,
    /// The nonce last heard from the other side; 0 when none was.
    pub heard: u32,
    /// Whether the sender considers the link in service.
    pub in_service: bool,
}

impl Hello {
    /// Whether two images that greet each other so can work together.
    #[must_use]
    pub const fn fits(&self, other: &Self) -> bool {
        self.protocol == other.protocol
            && self.product == other.product
            && self.dictionary == other.dictionary
    }
}
