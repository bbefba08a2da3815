//! DEV1 on zencan-node.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use perf_dev1::Stack;
use perf_dev1::zencan::Zencan;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut STACK: MaybeUninit<Zencan> = MaybeUninit::uninit();
    perf_footprint::run(STACK.write(Stack::new()))
}
