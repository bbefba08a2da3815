//! A CANopen device, CiA 301, without a bus, a clock or a task of its own.
#![no_std]

mod application;
mod cob_id;
mod emcy;
mod frame;
mod heartbeat;
mod nmt;
mod node;
mod outbox;
mod pdo;
mod sdo;
mod settings;
mod sync;

pub use application::{Application, ReadError, WriteError, Written};
pub use cob_id::NodeId;
pub use frame::{CanId, DATA_MAX, Frame};
pub use nmt::State;
pub use node::{Accepted, Event, Node};
pub use outbox::TRANSMIT_MAX;
pub use sdo::AbortCode;
pub use settings::{AbortCodes, Expedited, Settings, Trigger};
