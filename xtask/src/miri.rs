//! The tests of what takes bytes from outside, under an interpreter that sees undefined behaviour.

use std::process::Command;

use crate::run::{self, Failure};
use crate::tools::{self, NIGHTLY, Tool};

/// Packages that are interpreted.
const PACKAGES: [&str; 3] = ["canopen", "object-dictionary", "shared-proto"];

/// Property tests try so many inputs: the interpreter is a thousand times slower than the machine.
const CASES: &str = "2";

/// Runs the tests of all [`PACKAGES`].
pub(crate) fn miri() -> Result<(), Failure> {
    tools::require(&[Tool::Miri])?;
    let packages = PACKAGES.iter().flat_map(|package| ["--package", package]);
    run::step(
        Command::new("rustup")
            .current_dir(run::root())
            .args(["run", NIGHTLY, "cargo", "miri", "test"])
            .args(packages)
            .env("PROPTEST_CASES", CASES)
            // Tests compare with files, and look for seeds that failed before.
            .env("MIRIFLAGS", "-Zmiri-disable-isolation"),
    )
}
