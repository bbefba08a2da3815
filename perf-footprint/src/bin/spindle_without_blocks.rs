//! DEV1 on the stack of this repository, without block transfer.
#![no_std]
#![no_main]

use perf_dev1::Stack;
use perf_dev1::spindle::{Spindle, WithoutBlocks};
use static_cell::StaticCell;

#[cortex_m_rt::entry]
fn main() -> ! {
    static STACK: StaticCell<Spindle<WithoutBlocks>> = StaticCell::new();
    perf_footprint::run(STACK.init_with(Stack::new))
}
