//! Time inside the stack: the clock of the node, of which 32 bits do. They come round after 71
//! minutes, so a moment is before or after another one only if less than half of that lies between.

use units::{Duration, Instant};

/// A point in time. The microseconds of an [`Instant`], without their high bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Moment(u32);

/// A span of time in microseconds, at most [`Self::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Span(u32);

/// When something is due, if ever.
///
/// What is due has to be cleared before it is half a round old, or it seems to lie ahead. So nobody
/// keeps one that is over: [`crate::Node::handle_timeout`] clears all that are due, also the end of an
/// inhibit time that holds nothing back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Deadline(u32);

impl From<Instant> for Moment {
    fn from(instant: Instant) -> Self {
        let [a, b, c, d, ..] = instant.as_micros().to_le_bytes();
        Self(u32::from_le_bytes([a, b, c, d]))
    }
}

impl Span {
    pub(crate) const ZERO: Self = Self(0);

    /// 35 minutes and 47 seconds: less than half a round of the clock, and less than never.
    pub(crate) const MAX_US: u32 = i32::MAX.unsigned_abs() - 1;

    pub(crate) const MAX: Self = Self(Self::MAX_US);

    pub(crate) const fn from_micros(us: u32) -> Self {
        if us < Self::MAX_US { Self(us) } else { Self::MAX }
    }

    pub(crate) const fn from_millis(ms: u32) -> Self {
        Self(1_000).times(ms)
    }

    #[inline(never)]
    pub(crate) const fn times(self, number: u32) -> Self {
        Self::from_micros(self.0.saturating_mul(number))
    }
}

impl From<Duration> for Span {
    fn from(time: Duration) -> Self {
        u32::try_from(time.as_micros()).map_or(Self::MAX, Self::from_micros)
    }
}

impl Deadline {
    /// Nothing is due.
    pub(crate) const NEVER: Self = Self(0);

    /// The one moment that means [`Self::NEVER`] gives way to the microsecond before.
    pub(crate) const fn at(Moment(us): Moment) -> Self {
        Self(if us == Self::NEVER.0 { u32::MAX } else { us })
    }

    /// One `time` after `now`; no time at all switches off.
    #[inline(never)]
    pub(crate) fn after(Moment(now): Moment, time: Span) -> Self {
        if time > Span::ZERO { Self::at(Moment(now.wrapping_add(time.0))) } else { Self::NEVER }
    }

    /// One `period` later: in step unless that is over, too.
    #[inline(never)]
    pub(crate) fn next(self, now: Moment, period: Span) -> Self {
        let next = Self::after(Moment(self.0), period);
        if next.is_due(now) { Self::after(now, period) } else { next }
    }

    /// No later than one `time` after `now`, unless it is never.
    pub(crate) fn limited(self, now: Moment, time: Span) -> Self {
        let is_late = self != Self::NEVER && self.left_us(now) > time.0.cast_signed();
        if is_late { Self::after(now, time) } else { self }
    }

    /// The earlier of two.
    #[inline(never)]
    pub(crate) fn or_earlier(self, other: Self, now: Moment) -> Self {
        if other.left_us(now) < self.left_us(now) { other } else { self }
    }

    pub(crate) fn is_due(self, now: Moment) -> bool {
        self.left_us(now) <= 0
    }

    /// Whether it is due, which it then is no more.
    pub(crate) fn take_due(&mut self, now: Moment) -> bool {
        let is_due = self.is_due(now);
        if is_due {
            *self = Self::NEVER;
        }
        is_due
    }

    /// When it comes on a clock that shows `now`; `now` for what is overdue.
    pub(crate) fn instant(self, now: Instant) -> Instant {
        let left_us = self.left_us(now.into()).max(0).unsigned_abs();
        now + Duration::from_micros(left_us.into())
    }

    /// What is left until then, below zero what has passed since; for never, more than for all others.
    fn left_us(self, Moment(now): Moment) -> i32 {
        if self == Self::NEVER { i32::MAX } else { self.0.wrapping_sub(now).cast_signed() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Wherever the clock comes round, and at the moment that means never.
    #[test]
    fn a_deadline_is_the_same_on_both_sides_of_the_wrap() {
        for now in [1, 0, u32::MAX, u32::MAX - 9, u32::MAX / 2, u32::MAX / 2 + 1] {
            let after = |us: u32| Moment(now.wrapping_add(us));
            let deadline = Deadline::after(Moment(now), Span(10));
            assert!(!deadline.is_due(after(8)), "{now}");
            assert!(deadline.is_due(after(10)), "{now}");
            assert!(deadline.is_due(after(1_800_000_000)), "half an hour after {now}");
            assert!(Deadline::at(Moment(now)).is_due(Moment(now)), "{now}");
            assert!(
                !Deadline::after(Moment(now), Span::MAX).is_due(after(Span::MAX.0 - 2)),
                "{now}"
            );
            let last = Deadline::after(Moment(now), Span::MAX);
            assert_eq!(Deadline::NEVER.or_earlier(last, Moment(now)), last);
            let later = Deadline::after(Moment(now), Span(20));
            assert_eq!(later.or_earlier(deadline, Moment(now)), deadline);
            assert_eq!(deadline.or_earlier(later, Moment(now)), deadline);
            assert_eq!(Deadline::NEVER.or_earlier(later, Moment(now)), later);
            assert_eq!(later.limited(Moment(now), Span(10)), deadline);
            assert_eq!(deadline.limited(Moment(now), Span(20)), deadline);
            assert_eq!(Deadline::NEVER.limited(Moment(now), Span(20)), Deadline::NEVER);
        }
    }

    #[test]
    fn spans_end_at_half_a_round() {
        assert_eq!(Span::from_millis(u32::MAX), Span::MAX);
        assert_eq!(Span::from(Duration::from_millis(5_000_000)), Span::MAX);
        assert_eq!(Span::from_millis(65_535).times(255), Span::MAX);
        assert_eq!(Span::from_millis(65_535), Span(65_535_000));
    }
}
