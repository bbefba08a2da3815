//! Devices without emulation: the cores of both controllers and their world in one process, on one
//! virtual clock.
//!
//! A device has two controllers ([`Kind::Pair`], the NM17x) or one ([`Kind::Single`], the position
//! sensors). Nothing here is an image. What an image's shell does (`firmware-stm`, `firmware-msp`) is done by
//! `stm`, `msp` and `single`, and takes no time: a frame is answered in the instant it is valid. Time jumps
//! from one event to the next, so many devices run faster than real time. What only an image can
//! show, instructions, interrupts, stack and flash cells, is not here.

mod board;
mod can_port;
mod device;
mod fleet;
mod line;
mod memory;
mod msp;
mod pair;
mod single;
mod stm;

pub use device::{Kind, kind, slugs};
pub use fleet::{Fleet, Options};
