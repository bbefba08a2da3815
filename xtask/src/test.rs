//! Everything that has to pass before a change is done.

use crate::images::{self, TARGET};
use crate::run::{self, Failure};
use crate::tools::{self, Tool};
use crate::{python, qemu, trace, up};

/// Packages that exist for the controllers only.
const FIRMWARE: &[&str] = &["firmware-board", "firmware-msp", "firmware-stm"];

/// Style first, because it is cheap; then what takes longer and longer.
pub(crate) fn test() -> Result<(), Failure> {
    tools::require(&[Tool::ThumbTarget, Tool::Qemu, Tool::PythonVenv])?;
    trace::check()?;
    run::step(&mut run::cargo(["fmt", "--all", "--check"]))?;
    lint()?;
    document()?;
    for product in images::PRODUCTS {
        images::build(product)?;
    }
    let bench = up::build_bench()?;
    run::step(&mut run::cargo(["test"]))?;
    qemu::test()?;
    python::test(&bench)?;
    eprintln!("\nxtask: everything passed");
    Ok(())
}

fn lint() -> Result<(), Failure> {
    run::step(&mut run::cargo(["clippy", "--all-targets", "--", "-D", "warnings"]))?;
    for package in FIRMWARE {
        run::step(&mut run::cargo([
            "clippy",
            "--package",
            package,
            "--target",
            TARGET,
            "--",
            "-D",
            "warnings",
        ]))?;
    }
    let vectors = ["--package", "tests-qemu", "--features", "image", "--bin", "vectors"];
    run::step(
        run::cargo(["clippy", "--target", TARGET]).args(vectors).args(["--", "-D", "warnings"]),
    )
}

fn document() -> Result<(), Failure> {
    let flags = ("RUSTDOCFLAGS", "-D warnings");
    run::step(run::cargo(["doc", "--no-deps"]).env(flags.0, flags.1))?;
    for package in FIRMWARE {
        let arguments = ["doc", "--no-deps", "--lib", "--package", package, "--target", TARGET];
        run::step(run::cargo(arguments).env(flags.0, flags.1))?;
    }
    Ok(())
}
