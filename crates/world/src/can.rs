//! The CAN bus: frames, arbitration, errors; the devices on it and the outside nodes (masters on a
//! gateway, the control port).
//!
//! The bus works frame by frame and to the nanosecond. Devices run in quanta; at every boundary
//! between two quanta each device hands over a [`PortState`], and [`Bus::resolve`] answers with a
//! [`Delivery`] for each: what will happen to it, and at which instant still to come.
//!
//! # Why the quantum does not show
//!
//! At the boundary `T` every request made up to `T` is known. The next start of frame is the later
//! of *bus free* and *earliest request*; when it is not later than `T`, everything requested up to
//! that start contends, whatever was requested after it waits. The first thing a controller notices
//! of a frame comes [`EARLIEST_OUTCOME_BITS`] bits after its start. With a quantum no longer than
//! that ([`greatest_quantum`]) the outcome lies behind `T`, and an event can be placed at its exact
//! instant. Four things are rounded, each by less than one quantum:
//!
//! - a request to leave the bus is answered at a boundary, because only there it is known whether a
//!   frame is under way;
//! - a mailbox aborted while some frame is under way is answered there too, for the same reason;
//! - a disturbance never hits a bit that is already behind `T`;
//! - after a change of bit rate the first frame may be longer than it should.

mod attempt;
mod bits;
mod bus;
mod counters;
mod faults;
mod frame;
mod outside;
mod port;
mod time;

pub use bits::{Wire, crc15};
pub use bus::{Bus, EARLIEST_OUTCOME_BITS, LOG_MAX, LogCursor, Logged, Source, greatest_quantum};
pub use counters::{Confinement, ErrorCounters, RecessiveWait};
pub use faults::Faults;
pub use frame::{Frame, FrameError, Id};
pub use outside::{Outside, QueueFull, RECEIVE_MAX, Rate, Role, SEND_MAX, Status, UnknownOutside};
pub use port::{
    Activity, Delivery, MAILBOXES, Outcome, PortState, Presence, Request, SendOrder, What,
    WireError,
};
pub use time::{BitTime, Nanos};
