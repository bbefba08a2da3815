use std::sync::MutexGuard;

use units::Instant;

use crate::Surroundings;
use crate::can::Bus;

/// One of the two controllers of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mcu {
    /// The CAN interface controller.
    Stm,
    /// The application controller.
    Msp,
}

impl Mcu {
    /// Both, in the order figures are reported in.
    pub const BOTH: [Self; 2] = [Self::Stm, Self::Msp];

    /// The name used on the command line and the control port.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stm => "stm",
            Self::Msp => "msp",
        }
    }
}

/// The contents of one controller's flash, from the first address of bank 1.
pub type FlashImage = Vec<u8>;

/// A restart of a controller, and what asked for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reset {
    /// When it happened.
    pub at: Instant,
    /// `power-on`, `watchdog`, `software`, …
    pub cause: String,
}

/// What a controller has done since power-on of the bench.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct McuStats {
    /// Instructions executed.
    pub instructions: u64,
    /// The part of the powered time the core was not asleep, 0 to 1.
    pub awake_fraction: f64,
    /// The deepest the stack has been, in bytes.
    pub stack_used: u32,
    /// Restarts, oldest first.
    pub resets: Vec<Reset>,
    /// Words programmed into flash.
    pub flash_ops: u64,
    /// Flash sectors erased.
    pub sector_erases: u64,
    /// CAN interrupts taken (STM only).
    pub can_interrupts: u64,
    /// From the interrupt of the last received CAN frame to the first request for a transmission
    /// behind it (STM of the engine that runs the images), in nanoseconds.
    pub can_reaction_ns: u64,
    /// The longest that a received CAN frame waited for the firmware to look at its FIFO (STM of the
    /// engine that runs the images), in nanoseconds.
    pub can_wait_ns: u64,
    /// The longest that all interrupts were masked on the bus (STM of the engine that runs the
    /// images), in nanoseconds.
    pub masked_ns: u64,
}

/// One line a controller logged over RTT.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogLine {
    /// Who logged it.
    pub mcu: Mcu,
    /// Virtual time of the drain that found it.
    pub at: Instant,
    /// `trace`, `debug`, `info`, `warn`, `error`; empty when the line carries none.
    pub level: String,
    /// The decoded text.
    pub text: String,
}

/// The run can not go on: a sentence for the user. An access the emulator could not stand in for
/// is one; the message names controller, address and program counter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EngineError(pub String);

impl std::fmt::Display for EngineError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for EngineError {}

/// One bus with its devices, running on virtual time.
///
/// Nothing happens between calls: time passes only in [`Engine::run_until`]. The same seed and the
/// same calls give the same run, bit for bit.
pub trait Engine: Send {
    /// How many devices hang on the bus.
    fn node_count(&self) -> usize;

    /// Virtual time.
    fn now(&self) -> Instant;

    /// Lets virtual time pass until `at`.
    ///
    /// # Errors
    /// When a controller did something no part of the bench stands in for.
    fn run_until(&mut self, at: Instant) -> Result<(), EngineError>;

    /// What surrounds device `node`. Panics on a node that does not exist.
    fn surroundings(&self, node: usize) -> MutexGuard<'_, Surroundings>;

    /// The CAN bus all devices hang on.
    fn bus(&self) -> MutexGuard<'_, Bus>;

    /// Supply of both controllers of `node`. Flash keeps what was finished.
    fn set_power(&mut self, node: usize, on: bool);

    /// Cuts the supply of one controller in the middle of its `operation`-th flash operation from
    /// now (1 is the next).
    fn cut_power_at_flash_operation(&mut self, node: usize, mcu: Mcu, operation: u32);

    /// Figures of both controllers of `node`: STM, MSP.
    fn stats(&self, node: usize) -> [McuStats; 2];

    /// Lines logged since the last call.
    fn take_log(&mut self, node: usize) -> Vec<LogLine>;

    /// The flash of one controller, to be kept between runs.
    fn flash(&self, node: usize, mcu: Mcu) -> FlashImage;
}
