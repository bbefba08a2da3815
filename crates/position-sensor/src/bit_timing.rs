use units::{Duration, Instant};

/// A change of the bit rate on the way: all devices of the bus are silent before and behind it
/// (CiA 305, activate bit timing; encoder B-37).
#[derive(Clone, Copy, Debug)]
pub(crate) struct BitTiming {
    pub(crate) bit_rate: u32,
    delay: Duration,
    silence: Silence,
}

#[derive(Clone, Copy, Debug)]
enum Silence {
    Before { until: Instant },
    Behind { until: Instant },
}

/// What a change of the bit rate asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Be a new node at the new rate, and say nothing yet.
    Switch,
    /// Boot.
    Boot,
}

impl BitTiming {
    /// The silence before the change to `bit_rate`, in bit/s, begins.
    pub(crate) fn new(now: Instant, bit_rate: u32, delay: Duration) -> Self {
        Self { bit_rate, delay, silence: Silence::Before { until: now + delay } }
    }

    /// When a silence ends.
    pub(crate) const fn due_at(&self) -> Instant {
        match self.silence {
            Silence::Before { until } | Silence::Behind { until } => until,
        }
    }

    /// The next step, once a silence has ended, and what is left of the change.
    pub(crate) fn step(self, now: Instant) -> Option<(Step, Option<Self>)> {
        if now < self.due_at() {
            return None;
        }
        Some(match self.silence {
            Silence::Before { .. } => {
                let silence = Silence::Behind { until: now + self.delay };
                (Step::Switch, Some(Self { silence, ..self }))
            }
            Silence::Behind { .. } => (Step::Boot, None),
        })
    }
}
