//! DEV1 on the stack of this repository.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use perf_dev1::Stack;
use perf_dev1::spindle::Spindle;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut STACK: MaybeUninit<Spindle> = MaybeUninit::uninit();
    perf_footprint::run(STACK.write(Stack::new()))
}
