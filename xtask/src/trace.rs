//! Which requirement is shown by which test.
//!
//! `docs/requirements/PRODUCT.csv` lists the requirements of a product. A test names those it shows
//! in its documentation, as in `NM17x POS-04, POS-05` or `NM17x BOOT-01 to BOOT-03`. A requirement
//! marked `done` that no test names is an error, and so is a name that no list has.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::run::{self, Failure};

/// One line of a list.
struct Requirement {
    id: String,
    line: String,
    done: bool,
}

/// Prints the matrix of every product and fails when it has holes.
pub(crate) fn trace() -> Result<(), Failure> {
    judge(Print::Matrix)
}

/// Fails when a matrix has holes.
pub(crate) fn check() -> Result<(), Failure> {
    judge(Print::Summary)
}

/// How much is printed.
#[derive(Clone, Copy)]
enum Print {
    Summary,
    Matrix,
}

fn judge(print: Print) -> Result<(), Failure> {
    let root = run::root();
    let mut sources = Vec::new();
    for folder in source_folders(&root)? {
        collect(&folder, &mut sources)?;
    }
    sources.sort();
    let mut holes = Vec::new();
    for list in lists(&root)? {
        let product = list.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let requirements = parse(&read(&list)?).map_err(|line| {
            Failure::Step(format!("{}: not a requirement: {line}", list.display()))
        })?;
        let mut shown = BTreeMap::<String, Vec<String>>::new();
        for source in &sources {
            let file = source.strip_prefix(&root).unwrap_or(source).display().to_string();
            for id in named(&test_code(source, &read(source)?), &product) {
                shown.entry(id).or_default().push(file.clone());
            }
        }
        let mut out = std::io::stdout().lock();
        let text = match print {
            Print::Summary => summary(&product, &requirements),
            Print::Matrix => summary(&product, &requirements) + &matrix(&requirements, &shown),
        };
        // A reader who has seen enough closes the pipe.
        let _ = out.write_all(text.as_bytes());
        holes.extend(holes_in(&product, &requirements, &shown));
    }
    if holes.is_empty() { Ok(()) } else { Err(Failure::Step(holes.join("; "))) }
}

fn summary(product: &str, requirements: &[Requirement]) -> String {
    let done = requirements.iter().filter(|requirement| requirement.done).count();
    format!("{product}: {done} of {} requirements done\n", requirements.len())
}

fn matrix(requirements: &[Requirement], shown: &BTreeMap<String, Vec<String>>) -> String {
    let mut text = String::new();
    for Requirement { id, line, done } in requirements {
        let state = if *done { "done" } else { "open" };
        text += &format!("  {state}  {id:<11}  {line}");
        if let Some(files) = shown.get(id) {
            text += &format!("  <- {}", files.join(", "));
        }
        text.push('\n');
    }
    text
}

/// What a list and the tests contradict each other in.
fn holes_in(
    product: &str,
    requirements: &[Requirement],
    shown: &BTreeMap<String, Vec<String>>,
) -> Vec<String> {
    let known: BTreeSet<&str> = requirements.iter().map(|r| r.id.as_str()).collect();
    let unshown = requirements
        .iter()
        .filter(|requirement| requirement.done && !shown.contains_key(&requirement.id))
        .map(|requirement| format!("{product} {} is done and no test names it", requirement.id));
    let unknown = shown
        .iter()
        .filter(|(id, _)| !known.contains(id.as_str()))
        .map(|(id, files)| format!("{product} {id} is not in the list ({})", files.join(", ")));
    unshown.chain(unknown).collect()
}

/// The folders of the workspace that hold sources, one level deep and below `crates`.
fn source_folders(root: &Path) -> Result<Vec<PathBuf>, Failure> {
    let target = run::target_dir();
    let skipped = |path: &Path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        path == target || name.starts_with('.') || name == "target" || name == "docs"
    };
    Ok(entries(root)?.into_iter().filter(|path| path.is_dir() && !skipped(path)).collect())
}

fn lists(root: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut lists = entries(&root.join("docs").join("requirements"))?;
    lists.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    lists.sort();
    Ok(lists)
}

fn collect(folder: &Path, sources: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for path in entries(folder)? {
        if path.is_dir() {
            collect(&path, sources)?;
        } else if path.extension().is_some_and(|extension| extension == "rs" || extension == "py") {
            sources.push(path);
        }
    }
    Ok(())
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |e: std::io::Error| Failure::Step(format!("{}: {e}", folder.display()));
    fs::read_dir(folder).map_err(failed)?.map(|entry| Ok(entry.map_err(failed)?.path())).collect()
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|e| Failure::Step(format!("{}: {e}", path.display())))
}

/// `id,section,line,state`; a field with commas is in quotes. The line that is not, on failure.
fn parse(list: &str) -> Result<Vec<Requirement>, String> {
    let mut lines = list.lines();
    if lines.next() != Some("id,section,line,state") {
        return Err("the header has to be id,section,line,state".to_owned());
    }
    lines
        .map(|text| match fields(text).as_slice() {
            [id, _section, line, state] if !id.is_empty() && !line.is_empty() => {
                let done = match state.as_str() {
                    "done" => true,
                    "open" => false,
                    _ => return Err(text.to_owned()),
                };
                Ok(Requirement { id: id.clone(), line: line.clone(), done })
            }
            _ => Err(text.to_owned()),
        })
        .collect()
}

fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => {
                if let Some(field) = fields.last_mut() {
                    field.push(c);
                }
            }
        }
    }
    fields
}

