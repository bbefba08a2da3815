use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The processor of both boards.
const TARGET: &str = "thumbv7em-none-eabihf";

/// The directory with the firmware images of all products: `SPINDLE_IMAGES` if that is set, else
/// built once per test program.
///
/// # Panics
/// If they cannot be built.
pub fn images() -> &'static Path {
    static IMAGES: OnceLock<PathBuf> = OnceLock::new();
    IMAGES.get_or_init(|| {
        if let Some(built) = std::env::var_os("SPINDLE_IMAGES") {
            return built.into();
        }
        // One at a time: together their features would be unified.
        for package in ["firmware-stm", "firmware-msp"] {
            cargo(&["build", "--release", "--package", package, "--target", TARGET]);
        }
        target_dir().join(TARGET).join("release")
    })
}

/// The bench: `SPINDLE_BENCH` if that is set, else built once per test program.
///
/// # Panics
/// If it cannot be built.
pub fn bench_program() -> &'static Path {
    static BENCH: OnceLock<PathBuf> = OnceLock::new();
    BENCH.get_or_init(|| {
        if let Some(built) = std::env::var_os("SPINDLE_BENCH") {
            return built.into();
        }
        cargo(&["build", "--package", "bench"]);
        target_dir().join("debug").join("bench")
    })
}

/// The root of the workspace.
pub(crate) fn root() -> &'static Path {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().expect("the package lies in the workspace")
}

fn target_dir() -> PathBuf {
    root().join(std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()))
}

fn cargo(arguments: &[&str]) {
    let built = Command::new(env!("CARGO")).current_dir(root()).args(arguments).output();
    let built = built.unwrap_or_else(|e| panic!("cargo does not run: {e}"));
    let errors = String::from_utf8_lossy(&built.stderr);
    assert!(built.status.success(), "cargo {}:\n{errors}", arguments.join(" "));
}
