use std::collections::VecDeque;

use super::counters::{Confinement, ErrorCounters, RecessiveWait};
use super::frame::Frame;
use super::port::{Activity, Outcome, Request, What};
use super::time::{BitTime, Nanos};

/// Frames an outside node may have waiting to be sent.
pub const SEND_MAX: usize = 256;
/// Frames kept for an outside node that does not fetch them; older ones are dropped and counted.
pub const RECEIVE_MAX: usize = 65_536;

/// An outside node, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Outside(pub(super) u64);

/// Which bit rate an outside node works at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rate {
    /// This many bits per second, right or wrong.
    Fixed(u32),
    /// Always the one of the devices: the first device on the bus, or the last rate seen there.
    Automatic,
}

/// What an outside node does on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It sends, acknowledges and flags errors as every node.
    Normal,
    /// It only listens.
    ListenOnly,
}

/// The node has as many frames waiting as it may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QueueFull;

impl std::fmt::Display for QueueFull {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{SEND_MAX} frames are waiting already")
    }
}

impl std::error::Error for QueueFull {}

/// No such node: it was never attached or is detached.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownOutside;

/// How an outside node is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status {
    /// Its error counters.
    pub counters: ErrorCounters,
    /// Errors it saw: failed frames of its own and of others.
    pub errors: u64,
    /// Frames it sent.
    pub sent: u64,
    /// Frames waiting to be sent.
    pub waiting: usize,
    /// Received frames dropped because nobody fetched them.
    pub dropped: u64,
}

/// An outside node's end of the bus.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) name: Outside,
    pub(super) rate: Rate,
    pub(super) role: Role,
    pub(super) since: Nanos,
    pub(super) counters: ErrorCounters,
    pub(super) suspended_until: Nanos,
    to_send: VecDeque<(Nanos, Frame)>,
    received: VecDeque<(Nanos, Frame)>,
    recovery: Option<RecessiveWait>,
    errors: u64,
    sent: u64,
    dropped: u64,
}

impl Node {
    pub(super) fn new(name: Outside, rate: Rate, role: Role, since: Nanos) -> Self {
        Self {
            name,
            rate,
            role,
            since,
            counters: ErrorCounters::NONE,
            suspended_until: Nanos::ZERO,
            to_send: VecDeque::new(),
            received: VecDeque::new(),
            recovery: None,
            errors: 0,
            sent: 0,
            dropped: 0,
        }
    }

    /// The frame at the head of the queue.
    pub(super) fn request(&self) -> Option<Request> {
        self.to_send.front().map(|&(at, frame)| Request { at, withdrawn_at: None, frame })
    }

    pub(super) fn status(&self) -> Status {
        Status {
            counters: self.counters,
            errors: self.errors,
            sent: self.sent,
            waiting: self.to_send.len(),
            dropped: self.dropped,
        }
    }

    pub(super) fn send(&mut self, at: Nanos, frame: Frame) -> Result<(), QueueFull> {
        if self.to_send.len() >= SEND_MAX {
            return Err(QueueFull);
        }
        self.to_send.push_back((at, frame));
        Ok(())
    }

    pub(super) fn receive(&mut self) -> Option<(Nanos, Frame)> {
        self.received.pop_front()
    }

    /// Takes an outcome whose instant has come.
    pub(super) fn handle(&mut self, outcome: &Outcome, bit: BitTime, quiet_from: Nanos) {
        self.counters = outcome.counters;
        match outcome.what {
            What::Received(frame) => {
                if self.received.len() >= RECEIVE_MAX {
                    self.received.pop_front();
                    self.dropped += 1;
                }
                self.received.push_back((outcome.at, frame));
            }
            What::Transmitted(_) => {
                self.to_send.pop_front();
                self.sent += 1;
            }
            What::LostArbitration(_) => {}
            What::TransmitFailed(..) | What::ReceiveFailed(_) => self.errors += 1,
        }
        if self.counters.confinement() == Confinement::BusOff && self.recovery.is_none() {
            let sequences = RecessiveWait::AFTER_BUS_OFF;
            self.recovery = Some(RecessiveWait::new(sequences, quiet_from, bit));
        }
    }

    pub(super) fn saw(&mut self, activity: &Activity) {
        if let Some(wait) = &mut self.recovery {
            wait.interrupted(activity);
        }
    }

    /// When it will be back from bus-off, going by what is known so far; `None` when it is not off.
    pub(super) fn back_at(&self) -> Option<Nanos> {
        self.recovery.map(|wait| wait.over_at())
    }

    /// Comes back from bus-off when the wait is over.
    pub(super) fn recover(&mut self, now: Nanos) {
        if let Some(wait) = self.recovery.take_if(|wait| wait.over_at() <= now) {
            self.counters = ErrorCounters::NONE;
            self.since = wait.over_at();
        }
    }
}
