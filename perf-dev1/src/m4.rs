//! On a Cortex-M4 under QEMU that counts instructions: one of them is one nanosecond of its clock,
//! and the timer of the processor reads that clock.

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use semihosting::println;

use crate::operations::OPERATIONS;
use crate::{Memory, Stack};

/// How often each operation is done.
const TIMES: u32 = 1_000;
/// The timer of the emulated board runs at 25 MHz.
const NANOSECONDS_PER_TICK: u32 = 40;
/// The timer counts down 24 bits.
const TIMER_MAX: u32 = 0x00FF_FFFF;

/// Checks all operations, counts their instructions and prints a line for each: instructions, a
/// tab, the name. Does not return; the status is 0.
pub fn main<S: Stack>() -> ! {
    let mut timer = cortex_m::Peripherals::take().expect("taken once").SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload(TIMER_MAX);
    timer.clear_current();
    timer.enable_counter();
    for operation in OPERATIONS {
        operation.check::<S>();
        let bus = Memory::default();
        let (mut stack, frames) = operation.prepare::<S>(&bus);
        let mut count = |function: fn(&mut S, &S::Frame, &Memory)| {
            ticks(|| {
                let function = core::hint::black_box(function);
                for _ in 0..TIMES / 2 {
                    for frame in &frames {
                        function(&mut stack, frame, &bus);
                    }
                }
            })
        };
        let overhead = count(nothing);
        let all = count(operation.function());
        let each = all.saturating_sub(overhead) * NANOSECONDS_PER_TICK / TIMES;
        println!("{each}\t{}", operation.name);
    }
    semihosting::process::exit(0)
}

fn ticks(action: impl FnOnce()) -> u32 {
    let start = SYST::get_current();
    action();
    start.wrapping_sub(SYST::get_current()) & TIMER_MAX
}

/// What is not the operation: its loop and its call.
#[inline(never)]
fn nothing<S: Stack>(stack: &mut S, frame: &S::Frame, bus: &Memory) {
    core::hint::black_box((stack, frame, bus));
}
