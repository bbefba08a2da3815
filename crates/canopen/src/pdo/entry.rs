use object_dictionary::{DataType, Dictionary, ObjectId, PdoMapping};

use super::Direction;
use crate::sdo::AbortCode;

/// An entry of a mapping object: index, sub-index and length in bits (CiA 301, section 7.5.2.36).
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) object: ObjectId,
    bits: u8,
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

    /// Its length in bytes, if a PDO of this direction can carry it.
    pub(super) fn check(
        self,
        dictionary: &Dictionary,
        direction: Direction,
    ) -> Result<u8, AbortCode> {
        let len = match (self.dummy_len(), direction) {
            (Some(len), Direction::Receive) => len,
            (Some(_) | None, _) => self.mappable_len(dictionary, direction)?,
        };
        if self.byte_len() == Some(len) { Ok(len) } else { Err(AbortCode::NOT_MAPPABLE) }
    }

    /// Length of a data type that stands for bytes to be skipped (CiA 301, section 7.4.7.1).
    const fn dummy_len(self) -> Option<u8> {
        match (self.object.index, self.object.sub) {
            (0x0002 | 0x0005, 0) => Some(1),
            (0x0003 | 0x0006, 0) => Some(2),
            (0x0004 | 0x0007, 0) => Some(4),
            _ => None,
        }
    }

    fn mappable_len(self, dictionary: &Dictionary, direction: Direction) -> Result<u8, AbortCode> {
        let slot = dictionary.find(self.object).map_err(|_| AbortCode::NO_OBJECT)?;
        let row = dictionary.row(slot).ok_or(AbortCode::NO_OBJECT)?;
        match (row.pdo(), direction, row.data_type()) {
            (_, _, DataType::VisibleString(_))
            | (PdoMapping::No, ..)
            | (PdoMapping::Transmit, Direction::Receive, _)
            | (PdoMapping::Receive, Direction::Transmit, _) => Err(AbortCode::NOT_MAPPABLE),
            (PdoMapping::Transmit | PdoMapping::Both, Direction::Transmit, _)
            | (PdoMapping::Receive | PdoMapping::Both, Direction::Receive, _) => {
                u8::try_from(row.data_type().len()).map_err(|_| AbortCode::NOT_MAPPABLE)
            }
        }
    }
}
