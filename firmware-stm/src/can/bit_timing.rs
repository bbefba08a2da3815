//! Bit timing of the nine CiA bit rates (CiA 301 section 5.3, RM0090 section 32.7.7).
//!
//! A bit is one quantum for synchronisation, `before` quanta up to the sample point and `after`
//! quanta behind it. Found by search at compile time; a rate that cannot be had exactly, or whose
//! sample point lies outside what CiA 301 permits, does not compile.
use firmware_board::APB1_HZ;

/// Where CiA 301 wants the sample point, in thousandths of a bit.
const SAMPLE_POINT: u32 = 875;

#[derive(Clone, Copy)]
struct BitTiming {
    prescaler: u32,
    before: u32,
    after: u32,
}

impl BitTiming {
    const fn quanta(self) -> u32 {
        1 + self.before + self.after
    }

    /// In thousandths of a bit.
    const fn sample_point(self) -> u32 {
        (1 + self.before) * 1_000 / self.quanta()
    }

    /// The widest synchronisation jump the hardware and the second segment allow.
    const fn jump(self) -> u32 {
        if self.after < JUMP_MAX { self.after } else { JUMP_MAX }
    }

    /// Register BTR.
    const fn register(self) -> u32 {
        (self.prescaler - 1)
            | (self.before - 1) << 16
            | (self.after - 1) << 20
            | (self.jump() - 1) << 24
    }
}

/// Limits of register BTR.
const PRESCALER_MAX: u32 = 1_024;
const BEFORE_MAX: u32 = 16;
const AFTER_MAX: u32 = 8;
const JUMP_MAX: u32 = 4;
/// Fewer quanta would make the phase errors of resynchronisation too coarse.
const QUANTA_MIN: u32 = 8;

/// The exact timing for `bit_rate` (bit/s) whose sample point is nearest to [`SAMPLE_POINT`]; the
/// one with more quanta if several are equally near.
const fn exact(bit_rate: u32) -> BitTiming {
    assert!(APB1_HZ.is_multiple_of(bit_rate));
    let clocks = APB1_HZ / bit_rate;
    let mut best: Option<BitTiming> = None;
    let mut before = 1;
    while before <= BEFORE_MAX {
        let mut after = 1;
        while after <= AFTER_MAX {
            let quanta = 1 + before + after;
            if quanta >= QUANTA_MIN
                && clocks.is_multiple_of(quanta)
                && clocks / quanta <= PRESCALER_MAX
            {
                let found = BitTiming { prescaler: clocks / quanta, before, after };
                best = match best {
                    Some(so_far) if !better(found, so_far) => best,
                    _ => Some(found),
                };
            }
            after += 1;
        }
        before += 1;
    }
    let timing = best.expect("no exact timing for this bit rate");
    assert!(timing.prescaler * timing.quanta() * bit_rate == APB1_HZ);
    // CiA 301 table 1: 75..90 % from 800 kbit/s, 85..90 % below.
    let earliest = if bit_rate >= 800_000 { 750 } else { 850 };
    assert!(timing.sample_point() >= earliest && timing.sample_point() <= 900);
    // Exactly 87.5 % everywhere but at 800 kbit/s, where 40 MHz leaves 90 % or 80 %.
    assert!(timing.sample_point() == SAMPLE_POINT || bit_rate == 800_000);
    timing
}

const fn better(a: BitTiming, b: BitTiming) -> bool {
    let (off_a, off_b) =
        (a.sample_point().abs_diff(SAMPLE_POINT), b.sample_point().abs_diff(SAMPLE_POINT));
    off_a < off_b || (off_a == off_b && a.quanta() > b.quanta())
}

/// The nine bit rates in bit/s, in the order of the CiA bit timing table (CiA 305), with register
/// BTR.
static REGISTERS: [(u32, u32); 9] = [
    registers(1_000_000),
    registers(800_000),
    registers(500_000),
    registers(250_000),
    registers(125_000),
    registers(100_000),
    registers(50_000),
    registers(20_000),
    registers(10_000),
];

const fn registers(bit_rate: u32) -> (u32, u32) {
    (bit_rate, exact(bit_rate).register())
}

/// Register BTR for `bit_rate` in bit/s; `None` if it is none of the nine.
pub(super) fn register(bit_rate: u32) -> Option<u32> {
    REGISTERS.iter().find(|(rate, _)| *rate == bit_rate).map(|(_, register)| *register)
}
