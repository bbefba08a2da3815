//! A program that cannot go on: its last words are kept for the next start, and it restarts.
//!
//! The motor's lines go off first; the interface controller notices the silence and the restart.
#![expect(unsafe_code, reason = "the signature of a hard fault handler")]

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};

use crate::motor;

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    motor::off();
    firmware_board::stop(format_args!("{info}"))
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    motor::off();
    firmware_board::stop_on_fault(frame)
}
