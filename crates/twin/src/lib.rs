//! Devices without emulation: the cores of both controllers and their world in one process, on one
//! virtual clock.
//!
//! Nothing here is an image. What an image's shell does (`firmware-stm`, `firmware-msp`) is done by
//! `stm` and `msp`, and takes no time: a frame is answered in the instant it is valid. Time jumps
//! from one event to the next, so many devices run faster than real time. What only an image can
//! show, instructions, interrupts, stack and flash cells, is not here.

mod board;
mod can_port;
mod device;
mod fleet;
mod line;
mod memory;
mod msp;
mod stm;

use profiles::Product;

pub use fleet::{Fleet, Options};

/// The product of that name, as it is called on the command line.
#[must_use]
pub fn product(slug: &str) -> Option<&'static Product> {
    [&profiles::nm172::PRODUCT].into_iter().find(|product| product.slug == slug)
}
