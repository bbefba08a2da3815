//! The synchronous serial interface of absolute sensors.
//!
//! The line is high while the sensor rests. The first falling clock edge latches the position, the
//! following ones shift it out, most significant bit first; then the line stays low for the
//! monoflop time and returns to high. So the bit before the word must be 1 and the bits after it
//! must be 0. A broken or shorted line rests at one level and fails one of the two checks, whatever
//! the receiver pulls it to.

/// Bits before the word: the idle level.
const IDLE_BITS: usize = 1;
/// Bits behind the word that are needed at least to see the monoflop.
const MONOFLOP_BITS: usize = 1;
/// Shortest word of any sensor, in bits.
pub const BITS_MIN: u8 = 12;
/// Longest word of any sensor, in bits.
pub const BITS_MAX: u8 = 32;
/// Bytes to clock in for the longest word.
pub const READ_LEN_MAX: usize = Format::new(BITS_MAX, Code::Binary).read_len();

/// How a sensor sends its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Format {
    bits: u8,
    code: Code,
}

/// The code of the word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Code {
    /// Plain binary.
    Binary,
    /// Reflected binary (Gray) over the whole word.
    Gray,
}

/// What is wrong with the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineFault {
    /// Low before the word.
    IdleLow,
    /// High after the word.
    MonoflopHigh,
}

impl Format {
    /// Words of `bits` bits in `code`. Panics unless there are 12 to 32 bits: meant for constants
    /// and for values that were checked against these limits.
    #[must_use]
    pub const fn new(bits: u8, code: Code) -> Self {
        assert!(BITS_MIN <= bits && bits <= BITS_MAX, "SSI words have 12 to 32 bits");
        Self { bits, code }
    }

    /// Bytes to clock in for one read.
    #[must_use]
    pub const fn read_len(self) -> usize {
        (IDLE_BITS + self.bits as usize + MONOFLOP_BITS).div_ceil(8)
    }

    /// The word in the bits clocked in, first bit in the top of the first byte. A read that is too
    /// short counts as filled up with the resting level.
    ///
    /// # Errors
    /// When the line does not behave like that of a sensor.
    pub fn decode(self, read: &[u8]) -> Result<u32, LineFault> {
        const RESTING: u8 = 0xFF;
        let bytes = read.iter().copied().chain(core::iter::repeat(RESTING)).take(self.read_len());
        let line = bytes.fold(0_u64, |line, byte| line << 8 | u64::from(byte));
        let behind = self.read_len() * 8 - IDLE_BITS - usize::from(self.bits);
        if line >> (behind + usize::from(self.bits)) & 1 == 0 {
            return Err(LineFault::IdleLow);
        }
        if line & ((1 << behind) - 1) != 0 {
            return Err(LineFault::MonoflopHigh);
        }
        let word = line >> behind & ((1 << self.bits) - 1);
        let word = u32::try_from(word).unwrap_or(u32::MAX);
        Ok(match self.code {
            Code::Binary => word,
            Code::Gray => gray_to_binary(word),
        })
    }
}

/// Each bit of the binary number is the parity of the Gray bits from the top down to it.
const fn gray_to_binary(gray: u32) -> u32 {
    let mut binary = gray;
    let mut span = 1;
    while span < u32::BITS {
        binary ^= binary >> span;
        span *= 2;
    }
    binary
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    const KIT: Format = Format::new(25, Code::Gray);

    /// NM17x SENSOR-01, SENSOR-02: words of 12 to 32 bits, binary or Gray.
    #[test]
    fn the_word_lies_between_idle_bit_and_monoflop() {
        for (format, read, expected) in [
            (KIT, &[0b1000_0000, 0, 0, 0][..], Ok(0)),
            (KIT, &[0b1000_0000, 0, 0, 0b0100_0000], Ok(1)),
            (KIT, &[0b1000_0000, 0, 0, 0b1100_0000], Ok(2)),
            (KIT, &[0b1000_0000, 0, 0, 0b1000_0000], Ok(3)),
            (KIT, &[0b1100_0000, 0, 0, 0], Ok(0x1FF_FFFF)),
            (Format::new(25, Code::Binary), &[0xFF, 0xFF, 0xFF, 0xC0], Ok(0x1FF_FFFF)),
            (Format::new(12, Code::Binary), &[0b1101_0101, 0b0101_1000], Ok(0b1010_1010_1011)),
            (Format::new(13, Code::Gray), &[0b1100_0000, 0], Ok(0x1FFF)),
            (Format::new(32, Code::Binary), &[0xFF, 0xFF, 0xFF, 0xFF, 0x80], Ok(u32::MAX)),
            (Format::new(32, Code::Gray), &[0xC0, 0, 0, 0, 0], Ok(u32::MAX)),
            (KIT, &[0xFF, 0xFF, 0xFF, 0xFF], Err(LineFault::MonoflopHigh)),
            (KIT, &[0, 0, 0, 0], Err(LineFault::IdleLow)),
            (KIT, &[0x7F, 0xFF, 0xFF, 0xFF], Err(LineFault::IdleLow)),
            (KIT, &[0x80, 0, 0, 0b0010_0000], Err(LineFault::MonoflopHigh)),
            (KIT, &[0x80, 0, 0, 0b0000_0001], Err(LineFault::MonoflopHigh)),
            (KIT, &[0x80, 0, 0], Err(LineFault::MonoflopHigh)),
            (KIT, &[], Err(LineFault::MonoflopHigh)),
        ] {
            assert_eq!(format.decode(read), expected, "{format:?} {read:02x?}");
        }
    }

    #[test]
    fn a_read_has_room_for_idle_bit_word_and_monoflop() {
        for (bits, bytes) in [(12, 2), (14, 2), (15, 3), (25, 4), (30, 4), (31, 5), (32, 5)] {
            assert_eq!(Format::new(bits, Code::Gray).read_len(), bytes, "{bits} bits");
        }
        assert_eq!(READ_LEN_MAX, 5);
    }

    fn line(format: Format, word: u32) -> [u8; READ_LEN_MAX] {
        let sent = match format.code {
            Code::Binary => word,
            Code::Gray => word ^ word >> 1,
        };
        let bits = 1_u64 << 39 | u64::from(sent) << (39 - format.bits);
        let mut read = [0; READ_LEN_MAX];
        read.copy_from_slice(&bits.to_be_bytes()[3..]);
        read
    }

    proptest! {
        #[test]
        fn every_word_arrives_as_it_was_sent(word: u32, bits in BITS_MIN..=BITS_MAX, gray: bool) {
            let format = Format::new(bits, if gray { Code::Gray } else { Code::Binary });
            let word = word >> (32 - bits);
            let read = line(format, word);
            prop_assert_eq!(format.decode(&read[..format.read_len()]), Ok(word));
        }

        #[test]
        fn any_bytes_are_a_word_or_a_fault(read: Vec<u8>, bits in BITS_MIN..=BITS_MAX) {
            if let Ok(word) = Format::new(bits, Code::Gray).decode(&read) {
                prop_assert!(u64::from(word) < 1 << bits);
            }
        }
    }
}
