//! What has to be installed, how that is found out, and what to type when it is not.

use std::process::{Command, Stdio};

use crate::images::TARGET;
use crate::run::Failure;

/// The compiler that has Miri; everything else is done with the one of `rust-toolchain.toml`.
pub(crate) const NIGHTLY: &str = "nightly-2026-10-30";

/// A program or component that cargo does not fetch on its own.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tool {
    /// The standard library for the controllers.
    ThumbTarget,
    /// An emulated Cortex-M4.
    Qemu,
    /// Python's own means to install packages apart from the system's.
    PythonVenv,
    /// Counts instructions on the host.
    Valgrind,
    /// Writes to the boards.
    ProbeRs,
    /// Runs the fuzz targets.
    CargoFuzz,
    /// Interprets tests.
    Miri,
}

impl Tool {
    fn is_there(self) -> bool {
        match self {
            Self::ThumbTarget => Command::new("rustc")
                .args(["--print", "target-libdir", "--target", TARGET])
                .output()
                .ok()
                .and_then(|output| String::from_utf8(output.stdout).ok())
                .is_some_and(|dir| std::path::Path::new(dir.trim()).is_dir()),
            Self::Qemu => runs("qemu-system-arm", &["--version"]),
            Self::PythonVenv => runs("python3", &["-c", "import venv, ensurepip"]),
            Self::Valgrind => runs("valgrind", &["--version"]),
            Self::ProbeRs => runs("probe-rs", &["--version"]),
            Self::CargoFuzz => runs("cargo-fuzz", &["--version"]),
            Self::Miri => runs("rustup", &["run", NIGHTLY, "cargo", "miri", "--version"]),
        }
    }

    fn advice(self) -> &'static str {
        match self {
            Self::ThumbTarget => {
                "the standard library for the controllers is missing: rustup target add \
                 thumbv7em-none-eabihf"
            }
            Self::Qemu => "qemu-system-arm is missing: sudo apt-get install qemu-system-arm",
            Self::PythonVenv => {
                "python3 with the venv module is missing: sudo apt-get install python3-venv"
            }
            Self::Valgrind => "valgrind is missing: sudo apt-get install valgrind",
            Self::ProbeRs => {
                "probe-rs is missing: cargo install probe-rs-tools --locked (it needs: sudo \
                 apt-get install pkg-config libudev-dev)"
            }
            Self::CargoFuzz => "cargo-fuzz is missing: cargo install cargo-fuzz --locked",
            Self::Miri => {
                "Miri is missing: rustup toolchain install nightly-2026-10-30 --profile minimal \
                 --component miri,rust-src"
            }
        }
    }
}

/// Names every tool that is missing, all at once.
pub(crate) fn require(tools: &[Tool]) -> Result<(), Failure> {
    let missing: Vec<String> =
        tools.iter().filter(|tool| !tool.is_there()).map(|tool| tool.advice().to_owned()).collect();
    if missing.is_empty() { Ok(()) } else { Err(Failure::Missing(missing)) }
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    Command::new(program)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}
