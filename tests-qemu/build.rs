//! Hands the linker the memory map of the emulated board, for the program that runs on it.

use std::env;

fn main() {
    println!("cargo::rerun-if-changed=qemu.x");
    let on_board = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if let (true, Ok(folder)) = (on_board, env::var("CARGO_MANIFEST_DIR")) {
        println!("cargo::rustc-link-arg-bin=vectors=-T{folder}/qemu.x");
    }
}
