//! From the bits of the sensor to hundredths of a millimetre.

use positioning::chain::{Correction, CountingDirection, Params};
use positioning::encoder::{NM17X, TurnOffset};
use positioning::ssi::{Code, Format};
use units::{Position, Scaling, Steps};

/// A length by scaling alone.
struct Length {
    name: &'static str,
    scaling: u32,
    steps: i64,
    hundredths_mm: i32,
}

/// A read of the sensor and the position it means.
struct Read {
    name: &'static str,
    bits: [u8; 4],
    direction: CountingDirection,
    preset_offset: i64,
    hundredths_mm: i32,
}

/// NM17x POS-04, POS-05, A-54, A-58.
#[rustfmt::skip]
const LENGTHS: &[Length] = &[
    Length { name: "a turn of 2304 steps is a pitch of 4 mm", scaling: 1_736_111, steps: 2_304, hundredths_mm: 400 },
    Length { name: "a turn of 4096 steps is a pitch of 4 mm", scaling: 976_563, steps: 4_096, hundredths_mm: 400 },
    Length { name: "a step of 0.01 mm is itself", scaling: 10_000_000, steps: -12_345, hundredths_mm: -12_345 },
    Length { name: "half a hundredth is rounded up", scaling: 5_000_000, steps: 1, hundredths_mm: 1 },
    Length { name: "minus half a hundredth is rounded down", scaling: 5_000_000, steps: -1, hundredths_mm: -1 },
    Length { name: "less than half a hundredth is none", scaling: 4_999_999, steps: 1, hundredths_mm: 0 },
    Length { name: "the longest travel", scaling: 99_999_999, steps: 9_437_183, hundredths_mm: 94_371_829 },
    Length { name: "beyond 32 bits is the end of 32 bits", scaling: 99_999_999, steps: -9_000_000_000, hundredths_mm: i32::MIN },
];

/// NM17x POS-01 to POS-04, POS-09: idle bit, 25 bits of Gray code, monoflop.
#[rustfmt::skip]
const READS: &[Read] = &[
    // Turn 4096, angle 0 is 0x100_0000, in Gray code 0x180_0000.
    Read { name: "the middle turn is zero", bits: [0xE0, 0x00, 0x00, 0x00], direction: CountingDirection::ClockwiseUp, preset_offset: 0, hundredths_mm: 0 },
    // Turn 4097, angle 0 is 0x100_1000, in Gray code 0x180_1800.
    Read { name: "one turn up is 4 mm", bits: [0xE0, 0x06, 0x00, 0x00], direction: CountingDirection::ClockwiseUp, preset_offset: 0, hundredths_mm: 400 },
    Read { name: "one turn up counted down is -4 mm", bits: [0xE0, 0x06, 0x00, 0x00], direction: CountingDirection::ClockwiseDown, preset_offset: 0, hundredths_mm: -400 },
    // Turn 4095, angle 4095 is 0x0FF_FFFF, in Gray code 0x080_0000.
    Read { name: "one step below zero", bits: [0xA0, 0x00, 0x00, 0x00], direction: CountingDirection::ClockwiseUp, preset_offset: 0, hundredths_mm: 0 },
    // Turn 0, angle 0.
    Read { name: "the lowest place", bits: [0x80, 0x00, 0x00, 0x00], direction: CountingDirection::ClockwiseUp, preset_offset: 0, hundredths_mm: -1_638_400 },
    Read { name: "a preset of 5000.00 mm", bits: [0xE0, 0x00, 0x00, 0x00], direction: CountingDirection::ClockwiseUp, preset_offset: 2_880_000, hundredths_mm: 500_000 },
];

pub(crate) fn run(differs: &mut impl FnMut(&str)) -> usize {
    for Length { name, scaling, steps, hundredths_mm } in LENGTHS {
        let length = Scaling::from_ten_millionths(*scaling).to_position(Steps::new(*steps));
        if length.hundredths_mm() != *hundredths_mm {
            differs(name);
        }
    }
    for read in READS {
        if position(read) != Some(Position::from_hundredths_mm(read.hundredths_mm)) {
            differs(read.name);
        }
    }
    LENGTHS.len() + READS.len()
}

fn position(read: &Read) -> Option<Position> {
    let word = Format::new(NM17X.bits(), Code::Gray).decode(&read.bits).ok()?;
    let params = Params {
        direction: read.direction,
        scaling: Scaling::from_ten_millionths(1_736_111),
        preset_offset: Steps::new(read.preset_offset),
        correction: Correction::Off,
    };
    Some(params.position(NM17X.steps(word, TurnOffset::default())))
}
