//! The CAN port: bxCAN of the STM32F429 (RM0090 chapter 32) behind what the core needs of it.
mod acceptance;
mod bit_timing;
mod port;
mod registers;

pub(crate) use port::{Pins, Port};
pub(crate) use registers::{ErrorState, Fifo, Received};
