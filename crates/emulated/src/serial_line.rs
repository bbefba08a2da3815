//! One controller's end of the line to the other.
//!
//! A byte leaves the sender when its stop bit has ended, is carried to the other end at the next
//! boundary between two quanta, and starts there [`LINE_DELAY_NS`] after it left: a constant delay,
//! whatever the quantum was, so that spacing and order of the bytes are those of the sender to the
//! nanosecond. (Two metres of wire take 10 ns; the delay is what running both controllers at the
//! same time costs.)
use std::collections::VecDeque;

use rigless::chip::{Timeline, uart};
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;
use world::{Dice, Link};

/// From the end of a byte's stop bit at the sender to the start of its start bit at the receiver.
/// No quantum is longer.
pub(crate) const LINE_DELAY_NS: u64 = 100_000;

/// How late the receiver may take a byte off the line: it may still be busy with the one before.
/// Anything later was not listened to. A little more than one byte at 460 800 bit/s.
const MISSED_AFTER_NS: u64 = 25_000;

/// A byte, and when it left or arrives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Byte {
    pub(crate) at_ns: u64,
    pub(crate) value: u8,
}

/// The end of the line.
#[derive(Debug, Default)]
pub(crate) struct SerialLine {
    sent: Vec<Byte>,
    arriving: VecDeque<Byte>,
}

impl SerialLine {
    /// What has been sent since the last call.
    pub(crate) fn take_sent(&mut self) -> Vec<Byte> {
        std::mem::take(&mut self.sent)
    }

    /// Bytes on their way in, in the order of time.
    pub(crate) fn bring(&mut self, bytes: impl IntoIterator<Item = Byte>) {
        self.arriving.extend(bytes);
    }

    /// Forgets what is on its way.
    pub(crate) fn clear(&mut self) {
        self.sent.clear();
        self.arriving.clear();
    }
}

impl Store for SerialLine {}

impl uart::Peer for SerialLine {
    fn receive(&mut self, word: u16, context: &mut Timeline<'_, '_>) {
        let [value, _] = word.to_le_bytes();
        self.sent.push(Byte { at_ns: context.now().0, value });
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        while self.arriving.front()?.at_ns + MISSED_AFTER_NS < now.0 {
            self.arriving.pop_front();
        }
        let due = self.arriving.front().is_some_and(|byte| byte.at_ns <= now.0);
        let byte = if due { self.arriving.pop_front() } else { None };
        byte.map(|byte| u16::from(byte.value))
    }
}

/// Carries `sent` to the other end over a line with `faults`: each byte with its instant there.
pub(crate) fn carry(sent: Vec<Byte>, faults: Link, dice: &mut Dice) -> Vec<Byte> {
    sent.into_iter()
        .filter_map(|byte| {
            let value = faults.carry(byte.value, dice)?;
            Some(Byte { at_ns: byte.at_ns + LINE_DELAY_NS, value })
        })
        .collect()
}
