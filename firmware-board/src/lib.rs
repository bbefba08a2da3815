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
mod parameters;
pub mod priority;
mod record_queue;
mod reset_cause;
mod start;
mod start_number;
mod watchdog;

pub use clock::{APB1_HZ, APB2_HZ, SYSCLK_HZ};
pub use identity::serial_number;
pub use last_words::{stop, stop_on_fault};
pub use link_port::{
    LinkPins, LinkReceiver, LinkTransmitter, OUTBOX_LEN, Outbox, RECEIVE_RING_LEN, open, transmit,
};
pub use parameters::{NumberSet, Outcome, Parameters, RECORDS_MAX, Records};
pub use record_queue::RecordQueue;

pub use start::{Started, start};
pub use watchdog::{Beat, SHOW_UP_EVERY, supervise};
