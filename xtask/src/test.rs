//! Everything that has to pass before a change is done.

use std::fs;

use crate::images::{self, TARGET};
use crate::run::{self, Failure};
use crate::tools::{self, Tool};
use crate::{panics, python, qemu, stack, trace, up};

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
    stack::build_image()?;
    stack::check()?;
    panics::check()?;
    let bench = up::build_bench()?;
    run::step(
        run::cargo(["test"])
            .env("SPINDLE_BENCH", &bench)
            .env("SPINDLE_IMAGES", images::directory()),
    )?;
    qemu::test()?;
    python::test(&bench)?;
    eprintln!("\nxtask: everything passed");
    Ok(())
}

/// Packages that exist for the controllers only: `cargo` leaves them out unless they are named.
fn firmware() -> Result<Vec<String>, Failure> {
    let root = run::root();
    let failed = |e: std::io::Error| Failure::Step(format!("{}: {e}", root.display()));
    let mut packages = Vec::new();
    for entry in fs::read_dir(&root).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name().to_string_lossy().into_owned();
        if name.starts_with("firmware-") {
            packages.push(name);
        }
    }
    packages.sort();
    Ok(packages)
}

fn lint() -> Result<(), Failure> {
    run::step(&mut run::cargo(["clippy", "--all-targets", "--", "-D", "warnings"]))?;
    for package in &firmware()? {
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
    )?;
    for package in [
        ["perf-dev1", "--features", "image,peers", "--bins"].as_slice(),
        &["perf-footprint", "--features", "image", "--bins"],
    ] {
        run::step(
            run::cargo(["clippy", "--target", TARGET, "--package"])
                .args(package)
                .args(["--", "-D", "warnings"]),
        )?;
    }
    Ok(())
}

fn document() -> Result<(), Failure> {
    let flags = ("RUSTDOCFLAGS", "-D warnings");
    run::step(run::cargo(["doc", "--no-deps"]).env(flags.0, flags.1))?;
    for package in &firmware()? {
        let arguments = ["doc", "--no-deps", "--lib", "--target", TARGET, "--package", package];
        run::step(run::cargo(arguments).env(flags.0, flags.1))?;
    }
    Ok(())
}
