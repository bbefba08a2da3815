//! A client's place on the bus.

use world::can::{Bus, ErrorCounters, Frame, Nanos, Outside, QueueFull, Rate, Role, Status};

/// What is known of a node somebody else took off the bus.
const DETACHED: Status =
    Status { counters: ErrorCounters::NONE, errors: 0, sent: 0, waiting: 0, dropped: 0 };

/// A node of the bus that belongs to a client; [`Attachment::detach`] takes it off again.
#[derive(Debug)]
pub struct Attachment {
    outside: Outside,
    role: Role,
    errors_reported: u64,
}

impl Attachment {
    /// Joins `bus`.
    pub fn attach(bus: &mut Bus, rate: Rate, role: Role) -> Self {
        Self { outside: bus.attach(rate, role), role, errors_reported: 0 }
    }

    /// Leaves `bus`, with whatever was waiting.
    pub fn detach(self, bus: &mut Bus) {
        bus.detach(self.outside);
    }

    /// Whether it sends and acknowledges.
    #[must_use]
    pub const fn role(&self) -> Role {
        self.role
    }

    /// Queues `frame` for sending.
    ///
    /// # Errors
    /// When as many frames are waiting as may.
    pub fn send(&self, bus: &mut Bus, frame: Frame) -> Result<(), QueueFull> {
        bus.send(self.outside, frame)
    }

    /// The next frame received, and when.
    pub fn receive(&self, bus: &mut Bus) -> Option<(Nanos, Frame)> {
        bus.receive(self.outside)
    }

    /// How the node is doing.
    #[must_use]
    pub fn status(&self, bus: &Bus) -> Status {
        bus.status(self.outside).unwrap_or(DETACHED)
    }

    /// How many failed frames it saw since the last call.
    pub fn new_errors(&mut self, bus: &Bus) -> u64 {
        let errors = self.status(bus).errors;
        let new = errors.saturating_sub(self.errors_reported);
        self.errors_reported = errors;
        new
    }
}
