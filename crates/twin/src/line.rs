//! One direction of the line between the controllers.

use std::collections::VecDeque;

use shared_proto::limits::BIT_RATE;
use world::{Dice, Link};

/// Frames that may be under way: one on the line, and as many as a shell lets wait for it.
const FRAMES_MAX: usize = 1 + 4;

const NANOS_PER_SECOND: u64 = 1_000_000_000;
/// Start, eight data bits, stop.
const BITS_PER_BYTE: u64 = 10;

/// How long `bytes` take, in nanoseconds.
const fn duration_ns(bytes: u64) -> u64 {
    bytes * BITS_PER_BYTE * NANOS_PER_SECOND / BIT_RATE as u64
}

/// The line stays idle for the time of a byte before the receiver looks at what has come.
const IDLE_NS: u64 = duration_ns(1);

/// Frames on their way.
#[derive(Debug, Default)]
pub(crate) struct Line {
    free_at_ns: u64,
    frames: VecDeque<Arriving>,
}

#[derive(Debug)]
struct Arriving {
    sent_at_ns: u64,
    bytes: Vec<u8>,
}

impl Line {
    /// Whether another frame can be given to it.
    pub(crate) fn has_room(&self, now_ns: u64) -> bool {
        self.frames.iter().filter(|frame| frame.sent_at_ns > now_ns).count() < FRAMES_MAX
    }

    /// When there is room again; `None` while there is.
    pub(crate) fn room_at(&self, now_ns: u64) -> Option<u64> {
        let next = self.frames.iter().map(|frame| frame.sent_at_ns).find(|at| *at > now_ns);
        next.filter(|_| !self.has_room(now_ns))
    }

    /// When everything given to it has left the sender.
    pub(crate) fn sent_at(&self) -> u64 {
        self.free_at_ns
    }

    /// Sends a frame, and decides what of it arrives.
    pub(crate) fn send(&mut self, now_ns: u64, frame: &[u8], faults: Link, dice: &mut Dice) {
        let len = frame.len().try_into().unwrap_or(u64::MAX);
        let sent_at_ns = self.free_at_ns.max(now_ns) + duration_ns(len);
        let bytes = frame.iter().filter_map(|byte| faults.carry(*byte, dice)).collect();
        self.free_at_ns = sent_at_ns;
        self.frames.push_back(Arriving { sent_at_ns, bytes });
    }

    /// When the receiver finds something.
    pub(crate) fn arrives_at(&self) -> Option<u64> {
        self.frames.front().map(|frame| frame.sent_at_ns + IDLE_NS)
    }

    /// What the receiver finds.
    pub(crate) fn arrived(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        self.arrives_at().filter(|at| *at <= now_ns)?;
        self.frames.pop_front().map(|frame| frame.bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOUND: Link = Link { cut: false, bit_error_rate: 0.0, drop_rate: 0.0 };

    #[test]
    fn frames_follow_each_other_at_the_bit_rate() {
        let mut line = Line::default();
        let mut dice = Dice::new(0, 0);
        line.send(1_000, &[1, 2, 3], SOUND, &mut dice);
        line.send(1_000, &[4], SOUND, &mut dice);
        assert_eq!(line.arrives_at(), Some(1_000 + duration_ns(3) + IDLE_NS));
        assert_eq!(line.arrived(1_000), None);
        assert_eq!(line.sent_at(), 1_000 + duration_ns(3) + duration_ns(1));
        let end = line.sent_at() + IDLE_NS;
        assert_eq!(line.arrived(end), Some(vec![1, 2, 3]));
        assert_eq!(line.arrived(end), Some(vec![4]));
        assert_eq!(line.arrived(end), None);
    }

    #[test]
    fn a_full_line_says_when_there_is_room() {
        let mut line = Line::default();
        let mut dice = Dice::new(0, 0);
        for _ in 0..FRAMES_MAX {
            assert!(line.has_room(0));
            line.send(0, &[0; 10], SOUND, &mut dice);
        }
        assert_eq!(line.room_at(0), Some(duration_ns(10)));
        assert!(line.has_room(duration_ns(10)));
    }

    /// NM17x LINK-06: nothing passes a cut line, yet it takes its time.
    #[test]
    fn a_cut_line_brings_nothing() {
        let mut line = Line::default();
        let cut = Link { cut: true, ..SOUND };
        line.send(0, &[1, 2], cut, &mut Dice::new(0, 0));
        assert_eq!(line.arrived(u64::MAX), Some(Vec::new()));
    }
}
