//! Electronic data sheets (CiA 306-1, version 4).

use std::fmt::Write as _;

use object_dictionary::{
    Access, DataType, Default, Limits, Listing, ObjectId, PdoMapping, Row, Storage, Text,
    WriteState,
};
use profiles::{Lss, Sheet};

/// Bit rates that a data sheet can name, in kbit/s. There is no entry for 100 kbit/s.
const BIT_RATES: [u16; 8] = [10, 20, 50, 125, 250, 500, 800, 1000];

/// Objects that CiA 301 asks every device to have.
const MANDATORY: [u16; 3] = [0x1000, 0x1001, 0x1018];

/// Objects of CiA 301 that are arrays. All others with sub-indices are records.
const ARRAYS: [u16; 5] = [0x1003, 0x1010, 0x1011, 0x1016, 0x1029];

/// Entries 1 and up of these say what a PDO carries: index, sub-index, length in bits.
const PDO_MAPPINGS: [std::ops::RangeInclusive<u16>; 2] = [0x1600..=0x17FF, 0x1A00..=0x1BFF];

/// How the name of an object's sub-index 0 ends, which is the object's name otherwise.
const HIGHEST_SUB_INDEX: &str = " - highest sub-index";

/// One object: its rows with their names, sub-index 0 first.
type Entry<'a> = (Row, &'a Text);

/// What an object is made of (CiA 306-1, object code).
#[derive(Clone, Copy)]
enum Kind {
    Variable,
    Array,
    Record,
}

