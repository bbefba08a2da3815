//! What the tests of whole devices stand on: the images as cargo builds them, a bench that runs
//! them, and clients for its control port and its CAN gateway.
//!
//! Everything here fails by panicking, with a sentence: it is called by tests only.
#![expect(clippy::indexing_slicing, reason = "what a JSON answer lacks reads as null")]

mod bench;
mod build;
mod control;
mod fleet;
mod scene;
mod slcan;

pub use bench::Bench;
pub use build::{bench_program, images};
pub use control::Control;
pub use fleet::fleet;
pub use scene::Scene;
pub use slcan::{Frame, Slcan};

use std::time::Duration;

/// Longest wait for an answer of the bench. It only bounds a hang; nothing is timed by it.
const ANSWER_TIME_MAX: Duration = Duration::from_secs(120);
