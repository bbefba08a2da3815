//! Rows of CiA 301 that the products have in common.

use object_dictionary::{Object, Value};

/// A CAN-ID with bit 31 or bit 30, besides the one with neither.
pub(crate) const PDO_COB_IDS: &[(i64, i64)] =
    &[(0x4000_0001, 0x4000_07FF), (0x8000_0001, 0x8000_07FF), (0xC000_0001, 0xC000_07FF)];

/// A CAN-ID with bit 31, besides the one without.
pub(crate) const COB_IDS: &[(i64, i64)] = &[(0x8000_0001, 0x8000_07FF)];

pub(crate) const fn number<T: Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name)
}

pub(crate) const fn highest(index: u16, name: &'static str, sub: u8) -> Object<u8> {
    Object::highest_sub_index(index, name, sub)
}

/// An entry of a PDO mapping that can not be changed.
pub(crate) const fn mapped(index: u16, sub: u8, name: &'static str, entry: i64) -> Object<u32> {
    number(index, sub, name).within(entry, entry).default(entry)
}

/// Saves when `save` is written, 0x65766173; reads that it does so on command. Whoever saves checks
/// the signature: what is wrong with another number is not its range.
pub(crate) const fn store(sub: u8, name: &'static str) -> Object<u32> {
    number(0x1010, sub, name).read_write().default(1)
}

/// Brings the values at delivery back when `load` is written, 0x64616F6C; reads that it can.
pub(crate) const fn restore(sub: u8, name: &'static str) -> Object<u32> {
    number(0x1011, sub, name).read_write().default(1)
}

const fn error(sub: u8, name: &'static str) -> Object<u32> {
    number(0x1003, sub, name)
}

/// How many errors the list holds; writing 0 clears it.
pub const ERROR_COUNT: Object<u8> =
    number(0x1003, 0, "Pre-defined error field - number of errors").read_write().within(0, 0);
/// Newest error.
pub const ERROR_1: Object<u32> = error(1, "Pre-defined error field - entry 1");
/// Second newest.
pub const ERROR_2: Object<u32> = error(2, "Pre-defined error field - entry 2");
/// Third newest.
pub const ERROR_3: Object<u32> = error(3, "Pre-defined error field - entry 3");
/// Fourth newest.
pub const ERROR_4: Object<u32> = error(4, "Pre-defined error field - entry 4");
/// Fifth newest.
pub const ERROR_5: Object<u32> = error(5, "Pre-defined error field - entry 5");
/// Sixth newest.
pub const ERROR_6: Object<u32> = error(6, "Pre-defined error field - entry 6");
/// Seventh newest.
pub const ERROR_7: Object<u32> = error(7, "Pre-defined error field - entry 7");
/// Oldest error.
pub const ERROR_8: Object<u32> = error(8, "Pre-defined error field - entry 8");
