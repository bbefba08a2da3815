use object_dictionary::ObjectId;

use crate::frame::{DATA_MAX, Frame};

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
    /// The message in a frame, zeros where that is shorter.
    pub(super) const fn received(frame: &Frame) -> Self {
        let (head, data) = frame.words();
        Self { head, data }
    }

    pub(crate) const fn to_bytes(self) -> [u8; DATA_MAX] {
        let ([a, b, c, d], [e, f, g, h]) = (self.head.to_le_bytes(), self.data.to_le_bytes());
        [a, b, c, d, e, f, g, h]
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

    /// A message that names no object, with its first bytes of data.
    pub(super) const fn short(command: u8, data: u16) -> Self {
        Self { head: (data as u32) << 8 | command as u32, data: 0 }
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
    let behind = rest.get(3..).unwrap_or(&[]);
    Message { head: word(rest) << 8 | u32::from(command), data: word(behind) }
}

/// The first four bytes of a value, filled with zeros.
#[inline(never)]
pub(super) fn word(value: &[u8]) -> u32 {
    let mut word = [0; 4];
    for (place, &byte) in word.iter_mut().zip(value) {
        *place = byte;
    }
    u32::from_le_bytes(word)
}

/// A length as messages have it.
pub(super) fn size(len: usize) -> u32 {
    u32::try_from(len).unwrap_or(u32::MAX)
}
