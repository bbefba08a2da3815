use object_dictionary::{DataType, Dictionary, ObjectId, PdoMapping, Slot};

use super::Direction;
use super::mapping::{Bytes, LEN_MAX};
use crate::sdo::AbortCode;

/// Where the bytes of one object lie in a PDO.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field {
    /// Nowhere for bytes that are skipped.
    pub(super) slot: Slot,
    pub(super) at: u8,
    width: Width,
}

/// How much of 32 bits a number is: the bits above it, and whether they repeat its sign.
#[derive(Clone, Copy, Debug)]
struct Width(u8);

impl Field {
    /// The field at the byte `at` for an entry of a mapping object: index, sub-index and length in
    /// bits (CiA 301, section 7.5.2.36). An entry that a PDO of this direction cannot carry gives
    /// the reason.
    pub(super) fn new(
        entry: u32,
        at: u8,
        dictionary: &Dictionary,
        direction: Direction,
    ) -> Result<Self, AbortCode> {
        let [bits, sub, low, high] = entry.to_le_bytes();
        let object = ObjectId { index: u16::from_le_bytes([low, high]), sub };
        let (slot, data_type) = match (dummy(object), direction) {
            (Some(data_type), Direction::Receive) => (Slot::NOWHERE, data_type),
            (Some(_) | None, _) => mappable(object, dictionary, direction)?,
        };
        if usize::from(bits) != 8 * data_type.len() {
            return Err(AbortCode::NOT_MAPPABLE);
        }
        Ok(Self { slot, at, width: Width::new(data_type) })
    }

    /// Where the next field begins.
    pub(super) const fn end(self) -> u8 {
        self.at + self.width.byte_len()
    }

    /// The number in the bytes of a PDO.
    pub(super) fn number(self, bytes: &Bytes) -> u32 {
        let word = bytes.get(usize::from(self.at % LEN_MAX)..).and_then(<[u8]>::first_chunk);
        self.width.number(word.map_or(0, |word| u32::from_le_bytes(*word)))
    }
}

impl Width {
    const SIGNED: u8 = 1 << 7;

    const fn new(data_type: DataType) -> Self {
        match data_type {
            DataType::Unsigned8 => Self(24),
            DataType::Unsigned16 => Self(16),
            DataType::Unsigned32 | DataType::Integer32 | DataType::VisibleString(_) => Self(0),
            DataType::Integer8 => Self(Self::SIGNED | 24),
            DataType::Integer16 => Self(Self::SIGNED | 16),
        }
    }

    const fn spare_bits(self) -> u8 {
        self.0 % 32
    }

    const fn byte_len(self) -> u8 {
        4 - self.spare_bits() / 8
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

/// The data types that stand for bytes to be skipped (CiA 301, section 7.4.7.1).
const fn dummy(object: ObjectId) -> Option<DataType> {
    match (object.index, object.sub) {
        (0x0002 | 0x0005, 0) => Some(DataType::Unsigned8),
        (0x0003 | 0x0006, 0) => Some(DataType::Unsigned16),
        (0x0004 | 0x0007, 0) => Some(DataType::Unsigned32),
        _ => None,
    }
}

fn mappable(
    object: ObjectId,
    dictionary: &Dictionary,
    direction: Direction,
) -> Result<(Slot, DataType), AbortCode> {
    let slot = dictionary.find(object).map_err(|_| AbortCode::NO_OBJECT)?;
    let row = dictionary.row(slot).ok_or(AbortCode::NO_OBJECT)?;
    match (row.pdo(), direction) {
        _ if row.data_type().is_text() => Err(AbortCode::NOT_MAPPABLE),
        (PdoMapping::Transmit | PdoMapping::Both, Direction::Transmit)
        | (PdoMapping::Receive | PdoMapping::Both, Direction::Receive) => {
            Ok((slot, row.data_type()))
        }
        (PdoMapping::No, _)
        | (PdoMapping::Transmit, Direction::Receive)
        | (PdoMapping::Receive, Direction::Transmit) => Err(AbortCode::NOT_MAPPABLE),
    }
}
