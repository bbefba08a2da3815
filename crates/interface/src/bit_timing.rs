use canopen::NodeId;
use canopen::lss::BitRate;
use units::{Duration, Instant};

/// A change of the bit rate on the way: all devices of the bus are silent before and behind it
/// (CiA 305, activate bit timing; A-26).
#[derive(Clone, Copy, Debug)]
pub(crate) struct BitTiming {
    bit_rate: BitRate,
    node_id: NodeId,
    delay: Duration,
    silence: Silence,
}

#[derive(Clone, Copy, Debug)]
enum Silence {
    Before { until: Instant },
    Behind { until: Instant },
}

/// What a change of the bit rate asks for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Step {
    /// Be a new node at the new rate, and say nothing yet.
    Switch(BitRate, NodeId),
    /// Boot.
    Boot,
}

impl BitTiming {
    /// The silence begins. The node behind it has `node_id`.
    pub(crate) fn new(now: Instant, bit_rate: BitRate, node_id: NodeId, delay: Duration) -> Self {
        Self { bit_rate, node_id, delay, silence: Silence::Before { until: now + delay } }
    }

    /// When a silence ends.
    pub(crate) const fn due_at(&self) -> Instant {
        match self.silence {
            Silence::Before { until } | Silence::Behind { until } => until,
        }
    }

    /// The next step and what is left of the change, once a silence has ended.
    pub(crate) fn step(self, now: Instant) -> Option<(Step, Option<Self>)> {
        if now < self.due_at() {
            return None;
        }
        Some(match self.silence {
            Silence::Before { .. } => {
                let silence = Silence::Behind { until: now + self.delay };
                (Step::Switch(self.bit_rate, self.node_id), Some(Self { silence, ..self }))
            }
            Silence::Behind { .. } => (Step::Boot, None),
        })
    }
}
