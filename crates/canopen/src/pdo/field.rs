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
    /// The field at the byte `at` for an entry of the mapping object with this index: index,
    /// sub-index and length in bits (CiA 301, section 7.5.2.36). An entry that the PDO cannot carry
    /// gives the reason.
    pub(super) fn new(
        mapping: u16,
        entry: u32,
        at: u8,
        dictionary: &Dictionary,
    ) -> Result<Self, AbortCode> {
        let direction = Direction::of(mapping);
        let [bits, sub, low, high] = entry.to_le_bytes();
        let object = ObjectId { index: u16::from_le_bytes([low, high]), sub };
        let skipped = match direction {
            Direction::Receive => dummy(object),
            Direction::Transmit => None,
        };
        let (slot, width) = match skipped {
            Some(width) => (Slot::NOWHERE, width),
            None => mappable(object, dictionary, direction)?,
        };
        if bits == width.bits() {
            Ok(Self { slot, at, width })
        } else {
            Err(AbortCode::NOT_MAPPABLE)
        }
    }

    /// The bytes of an entry that cannot be carried.
    pub(super) const fn gap(entry: u32, at: u8) -> Self {
        let [bits, ..] = entry.to_le_bytes();
        Self { slot: Slot::NOWHERE, at, width: Width(32_u8.wrapping_sub(bits) % 32) }
    }

    /// Where the next field begins.
    pub(super) const fn end(self) -> u8 {
        self.at + self.width.bits() / 8
    }

    /// The number in the bytes of a PDO.
    pub(super) fn number(self, bytes: &Bytes) -> u32 {
        let word = bytes.get(usize::from(self.at % LEN_MAX)..).and_then(<[u8]>::first_chunk);
        self.width.number(word.map_or(0, |word| u32::from_le_bytes(*word)))
    }
}

impl Width {
    const SIGNED: u8 = 1 << 7;

    const fn unsigned(bits: u8) -> Self {
        Self(32 - bits)
    }

    const fn signed(bits: u8) -> Self {
        Self(Self::SIGNED | (32 - bits))
    }

    /// `None` for texts, which no PDO carries.
    const fn of(data_type: DataType) -> Option<Self> {
        match data_type {
            DataType::Unsigned8 => Some(Self::unsigned(8)),
            DataType::Unsigned16 => Some(Self::unsigned(16)),
            DataType::Unsigned32 => Some(Self::unsigned(32)),
            DataType::Integer8 => Some(Self::signed(8)),
            DataType::Integer16 => Some(Self::signed(16)),
            DataType::Integer32 => Some(Self::signed(32)),
            DataType::VisibleString(_) => None,
        }
    }

    const fn bits(self) -> u8 {
        32 - self.spare_bits()
    }

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

/// The width of a data type that stands for bytes to be skipped (CiA 301, section 7.4.7.1).
const fn dummy(object: ObjectId) -> Option<Width> {
    match (object.index, object.sub) {
        (0x0002 | 0x0005, 0) => Some(Width::unsigned(8)),
        (0x0003 | 0x0006, 0) => Some(Width::unsigned(16)),
        (0x0004 | 0x0007, 0) => Some(Width::unsigned(32)),
        _ => None,
    }
}

fn mappable(
    object: ObjectId,
    dictionary: &Dictionary,
    direction: Direction,
) -> Result<(Slot, Width), AbortCode> {
    let slot = dictionary.find(object).unwrap_or(Slot::NOWHERE);
    let row = dictionary.row(slot).ok_or(AbortCode::NO_OBJECT)?;
    let one_way = match direction {
        Direction::Receive => PdoMapping::Receive,
        Direction::Transmit => PdoMapping::Transmit,
    };
    let goes = row.pdo() == one_way || row.pdo() == PdoMapping::Both;
    let width = Width::of(row.data_type()).filter(|_| goes);
    width.map(|width| (slot, width)).ok_or(AbortCode::NOT_MAPPABLE)
}
