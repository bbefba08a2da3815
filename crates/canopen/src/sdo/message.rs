use object_dictionary::ObjectId;

use crate::frame::DATA_MAX;

/// Data bytes in an SDO segment.
pub(super) const SEGMENT_LEN: usize = 7;

/// An SDO message that names an object, in two words: command, index and sub-index; data (CiA 301,
/// section 7.2.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Message {
    head: u32,
    data: u32,
}

impl Message {
    pub(super) const fn from_bytes(bytes: [u8; DATA_MAX]) -> Self {
        let word = u64::from_le_bytes(bytes);
        Self { head: low(word), data: low(word >> 32) }
    }

    pub(crate) const fn to_bytes(self) -> [u8; DATA_MAX] {
        (self.head as u64 | (self.data as u64) << 32).to_le_bytes()
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
        let [sub, ..] = (self.head >> 24).to_le_bytes();
        let [low, high, ..] = (self.head >> 8).to_le_bytes();
        ObjectId { index: u16::from_le_bytes([low, high]), sub }
    }

    pub(super) const fn data(self) -> u32 {
        self.data
    }
}

/// A command byte and the first bytes of what is left of a value, filled with zeros.
pub(super) fn segment(command: u8, rest: &[u8]) -> Message {
    let mut bytes = [0; DATA_MAX];
    let [first, data @ ..] = &mut bytes;
    *first = command;
    for (place, &byte) in data.iter_mut().zip(rest) {
        *place = byte;
    }
    Message::from_bytes(bytes)
}

#[expect(clippy::cast_possible_truncation, reason = "the lower half is what is asked for")]
const fn low(word: u64) -> u32 {
    word as u32
}
