//! Programs that run on the bench.

use std::path::PathBuf;
use std::process::Command;

use crate::images;
use crate::run::{self, Failure};
use crate::stack;

/// Builds the bench and says where it is.
pub(crate) fn build_bench() -> Result<PathBuf, Failure> {
    run::step(&mut run::cargo(["build", "--package", "bench"]))?;
    Ok(run::target_dir().join("debug").join("bench"))
}

/// Builds everything a product needs and becomes its bench: same terminal, same exit code.
pub(crate) fn up(arguments: &[&str]) -> Result<(), Failure> {
    let Some(name) = arguments.first().filter(|first| !first.starts_with('-')) else {
        return Err(Failure::Usage("which product? Try: cargo xtask up nm172".to_owned()));
    };
    if *name == stack::DEV1 {
        stack::build_image()?;
    } else if !names_twin(arguments) {
        images::build(images::product(name)?)?;
    }
    let bench = build_bench()?;
    become_program(Command::new(bench).arg("up").args(arguments))
}

/// Whether the devices are made without images.
fn names_twin(arguments: &[&str]) -> bool {
    arguments.contains(&"--engine=twin")
        || arguments.windows(2).any(|pair| pair == ["--engine", "twin"])
}

/// Builds the images and runs the measuring program on them.
pub(crate) fn perf() -> Result<(), Failure> {
    for product in images::PRODUCTS {
        images::build(product)?;
    }
    let bench = build_bench()?;
    become_program(
        run::cargo(["run", "--quiet", "--package", "tests-host", "--bin", "perf"])
            .env("SPINDLE_BENCH", bench)
            .env("SPINDLE_IMAGES", images::directory()),
    )
}

#[cfg(unix)]
fn become_program(command: &mut Command) -> Result<(), Failure> {
    use std::os::unix::process::CommandExt;
    let error = command.exec();
    Err(Failure::Step(format!("{}: {error}", command.get_program().to_string_lossy())))
}

#[cfg(not(unix))]
fn become_program(command: &mut Command) -> Result<(), Failure> {
    match command.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => {
            Err(Failure::Step(format!("{}: {error}", command.get_program().to_string_lossy())))
        }
    }
}
