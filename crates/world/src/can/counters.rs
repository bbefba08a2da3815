use super::port::{Activity, WireError};
use super::time::{BitTime, Nanos};

/// What a node may still do on the bus (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Confinement {
    /// Everything; it answers errors with six dominant bits.
    ErrorActive,
    /// Send and receive, but its error flags are recessive and it pauses after sending.
    ErrorPassive,
    /// Nothing until 128 times 11 recessive bits were seen.
    BusOff,
}

/// Transmit and receive error counters of one node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ErrorCounters {
    transmit: u16,
    receive: u8,
}

/// A node is error-passive when a counter is above this.
const ACTIVE_MAX: u16 = 127;
/// A node is off the bus when its transmit counter is above this.
const PASSIVE_MAX: u16 = 255;
/// Where the receive counter of an error-passive node goes on after a good frame: ISO 11898-1
/// leaves 119 to 127 open, the STM32 manual names 120 (RM0090, 32.7.6).
const RECEIVE_AFTER_PASSIVE: u8 = 120;
/// What an error costs a transmitter, and a receiver that noticed it before all others.
const HEAVY: u8 = 8;

impl ErrorCounters {
    /// A node that has seen no error.
    pub const NONE: Self = Self { transmit: 0, receive: 0 };

    /// The transmit error counter, 0 to 263 (above 255 the node is off the bus).
    #[must_use]
    pub const fn transmit(&self) -> u16 {
        self.transmit
    }

    /// The receive error counter, 0 to 255.
    #[must_use]
    pub const fn receive(&self) -> u8 {
        self.receive
    }

    /// What the node may do.
    #[must_use]
    pub const fn confinement(&self) -> Confinement {
        if self.transmit > PASSIVE_MAX {
            Confinement::BusOff
        } else if self.transmit > ACTIVE_MAX || self.receive as u16 > ACTIVE_MAX {
            Confinement::ErrorPassive
        } else {
            Confinement::ErrorActive
        }
    }

    /// After a frame of its own went through.
    #[must_use]
    pub const fn transmitted(self) -> Self {
        Self { transmit: self.transmit.saturating_sub(1), ..self }
    }

    /// After a frame of another node was good.
    #[must_use]
    pub const fn received(self) -> Self {
        let receive = if self.receive as u16 > ACTIVE_MAX {
            RECEIVE_AFTER_PASSIVE
        } else {
            self.receive.saturating_sub(1)
        };
        Self { receive, ..self }
    }

    /// After a frame of its own failed. An error-passive node that only misses the acknowledgement
    /// does not count it: it may simply be alone.
    #[must_use]
    pub fn transmit_failed(self, error: WireError) -> Self {
        match (self.confinement(), error) {
            (Confinement::BusOff, _) | (Confinement::ErrorPassive, WireError::Ack) => self,
            (
                Confinement::ErrorActive | Confinement::ErrorPassive,
                WireError::Stuff
                | WireError::Form
                | WireError::Ack
                | WireError::BitRecessive
                | WireError::BitDominant
                | WireError::Crc,
            ) => Self { transmit: self.transmit + u16::from(HEAVY), ..self },
        }
    }

    /// After an error in a frame of another node, noticed together with all others.
    #[must_use]
    pub const fn receive_failed(self) -> Self {
        Self { receive: self.receive.saturating_add(1), ..self }
    }

    /// After an error in a frame of another node that this node noticed before all others: it finds
    /// a dominant bit behind its own error flag.
    #[must_use]
    pub const fn receive_failed_first(self) -> Self {
        Self { receive: self.receive.saturating_add(1 + HEAVY), ..self }
    }
}

/// Bits of one sequence a node counts while it waits to join the bus.
const SEQUENCE_BITS: u32 = 11;

/// A node waiting for the bus: for one sequence of 11 recessive bits to join it, for
/// [`RecessiveWait::AFTER_BUS_OFF`] of them to come back from bus-off. Every frame ends in one
/// (acknowledge delimiter, end of frame, intermission), an idle bus gives one after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecessiveWait {
    left: u32,
    run_from: Nanos,
    bit: BitTime,
}

impl RecessiveWait {
    /// Sequences that end bus-off.
    pub const AFTER_BUS_OFF: u32 = 128;
    /// Sequences to join the bus.
    pub const TO_JOIN: u32 = 1;

    /// Waits for `sequences` from `from` on.
    #[must_use]
    pub const fn new(sequences: u32, from: Nanos, bit: BitTime) -> Self {
        Self { left: sequences, run_from: from, bit }
    }

    /// When the wait is over, if nobody sends any more.
    #[must_use]
    pub const fn over_at(&self) -> Nanos {
        self.run_from.after(self.bit.bits(SEQUENCE_BITS.saturating_mul(self.left)))
    }

    /// Takes something that went over the bus into account.
    pub fn interrupted(&mut self, activity: &Activity) {
        if self.over_at() <= activity.start || activity.quiet_from <= self.run_from {
            return;
        }
        let sequence = self.bit.bits(SEQUENCE_BITS).max(1);
        let seen = activity.start.since(self.run_from) / sequence;
        self.left = self.left.saturating_sub(u32::try_from(seen).unwrap_or(u32::MAX)).max(1);
        self.run_from = activity.quiet_from;
    }
}
