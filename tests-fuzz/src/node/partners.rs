//! Who a node exchanges signs of life with, as a plain reading of CiA 301 has it: the master that
//! guards it (section 7.2.8.2.2) and the producers it monitors (section 7.2.8.2.2.1).

use std::collections::BTreeMap;

use units::{Duration, Instant};

/// The longest time that the stack waits for a sign of life.
const WAIT_MAX: Duration = Duration::from_micros(i32::MAX as u64 - 1);

/// Bit 7 of an answer to a guarding request.
const TOGGLE: u8 = 1 << 7;

pub(super) struct Partners {
    /// Bit 7 of the next answer.
    toggle: u8,
    life: Life,
    /// When a producer that was heard counts as lost.
    expiries: BTreeMap<u8, Expiry>,
    /// Whether a producer that was lost certainly is: a master that changes its entry forgets it.
    lost: BTreeMap<u8, bool>,
}

/// Life guarding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Life {
    /// Not before the next request.
    Off,
    Until(Instant),
    Lost,
    /// A master may have changed one of its objects.
    Open,
}

#[derive(Clone, Copy)]
struct Expiry {
    at: Instant,
    /// Not when a master may have changed the entry.
    is_certain: bool,
}

impl Partners {
    /// Those of a node that has just booted.
    pub(super) const fn new() -> Self {
        Self { toggle: 0, life: Life::Off, expiries: BTreeMap::new(), lost: BTreeMap::new() }
    }

    /// A guarding request: what answers it where the heartbeat would be `state`.
    pub(super) fn request(&mut self, state: u8) -> u8 {
        let answer = state | self.toggle;
        self.toggle ^= TOGGLE;
        answer
    }

    /// The request was served: the next has to come within the life time.
    pub(super) fn renew(&mut self, now: Instant, life_time: Duration) {
        assert_ne!(self.life, Life::Lost, "asked, and still lost");
        let is_on = life_time > Duration::ZERO;
        self.life = if is_on { Life::Until(now + life_time.min(WAIT_MAX)) } else { Life::Off };
    }

    /// A message of a monitored producer. `is_certain` where nothing else may have taken it.
    pub(super) fn hear(&mut self, now: Instant, producer: u8, time: Duration, is_certain: bool) {
        self.expiries.insert(producer, Expiry { at: now + time, is_certain });
    }

    /// A master may have written to any object.
    pub(super) fn doubt(&mut self) {
        if self.life != Life::Off {
            self.life = Life::Open;
        }
        self.expiries.values_mut().for_each(|expiry| expiry.is_certain = false);
        self.lost.values_mut().for_each(|is_certain| *is_certain = false);
    }

    pub(super) fn lose_master(&mut self, now: Instant) {
        match self.life {
            Life::Until(at) => assert!(at <= now, "lost before the life time ends"),
            Life::Open => {}
            Life::Off | Life::Lost => panic!("{:?}, and lost", self.life),
        }
        self.life = Life::Lost;
    }

    pub(super) fn recover_master(&mut self) {
        assert!(matches!(self.life, Life::Lost | Life::Open), "{:?}, and recovered", self.life);
        self.life = Life::Off;
    }

    pub(super) fn lose(&mut self, now: Instant, producer: u8) {
        let expiry = self.expiries.remove(&producer);
        assert!(expiry.is_some_and(|expiry| expiry.at <= now), "{producer} lost, heard in time");
        self.lost.insert(producer, true);
    }

    pub(super) fn recover(&mut self, producer: u8) {
        assert!(self.lost.remove(&producer).is_some(), "{producer} recovered, never lost");
    }

    /// Whether the master or a producer is lost. `None` when a master may have changed that.
    pub(super) fn is_one_lost(&self) -> Option<bool> {
        if self.life == Life::Lost || self.lost.values().any(|&is_certain| is_certain) {
            return Some(true);
        }
        (self.life != Life::Open && self.lost.is_empty()).then_some(false)
    }

    /// Nobody stays away longer than permitted.
    pub(super) fn check(&self, now: Instant) {
        if let Life::Until(at) = self.life {
            assert!(at > now, "the master is overdue");
        }
        for (producer, expiry) in &self.expiries {
            assert!(expiry.at > now || !expiry.is_certain, "{producer} is overdue");
        }
    }
}
