use units::{Duration, Instant};

/// When something is due, if ever.
///
/// As small as the instant itself, and the earlier of two is their minimum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Deadline(Instant);

impl Deadline {
    /// Nothing is due.
    pub(crate) const NEVER: Self = Self(Instant::from_micros(u64::MAX));

    pub(crate) const fn at(instant: Instant) -> Self {
        Self(instant)
    }

    /// One `time` after `now`; no time at all switches off.
    #[inline(never)]
    pub(crate) fn after(now: Instant, time: Duration) -> Self {
        if time > Duration::ZERO { Self(now + time) } else { Self::NEVER }
    }

    /// One `period` later: in step unless that is over, too.
    #[inline(never)]
    pub(crate) fn next(self, now: Instant, period: Duration) -> Self {
        let next_at = self.0 + period;
        Self(if next_at > now { next_at } else { now + period })
    }

    /// The earlier of two, where size counts more than time.
    #[inline(never)]
    pub(crate) fn or_earlier(self, other: Self) -> Self {
        self.min(other)
    }

    pub(crate) fn is_due(self, now: Instant) -> bool {
        self.0 <= now
    }

    pub(crate) fn instant(self) -> Option<Instant> {
        (self != Self::NEVER).then_some(self.0)
    }
}

impl From<Option<Instant>> for Deadline {
    fn from(instant: Option<Instant>) -> Self {
        instant.map_or(Self::NEVER, Self)
    }
}
