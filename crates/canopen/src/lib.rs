//! A CANopen device, CiA 301, without a bus, a clock or a task of its own.
//!
//! [`Node`] is the whole device towards the bus. Frames and time go in, frames and events come out;
//! the product hangs on the object dictionary and on the few hooks of [`Application`]. What products
//! do differently is data: their dictionary, and [`Settings`].
//!
//! ```text
//! controller ── handle_frame ──→ ┌──────┐ ←── set_value ────── product
//!            ←─ take_transmit ── │ Node │ ─── poll_event ────→
//! clock ─────── handle_timeout → └──────┘ ─── Application ───→
//! ```
//!
//! | CiA 301 | here |
//! |---|---|
//! | NMT slave, boot-up, self-start (0x1F80) | all commands; a reset is an event for the core above |
//! | error control | heartbeat producer and consumers (0x1016), error behaviour (0x1029) |
//! | | node guarding and life guarding (0x100C, 0x100D) where no heartbeat is produced |
//! | SDO server | one; expedited and segmented, in blocks where [`Application::BLOCK_TRANSFER`] asks for it; both ways |
//! | storage (0x1010, 0x1011) | commands to store and restore are events; the answer follows the storage |
//! | PDO | transmit: types 0 to 240, 252 to 255; remote frames, inhibit time, event timer, SYNC start value |
//! | | receive: types 0 to 240, 254, 255; deadline |
//! | | mapping: fixed, or changed by masters where the rows may be written; whole bytes, dummy entries |
//! | SYNC | consumer and producer (0x1006) with counter (0x1019) and window (0x1007) |
//! | TIME | consumer (0x1012): an event |
//! | EMCY | identifier (0x1014), inhibit time, error field (0x1003), error reset with the error register |
//! | bus | warning, passive, bus-off, recovery and lost frames are inputs; [`Settings::bus`] says what is sent |
//! | LSS (CiA 305) | all services, where [`Settings::lss`] asks for it |
//!
//! **Limits.** Identifiers have eleven bits. Objects are numbers of 8, 16 and 32 bits and texts of up to
//! 255 bytes. There are four PDOs each way, with up to eight objects each, and eight monitored nodes; what
//! a dictionary has beyond is kept and has no effect. There is no SDO client, no network manager and no
//! multiplexed PDO.
//!
//! **Concurrency.** A node is one value with `&mut` methods and no interior sharing: run it where
//! frames arrive, in an interrupt or a task, and give nothing else access meanwhile. No call waits.
//!
//! **Work.** One frame costs one look into the dictionary (a hash without collisions) and at most one
//! pass over the PDOs: on a Cortex-M4 less than 350 instructions for an expedited request with its
//! answer, and less than 300 for a PDO either way. There is no tick: nothing is due before
//! [`Node::poll_timeout`], which looks nothing up, and now and then wakes for nothing. A frame for
//! another node costs a look at one bit, and nothing at all where the controller filters by
//! [`Node::accepts`]. What is rare costs more: each sub-index of a PDO's parameters that a master
//! writes, one reading of that PDO's parameters and mapping; an emergency, one look for each entry of
//! 0x1003; a sub-index that an object does not have, one short step for each one below, at most 256.
//!
//! **Time.** The clock of the calls never comes round. Inside, deadlines have 32 bits of its
//! microseconds: nothing lies more than 35 minutes and 47 seconds ahead, which limits the SYNC period
//! and window (0x1006, 0x1007) and the life time of guarding, and [`Node::handle_timeout`] is called no
//! later than half an hour after [`Node::poll_timeout`] says. A node may be idle for any time.
//!
//! **Memory.** A node has no memory but its own: on a processor of 32 bits less than 1.7 KiB, and four
//! bytes for each object. All bounds are constants: [`TRANSMIT_MAX`] frames wait for mailboxes, and the
//! least urgent of too many is dropped, counted and reported.
//! PDOs and heartbeats that wait are replaced by newer ones, and an emergency takes the place of one
//! that says the same, so only clients that do not wait for their answers, and different emergencies
//! in great number, can fill it. Eight emergencies wait for the end of the inhibit time, and sixteen
//! events for [`Node::poll_event`], which is more than one call brings about; the oldest of too many
//! is dropped.
//!
//! **Bad input.** Every frame is defined input. One that is no request for this node changes
//! nothing; one that is has exactly one answer, the segments of a block excepted.
#![no_std]

mod acceptance;
mod application;
mod bus;
mod cob_id;
mod deadline;
mod emcy;
mod frame;
mod guarding;
mod heartbeat;
pub mod lss;
mod nmt;
mod node;
mod outbox;
mod parameter;
mod pdo;
mod sdo;
mod settings;
mod sync;
mod time;

pub use acceptance::Accepted;
pub use application::{Application, ReadError, WriteError, Written};
pub use bus::BusState;
pub use cob_id::NodeId;
pub use frame::{CanId, DATA_MAX, Frame};
pub use nmt::State;
pub use node::{Event, Node};
pub use outbox::TRANSMIT_MAX;
pub use pdo::Mapped;
pub use sdo::AbortCode;
pub use settings::{
    AbortCodes, AdditionalInformation, BlockTransfer, BusOff, BusRules, Emergency, ErrorBehaviour,
    Expedited, Identifiers, PdoChanges, PdoRules, ProductSettings, ReceiveErrors, RemoteRequests,
    Settings, SyncDivision, Trigger,
};
pub use time::TimeOfDay;
