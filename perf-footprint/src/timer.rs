//! The timer of the processor (Armv7-M, section B3.3), for a clock of milliseconds.

use crate::register::{read, write};

/// Clocks of the processor after a reset, per millisecond.
const CLOCKS_PER_MS: u32 = 16_000;

const CSR: usize = 0xE000_E010;
const RVR: usize = CSR + 0x4;

pub(crate) struct Timer(());

impl Timer {
    /// Starts it with the clock of the processor.
    pub(crate) fn new() -> Self {
        write(RVR, CLOCKS_PER_MS - 1);
        write(CSR, 1 << 2 | 1);
        Self(())
    }

    /// Whether another millisecond is over.
    pub(crate) fn is_over(&self) -> bool {
        read(CSR) & 1 << 16 != 0
    }
}
