//! The operations on the stack of this repository.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg_attr(target_os = "none", cortex_m_rt::entry)]
fn main() -> ! {
    perf_dev1::main::<perf_dev1::spindle::Spindle>()
}
