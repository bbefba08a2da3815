//! DEV1 on zencan-node.
#![no_std]
#![no_main]

use perf_dev1::Stack;
use perf_dev1::zencan::Zencan;
use static_cell::StaticCell;

#[cortex_m_rt::entry]
fn main() -> ! {
    static STACK: StaticCell<Zencan> = StaticCell::new();
    perf_footprint::run(STACK.init_with(Stack::new))
}
