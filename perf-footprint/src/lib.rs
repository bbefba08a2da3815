//! The smallest program that is a CANopen device, to see how much flash and RAM a stack takes:
//! start-up code, a CAN controller that is asked again and again, a clock of milliseconds, the
//! stack, and DEV1. The one on the stack of this repository also runs, on the virtual bench.
#![no_std]
#![cfg(feature = "image")]

mod controller;
mod memory;
mod register;
mod timer;

use core::panic::PanicInfo;

use perf_dev1::Stack;

use controller::Controller;
use timer::Timer;

/// The vectors behind those of the processor. The controller is asked again and again: no interrupt
/// is ever enabled.
#[expect(unsafe_code, reason = "the linker puts the vectors where the processor looks for them")]
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
pub static __INTERRUPTS: [usize; 1] = [0];

/// Runs `stack` for ever.
pub fn run<S: Stack>(stack: &mut S) -> ! {
    let controller = Controller::new();
    let timer = Timer::new();
    stack.start();
    let mut now_us = 0;
    loop {
        if timer.is_over() {
            now_us += 1_000;
        }
        if let Some(frame) = controller.receive(S::frame, S::remote_frame) {
            stack.handle(now_us, &frame, &controller);
        }
        stack.tick(now_us, &controller);
    }
}

/// Without a text: a device of this size has nobody to read it.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    cortex_m::asm::udf()
}
