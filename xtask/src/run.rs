use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Why a verb did not do its work.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line is wrong.
    Usage(String),
    /// The machine lacks something; each line says what, and how to get it.
    Missing(Vec<String>),
    /// A step failed and has said why on its own.
    Step(String),
}

impl Failure {
    /// Says what is wrong. 2 for what the user has to change, 1 for what failed.
    pub(crate) fn report(&self) -> ExitCode {
        match self {
            Self::Usage(reason) => {
                eprintln!("xtask: {reason}");
                ExitCode::from(2)
            }
            Self::Missing(lines) => {
                for line in lines {
                    eprintln!("xtask: {line}");
                }
                ExitCode::from(2)
            }
            Self::Step(what) => {
                eprintln!("xtask: failed: {what}");
                ExitCode::FAILURE
            }
        }
    }
}

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR"));
    manifest.parent().unwrap_or(manifest).to_owned()
}

/// Where cargo puts what it builds.
pub(crate) fn target_dir() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(dir) => root().join(dir),
        None => root().join("target"),
    }
}

/// The cargo that runs this program, in the root of the workspace.
pub(crate) fn cargo<S: AsRef<OsStr>>(arguments: impl IntoIterator<Item = S>) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(arguments);
    command
}

/// Runs `command` to its end and shows what is run.
pub(crate) fn step(command: &mut Command) -> Result<(), Failure> {
    let line = line_of(command);
    eprintln!("\n--- {line}");
    let status = command.status().map_err(|e| Failure::Step(format!("{line}: {e}")))?;
    if status.success() { Ok(()) } else { Err(Failure::Step(format!("{line} ({status})"))) }
}

fn line_of(command: &Command) -> String {
    let program = Path::new(command.get_program()).file_name().unwrap_or_default();
    let words = std::iter::once(program).chain(command.get_args());
    words.map(|word| word.to_string_lossy()).collect::<Vec<_>>().join(" ")
}
