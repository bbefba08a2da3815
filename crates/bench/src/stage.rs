//! The devices on their bus, with what is remembered about them.

use std::collections::VecDeque;

use units::Instant;
use world::can::Nanos;
use world::{Engine, EngineError, LogLine};

/// Log lines kept of each device; older ones are dropped.
pub const LOG_LINES_MAX: usize = 10_000;

/// An engine with its log.
pub struct Stage {
    /// The product of all devices.
    pub product: String,
    /// What runs them.
    pub engine: Box<dyn Engine>,
    /// What each device logged.
    pub logs: Vec<LogBook>,
    powered: Vec<bool>,
    failure: Option<EngineError>,
}

impl Stage {
    /// Devices of `product`, under supply.
    #[must_use]
    pub fn new(product: &str, engine: Box<dyn Engine>) -> Self {
        let nodes = engine.node_count();
        Self {
            product: product.to_owned(),
            engine,
            logs: vec![LogBook::default(); nodes],
            powered: vec![true; nodes],
            failure: None,
        }
    }

    /// Virtual time in nanoseconds.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        Nanos::from_instant(self.engine.now()).0
    }

    /// Lets virtual time pass until `at`.
    ///
    /// # Errors
    /// When the engine can not go on; then it never will.
    pub fn run_until(&mut self, at: Instant) -> Result<(), EngineError> {
        if let Some(failure) = &self.failure {
            return Err(failure.clone());
        }
        let ran = self.engine.run_until(at);
        for (node, book) in self.logs.iter_mut().enumerate() {
            book.add(self.engine.take_log(node));
        }
        self.failure = ran.clone().err();
        ran
    }

    /// Why the run can not go on, if it can not.
    #[must_use]
    pub const fn failure(&self) -> Option<&EngineError> {
        self.failure.as_ref()
    }

    /// Whether the supply of `node` is switched on.
    #[must_use]
    pub fn powered(&self, node: usize) -> bool {
        self.powered.get(node).copied().unwrap_or(false)
    }

    /// Switches the supply of both controllers of `node`.
    pub fn set_power(&mut self, node: usize, on: bool) {
        self.engine.set_power(node, on);
        if let Some(powered) = self.powered.get_mut(node) {
            *powered = on;
        }
    }
}

/// The newest lines of one device.
#[derive(Clone, Debug, Default)]
pub struct LogBook {
    lines: VecDeque<LogLine>,
    dropped: u64,
}

/// A place in a log. The default is the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LogPlace(u64);

impl LogBook {
    fn add(&mut self, lines: Vec<LogLine>) {
        self.lines.extend(lines);
        while self.lines.len() > LOG_LINES_MAX {
            self.lines.pop_front();
            self.dropped += 1;
        }
    }

    /// Lines after `place`, oldest first; moves `place` to the end.
    pub fn since(&self, place: &mut LogPlace) -> Vec<LogLine> {
        let skip = usize::try_from(place.0.saturating_sub(self.dropped)).unwrap_or(usize::MAX);
        place.0 = self.dropped + self.lines.len() as u64;
        self.lines.iter().skip(skip).cloned().collect()
    }

    /// The newest `count` lines, oldest first.
    #[must_use]
    pub fn newest(&self, count: usize) -> Vec<LogLine> {
        self.lines.iter().skip(self.lines.len().saturating_sub(count)).cloned().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use world::Mcu;

    fn line(n: usize) -> LogLine {
        let text = n.to_string();
        LogLine { mcu: Mcu::Stm, at: Instant::ZERO, level: String::new(), text }
    }

    #[test]
    fn a_reader_gets_every_line_once_and_the_newest_when_it_was_slow() {
        let mut book = LogBook::default();
        let mut place = LogPlace::default();
        book.add(vec![line(0), line(1)]);
        assert_eq!(book.since(&mut place), [line(0), line(1)]);
        assert_eq!(book.since(&mut place), []);
        book.add((2..LOG_LINES_MAX + 3).map(line).collect());
        assert_eq!(book.since(&mut place).first(), Some(&line(3)));
        assert_eq!(book.newest(2), [line(LOG_LINES_MAX + 1), line(LOG_LINES_MAX + 2)]);
    }
}
