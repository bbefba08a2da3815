//! The absolute multiturn encoder on the shaft and its synchronous serial line (SSI).
//!
//! The line as the controller samples it on the falling clock edges: the first edge after a pause
//! freezes the position and still finds the idle level (1), the next 25 find the word, most
//! significant bit first, then the line is 0 until the monoflop has run out ([`MONOFLOP_NS`] after
//! the last clock edge) and 1 again until the next read. The word is 13 bit turns and 12 bit
//! angle, Gray coded as one number of 25 bits.
use crate::spindle::Spindle;

/// Bits of the word.
pub const WORD_BITS: u32 = 25;

/// How long the line stays low after the last clock edge. A clock edge within this time goes on
/// with the word that is being read.
pub const MONOFLOP_NS: u64 = 20_000;

/// The encoder's end of the line.
#[derive(Clone, Debug, Default)]
pub struct SsiEncoder {
    /// Condition of the data line.
    pub line: Line,
    reading: Option<Reading>,
}

/// Condition of the data line between encoder and controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Line {
    /// As wired.
    #[default]
    Connected,
    /// A wire is broken or the connector is off: the line receiver's fail-safe output is high.
    Open,
    /// Shorted low, or the encoder's driver is dead.
    StuckLow,
}

/// A word being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Reading {
    word: u32,
    falling_edges: u32,
    last_edge_ns: u64,
}

impl SsiEncoder {
    /// The controller gives `clocks` (at most 32) periods of `period_ns`, the first falling edge
    /// at `at_ns`; the answer is what it samples on the falling edges, first sample in the highest
    /// of `clocks` bits.
    pub fn clock(&mut self, at_ns: u64, spindle: &Spindle, clocks: u8, period_ns: u64) -> u32 {
        (0..u64::from(clocks)).fold(0, |sampled, n| {
            let bit = self.falling_edge(at_ns + n * period_ns, spindle, period_ns);
            sampled << 1 | u32::from(bit)
        })
    }

    fn falling_edge(&mut self, at_ns: u64, spindle: &Spindle, period_ns: u64) -> bool {
        let reading = self
            .reading
            .filter(|reading| at_ns.saturating_sub(reading.last_edge_ns) < MONOFLOP_NS)
            .unwrap_or_else(|| Reading {
                word: gray(spindle.raw(at_ns)),
                falling_edges: 0,
                last_edge_ns: at_ns,
            });
        let level = match reading.falling_edges {
            0 => true,
            n @ 1..=WORD_BITS => reading.word >> (WORD_BITS - n) & 1 == 1,
            _ => false,
        };
        self.reading = Some(Reading {
            falling_edges: reading.falling_edges.saturating_add(1),
            last_edge_ns: at_ns + period_ns / 2,
            ..reading
        });
        match self.line {
            Line::Connected => level,
            Line::Open => true,
            Line::StuckLow => false,
        }
    }
}

/// The Gray code of a binary number.
const fn gray(binary: u32) -> u32 {
    binary ^ binary >> 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spindle::RAW_AT_START;

    const PERIOD_NS: u64 = 1_600;

    fn read(encoder: &mut SsiEncoder, at_ns: u64, shaft: &Spindle) -> u32 {
        encoder.clock(at_ns, shaft, 32, PERIOD_NS)
    }

    #[test]
    fn a_read_is_idle_level_word_and_monoflop() {
        let mut encoder = SsiEncoder::default();
        let mut shaft = Spindle::default();
        let at_start = gray(RAW_AT_START);
        assert_eq!(read(&mut encoder, 0, &shaft), 1 << 31 | at_start << 6);
        shaft.turn(5);
        assert_eq!(read(&mut encoder, 2_000_000, &shaft), 1 << 31 | gray(RAW_AT_START + 5) << 6);
    }

    #[test]
    fn the_word_is_frozen_at_the_first_edge() {
        let mut encoder = SsiEncoder::default();
        let mut shaft = Spindle::default();
        shaft.turn_steadily(0, 4_000_000);
        let whole = read(&mut encoder, 1_000_000, &shaft);
        assert_eq!(whole, 1 << 31 | gray(shaft.raw(1_000_000)) << 6);
    }

    #[test]
    fn bytes_of_one_read_continue_the_word_and_a_pause_ends_it() {
        let mut encoder = SsiEncoder::default();
        let shaft = Spindle::default();
        let mut bytes = [0; 4];
        for (n, byte) in (0..).zip(&mut bytes) {
            *byte = u8::try_from(encoder.clock(n * 8 * PERIOD_NS, &shaft, 8, PERIOD_NS)).unwrap();
        }
        assert_eq!(u32::from_be_bytes(bytes), 1 << 31 | gray(RAW_AT_START) << 6);
        let end = 32 * PERIOD_NS;
        assert_eq!(encoder.clock(end + MONOFLOP_NS / 2, &shaft, 1, PERIOD_NS), 0);
        assert_eq!(encoder.clock(end + 3 * MONOFLOP_NS, &shaft, 1, PERIOD_NS), 1);
    }

    #[test]
    fn a_broken_or_shorted_line_fails_the_idle_or_the_monoflop_check() {
        let shaft = Spindle::default();
        for (line, sampled) in [(Line::Open, u32::MAX), (Line::StuckLow, 0)] {
            let mut encoder = SsiEncoder { line, ..SsiEncoder::default() };
            assert_eq!(read(&mut encoder, 0, &shaft), sampled, "{line:?}");
        }
    }

    #[test]
    fn gray_code_changes_one_bit_per_step() {
        for value in [0, 1, 2, 0xFFF, 0x1000, RAW_AT_START - 1] {
            assert_eq!((gray(value) ^ gray(value + 1)).count_ones(), 1);
        }
        assert_eq!(gray(0b110), 0b101);
    }
}
