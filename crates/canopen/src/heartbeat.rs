mod consumer;

pub(crate) use consumer::{CONSUMER_TIME, CONSUMERS_MAX, Consumers};

use crate::deadline::{Deadline, Moment, Span};

/// The heartbeat producer (CiA 301, section 7.2.8.3.2.2; object 0x1017).
///
/// The boot-up message is the first heartbeat; the next follows one period later. A new period
/// acts at once: the first heartbeat with it goes out immediately. Deadlines follow each other at
/// exact distances however late they are served, so the period does not drift.
#[derive(Debug)]
pub(crate) struct Producer {
    /// In milliseconds; 0 while it is switched off.
    period_ms: u32,
    due_at: Deadline,
}

impl Producer {
    /// One that is switched off.
    pub(crate) const fn off() -> Self {
        Self { period_ms: 0, due_at: Deadline::NEVER }
    }

    /// Takes the value of 0x1017 over, 0 to 65535 ms; 0 switches off.
    pub(crate) fn set_period_ms(&mut self, period_ms: u32) {
        self.period_ms = period_ms;
    }

    /// Counts from the boot-up message.
    pub(crate) fn start(&mut self, now: Moment) {
        self.due_at = Deadline::after(now, self.period());
    }

    /// Counts from now on, beginning with a heartbeat.
    pub(crate) fn restart(&mut self, now: Moment) {
        self.due_at = if self.is_on() { Deadline::at(now) } else { Deadline::NEVER };
    }

    /// When the next heartbeat is due.
    pub(crate) const fn due_at(&self) -> Deadline {
        self.due_at
    }

    /// Whether one is due; the next deadline is then set.
    pub(crate) fn take_due(&mut self, now: Moment) -> bool {
        let due = self.due_at.is_due(now);
        if due {
            self.due_at = self.due_at.next(now, self.period());
        }
        due
    }

    /// Whether the period is not 0.
    pub(crate) fn is_on(&self) -> bool {
        self.period_ms > 0
    }

    fn period(&self) -> Span {
        Span::from_millis(self.period_ms)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> Moment {
        (units::Instant::ZERO + units::Duration::from_millis(ms)).into()
    }

    /// NM17x HB-01.
    #[test]
    fn a_late_heartbeat_does_not_move_the_next() {
        let mut producer = Producer::off();
        producer.set_period_ms(100);
        producer.start(at(10));
        for (now, due, next) in [(109, false, 110), (113, true, 210), (215, true, 310)] {
            assert_eq!(producer.take_due(at(now)), due, "at {now} ms");
            assert_eq!(producer.due_at(), Deadline::at(at(next)), "at {now} ms");
        }
        assert!(producer.take_due(at(900)));
        assert_eq!(producer.due_at(), Deadline::at(at(1_000)), "missed ones are not made up for");
    }
}
