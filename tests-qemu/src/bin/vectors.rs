//! The golden vectors as a program for the emulated Cortex-M4. It ends with status 0 if all came
//! out right, else with 1 after their names.
#![no_std]
#![no_main]

use semihosting::{println, process};

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut failures = 0_u32;
    let count = tests_qemu::run(|name| {
        failures += 1;
        println!("wrong: {name}");
    });
    println!("{count} vectors, {failures} wrong");
    process::exit(i32::from(failures > 0))
}
