//! Golden vectors of the logic crates: results that were worked out by hand or printed in the
//! manual, and must come out the same on the computer of a developer and on a Cortex-M4.
//!
//! The tests of this package run them on the host. The program `vectors` runs them on the emulated
//! board, built as the images are: same instruction set, same optimisation.
#![no_std]

// The vectors name the device beside them from the root of the crate.
#[path = "../../crates/canopen/tests/node/device.rs"]
mod device;
mod link;
mod position;
#[path = "../../crates/canopen/tests/node/vectors.rs"]
mod vectors;

/// Runs all vectors and calls `differs` with the name of each one that comes out wrong. Returns
/// how many there are.
pub fn run(mut differs: impl FnMut(&str)) -> usize {
    if let Some(name) = vectors::first_failure() {
        differs(name);
    }
    vectors::VECTORS.len() + position::run(&mut differs) + link::run(&mut differs)
}
