//! Finds the images to run: cargo builds them, so that no run can use a stale one.
use std::path::PathBuf;
use std::process::Command;

use world::EngineError;

use crate::Firmware;

/// The target the images are built for.
const TARGET: &str = "thumbv7em-none-eabihf";

/// Builds binary `bin` of `package` in release and reads it. Cargo decides whether anything is
/// left to do; both the cargo and the target directory are those of the calling process.
///
/// # Errors
/// When cargo cannot be run, the image does not build, or it is no image for the part.
pub fn build(package: &str, bin: &str) -> Result<Firmware, EngineError> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let output = Command::new(&cargo)
        .current_dir(&workspace)
        .args(["build", "--quiet", "--release", "--package", package, "--bin", bin])
        .args(["--target", TARGET])
        .output()
        .map_err(|error| EngineError(format!("cargo cannot be run: {error}")))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        return Err(EngineError(format!("{bin} does not build:\n{said}")));
    }
    let target_dir = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| workspace.join("target"), PathBuf::from);
    Firmware::read(&target_dir.join(TARGET).join("release").join(bin))
}
