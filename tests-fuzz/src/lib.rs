//! Conversations with the parts that take bytes from outside, decided by bytes.
//!
//! A target reads its input as a list of things that happen (frames, time that passes, values that
//! change), lets them happen, and panics when a rule is broken. Any input is a conversation, so a
//! fuzzer, a property test and a kept seed drive a target alike. Where what has to happen can be
//! said without the code under test, a model says it: [`sdo`] and [`lss`].
#![expect(
    clippy::cast_possible_truncation,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a test that meets what it does not expect has to fail"
)]

mod bytes;
#[path = "../../crates/canopen/tests/node/cia_301.rs"]
#[expect(dead_code, reason = "the nodes of this device are made elsewhere")]
mod cia_301;
#[path = "../../crates/canopen/tests/node/device.rs"]
#[expect(dead_code, reason = "the product behind it is another one here")]
mod device;
pub mod link;
pub mod lss;
pub mod node;
pub mod sdo;

/// A target: its name and what it does with an input.
pub type Target = (&'static str, fn(&[u8]));

/// All of them.
pub const TARGETS: [Target; 4] = [
    ("node", node::converse),
    ("sdo", sdo::converse),
    ("lss", lss::converse),
    ("link", link::converse),
];
