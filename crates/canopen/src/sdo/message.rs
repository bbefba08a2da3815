use object_dictionary::ObjectId;

use crate::frame::DATA_MAX;

/// Data bytes in an SDO segment.
pub(super) const SEGMENT_LEN: usize = 7;

/// An SDO message that names an object, in two words: command, index and sub-index; data (CiA 301,
/// section 7.2.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Message {
    head: u32,
    data: u32,
}

impl Message {
    pub(super) const fn from_bytes([command, i, j, k, a, b, c, d]: [u8; DATA_MAX]) -> Self {
        let head = u32::from_le_bytes([command, i, j, k]);
        Self { head, data: u32::from_le_bytes([a, b, c, d]) }
    }

    pub(super) const fn to_bytes(self) -> [u8; DATA_MAX] {
        let ([command, i, j, k], [a, b, c, d]) = (self.head.to_le_bytes(), self.data.to_le_bytes());
        [command, i, j, k, a, b, c, d]
    }

    /// A message about an object.
    pub(super) const fn new(command: u8, object: ObjectId, data: u32) -> Self {
        let [low, high] = object.index.to_le_bytes();
        Self { head: u32::from_le_bytes([command, low, high, object.sub]), data }
    }

    /// A message about the same object.
    pub(super) const fn answer(self, command: u8, data: u32) -> Self {
        Self { head: self.head & !0xFF | command as u32, data }
    }

    pub(super) const fn command(self) -> u8 {
        let [command, ..] = self.head.to_le_bytes();
        command
    }

    pub(super) const fn object(self) -> ObjectId {
        let [_, low, high, sub] = self.head.to_le_bytes();
        ObjectId { index: u16::from_le_bytes([low, high]), sub }
    }

    pub(super) const fn data(self) -> u32 {
        self.data
    }
}

/// A command byte and the first bytes of what is left of a value, filled with zeros.
pub(super) fn segment(command: u8, rest: &[u8]) -> [u8; DATA_MAX] {
    let mut bytes = [0; DATA_MAX];
    let [first, data @ ..] = &mut bytes;
    *first = command;
    for (place, &byte) in data.iter_mut().zip(rest) {
        *place = byte;
    }
    bytes
}
