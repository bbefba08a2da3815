use core::cmp::Ordering;

use units::{Duration, Instant};

/// When something is due, if ever.
///
/// As small as the instant itself, and the earlier of two is their minimum. Kept is how long before
/// the end of the clock it is, so that nothing is due in memory that is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Deadline(u64);

impl Deadline {
    /// Nothing is due.
    pub(crate) const NEVER: Self = Self(0);

    pub(crate) const fn at(instant: Instant) -> Self {
        Self(!instant.as_micros())
    }

    /// One `time` after `now`; no time at all switches off.
    #[inline(never)]
    pub(crate) fn after(now: Instant, time: Duration) -> Self {
        if time > Duration::ZERO { Self::at(now + time) } else { Self::NEVER }
    }

    /// One `period` later: in step unless that is over, too.
    #[inline(never)]
    pub(crate) fn next(self, now: Instant, period: Duration) -> Self {
        let next_at = Instant::from_micros(!self.0) + period;
        Self::at(if next_at > now { next_at } else { now + period })
    }

    /// The earlier of two, where size counts more than time.
    #[inline(never)]
    pub(crate) fn or_earlier(self, other: Self) -> Self {
        self.min(other)
    }

    pub(crate) fn is_due(self, now: Instant) -> bool {
        !self.0 <= now.as_micros()
    }

    pub(crate) fn instant(self) -> Option<Instant> {
        (self != Self::NEVER).then_some(Instant::from_micros(!self.0))
    }
}

impl Ord for Deadline {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.cmp(&self.0)
    }
}

impl PartialOrd for Deadline {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl From<Option<Instant>> for Deadline {
    fn from(instant: Option<Instant>) -> Self {
        instant.map_or(Self::NEVER, Self::at)
    }
}
