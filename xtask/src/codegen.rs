//! Files that are made from the dictionaries, committed, and compared by a test.

mod eds;
mod handbook;

use std::fs;
use std::path::PathBuf;

use profiles::SHEETS;

use crate::run::{self, Failure};

/// Writes what has changed.
pub(crate) fn write() -> Result<(), Failure> {
    for (path, wanted) in files() {
        let failed = |e: std::io::Error| Failure::Step(format!("{}: {e}", path.display()));
        if fs::read_to_string(&path).is_ok_and(|found| found == wanted) {
            continue;
        }
        if let Some(directory) = path.parent() {
            fs::create_dir_all(directory).map_err(failed)?;
        }
        fs::write(&path, wanted).map_err(failed)?;
        println!("{}", path.display());
    }
    Ok(())
}

/// Path and contents of each generated file.
fn files() -> impl Iterator<Item = (PathBuf, String)> {
    SHEETS.iter().flat_map(|sheet| {
        let page = run::root().join("docs/od").join(sheet.file.to_lowercase());
        let eds = run::root().join("eds").join(sheet.file);
        [
            (page.with_extension("md"), handbook::page(sheet)),
            (eds.with_extension("eds"), eds::file(sheet)),
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generated_files_are_up_to_date() {
        for (path, wanted) in files() {
            let found = fs::read_to_string(&path).unwrap_or_default();
            assert!(found == wanted, "{} is stale: run `cargo xtask codegen`", path.display());
        }
    }
}
