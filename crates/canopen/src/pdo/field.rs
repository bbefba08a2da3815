use object_dictionary::{Row, Slot};

use super::entry::Entry;
use super::mapping::{Bytes, LEN_MAX};

/// Where the bytes of one object lie in a PDO. Those of an object that the product does not have are
/// zero when sent and dropped when received.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    pub(super) slot: Slot,
    pub(super) at: u8,
    width: Width,
}

/// How much of 32 bits a number is: the bits above it, and whether they repeat its sign.
#[derive(Clone, Copy, Debug)]
struct Width(u8);

impl Field {
    /// The field of an entry at the byte `at`, whose object has this slot and row.
    pub(super) fn new(entry: Entry, at: u8, slot: Slot, row: Option<Row>) -> Self {
        let is_signed = row.is_some_and(|row| row.data_type().is_signed());
        let sign = if is_signed { Width::SIGNED } else { 0 };
        Self { slot, at, width: Width(sign | 32_u8.saturating_sub(entry.bits)) }
    }

    /// The number in the bytes of a PDO.
    pub(super) fn number(self, bytes: &Bytes) -> u32 {
        let word = bytes.get(usize::from(self.at % LEN_MAX)..).and_then(<[u8]>::first_chunk);
        self.width.number(word.map_or(0, |word| u32::from_le_bytes(*word)))
    }
}

impl Width {
    const SIGNED: u8 = 1 << 7;

    const fn spare_bits(self) -> u8 {
        self.0 % 32
    }

    /// The low bytes of `word` as a number.
    const fn number(self, word: u32) -> u32 {
        let shifted = word << self.spare_bits();
        if self.0 & Self::SIGNED == 0 {
            shifted >> self.spare_bits()
        } else {
            (shifted.cast_signed() >> self.spare_bits()).cast_unsigned()
        }
    }
}
