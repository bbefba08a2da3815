use super::frame::{Frame, Id};

/// A stuff bit follows this many equal bits.
const STUFF_AFTER: u32 = 5;
/// CRC delimiter, ACK slot, ACK delimiter and the seven bits of end of frame: never stuffed.
const TAIL_BITS: u32 = 10;
/// The longest stuffed part: 118 bits of an extended frame with 8 bytes, a stuff bit after the
/// first five and then after every four.
const STUFFED_MAX: usize = 118 + 118 / 4;

const CRC_POLYNOMIAL: u16 = 0x4599;
const CRC_BITS: u32 = 15;

/// The check sequence of CAN (ISO 11898-1): x15+x14+x10+x8+x7+x4+x3+1, over the bits from start of
/// frame to the end of the data, before stuffing. `true` is recessive.
#[must_use]
pub fn crc15(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |crc, &bit| {
        let carry = (crc >> (CRC_BITS - 1) & 1 == 1) != bit;
        let shifted = crc << 1 & 0x7FFF;
        if carry { shifted ^ CRC_POLYNOMIAL } else { shifted }
    })
}

/// A frame as its transmitter drives it, bit by bit, from start of frame to end of frame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    stuffed: Vec<bool>,
    arbitration: u32,
}

impl Wire {
    /// The bits of `frame`.
    #[must_use]
    pub fn of(frame: &Frame) -> Self {
        let mut plain = Plain(Vec::with_capacity(STUFFED_MAX));
        plain.push(0, 1);
        let arbitration_end = match frame.id() {
            Id::Standard(id) => {
                plain.push(id.into(), 11);
                plain.push(frame.is_remote().into(), 1);
                let end = plain.0.len();
                plain.push(0b00, 2);
                end
            }
            Id::Extended(id) => {
                plain.push(id >> 18, 11);
                plain.push(0b11, 2);
                plain.push(id, 18);
                plain.push(frame.is_remote().into(), 1);
                let end = plain.0.len();
                plain.push(0b00, 2);
                end
            }
        };
        plain.push(frame.dlc().into(), 4);
        for byte in frame.data() {
            plain.push((*byte).into(), 8);
        }
        let crc = crc15(&plain.0);
        plain.push(crc.into(), CRC_BITS);
        plain.stuff(arbitration_end)
    }

    /// Bits on the wire, from start of frame to the end of end of frame, stuff bits included.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.stuffed_len() + TAIL_BITS
    }

    /// Never: a frame has bits.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        false
    }

    /// The place of the ACK slot, counted from start of frame.
    #[must_use]
    pub fn ack_slot(&self) -> u32 {
        self.stuffed_len() + 1
    }

    /// The place of the first bit after the arbitration field.
    #[must_use]
    pub const fn after_arbitration(&self) -> u32 {
        self.arbitration
    }

    /// The level the transmitter drives at a place: `true` is recessive, as everything behind the
    /// check sequence is.
    #[must_use]
    pub fn bit(&self, place: u32) -> bool {
        usize::try_from(place).ok().and_then(|p| self.stuffed.get(p)).copied().unwrap_or(true)
    }

    /// The first place at which two transmitters drive different levels.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<u32> {
        (0..self.len().max(other.len())).find(|&place| self.bit(place) != other.bit(place))
    }

    fn stuffed_len(&self) -> u32 {
        u32::try_from(self.stuffed.len()).unwrap_or(u32::MAX)
    }
}

/// Bits before stuffing.
struct Plain(Vec<bool>);

impl Plain {
    /// Appends the lower `count` bits of `value`, most significant first.
    fn push(&mut self, value: u32, count: u32) {
        self.0.extend((0..count).rev().map(|n| value >> n & 1 == 1));
    }

    fn stuff(self, arbitration_end: usize) -> Wire {
        let mut stuffed = Vec::with_capacity(STUFFED_MAX);
        let (mut run, mut last, mut arbitration) = (0, true, 0);
        for (place, bit) in self.0.into_iter().enumerate() {
            if place == arbitration_end {
                arbitration = u32::try_from(stuffed.len()).unwrap_or(u32::MAX);
            }
            run = if bit == last { run + 1 } else { 1 };
            last = bit;
            stuffed.push(bit);
            if run == STUFF_AFTER {
                last = !bit;
                stuffed.push(last);
                run = 1;
            }
        }
        Wire { stuffed, arbitration }
    }
}
