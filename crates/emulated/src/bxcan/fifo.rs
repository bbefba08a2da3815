use std::collections::VecDeque;

use world::can::Frame;

use super::registers::rfr;

/// Frames a FIFO holds.
const DEPTH: usize = 3;

/// What happens to a frame that finds the FIFO full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WhenFull {
    /// It takes the place of the newest one.
    Overwrite,
    /// It is dropped (MCR.RFLM).
    Lock,
}

/// A receive FIFO (RM0090, 32.7.3).
#[derive(Clone, Debug, Default)]
pub(super) struct Fifo {
    frames: VecDeque<(Frame, u8)>,
    full: bool,
    overrun: bool,
}

impl Fifo {
    pub(super) fn push(&mut self, frame: Frame, filter: u8, when_full: WhenFull) {
        if self.frames.len() < DEPTH {
            self.frames.push_back((frame, filter));
            self.full |= self.frames.len() == DEPTH;
            return;
        }
        self.overrun = true;
        match when_full {
            WhenFull::Lock => {}
            WhenFull::Overwrite => {
                self.frames.pop_back();
                self.frames.push_back((frame, filter));
            }
        }
    }

    /// The frame in the output mailbox and the number of the filter it passed.
    pub(super) fn front(&self) -> Option<&(Frame, u8)> {
        self.frames.front()
    }

    /// RFxR.
    pub(super) fn status(&self) -> u32 {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        u32::try_from(self.frames.len()).unwrap_or_default()
            | flag(self.full, rfr::FULL)
            | flag(self.overrun, rfr::FOVR)
    }

    /// A write to RFxR.
    pub(super) fn command(&mut self, value: u32) {
        if value & rfr::FULL != 0 {
            self.full = false;
        }
        if value & rfr::FOVR != 0 {
            self.overrun = false;
        }
        if value & rfr::RFOM != 0 {
            self.frames.pop_front();
        }
    }
}
