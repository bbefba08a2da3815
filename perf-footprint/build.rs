//! Hands the linker the script of the start-up code.

use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    // No interrupt has a handler of its own, so that there are no names to provide.
    let out = env::var_os("OUT_DIR").ok_or(io::ErrorKind::NotFound)?;
    fs::write(Path::new(&out).join("device.x"), "")?;
    println!("cargo::rustc-link-search={}", out.display());
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
    Ok(())
}
