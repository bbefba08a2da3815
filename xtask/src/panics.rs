//! The logic cannot panic: no call in an image leads from it to a panic, whether directly or
//! through the libraries it uses.
//!
//! Calls are read from the machine code, and where they were written from the debug information, so
//! that inlined functions count for the crate they are of. Calls through pointers are not followed.

mod thumb;

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use addr2line::gimli;
use object::{Object, ObjectSection, ObjectSymbol, SymbolKind};

use crate::images::{self, Controller};
use crate::run::{self, Failure};

/// Where the sources of the logic are. `storage` is not among them: the library it stands on asserts
/// what it reads back from flash, and `async` code has a panic for being asked again at its end.
const LOGIC: &[&str] = &[
    "crates/application",
    "crates/canopen",
    "crates/interface",
    "crates/lcd",
    "crates/object-dictionary",
    "crates/positioning",
    "crates/profiles",
    "crates/units",
    "shared-proto",
];

/// What every panic ends in.
const PANICS: &[&str] = &["core::panicking::", "__rustc::rust_begin_unwind"];

type Reader<'a> = gimli::EndianSlice<'a, gimli::LittleEndian>;

/// A function of an image.
struct Function {
    name: String,
    /// The addresses it calls or jumps to, and from where.
    calls: Vec<thumb::Call>,
}

/// Builds every image and looks at it.
pub(crate) fn panics() -> Result<(), Failure> {
    for product in images::PRODUCTS {
        images::build(product)?;
    }
    check()
}

/// Fails with all calls that lead from the logic to a panic, in the images that are built.
pub(crate) fn check() -> Result<(), Failure> {
    let mut found = BTreeSet::new();
    for product in images::PRODUCTS {
        for controller in Controller::BOTH {
            let path = controller.image(product);
            let calls = in_image(&path)
                .map_err(|error| Failure::Step(format!("{}: {error}", path.display())))?;
            let image = format!("{}-{product}", controller.name());
            found.extend(calls.into_iter().map(|call| format!("{image}: {call}")));
        }
    }
    if found.is_empty() {
        eprintln!("\n--- no call leads from the logic to a panic");
        return Ok(());
    }
    let list: Vec<String> = found.into_iter().collect();
    Err(Failure::Step(format!("the logic can panic\n{}", list.join("\n"))))
}

/// The calls that lead from the logic to a panic: where, in which function, and to what.
fn in_image(path: &Path) -> Result<BTreeSet<String>, Box<dyn std::error::Error>> {
    let bytes = fs::read(path)?;
    let file = object::File::parse(bytes.as_slice())?;
    let functions = functions(&file);
    let dwarf = gimli::DwarfSections::load(|id| section(&file, id.name()))?;
    let dwarf = dwarf.borrow(|bytes| gimli::EndianSlice::new(bytes, gimli::LittleEndian));
    let source = addr2line::Context::from_dwarf(dwarf)?;
    let places = Places { source, root: format!("{}/", run::root().display()) };
    if !functions.values().any(|function| is_panic(&function.name)) {
        return Err("has no panic at all: its symbols are not as expected".into());
    }
    let leading = leading_to_panic(&functions, &places)?;
    let mut found = BTreeSet::new();
    for call in functions.values().flat_map(|function| &function.calls) {
        let Some(callee) = functions.get(&call.to).filter(|_| leading.contains(&call.to)) else {
            continue;
        };
        if let Some(Place { path, line, function }) = places.of(call.at)?
            && LOGIC.iter().any(|folder| path.starts_with(folder))
        {
            found.insert(format!("{path}:{line}: {function} -> {}", callee.name));
        }
    }
    Ok(found)
}

/// The functions that panic, and those of libraries that call one that leads there. What the logic
/// or a shell calls is judged where it is written.
fn leading_to_panic(
    functions: &BTreeMap<u64, Function>,
    places: &Places<'_>,
) -> Result<BTreeSet<u64>, gimli::Error> {
    let mut leading: BTreeSet<u64> = BTreeSet::new();
    leading.extend(functions.iter().filter(|(_, f)| is_panic(&f.name)).map(|(&at, _)| at));
    loop {
        let mut more = Vec::new();
        for (&at, function) in functions.iter().filter(|(at, _)| !leading.contains(at)) {
            for call in function.calls.iter().filter(|call| leading.contains(&call.to)) {
                if places.of(call.at)?.is_none() {
                    more.push(at);
                }
            }
        }
        if more.is_empty() {
            return Ok(leading);
        }
        leading.extend(more);
    }
}

fn is_panic(name: &str) -> bool {
    PANICS.iter().any(|start| name.starts_with(start))
}

/// All functions with their calls, by address.
fn functions(file: &object::File<'_>) -> BTreeMap<u64, Function> {
    let marks = marks(file);
    let mut functions = BTreeMap::new();
    for symbol in file.symbols().filter(|symbol| symbol.kind() == SymbolKind::Text) {
        let (Some(section), Ok(name)) = (symbol.section_index(), symbol.name()) else { continue };
        let Ok(section) = file.section_by_index(section) else { continue };
        let at = symbol.address() & !1;
        let Ok(Some(code)) = section.data_range(at, symbol.size()) else { continue };
        let is_code = |at: u64| marks.range(..=at).next_back().is_none_or(|(_, code)| *code);
        let name = format!("{:#}", rustc_demangle::demangle(name));
        functions.insert(at, Function { name, calls: thumb::calls(code, at, is_code) });
    }
    functions
}

/// From where on there is code, and from where on data (the mapping symbols of the ARM ABI).
fn marks(file: &object::File<'_>) -> BTreeMap<u64, bool> {
    let mark = |symbol: object::Symbol<'_, '_>| match symbol.name().ok()?.get(..2)? {
        "$t" => Some((symbol.address() & !1, true)),
        "$d" => Some((symbol.address(), false)),
        _ => None,
    };
    file.symbols().filter_map(mark).collect()
}

fn section<'a>(file: &object::File<'a>, name: &str) -> Result<Cow<'a, [u8]>, object::Error> {
    match file.section_by_name(name) {
        Some(section) => section.uncompressed_data(),
        None => Ok(Cow::Borrowed(&[])),
    }
}

/// Where code was written.
struct Places<'a> {
    source: addr2line::Context<Reader<'a>>,
    /// The folder of the workspace, with a slash.
    root: String,
}

/// A place in the sources of the workspace.
struct Place {
    path: String,
    line: u32,
    function: String,
}

impl Places<'_> {
    /// The innermost of the inlined functions at `address` that is written in the workspace.
    fn of(&self, address: u64) -> Result<Option<Place>, gimli::Error> {
        let mut frames = self.source.find_frames(address).skip_all_loads()?;
        while let Some(frame) = frames.next()? {
            let Some(location) = frame.location else { continue };
            let path = location.file.and_then(|file| file.strip_prefix(self.root.as_str()));
            let function = frame.function.as_ref().and_then(|name| name.demangle().ok());
            if let (Some(path), Some(function)) = (path, function) {
                let line = location.line.unwrap_or(0);
                let (path, function) = (path.to_owned(), function.into_owned());
                return Ok(Some(Place { path, line, function }));
            }
        }
        Ok(None)
    }
}
