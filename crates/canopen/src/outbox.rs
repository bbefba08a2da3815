use core::mem;

use heapless::Vec;

use crate::cob_id::Service;
use crate::frame::{CanId, Frame};

/// Frames that may wait for a transmit mailbox at the same time.
pub const TRANSMIT_MAX: usize = 16;

/// Frames waiting for a transmit mailbox: the lower CAN-ID first, as the bus itself would decide,
/// and in order among equal ones.
///
/// The last frame of the list is the next to go, so taking one moves nothing. The boot-up message
/// goes before all others although its identifier is high: it tells that there is a node at all.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    frames: Vec<Frame, TRANSMIT_MAX, u8>,
    /// An overflow is to be reported.
    has_overflowed: bool,
    /// An overflow is reported once, until all frames are gone: the report may itself send a frame.
    is_reported: bool,
    lost: u32,
}

impl Outbox {
    /// Adds a frame behind those with the same identifier.
    #[inline(never)]
    pub(crate) fn push(&mut self, frame: Frame) {
        if self.frames.is_empty() {
            self.push_alone(frame);
        } else {
            self.insert(frame, urgency(&frame) + 1);
        }
    }

    /// Adds a frame and drops an equal one that waits: it says nothing else.
    pub(crate) fn push_once(&mut self, frame: Frame) {
        self.retain(&mut |waiting| *waiting != frame);
        self.push(frame);
    }

    /// Puts a frame back that a more urgent one pushed out of a mailbox: in front of those with the
    /// same identifier.
    pub(crate) fn give_back(&mut self, frame: Frame) {
        self.insert(frame, urgency(&frame));
    }

    /// Adds a frame in place of the newest one with the same identifier, if one waits. A boot-up
    /// message stays.
    #[inline]
    pub(crate) fn supersede(&mut self, frame: Frame) {
        if self.frames.is_empty() {
            self.push_alone(frame);
        } else {
            self.replace(frame);
        }
    }

    /// Adds a frame where none waits.
    #[inline]
    fn push_alone(&mut self, frame: Frame) {
        self.is_reported = false;
        let _ = self.frames.push(frame);
    }

    #[inline(never)]
    fn replace(&mut self, frame: Frame) {
        match self.frames.iter_mut().find(|waiting| urgency(waiting) == urgency(&frame)) {
            Some(older) => *older = frame,
            None => self.push(frame),
        }
    }

    /// Drops all frames.
    pub(crate) fn clear(&mut self) {
        self.frames.clear();
    }

    /// Drops the waiting frames that are not to be kept.
    pub(crate) fn retain(&mut self, keep: &mut dyn FnMut(&Frame) -> bool) {
        for frame in mem::take(&mut self.frames).iter().filter(|frame| keep(frame)) {
            let _ = self.frames.push(*frame);
        }
    }

    #[inline]
    pub(crate) fn peek(&self) -> Option<&Frame> {
        self.frames.last()
    }

    #[inline]
    pub(crate) fn take(&mut self) -> Option<Frame> {
        self.frames.pop()
    }

    /// Whether a frame with this identifier waits.
    pub(crate) fn holds(&self, id: CanId) -> bool {
        self.frames.iter().any(|frame| frame.id() == id)
    }

    /// Whether the boot-up message still waits.
    pub(crate) fn holds_boot_up(&self) -> bool {
        self.frames.last().is_some_and(|frame| urgency(frame) == BOOT_UP)
    }

    /// Whether an overflow is to be reported.
    #[inline]
    pub(crate) const fn has_overflowed(&self) -> bool {
        self.has_overflowed
    }

    /// How many frames were dropped so far because the list was full, if that is to be reported.
    pub(crate) fn take_overflow(&mut self) -> Option<u32> {
        mem::take(&mut self.has_overflowed).then(|| {
            self.is_reported = true;
            self.lost
        })
    }

    /// Adds a frame behind those with an urgency below `limit`. In a full list the least urgent frame
    /// goes, which may be the new one.
    fn insert(&mut self, frame: Frame, limit: u16) {
        let goes_first = |waiting: &Frame| urgency(waiting) < limit;
        let mut carried = frame;
        if self.frames.is_full() {
            self.lost = self.lost.saturating_add(1);
            self.has_overflowed |= !self.is_reported;
            for place in self.frames.iter_mut().rev().filter(|place| !goes_first(place)) {
                mem::swap(place, &mut carried);
            }
        } else {
            for place in self.frames.iter_mut().filter(|place| goes_first(place)) {
                mem::swap(place, &mut carried);
            }
            let _ = self.frames.push(carried);
        }
    }
}

/// The urgency of the boot-up message: no other frame of a device has the identifier 0.
const BOOT_UP: u16 = 0;

/// What goes first has less.
fn urgency(frame: &Frame) -> u16 {
    let is_boot_up = Service::ErrorControl.has(frame.id()) && frame.data() == [0];
    if is_boot_up { BOOT_UP } else { frame.id().get() }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::vec::Vec;

    use super::*;

    fn frame(id: u16, byte: u8) -> Frame {
        Frame::single(CanId::new(id).unwrap(), byte)
    }

    fn drain(outbox: &mut Outbox) -> Vec<(u16, u8)> {
        core::iter::from_fn(|| outbox.take()).map(|f| (f.id().get(), f.data()[0])).collect()
    }

    #[test]
    fn the_lower_identifier_goes_first_and_equal_ones_keep_their_order() {
        let mut outbox = Outbox::default();
        for (id, byte) in [(0x700, 1), (0x580, 1), (0x180, 1), (0x580, 2), (0x700, 2)] {
            outbox.push(frame(id, byte));
        }
        outbox.give_back(frame(0x580, 0));
        outbox.supersede(frame(0x180, 9));
        outbox.push(frame(0x77F, 0));
        outbox.push_once(frame(0x700, 1));
        let order =
            [(0x77F, 0), (0x180, 9), (0x580, 0), (0x580, 1), (0x580, 2), (0x700, 2), (0x700, 1)];
        assert_eq!(drain(&mut outbox), order);
        assert_eq!(outbox.take_overflow(), None);
    }

    #[test]
    fn a_full_list_loses_its_least_urgent_frame() {
        let mut outbox = Outbox::default();
        for number in 0..16 {
            outbox.push(frame(0x500 + u16::from(number), number));
        }
        outbox.push(frame(0x600, 99));
        assert_eq!(outbox.take_overflow(), Some(1), "the new one was the least urgent");
        outbox.push(frame(0x100, 99));
        assert_eq!(outbox.take_overflow(), None, "reported until all frames are gone");
        let left = drain(&mut outbox);
        assert_eq!((left.len(), left[0], left[15]), (TRANSMIT_MAX, (0x100, 99), (0x50E, 14)));
        for number in 0..17 {
            outbox.push(frame(0x500, number));
        }
        assert_eq!(outbox.take_overflow(), Some(3));
        assert_eq!(drain(&mut outbox)[0], (0x500, 0), "the oldest of equal ones stay");
    }
}
