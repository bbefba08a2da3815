//! DEV1 on the stack of this repository, without block transfer.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use perf_dev1::Stack;
use perf_dev1::spindle::{Spindle, WithoutBlocks};

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut STACK: MaybeUninit<Spindle<WithoutBlocks>> = MaybeUninit::uninit();
    perf_footprint::run(STACK.write(Stack::new()))
}
