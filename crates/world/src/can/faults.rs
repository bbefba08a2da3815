/// What is wrong with the cable.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Faults {
    /// Probability that a frame is disturbed, 0 to 1: a bit of it arrives inverted at every node.
    pub error_rate: f64,
    /// Nobody acknowledges.
    pub no_ack: bool,
    /// The bus is held dominant: nothing can be sent, everybody counts receive errors.
    pub stuck_dominant: bool,
}

/// Repeatable random numbers: the same seed gives the same disturbances (SplitMix64).
#[derive(Clone, Debug)]
pub(crate) struct Chance(u64);

impl Chance {
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// True with probability `probability` (0 to 1).
    pub(crate) fn happens(&mut self, probability: f64) -> bool {
        const STEPS: u32 = 1 << 30;
        let [a, b, c, d, ..] = self.next().to_le_bytes();
        let drawn = u32::from_le_bytes([a, b, c, d]) % STEPS;
        f64::from(drawn) < probability * f64::from(STEPS)
    }

    /// A number from `from` to `to`, both included; `from` when the range is empty.
    pub(crate) fn between(&mut self, from: u32, to: u32) -> u32 {
        let span = u64::from(to.saturating_sub(from)) + 1;
        from + u32::try_from(self.next() % span).unwrap_or(0)
    }
}
