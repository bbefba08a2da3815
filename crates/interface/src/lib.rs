//! The core of the CAN interface controller: the CANopen device, its copy of the application's
//! values and its end of the link. Sans-IO: the firmware is a shell around [`Interface`].
#![no_std]

mod emergency;
mod interface;
pub mod link;
mod nm17x;
mod objects;
mod record;
mod slots;

pub use interface::{Boot, BusState, Event, Interface};
pub use record::Record;
