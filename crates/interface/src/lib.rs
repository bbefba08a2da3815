//! The core of the CAN interface controller: the CANopen device, its copy of the application's
//! values and its end of the link. Sans-IO: the firmware is a shell around [`Interface`].
#![no_std]

mod bit_timing;
mod control_word;
mod emergency;
mod interface;
pub mod link;
mod message;
mod nm17x;
mod objects;
mod record;
mod saving;
mod slots;
mod stored;

pub use interface::{Boot, Event, Interface, NotSaved};
pub use record::Record;
