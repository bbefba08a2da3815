//! How virtual time follows the wall clock.

use units::{Duration, Instant};

/// Virtual time may be this far behind before the rest is given up for good: a bench that was slow
/// for a while does not race afterwards.
pub const LAG_MAX: Duration = Duration::from_millis(50);

/// Span over which the speed is measured.
const MEASURED_OVER: Duration = Duration::from_millis(500);

/// Keeps virtual time behind the wall clock, which is told in microseconds from any start.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    wall: u64,
    virtual_time: Instant,
    measured_wall: u64,
    measured_virtual: Instant,
    factor: f64,
}

impl Pace {
    /// Virtual time is `now` when the wall clock shows `wall_us`.
    #[must_use]
    pub const fn new(wall_us: u64, now: Instant) -> Self {
        Self {
            wall: wall_us,
            virtual_time: now,
            measured_wall: wall_us,
            measured_virtual: now,
            factor: 1.0,
        }
    }

    /// How far virtual time, which is `now`, may go when the wall clock shows `wall_us`.
    pub fn due(&mut self, wall_us: u64, now: Instant) -> Instant {
        let passed = Duration::from_micros(wall_us.saturating_sub(self.wall));
        let due = self.virtual_time + passed;
        self.measure(wall_us, now);
        if due.since(now) > LAG_MAX {
            (self.wall, self.virtual_time) = (wall_us, now + LAG_MAX);
            return self.virtual_time;
        }
        due
    }

    /// Virtual seconds per second of the wall clock, of late.
    #[must_use]
    pub const fn factor(&self) -> f64 {
        self.factor
    }

    #[expect(clippy::cast_precision_loss, reason = "a figure to look at")]
    fn measure(&mut self, wall_us: u64, now: Instant) {
        let wall = wall_us.saturating_sub(self.measured_wall);
        if wall >= MEASURED_OVER.as_micros() {
            self.factor = now.since(self.measured_virtual).as_micros() as f64 / wall as f64;
            (self.measured_wall, self.measured_virtual) = (wall_us, now);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(ms: u64) -> Instant {
        Instant::from_micros(ms * 1_000)
    }

    #[test]
    fn virtual_time_never_leads_and_does_not_race_after_a_pause() {
        let mut pace = Pace::new(7_000, ms(0));
        assert_eq!(pace.due(8_000, ms(0)), ms(1));
        assert_eq!(pace.due(30_000, ms(1)), ms(23));
        // 200 ms later nothing has run: 50 ms are made up, the rest is lost.
        assert_eq!(pace.due(230_000, ms(23)), ms(73));
        assert_eq!(pace.due(231_000, ms(73)), ms(74));
    }

    #[test]
    fn the_factor_is_virtual_by_wall_time() {
        let mut pace = Pace::new(0, ms(0));
        pace.due(1_000_000, ms(250));
        assert!((pace.factor() - 0.25).abs() < 1e-9);
    }
}
