//! DEV1 on canopen-rs.
#![no_std]
#![no_main]

use core::mem::MaybeUninit;

use perf_dev1::Stack;
use perf_dev1::canopen_rs::CanopenRs;

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut STACK: MaybeUninit<CanopenRs> = MaybeUninit::uninit();
    perf_footprint::run(STACK.write(Stack::new()))
}
