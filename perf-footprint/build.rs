//! Hands the linker the script of the start-up code.

fn main() {
    println!("cargo::rustc-link-arg-bins=-Tlink.x");
}
