//! Hands the linker the memory map of the emulated board, for the programs that run on it.

use std::env;

/// The map that the golden vectors use too.
const SCRIPT: &str = "../tests-qemu/qemu.x";

fn main() {
    println!("cargo::rerun-if-changed={SCRIPT}");
    let on_board = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if let (true, Ok(folder)) = (on_board, env::var("CARGO_MANIFEST_DIR")) {
        println!("cargo::rustc-link-arg-bins=-T{folder}/{SCRIPT}");
    }
}
