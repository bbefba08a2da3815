//! Looks for inputs that break a rule, for longer than the tests do.

use std::fs;

use crate::run::{self, Failure};
use crate::tools::{self, Tool};

/// How long one target runs.
const MINUTES: u32 = 10;

/// Longest input, in bytes.
const LEN_MAX: u32 = 1_500;

/// `[TARGET] [--minutes N]`. What is found is left in `fuzz/artifacts`; put into `fuzz/seeds` it is
/// replayed by the tests.
pub(crate) fn fuzz(arguments: &[&str]) -> Result<(), Failure> {
    let (target, minutes) = match *arguments {
        [] => (None, MINUTES),
        ["--minutes", minutes] => (None, number(minutes)?),
        [target] => (Some(target), MINUTES),
        [target, "--minutes", minutes] => (Some(target), number(minutes)?),
        _ => {
            return Err(Failure::Usage(
                "what is understood: fuzz [TARGET] [--minutes N]".to_owned(),
            ));
        }
    };
    let mut targets = targets()?;
    if let Some(wanted) = target {
        let known = targets.join(", ");
        targets.retain(|target| target == wanted);
        if targets.is_empty() {
            return Err(Failure::Usage(format!(
                "there is no target `{wanted}`; there is: {known}"
            )));
        }
    }
    tools::require(&[Tool::CargoFuzz])?;
    for target in &targets {
        let folder = |kind: &str| run::root().join("fuzz").join(kind).join(target);
        let (corpus, seeds) = (folder("corpus"), folder("seeds"));
        let failed = |e: std::io::Error| Failure::Step(format!("{}: {e}", corpus.display()));
        fs::create_dir_all(&corpus).map_err(failed)?;
        // Without a sanitizer the project's own compiler does, and there is nothing for one to
        // find: the code under test is safe.
        run::step(
            run::cargo(["fuzz", "run", "--sanitizer", "none", target]).args([corpus, seeds]).args(
                [
                    "--".to_owned(),
                    format!("-max_total_time={}", minutes * 60),
                    format!("-max_len={LEN_MAX}"),
                ],
            ),
        )?;
    }
    Ok(())
}

fn number(minutes: &str) -> Result<u32, Failure> {
    let number = minutes.parse().ok().filter(|minutes| (1..=1_440).contains(minutes));
    number.ok_or_else(|| Failure::Usage(format!("`{minutes}` is no number of minutes, 1 to 1440")))
}

fn targets() -> Result<Vec<String>, Failure> {
    let folder = run::root().join("fuzz").join("fuzz_targets");
    let failed = |e: std::io::Error| Failure::Step(format!("{}: {e}", folder.display()));
    let mut targets = Vec::new();
    for entry in fs::read_dir(&folder).map_err(failed)? {
        let name = entry.map_err(failed)?.file_name().to_string_lossy().into_owned();
        targets.extend(name.strip_suffix(".rs").map(str::to_owned));
    }
    targets.sort();
    Ok(targets)
}
