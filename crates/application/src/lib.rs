//! The application controller of a position indicator: everything its image does apart from pins.
//!
//! [`Application`] is stepped every 2 ms with what the sensor and the keys say, is handed the bytes
//! of the link as they come, and is asked for what to drive, show, send and store. It owns the
//! values of every object that its product's dictionary gives to the application controller.
//!
//! The parts: `sensor` reads the shaft, `parameters` holds the objects and what of them must be
//! stored or told, `link` is this end of the line to the CAN interface controller, `panel` are the
//! keys, `guidance` says where the operator has to turn, `display` is the picture.
#![no_std]

#[cfg(test)]
extern crate std;

mod application;
mod display;
mod errors;
mod guidance;
mod link;
mod message;
mod offer;
mod panel;
mod parameters;
mod record;
mod sensor;
mod status;

pub use application::{Application, Boot, Inputs, MotorOutputs, STEP};
pub use sensor::SSI_READ_LEN;
