//! What both controller boards have in common: clock, interrupt priorities, link port, watchdog,
//! reset cause, last words, identity and the parameter sectors of the STM32F429ZI.
//!
//! Nothing here knows what a controller is for.
#![no_std]

use defmt_rtt as _;

mod clock;
mod identity;
mod last_words;
mod link_port;
mod parameter_flash;
pub mod priority;
mod reset_cause;
mod watchdog;

pub use clock::{APB1_HZ, APB2_HZ, SYSCLK_HZ, config};
pub use identity::serial_number;
pub use last_words::{report_last_words, stop, stop_on_fault};
pub use link_port::{BIT_RATE, LinkPins, LinkReceiver, LinkTransmitter, RECEIVE_RING_LEN, open};
pub use parameter_flash::ParameterFlash;
pub use reset_cause::ResetCause;
pub use watchdog::{Beat, PET_EVERY, supervise};
