//! Hands the linker the memory map of the emulated board, for the programs that run on it, and
//! lets zencan write its dictionary.

use std::env;

/// The map that the golden vectors use too.
const SCRIPT: &str = "../tests-qemu/qemu.x";

fn main() {
    println!("cargo::rerun-if-changed={SCRIPT}");
    let on_board = env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "none");
    if let (true, Ok(folder)) = (on_board, env::var("CARGO_MANIFEST_DIR")) {
        println!("cargo::rustc-link-arg-bins=-T{folder}/{SCRIPT}");
    }
    write_zencan_dictionary();
}

#[cfg(feature = "peers")]
fn write_zencan_dictionary() {
    println!("cargo::rerun-if-changed=zencan.toml");
    if let Err(e) = zencan_build::build_node_from_device_config("DEV1", "zencan.toml") {
        panic!("zencan.toml: {e}");
    }
}

#[cfg(not(feature = "peers"))]
const fn write_zencan_dictionary() {}
