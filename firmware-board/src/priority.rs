//! Who may interrupt whom, most urgent first.
//!
//! The CANopen core comes first: three frames fit into a receive FIFO, so nothing it does may take
//! longer than three shortest frames (141 µs at 1 Mbit/s). Everything that can be late without
//! losing anything (DMA moves the bytes) comes last.
use embassy_stm32::interrupt::{self, InterruptExt, Priority};

/// CAN interrupts, and the executor that the core hears of everything else through.
pub const CORE: Priority = Priority::P1;
/// The time base.
pub const TIME: Priority = Priority::P2;
/// DMA streams, UART, SPI, I2C and flash.
pub const DATA: Priority = Priority::P3;

/// Sets the priorities of the time base and of what both boards use. To be called right after the
/// HAL was initialised, which leaves all of them at the highest priority.
pub fn assign() {
    interrupt::TIM5.set_priority(TIME);
    interrupt::USART2.set_priority(DATA);
    interrupt::FLASH.set_priority(DATA);
}
