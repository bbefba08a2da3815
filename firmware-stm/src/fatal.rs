//! A program that cannot go on: its last words are kept for the next start, and it restarts.
//!
//! The reset silences the node; the application controller stops the motor when the link falls
//! silent.
#![expect(unsafe_code, reason = "the signature of a hard fault handler")]

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    firmware_board::stop(format_args!("{info}"))
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    firmware_board::stop_on_fault(frame)
}
