//! The tests that let a CANopen master written by others work with the device.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::images;
use crate::run::{self, Failure};

/// Runs the tests in an environment of their own, with the versions that are written down.
pub(crate) fn test(bench: &Path) -> Result<(), Failure> {
    let tests = run::root().join("tests-host").join("python");
    let environment = run::target_dir().join("python");
    let python = environment.join("bin").join("python");
    install(&tests.join("requirements.txt"), &environment, &python)?;
    run::step(
        Command::new(&python)
            .current_dir(run::root())
            .args(["-m", "pytest", "-p", "no:cacheprovider"])
            .arg(&tests)
            .env("SPINDLE_BENCH", bench)
            .env("SPINDLE_IMAGES", images::directory())
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}

fn install(requirements: &Path, environment: &Path, python: &Path) -> Result<(), Failure> {
    let wanted = fs::read_to_string(requirements)
        .map_err(|e| Failure::Step(format!("{}: {e}", requirements.display())))?;
    let installed = environment.join("installed.txt");
    if fs::read_to_string(&installed).is_ok_and(|found| found == wanted) {
        return Ok(());
    }
    run::step(Command::new("python3").args(["-m", "venv", "--clear"]).arg(environment))?;
    run::step(Command::new(python).args(["-m", "pip", "install", "-q", "-r"]).arg(requirements))?;
    fs::write(&installed, wanted)
        .map_err(|e| Failure::Step(format!("{}: {e}", installed.display())))
}
