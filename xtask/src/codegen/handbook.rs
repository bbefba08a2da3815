//! The objects of a product as a page for people.

use std::fmt::Write as _;

use object_dictionary::{
    Access, DataType, Default, Limits, Owner, PdoMapping, Row, Storage, Unit, WriteState,
};
use profiles::Sheet;

/// Objects of CiA 301 itself: their 32-bit numbers are bits, not amounts.
const COMMUNICATION: std::ops::RangeInclusive<u16> = 0x1000..=0x1FFF;

/// How numbers of an object are printed.
#[derive(Clone, Copy)]
enum Radix {
    Decimal,
    Hexadecimal,
}

/// The objects of a product as a table.
pub(super) fn page(sheet: &Sheet) -> String {
    let mut page = format!(
        "# Objects of the {}\n\nMade by `cargo xtask codegen` from `crates/profiles`.\n\n\
         | index | sub | name | type | access | default | values | stored | in PDOs | held by |\n\
         |---|---:|---|---|---|---|---|---|---|---|\n",
        sheet.name
    );
    for (row, text) in sheet.dictionary.rows().zip(sheet.texts) {
        let _ = writeln!(
            page,
            "| 0x{:04X} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            row.id().index,
            row.id().sub,
            text.name,
            type_name(row.data_type()),
            access(row),
            default(row),
            values(row, text.unit),
            stored(row.storage()),
            mapping(row.pdo()),
            holder(row.owner()),
        );
    }
    page
}

fn type_name(data_type: DataType) -> String {
    match data_type {
        DataType::Unsigned8 => "UNSIGNED8".into(),
        DataType::Unsigned16 => "UNSIGNED16".into(),
        DataType::Unsigned32 => "UNSIGNED32".into(),
        DataType::Integer8 => "INTEGER8".into(),
        DataType::Integer16 => "INTEGER16".into(),
        DataType::Integer32 => "INTEGER32".into(),
        DataType::VisibleString(len) => format!("VISIBLE_STRING, {len}"),
    }
}

/// With SDO, and the states in which it may be written when these are not all.
const fn access(row: Row) -> &'static str {
    match (row.access(), row.write_state()) {
        (Access::ReadOnly, _) => "ro",
        (Access::WriteOnly, WriteState::Any) => "wo",
        (Access::WriteOnly, WriteState::PreOperational) => "wo, Pre-operational",
        (Access::WriteOnly, WriteState::NotWithSdo) => "written by PDO only",
        (Access::ReadWrite, WriteState::Any) => "rw",
        (Access::ReadWrite, WriteState::PreOperational) => "rw, written in Pre-operational",
        (Access::ReadWrite, WriteState::NotWithSdo) => "ro, written by PDO only",
    }
}

fn default(row: Row) -> String {
    match (row.default(), row.access()) {
        (_, Access::WriteOnly) => String::new(),
        (Default::Text(text), _) => format!("`{text}`"),
        (Default::NodeIdPlus(base), _) => format!("0x{base:X} + node-ID"),
        (Default::Number(raw), _) => number(row.data_type().number(raw), radix(row)),
    }
}

/// What may be written, with the unit; nothing where all of the type may.
fn values(row: Row, unit: Unit) -> String {
    let Limits { min, max, also } = row.limits();
    let (lowest, highest) = row.data_type().span();
    let mut spans = Vec::new();
    if row.access() != Access::ReadOnly && (min, max) != (lowest, highest) {
        spans.push(span(min, max, radix(row)));
    }
    spans.extend(also.iter().map(|&(first, last)| span(first, last, radix(row))));
    [spans.join("; "), unit_name(unit).to_owned()].join(" ").trim().to_owned()
}

fn span(first: i64, last: i64, radix: Radix) -> String {
    let [first, last] = [first, last].map(|end| number(end, radix));
    if first == last { first } else { format!("{first} to {last}") }
}

fn radix(row: Row) -> Radix {
    if COMMUNICATION.contains(&row.id().index) && row.data_type() == DataType::Unsigned32 {
        Radix::Hexadecimal
    } else {
        Radix::Decimal
    }
}

fn number(value: i64, radix: Radix) -> String {
    match radix {
        Radix::Decimal => value.to_string(),
        Radix::Hexadecimal => format!("0x{value:X}"),
    }
}

const fn unit_name(unit: Unit) -> &'static str {
    match unit {
        Unit::None => "",
        Unit::HundredthMm => "(1/100 mm)",
        Unit::Millisecond => "(ms)",
        Unit::TenthSecond => "(0.1 s)",
        Unit::Second => "(s)",
        Unit::TenthHour => "(0.1 h)",
        Unit::SensorStep => "(steps)",
        Unit::ScalingFactor => "(1/10,000,000 of 1/100 mm per step)",
        Unit::Bit => "(bits)",
    }
}

const fn stored(storage: Storage) -> &'static str {
    match storage {
        Storage::Volatile => "",
        Storage::OnCommand => "on command",
        Storage::AtOnce => "at once",
    }
}

const fn mapping(pdo: PdoMapping) -> &'static str {
    match pdo {
        PdoMapping::No => "",
        PdoMapping::Transmit => "transmit",
        PdoMapping::Receive => "receive",
        PdoMapping::Both => "both",
    }
}

const fn holder(owner: Owner) -> &'static str {
    match owner {
        Owner::Interface => "interface",
        Owner::Application => "application",
    }
}
