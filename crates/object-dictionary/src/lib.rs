//! The object dictionary as data (CiA 301, section 7.4): an [`Object`] is at once the typed key to
//! a value, the row of the table, the line of the EDS file and the line of the handbook.
//!
//! ```
//! use object_dictionary::{Object, Unit, product};
//!
//! pub const LOOP_LENGTH: Object<u32> = Object::new(0x2002, 0, "Backlash loop length")
//!     .read_write().within(0, 9_999).default(100).unit(Unit::HundredthMm);
//! pub const POSITION: Object<i32> = Object::new(0x6004, 0, "Position value");
//!
//! product! { pub LOOP_LENGTH, POSITION }
//!
//! let mut values = object_dictionary::Values::<LEN>::new(&DICTIONARY, 127);
//! assert_eq!(values.get(&LOOP_LENGTH), 100);
//! values.set(&POSITION, -5);
//! ```
//!
//! A row out of order, a default outside its limits and a limit outside its type do not compile.
//! Names and units are kept apart from the rows, so that an image that only looks values up holds
//! none of the text.
#![no_std]

mod dictionary;
mod object;
mod row;
mod values;

pub use dictionary::{
    Dictionary, Missing, Places, Slot, Table, fingerprint, kinds_len, places_len,
};
pub use object::{Listing, Number, Object, Text, Unit, Value};
pub use row::{
    Access, DataType, Default, Kind, Limits, Line, ObjectId, OutOfLimits, Owner, Particulars,
    PdoMapping, Row, Storage, WriteState,
};
pub use values::Values;

/// The row of a constant object.
#[macro_export]
macro_rules! row {
    ($object:expr) => {
        $crate::Row::new(
            const { &$object.line() },
            const { &$object.kind(const { &$object.particulars() }) },
        )
    };
}

/// The dictionary of these constant rows.
#[macro_export]
macro_rules! dictionary {
    ($rows:expr) => {
        $crate::Dictionary::new(
            const { &$crate::Table::<{ $rows.len() }, { $crate::kinds_len($rows) }>::of($rows) },
            const { &$crate::Places::<{ $crate::places_len($rows) }>::of($rows) },
        )
    };
}

/// Lists the objects of a product in ascending order. Makes `LEN`, the `DICTIONARY` with its
/// `FINGERPRINT` and, apart from it, the `TEXTS`, all with the visibility given first.
#[macro_export]
macro_rules! product {
    ($vis:vis $($object:path),+ $(,)?) => {
        const ROWS: &[$crate::Row] = &[$($crate::row!($object)),+];

        /// How many entries the product has.
        $vis const LEN: usize = ROWS.len();

        /// The rows, in ascending order.
        $vis static DICTIONARY: $crate::Dictionary = $crate::dictionary!(ROWS);

        /// Sets this dictionary apart from every other one (see `fingerprint`).
        $vis const FINGERPRINT: u32 = $crate::fingerprint(ROWS);

        /// Name and unit of each row, for EDS files and handbooks.
        $vis const TEXTS: &[$crate::Text] = &[$($object.text()),+];
    };
}
