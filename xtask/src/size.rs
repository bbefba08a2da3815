//! What the images take of flash and RAM, and who takes it.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SymbolKind, elf};

use crate::images::{self, Controller};
use crate::run::Failure;

/// How many crates of each image are printed.
const CRATES_SHOWN: usize = 12;

/// What a task is wrapped in by the executor. Its code is that of the crate it is written in, and
/// of all that was inlined into it.
const TASK: &str = "embassy_executor::raw::TaskStorage<";

/// Bytes of the parts of an image.
#[derive(Default)]
struct Size {
    /// Code and constants, in flash.
    text: u64,
    /// Initial values: in flash, and copied to RAM.
    data: u64,
    /// Zeroed or uninitialised RAM.
    bss: u64,
}

/// Builds every image and prints its figures.
pub(crate) fn size() -> Result<(), Failure> {
    for product in images::PRODUCTS {
        images::build(product)?;
    }
    println!("| image | text | data | bss | flash (text + data) | RAM (data + bss) |");
    println!("|---|---:|---:|---:|---:|---:|");
    for_each_image(|name, file| {
        let Size { text, data, bss } = sections(file);
        println!("| {name} | {text} | {data} | {bss} | {} | {} |", text + data, data + bss);
    })?;
    for_each_image(|name, file| {
        println!("\n{name}: bytes in flash by crate\n");
        let mut crates: Vec<_> = crates(file).into_iter().collect();
        crates.sort_by_key(|&(_, size)| std::cmp::Reverse(size));
        for (krate, size) in crates.iter().take(CRATES_SHOWN) {
            println!("{size:>8}  {krate}");
        }
        let rest: u64 = crates.iter().skip(CRATES_SHOWN).map(|&(_, size)| size).sum();
        println!("{rest:>8}  (all others)");
    })
}

/// Bytes in flash and RAM that a program takes.
pub(crate) fn flash_and_ram(image: &Path) -> Result<(u64, u64), Failure> {
    let bytes = fs::read(image).map_err(|e| unreadable(image, &e))?;
    let file = object::File::parse(bytes.as_slice()).map_err(|e| unreadable(image, &e))?;
    let Size { text, data, bss } = sections(&file);
    Ok((text + data, data + bss))
}

fn for_each_image(mut each: impl FnMut(&str, &object::File<'_>)) -> Result<(), Failure> {
    for product in images::PRODUCTS {
        for controller in Controller::BOTH {
            let path = controller.image(product);
            let failed = |e: &dyn std::fmt::Display| unreadable(&path, e);
            let bytes = fs::read(&path).map_err(|e| failed(&e))?;
            let file = object::File::parse(bytes.as_slice()).map_err(|e| failed(&e))?;
            each(&format!("{}-{product}", controller.name()), &file);
        }
    }
    Ok(())
}

fn unreadable(path: &Path, error: &dyn std::fmt::Display) -> Failure {
    Failure::Step(format!("{}: {error}", path.display()))
}

/// Sections the program occupies; the log strings of defmt are in the file only.
fn sections(file: &object::File<'_>) -> Size {
    let mut size = Size::default();
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        if sh_flags & u64::from(elf::SHF_ALLOC) == 0 {
            continue;
        }
        let in_file = section.file_range().is_some_and(|(_, len)| len > 0);
        let part = match (in_file, sh_flags & u64::from(elf::SHF_WRITE) != 0) {
            (true, false) => &mut size.text,
            (true, true) => &mut size.data,
            (false, _) => &mut size.bss,
        };
        *part += section.size();
    }
    size
}

/// Bytes of all symbols in flash, by the crate that their name begins with. Code that was inlined
/// counts for the crate it was inlined into.
fn crates(file: &object::File<'_>) -> BTreeMap<String, u64> {
    let mut sizes = BTreeMap::new();
    for symbol in file.symbols() {
        let in_flash = (0x0800_0000..0x0900_0000).contains(&symbol.address());
        let occupies = matches!(symbol.kind(), SymbolKind::Text | SymbolKind::Data);
        if let (true, true, Ok(name)) = (in_flash, occupies, symbol.name()) {
            *sizes.entry(crate_of(name)).or_default() += symbol.size();
        }
    }
    sizes
}

/// The crate a mangled name belongs to: of `<T as Trait>::f` that of `T`, if it is a named type.
fn crate_of(mangled: &str) -> String {
    let Ok(demangled) = rustc_demangle::try_demangle(mangled) else {
        return "(no Rust name)".to_owned();
    };
    let name = format!("{demangled:#}");
    let path = name.trim_start_matches(['<', '&', '*', '[', '(', ' ']);
    let path = path.trim_start_matches("mut ").trim_start_matches("const ");
    let path = path.strip_prefix(TASK).unwrap_or(path);
    let krate: String =
        path.chars().take_while(|&c| c.is_ascii_alphanumeric() || c == '_').collect();
    if path.get(krate.len()..).is_some_and(|rest| rest.starts_with("::")) {
        krate
    } else {
        "core".to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symbol_belongs_to_the_crate_of_its_type() {
        for (mangled, expected) in [
            ("_ZN7canopen3sdo6server17h0123456789abcdefE", "canopen"),
            ("_RNvNtCs1234_7mycrate3foo3bar", "mycrate"),
            ("_RNvXs_CsaB_3lcdNtB4_4ViewNtNtCsxy_4core3fmt5Debug3fmt", "lcd"),
            ("Reset", "(no Rust name)"),
        ] {
            assert_eq!(crate_of(mangled), expected, "{mangled}");
        }
    }
}