/// The part of a source that is test code: all of a test program, the test module of a library.
fn test_code(path: &Path, text: &str) -> String {
    let is_test_program = path.components().any(|component| {
        let name = component.as_os_str().to_string_lossy();
        name == "tests" || name.starts_with("tests-")
    });
    match (is_test_program, text.find("#[cfg(test)]\nmod ")) {
        (true, _) => text.to_owned(),
        (false, Some(start)) => text.get(start..).unwrap_or_default().to_owned(),
        (false, None) => String::new(),
    }
}

/// The requirements of `product` that `code` names, in comments or strings.
fn named(code: &str, product: &str) -> BTreeSet<String> {
    let words: Vec<&str> = code
        .lines()
        .map(|line| line.trim().trim_start_matches(['/', '!', '#']))
        .flat_map(str::split_whitespace)
        .collect();
    let mut found = BTreeSet::new();
    let mut rest = words.as_slice();
    while let [word, tail @ ..] = rest {
        rest = tail;
        let opening = word.trim_start_matches(|c: char| !c.is_alphanumeric());
        if opening.eq_ignore_ascii_case(product) {
            rest = take_ids(tail, &mut found);
        }
    }
    found
}

/// Reads `A-1, A-2 and A-3`, `A-1 to A-3`; what is left begins behind the last of them.
fn take_ids<'a>(mut words: &'a [&'a str], found: &mut BTreeSet<String>) -> &'a [&'a str] {
    let mut last: Option<String> = None;
    let mut range = false;
    while let [word, tail @ ..] = words {
        match (*word, &last) {
            ("and", Some(_)) => {}
            ("to", Some(_)) => range = true,
            _ => {
                let Some((id, behind)) = id_in(word) else { break };
                if let (true, Some(first)) = (range, &last) {
                    found.extend(between(first, &id));
                }
                range = false;
                if is_requirement(&id) {
                    found.insert(id.clone());
                }
                last = Some(id);
                if !matches!(behind, "" | ",") {
                    return tail;
                }
            }
        }
        words = tail;
    }
    words
}

/// Whether an ID is one of a requirement. Decisions (`A-54`) and telegrams (`V-SDO-4`, `D-03`) may
/// be named along with them.
fn is_requirement(id: &str) -> bool {
    id.split('-').next().is_some_and(|group| group.len() >= 2)
}

/// `POS-04`, `OD-2000-1` or `V-SDO-4` at the start of a word, and what follows it.
fn id_in(word: &str) -> Option<(String, &str)> {
    let end = word
        .find(|c: char| !c.is_ascii_uppercase() && !c.is_ascii_digit() && c != '-')
        .unwrap_or(word.len());
    let (id, behind) = word.split_at(end);
    let (group, number) = id.rsplit_once('-')?;
    let is_id = group.starts_with(|c: char| c.is_ascii_uppercase())
        && !number.is_empty()
        && number.bytes().all(|digit| digit.is_ascii_digit());
    is_id.then(|| (id.to_owned(), behind))
}

/// The requirements after `first` up to `last`, if both belong to one group.
fn between(first: &str, last: &str) -> Vec<String> {
    let (Some((group, from)), Some((other, to))) = (first.rsplit_once('-'), last.rsplit_once('-'))
    else {
        return Vec::new();
    };
    match (from.parse::<u32>(), to.parse::<u32>()) {
        (Ok(low), Ok(high)) if group == other && low < high => {
            (low..high).map(|n| format!("{group}-{n:0width$}", width = from.len())).collect()
        }
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_found_where_a_test_names_them() {
        for (code, expected) in [
            ("/// QX9 POS-04: rounds.", "POS-04"),
            ("/// Rounds (QX9 POS-04, POS-05; A-54).", "POS-04 POS-05"),
            ("//! QX9 LINK-02 and LINK-03 travel", "LINK-02 LINK-03"),
            ("/// qx9 BOOT-01 to BOOT-03, BOOT-09.", "BOOT-01 BOOT-02 BOOT-03 BOOT-09"),
            ("/// QX9 POS-04,\n    /// OD-2000-1, OD-1F80-1", "OD-1F80-1 OD-2000-1 POS-04"),
            ("def test(): \"\"\"QX9 SDO-01\"\"\"", "SDO-01"),
            ("# QX9 SDO-01 SDO-02", "SDO-01 SDO-02"),
            ("/// POS-04 of another product", ""),
            ("/// QX9 decision A-54", ""),
            ("/// QX9 POS-04, A-54, V-SDO-4 and D-03; POS-05", "POS-04"),
            ("/// QX9 V-SDO-1, SDO-10", "SDO-10"),
        ] {
            let found: Vec<_> = named(code, "qx9").into_iter().collect();
            assert_eq!(found.join(" "), expected, "{code}");
        }
    }

    #[test]
    fn only_test_code_counts() {
        let text = "/// QX9 POS-01\nfn a() {}\n#[cfg(test)]\nmod tests {\n/// QX9 POS-02\n}";
        let ids = |path: &str| named(&test_code(Path::new(path), text), "qx9").len();
        assert_eq!(ids("crates/units/src/lib.rs"), 1);
        assert_eq!(ids("crates/units/tests/all.rs"), 2);
        assert_eq!(ids("tests-host/src/lib.rs"), 2);
        assert!(test_code(Path::new("crates/units/src/lib.rs"), "fn a() {}").is_empty());
    }

    #[test]
    fn a_list_is_read_or_refused() {
        let list = "id,section,line,state\nPOS-01,3.2,\"First this, then that\",done\n";
        let parsed = parse(list).ok().unwrap();
        let [requirement] = parsed.as_slice() else { panic!("one requirement") };
        assert_eq!(requirement.line, "First this, then that");
        assert!(requirement.done);
        for bad in ["POS-01,3.2,done", "POS-01,3.2,Line,maybe", ",3.2,Line,open", ""] {
            let list = format!("id,section,line,state\n{bad}\n");
            assert_eq!(parse(&list).err().as_deref(), Some(bad));
        }
    }
}
