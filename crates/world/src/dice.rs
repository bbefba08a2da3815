//! Chance that repeats: every random choice of the bench comes from a seed.

/// A sequence of random numbers (SplitMix64).
#[derive(Clone, Debug)]
pub struct Dice(u64);

impl Dice {
    /// The sequence of `seed` for one purpose: the same seed gives another sequence for another
    /// `purpose`.
    #[must_use]
    pub fn new(seed: u64, purpose: u64) -> Self {
        let mut dice = Self(seed ^ purpose.wrapping_mul(0xA24B_AED4_963E_E407));
        dice.draw();
        dice
    }

    /// 64 random bits.
    pub fn draw(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A number below `limit`, which is not 0.
    pub fn below(&mut self, limit: u64) -> u64 {
        let product = u128::from(self.draw()) * u128::from(limit);
        u64::try_from(product >> 64).expect("a product with a fraction of 2⁶⁴ fits")
    }

    /// True with `probability`, 0 to 1. Draws nothing at 0, so that a fault that is off leaves the
    /// sequence where it is.
    pub fn hits(&mut self, probability: f64) -> bool {
        const PARTS: u32 = 1 << 31;
        probability > 0.0
            && f64::from(u32::try_from(self.below(u64::from(PARTS))).expect("below 2³¹"))
                < probability * f64::from(PARTS)
    }
}
