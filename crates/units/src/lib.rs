//! The quantities every crate shares. Raw integers that must cross a wire carry their unit in the
//! name instead; inside the project a quantity has a type.
#![no_std]

mod position;
mod time;

pub use position::{Position, Scaling, Steps};
pub use time::{Duration, Instant};
