//! The smallest program that is a CANopen device, to see how much flash and RAM a stack takes:
//! start-up code, a CAN controller that is asked again and again, a clock of milliseconds, the
//! stack, and DEV1. It is linked and measured, not run.
#![no_std]
#![cfg(feature = "image")]

mod controller;
mod memory;

use core::panic::PanicInfo;

use cortex_m::peripheral::syst::SystClkSource;
use perf_dev1::Stack;

use controller::Controller;

/// Clocks of the processor after a reset, per millisecond.
const CLOCKS_PER_MS: u32 = 16_000;

/// The vectors behind those of the processor. The controller is asked again and again: no interrupt
/// is ever enabled.
#[expect(unsafe_code, reason = "the linker puts the vectors where the processor looks for them")]
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [usize; 1] = [0];

/// Runs `stack` for ever.
pub fn run<S: Stack>(stack: &mut S) -> ! {
    let controller = Controller::new();
    if let Some(peripherals) = cortex_m::Peripherals::take() {
        let mut timer = peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(CLOCKS_PER_MS - 1);
        timer.enable_counter();
        let mut now_us = 0;
        loop {
            if timer.has_wrapped() {
                now_us += 1_000;
            }
            if let Some(frame) = controller.receive(S::frame, S::remote_frame) {
                stack.handle(now_us, &frame, &controller);
            }
            stack.tick(now_us, &controller);
        }
    }
    halt()
}

/// Without a text: a device of this size has nobody to read it.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    halt()
}

fn halt() -> ! {
    cortex_m::asm::udf()
}
