use units::Instant;

/// An instant on the virtual clock, in nanoseconds since power-on of the bench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Nanos(pub u64);

impl Nanos {
    /// Power-on of the bench.
    pub const ZERO: Self = Self(0);

    /// `at`, exactly.
    #[must_use]
    pub const fn from_instant(at: Instant) -> Self {
        Self(at.as_micros().saturating_mul(1000))
    }

    /// The microsecond this instant lies in.
    #[must_use]
    pub const fn instant(self) -> Instant {
        Instant::from_micros(self.0 / 1000)
    }

    /// `ns` nanoseconds later.
    #[must_use]
    pub const fn after(self, ns: u64) -> Self {
        Self(self.0.saturating_add(ns))
    }

    /// Nanoseconds passed since `earlier`; 0 when `earlier` is later.
    #[must_use]
    pub const fn since(self, earlier: Self) -> u64 {
        self.0.saturating_sub(earlier.0)
    }
}

/// How long one bit takes, in picoseconds: every rate a controller can be set to is a whole number
/// of them, or off by less than one part in a million.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BitTime(u64);

const PS_PER_S: u64 = 1_000_000_000_000;
const PS_PER_NS: u64 = 1000;

/// Two nodes understand each other when their bit times differ by at most one part in this many.
/// (CiA 301 asks for crystals; ISO 11898-1 bears about 1.5 % with the best of bit timings.)
const TOLERANCE: u64 = 100;

impl BitTime {
    /// The bit time at `bits_per_second`. A rate of 0 counts as 1.
    #[must_use]
    pub const fn from_rate(bits_per_second: u32) -> Self {
        let rate = if bits_per_second == 0 { 1 } else { bits_per_second };
        Self(PS_PER_S / rate as u64)
    }

    /// `cycles` of a clock of `hz`. A clock that stands (0) counts as 1 Hz.
    #[must_use]
    pub fn from_cycles(cycles: u32, hz: u64) -> Self {
        Self((u64::from(cycles) * PS_PER_S / hz.max(1)).max(1))
    }

    /// The rate, rounded to the nearest bit per second.
    #[must_use]
    pub fn rate(self) -> u32 {
        u32::try_from((PS_PER_S + self.0 / 2) / self.0).unwrap_or(u32::MAX)
    }

    /// How long `bits` take, in nanoseconds.
    #[must_use]
    pub const fn bits(self, bits: u32) -> u64 {
        self.0.saturating_mul(bits as u64) / PS_PER_NS
    }

    /// How many whole bits fit into `ns` nanoseconds.
    #[must_use]
    pub fn whole_bits(self, ns: u64) -> u32 {
        u32::try_from(ns.saturating_mul(PS_PER_NS) / self.0).unwrap_or(u32::MAX)
    }

    /// Whether a node at this rate understands one at `other`.
    #[must_use]
    pub const fn matches(self, other: Self) -> bool {
        self.0.abs_diff(other.0).saturating_mul(TOLERANCE) <= self.0
    }
}
