use object_dictionary::Values;
use units::{Duration, Instant};

use crate::deadline::Deadline;
use crate::parameter::parameter;

/// The time between two guarding requests, in milliseconds.
pub(crate) const GUARD_TIME: u16 = 0x100C;
/// How many of them make the life time.
pub(crate) const LIFE_TIME_FACTOR: u16 = 0x100D;

/// The guarded side of node guarding and life guarding (CiA 301, section 7.2.8.2.2; objects 0x100C
/// and 0x100D).
///
/// Every request is answered, with a toggle bit that starts at 0. The first one starts life
/// guarding, where both objects are not 0. A node that sends heartbeats does neither.
#[derive(Debug)]
pub(crate) struct Guarded {
    toggle: Toggle,
    life_time: Duration,
    life: Life,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Toggle {
    Clear,
    Set,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    /// Not before the first request.
    Unguarded,
    Guarded {
        until: Deadline,
    },
    Lost,
}

/// What a request changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Request {
    Expected,
    /// The node was given up.
    Recovered,
}

impl Guarded {
    /// `None` when the product has no guard time.
    pub(crate) fn new<const LEN: usize>(values: &Values<LEN>) -> Option<Self> {
        parameter(values, GUARD_TIME, 0)?;
        let mut guarded =
            Self { toggle: Toggle::Clear, life_time: Duration::ZERO, life: Life::Unguarded };
        guarded.reread(values);
        Some(guarded)
    }

    /// Takes both objects over again. Life guarding starts anew with the next request.
    pub(crate) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>) {
        let value = |index| u64::from(parameter(values, index, 0).unwrap_or(0));
        self.life_time = Duration::from_millis(value(GUARD_TIME)) * value(LIFE_TIME_FACTOR);
        self.stop();
    }

    /// Ends life guarding until the next request.
    pub(crate) fn stop(&mut self) {
        self.life = Life::Unguarded;
    }

    /// Takes a request.
    pub(crate) fn handle(&mut self, now: Instant) -> Request {
        let before = self.life;
        self.life = Life::Guarded { until: Deadline::after(now, self.life_time) };
        match before {
            Life::Lost => Request::Recovered,
            Life::Unguarded | Life::Guarded { .. } => Request::Expected,
        }
    }

    /// The answer of a node whose heartbeat would be `state`.
    pub(crate) const fn answer(&mut self, state: u8) -> u8 {
        const TOGGLE: u8 = 1 << 7;
        match self.toggle {
            Toggle::Clear => {
                self.toggle = Toggle::Set;
                state
            }
            Toggle::Set => {
                self.toggle = Toggle::Clear;
                state | TOGGLE
            }
        }
    }

    /// When the node counts as lost.
    pub(crate) const fn due_at(&self) -> Deadline {
        match self.life {
            Life::Guarded { until } => until,
            Life::Unguarded | Life::Lost => Deadline::NEVER,
        }
    }

    /// Whether the node is lost from now on.
    pub(crate) fn take_due(&mut self, now: Instant) -> bool {
        let due = self.due_at().is_due(now);
        if due {
            self.life = Life::Lost;
        }
        due
    }

    /// Whether the node is lost.
    pub(crate) fn is_lost(&self) -> bool {
        self.life == Life::Lost
    }
}
