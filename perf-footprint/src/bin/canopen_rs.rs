//! DEV1 on canopen-rs.
#![no_std]
#![no_main]

use perf_dev1::Stack;
use perf_dev1::canopen_rs::CanopenRs;
use static_cell::StaticCell;

#[cortex_m_rt::entry]
fn main() -> ! {
    static STACK: StaticCell<CanopenRs> = StaticCell::new();
    perf_footprint::run(STACK.init_with(Stack::new))
}
