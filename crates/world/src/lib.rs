//! What surrounds the two controllers of a device: the spindle with its sensor and motor, keys and
//! inputs, the LCD chip with its glass, the CAN bus with other nodes and faults.
//!
//! Both engines, the emulated images and the twin, are wired to this one world, and the bench
//! drives both through [`Engine`].

pub mod can;
mod dice;
mod engine;
pub mod lcd_chip;
pub mod spindle;
pub mod ssi_encoder;
mod surroundings;

pub use dice::Dice;
pub use engine::{Engine, EngineError, FlashImage, LogLine, Mcu, McuStats, Reset};
pub use surroundings::{Link, MotorOutputs, Panel, Surroundings};
