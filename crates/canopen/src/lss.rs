//! Layer setting services, CiA 305: node-ID and bit rate over the bus itself.
//!
//! [`Slave`] is the whole machine: frames in, answers and events out. A [`Node`](crate::Node) whose
//! settings ask for it runs one, also as long as the device has no node-ID. What is stored, and when a
//! bit rate is switched, is up to the core above.
//!
//! | Service | Command | Answer |
//! |---|---|---|
//! | switch state global | 0x04 | none |
//! | switch state selective | 0x40 to 0x43 | 0x44 |
//! | identify remote slave | 0x46 to 0x4B | 0x4F |
//! | identify non-configured slave | 0x4C | 0x50 |
//! | fastscan | 0x51 | 0x4F |
//! | configure node-ID | 0x11 | 0x11 |
//! | configure bit timing | 0x13 | 0x13 |
//! | activate bit timing | 0x15 | none |
//! | store configuration | 0x17 | 0x17 |
//! | inquire identity, node-ID | 0x5A to 0x5D, 0x5E | the same |

mod bit_rate;
mod settings;
mod slave;

pub use bit_rate::BitRate;
pub use settings::{
    Addressing, Identification, RequestLength, Selected, Selection, Settings, Unconfigured,
};
pub use slave::{Event, Identity, Reaction, Slave, StoreError};

pub(crate) use slave::{REQUEST, RESPONSE};
