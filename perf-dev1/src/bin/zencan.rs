//! The operations on zencan-node.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg_attr(target_os = "none", cortex_m_rt::entry)]
fn main() -> ! {
    perf_dev1::main::<perf_dev1::zencan::Zencan>()
}
