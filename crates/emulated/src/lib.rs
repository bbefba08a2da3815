//! Engine 1 of the bench: the **unmodified** images of both controllers on emulated STM32F429s,
//! wired to the world like the real boards.
//!
//! The core and most peripherals are those of the emulator `rigless`; the part they are put
//! together to, its flash array, its CAN controller and its time base are described here. This
//! crate names none of the logic crates: what a device does it can only get from the images.
//!
//! Anything an image reaches that no model stands behind ends the run with an [`EngineError`] that
//! names controller, address and program counter.
//!
//! [`EngineError`]: world::EngineError

mod build;
pub mod bxcan;
mod controller;
mod firmware;
mod flash_array;
mod fleet;
mod lcd_port;
mod log_channel;
mod memory_map;
mod serial_line;
mod ssi_port;
mod stm32f429;
mod tim5;

pub use build::build;
pub use firmware::Firmware;
pub use fleet::{Fleet, Images, Options};