/// The data sheet of a product.
pub(super) fn file(sheet: &Sheet) -> String {
    let entries: Vec<Entry<'_>> = sheet
        .dictionary
        .rows()
        .zip(sheet.texts)
        .filter(|(_, text)| text.listing == Listing::Everywhere)
        .collect();
    let objects: Vec<&[Entry<'_>]> =
        entries.chunk_by(|(a, _), (b, _)| a.id().index == b.id().index).collect();
    let mut eds = String::new();
    about_the_file(&mut eds, sheet);
    about_the_device(&mut eds, sheet, &objects);
    for (section, in_section) in [
        ("MandatoryObjects", is_mandatory as fn(u16) -> bool),
        ("OptionalObjects", is_optional),
        ("ManufacturerObjects", is_manufacturer),
    ] {
        let listed = objects.iter().filter(|object| in_section(index(object)));
        let list: Vec<u16> = listed.clone().map(|object| index(object)).collect();
        let _ = writeln!(eds, "[{section}]\nSupportedObjects={}", list.len());
        for (number, index) in (1..).zip(&list) {
            let _ = writeln!(eds, "{number}=0x{index:04X}");
        }
        eds.push('\n');
        for object in listed {
            describe(&mut eds, sheet, object);
        }
    }
    eds
}

fn about_the_file(eds: &mut String, sheet: &Sheet) {
    let _ = write!(
        eds,
        "[FileInfo]\nFileName={}.eds\nFileVersion=1\nFileRevision=0\nEDSVersion=4.0\n\
         Description={}\nCreationTime=12:00AM\nCreationDate=01-01-2026\nCreatedBy=Spindle\n\
         ModificationTime=12:00AM\nModificationDate=01-01-2026\nModifiedBy=Spindle\n\n",
        sheet.file, sheet.name
    );
}

fn about_the_device(eds: &mut String, sheet: &Sheet, objects: &[&[Entry<'_>]]) {
    let identity = |sub| {
        let slot = sheet.dictionary.find(ObjectId { index: 0x1018, sub }).ok()?;
        sheet.dictionary.row(slot).map(|row| row.initial(0))
    };
    let _ = write!(eds, "[DeviceInfo]\nVendorName={}\n", sheet.vendor);
    for (key, sub) in [("VendorNumber", 1), ("ProductNumber", 2), ("RevisionNumber", 3)] {
        if let Some(number) = identity(sub) {
            let _ = writeln!(eds, "{key}=0x{number:X}");
        }
        if key == "VendorNumber" {
            let _ = writeln!(eds, "ProductName={}", sheet.name);
        }
    }
    let _ = writeln!(eds, "OrderCode={}", sheet.file);
    for rate in BIT_RATES {
        let supported = u8::from(sheet.bit_rates.contains(&rate));
        let _ = writeln!(eds, "BaudRate_{rate}={supported}");
    }
    let pdos = |area: std::ops::RangeInclusive<u16>| {
        objects.iter().filter(|object| area.contains(&index(object))).count()
    };
    let lss = match sheet.lss {
        Lss::None => 0,
        Lss::Slave => 1,
    };
    let _ = write!(
        eds,
        "SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=0\n\
         DynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO={}\nNrOfTXPDO={}\n\
         LSS_Supported={lss}\n\n[DummyUsage]\n",
        pdos(0x1400..=0x15FF),
        pdos(0x1800..=0x19FF),
    );
    for data_type in 1..=7 {
        let _ = writeln!(eds, "Dummy{data_type:04X}=0");
    }
    eds.push('\n');
}

fn index(object: &[Entry<'_>]) -> u16 {
    object.first().map_or(0, |(row, _)| row.id().index)
}

fn is_mandatory(index: u16) -> bool {
    MANDATORY.contains(&index)
}

fn is_manufacturer(index: u16) -> bool {
    (0x2000..=0x5FFF).contains(&index)
}

fn is_optional(index: u16) -> bool {
    !is_mandatory(index) && !is_manufacturer(index)
}

fn kind(object: &[Entry<'_>]) -> Kind {
    match object {
        [_] => Kind::Variable,
        _ if ARRAYS.contains(&index(object)) => Kind::Array,
        _ => Kind::Record,
    }
}

fn describe(eds: &mut String, sheet: &Sheet, object: &[Entry<'_>]) {
    let Some(&(first, text)) = object.first() else { return };
    let index = first.id().index;
    let name = text.name.strip_suffix(HIGHEST_SUB_INDEX).unwrap_or(text.name);
    let code = match kind(object) {
        Kind::Variable => {
            let _ = writeln!(eds, "[{index:04X}]");
            variable(eds, sheet, first, name);
            return;
        }
        Kind::Array => 8,
        Kind::Record => 9,
    };
    let _ = write!(
        eds,
        "[{index:04X}]\nParameterName={name}\nObjectType=0x{code}\nSubNumber={}\n\n",
        object.len()
    );
    for &(row, text) in object {
        let name = if row.id().sub == 0 && text.name == name {
            "Highest sub-index supported"
        } else {
            text.name
        };
        let _ = writeln!(eds, "[{index:04X}sub{:X}]", row.id().sub);
        variable(eds, sheet, row, name);
    }
}

fn variable(eds: &mut String, sheet: &Sheet, row: Row, name: &str) {
    let _ = write!(
        eds,
        "ParameterName={name}\nObjectType=0x7\nDataType=0x{:04X}\nAccessType={}\n",
        data_type(row.data_type()),
        access(row)
    );
    let (lowest, highest) = hull(row.limits());
    if let Some(value) = default(sheet, row) {
        let _ = writeln!(eds, "DefaultValue={value}");
    }
    if has_limits(row) {
        let [lowest, highest] = [lowest, highest].map(|limit| number(row.data_type(), limit));
        let _ = writeln!(eds, "LowLimit={lowest}\nHighLimit={highest}");
    }
    let _ = write!(eds, "PDOMapping={}\n\n", u8::from(row.pdo() != PdoMapping::No));
}

/// Codes of CiA 301, section 7.4.7.
const fn data_type(data_type: DataType) -> u8 {
    match data_type {
        DataType::Integer8 => 0x02,
        DataType::Integer16 => 0x03,
        DataType::Integer32 => 0x04,
        DataType::Unsigned8 => 0x05,
        DataType::Unsigned16 => 0x06,
        DataType::Unsigned32 => 0x07,
        DataType::VisibleString(_) => 0x09,
    }
}

/// `rww` and `rwr` say besides which PDOs may carry what can be read and written.
const fn access(row: Row) -> &'static str {
    match (row.access(), row.pdo()) {
        (Access::ReadOnly, _) => "ro",
        (Access::WriteOnly, _) => "wo",
        (Access::ReadWrite, PdoMapping::No | PdoMapping::Both) => "rw",
        (Access::ReadWrite, PdoMapping::Transmit) => "rwr",
        (Access::ReadWrite, PdoMapping::Receive) => "rww",
    }
}

/// The value at delivery, if the entry can be read. A PDO mapping that names an object the product
/// does not have, as the NM170 does, is left open: a master could not make sense of it.
fn default(sheet: &Sheet, row: Row) -> Option<String> {
    if row.access() == Access::WriteOnly {
        return None;
    }
    match row.default() {
        Default::Text(text) => Some(text.to_owned()),
        Default::NodeIdPlus(base) => Some(format!("$NODEID+0x{base:X}")),
        Default::Number(raw) if maps_nothing(sheet, row, raw) => None,
        Default::Number(raw) => Some(number(row.data_type(), row.data_type().number(raw))),
    }
}

fn maps_nothing(sheet: &Sheet, row: Row, entry: u32) -> bool {
    let [index_high, index_low, sub, _] = entry.to_be_bytes();
    let mapped = ObjectId { index: u16::from_be_bytes([index_high, index_low]), sub };
    row.id().sub > 0
        && PDO_MAPPINGS.iter().any(|area| area.contains(&row.id().index))
        && sheet.dictionary.find(mapped).is_err()
}

/// Smallest and largest number that may be written; a data sheet knows no gaps.
fn hull(limits: Limits) -> (i64, i64) {
    limits.also.iter().fold((limits.min, limits.max), |(lowest, highest), &(first, last)| {
        (lowest.min(first), highest.max(last))
    })
}

/// Limits are those of a write with SDO. They are left out where the entry reads a state that they
/// do not hold, such as the 0 of a drive at rest.
fn has_limits(row: Row) -> bool {
    let (lowest, highest) = hull(row.limits());
    let holds_default = match (row.access(), row.default()) {
        (Access::WriteOnly, _) | (_, Default::NodeIdPlus(_) | Default::Text(_)) => true,
        (Access::ReadOnly | Access::ReadWrite, Default::Number(raw)) => {
            (lowest..=highest).contains(&row.data_type().number(raw))
        }
    };
    let answers_with_state = row.access() == Access::ReadWrite
        && row.storage() == Storage::Volatile
        && lowest == highest;
    row.access() != Access::ReadOnly
        && row.write_state() != WriteState::NotWithSdo
        && (lowest, highest) != row.data_type().span()
        && holds_default
        && !answers_with_state
}

/// Signed numbers are decimal, all others hexadecimal.
fn number(data_type: DataType, value: i64) -> String {
    match data_type {
        DataType::Integer8 | DataType::Integer16 | DataType::Integer32 => value.to_string(),
        DataType::Unsigned8
        | DataType::Unsigned16
        | DataType::Unsigned32
        | DataType::VisibleString(_) => format!("0x{value:X}"),
    }
}
