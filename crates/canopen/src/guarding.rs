use object_dictionary::Values;

use crate::deadline::{Deadline, Moment, Span};
use crate::parameter::{number, parameter};

/// The time between two guarding requests, in milliseconds.
pub(crate) const GUARD_TIME: u16 = 0x100C;
/// How many of them make the life time.
pub(crate) const LIFE_TIME_FACTOR: u16 = 0x100D;

/// The guarded side of node guarding and life guarding (CiA 301, section 7.2.8.2.2; objects 0x100C
/// and 0x100D).
///
/// Every request is answered, with a toggle bit that starts at 0. The first one starts life
/// guarding, where both objects are not 0; the life time, their product, ends at 35 minutes and 47
/// seconds. A node that sends heartbeats does neither.
#[derive(Debug)]
pub(crate) struct Guarded {
    /// Whether the product has a guard time.
    is_served: bool,
    /// Bit 7 of the next answer.
    toggle: u8,
    /// Guard time × life time factor, at most [`Span::MAX`].
    life_time: Span,
    /// Only while the node is guarded: not before the first request.
    lost_at: Deadline,
    is_lost: bool,
}

impl Guarded {
    /// As in a product without its objects.
    pub(crate) const fn off() -> Self {
        Self {
            is_served: false,
            toggle: 0,
            life_time: Span::ZERO,
            lost_at: Deadline::NEVER,
            is_lost: false,
        }
    }

    /// Takes both objects over. Life guarding starts anew with the next request.
    pub(crate) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>) {
        let guard_time = parameter(values, GUARD_TIME, 0);
        self.is_served = guard_time.is_some();
        self.life_time =
            Span::from_millis(guard_time.unwrap_or(0)).times(number(values, LIFE_TIME_FACTOR, 0));
        self.stop();
    }

    /// Whether requests are answered.
    pub(crate) const fn is_served(&self) -> bool {
        self.is_served
    }

    /// Ends life guarding until the next request.
    pub(crate) fn stop(&mut self) {
        self.lost_at = Deadline::NEVER;
        self.is_lost = false;
    }

    /// Takes a request. Whether the node had been given up.
    pub(crate) fn handle(&mut self, now: Moment) -> bool {
        self.lost_at = Deadline::after(now, self.life_time);
        core::mem::take(&mut self.is_lost)
    }

    /// The answer of a node whose heartbeat would be `state`.
    pub(crate) const fn answer(&mut self, state: u8) -> u8 {
        const TOGGLE: u8 = 1 << 7;
        let answer = state | self.toggle;
        self.toggle ^= TOGGLE;
        answer
    }

    /// When the node counts as lost.
    pub(crate) const fn due_at(&self) -> Deadline {
        self.lost_at
    }

    /// Whether the node is lost from now on.
    pub(crate) fn take_due(&mut self, now: Moment) -> bool {
        let is_due = self.lost_at.take_due(now);
        self.is_lost |= is_due;
        is_due
    }

    /// Whether the node is lost.
    pub(crate) const fn is_lost(&self) -> bool {
        self.is_lost
    }
}
