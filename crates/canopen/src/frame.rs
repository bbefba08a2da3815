/// Longest data field of a CAN frame, in bytes.
pub const DATA_MAX: usize = 8;

/// An 11-bit CAN identifier. The smaller one wins the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CanId(u16);

/// A CAN frame with an 11-bit identifier. Frames with 29-bit identifiers never reach a device of
/// this stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(4))]
pub struct Frame {
    id: CanId,
    len: u8,
    remote: bool,
    data: [u8; DATA_MAX],
}

impl CanId {
    /// Largest identifier.
    pub const MAX: Self = Self(0x7FF);

    /// What a service listens to or sends with while it is off: no frame has this identifier.
    pub(crate) const NONE: Self = Self(u16::MAX);

    /// The identifier `id`. `None` above 0x7FF.
    #[must_use]
    pub const fn new(id: u16) -> Option<Self> {
        if id <= Self::MAX.0 { Some(Self(id)) } else { None }
    }

    /// Bits 10 to 0 of `raw`, as COB-IDs hold an identifier.
    #[must_use]
    pub const fn from_low_bits(raw: u32) -> Self {
        let [low, high, ..] = raw.to_le_bytes();
        Self(u16::from_le_bytes([low, high]) & Self::MAX.0)
    }

    /// The identifier as a number, 0 to 0x7FF.
    #[must_use]
    pub const fn get(self) -> u16 {
        self.0
    }
}

impl Frame {
    /// A data frame. `None` when `data` is longer than [`DATA_MAX`].
    #[must_use]
    pub fn new(id: CanId, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; DATA_MAX];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self { id, remote: false, len: u8::try_from(data.len()).ok()?, data: bytes })
    }

    /// A remote frame that asks for `len` bytes. `None` when `len` exceeds [`DATA_MAX`].
    #[must_use]
    pub fn new_remote(id: CanId, len: u8) -> Option<Self> {
        let fits = usize::from(len) <= DATA_MAX;
        fits.then_some(Self { id, remote: true, len, data: [0; DATA_MAX] })
    }

    /// A data frame of eight bytes.
    #[must_use]
    pub const fn full(id: CanId, data: [u8; DATA_MAX]) -> Self {
        Self { id, remote: false, len: 8, data }
    }

    /// A data frame without data.
    pub(crate) const fn empty(id: CanId) -> Self {
        Self { id, remote: false, len: 0, data: [0; DATA_MAX] }
    }

    /// A data frame of one byte.
    pub(crate) const fn single(id: CanId, byte: u8) -> Self {
        Self { id, remote: false, len: 1, data: [byte, 0, 0, 0, 0, 0, 0, 0] }
    }

    /// A data frame of the first `len` bytes of `data`; all of them when there are fewer.
    #[must_use]
    #[inline]
    pub const fn prefix(id: CanId, data: [u8; DATA_MAX], len: u8) -> Self {
        if len >= 8 {
            return Self::full(id, data);
        }
        let [a, b, c, d, e, f, g, h] = data;
        let low = u32::from_le_bytes([a, b, c, d]) & lowest_bytes(len);
        let high = u32::from_le_bytes([e, f, g, h]) & lowest_bytes(len.saturating_sub(4));
        let ([a, b, c, d], [e, f, g, h]) = (low.to_le_bytes(), high.to_le_bytes());
        Self { id, remote: false, len, data: [a, b, c, d, e, f, g, h] }
    }

    /// A data frame of `len` bytes, at most 8; those of `data` behind them are zero.
    pub(crate) const fn padded_from(id: CanId, data: [u8; DATA_MAX], len: u8) -> Self {
        Self { id, remote: false, len, data }
    }

    /// The identifier.
    #[must_use]
    pub const fn id(&self) -> CanId {
        self.id
    }

    /// Whether it asks for data instead of carrying any.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0 to 8. A remote frame has one without having data.
    #[must_use]
    pub const fn dlc(&self) -> u8 {
        self.len
    }

    /// The data bytes with zeros behind them, as a transmit mailbox takes them.
    #[must_use]
    pub const fn padded(&self) -> [u8; DATA_MAX] {
        self.data
    }

    /// [`Self::padded`] as two words, little endian.
    pub(crate) const fn words(&self) -> (u32, u32) {
        let ([low @ .., _, _, _, _], [_, _, _, _, high @ ..]) = (&self.data, &self.data);
        (u32::from_le_bytes(*low), u32::from_le_bytes(*high))
    }

    /// The data bytes; none in a remote frame.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        if self.remote { &[] } else { self.data.get(..usize::from(self.len)).unwrap_or(&[]) }
    }
}

/// The bits of the lowest `count` bytes; of all four if there are not so many.
const fn lowest_bytes(count: u8) -> u32 {
    if count < 4 { !(u32::MAX << (8 * count)) } else { u32::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_holds_up_to_eight_bytes_and_eleven_bits() {
        let id = CanId::new(0x7FF).unwrap();
        assert_eq!(CanId::new(0x800), None);
        assert_eq!(Frame::new(id, &[0; 9]), None);
        assert_eq!(Frame::new_remote(id, 9), None);
        assert_eq!(Frame::new(id, &[1, 2]).unwrap().data(), [1, 2]);
        assert_eq!(Frame::new_remote(id, 4).unwrap().data(), []);
        assert_eq!(Frame::new_remote(id, 4).unwrap().dlc(), 4);
    }

    #[test]
    fn what_follows_the_data_is_zero() {
        let id = CanId::new(0x100).unwrap();
        for (len, padded) in [
            (0, [0; 8]),
            (3, [1, 2, 3, 0, 0, 0, 0, 0]),
            (8, [1, 2, 3, 4, 5, 6, 7, 8]),
            (15, [1, 2, 3, 4, 5, 6, 7, 8]),
        ] {
            let frame = Frame::prefix(id, [1, 2, 3, 4, 5, 6, 7, 8], len);
            assert_eq!((frame.dlc(), frame.padded()), (len.min(8), padded));
            assert_eq!(Frame::new(id, frame.data()), Some(frame));
        }
    }
}
