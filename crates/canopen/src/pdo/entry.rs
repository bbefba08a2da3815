use object_dictionary::{DataType, Dictionary, ObjectId, PdoMapping, Row, Slot};

use super::Direction;
use crate::sdo::AbortCode;

/// An entry of a mapping object: index, sub-index and length in bits (CiA 301, section 7.5.2.36).
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    object: ObjectId,
    pub(super) bits: u8,
}

impl Entry {
    pub(super) const fn from_raw(raw: u32) -> Self {
        let [bits, sub, low, high] = raw.to_le_bytes();
        Self { object: ObjectId { index: u16::from_le_bytes([low, high]), sub }, bits }
    }

    /// Length of the object in the PDO, in whole bytes. `None` for anything else.
    pub(super) const fn byte_len(self) -> Option<u8> {
        if self.bits > 0 && self.bits.is_multiple_of(8) { Some(self.bits / 8) } else { None }
    }

    /// The object, if the product has it.
    pub(super) fn find(self, dictionary: &Dictionary) -> (Slot, Option<Row>) {
        let slot = dictionary.find(self.object).unwrap_or(Slot::NOWHERE);
        (slot, dictionary.row(slot))
    }

    /// Whether a master may give it to a PDO with this mapping object; `row` is that of its object.
    pub(super) fn check(self, row: Option<Row>, mapping: u16) -> Result<(), AbortCode> {
        let direction = Direction::of(mapping);
        let data_type = match (row, direction) {
            (Some(row), _) if !direction.takes(row.pdo()) || row.data_type().is_text() => {
                return Err(AbortCode::NOT_MAPPABLE);
            }
            (Some(row), _) => Some(row.data_type()),
            (None, Direction::Receive) => self.dummy(),
            (None, Direction::Transmit) => None,
        };
        let len = data_type.ok_or(AbortCode::NO_OBJECT)?.len();
        if usize::from(self.bits) == 8 * len { Ok(()) } else { Err(AbortCode::NOT_MAPPABLE) }
    }

    /// The data type that stands for bytes to be skipped (CiA 301, section 7.4.7.1).
    const fn dummy(self) -> Option<DataType> {
        match (self.object.index, self.object.sub) {
            (0x0002 | 0x0005, 0) => Some(DataType::Unsigned8),
            (0x0003 | 0x0006, 0) => Some(DataType::Unsigned16),
            (0x0004 | 0x0007, 0) => Some(DataType::Unsigned32),
            _ => None,
        }
    }
}

impl Direction {
    fn takes(self, pdo: PdoMapping) -> bool {
        let one_way = match self {
            Self::Receive => PdoMapping::Receive,
            Self::Transmit => PdoMapping::Transmit,
        };
        pdo == one_way || pdo == PdoMapping::Both
    }
}
