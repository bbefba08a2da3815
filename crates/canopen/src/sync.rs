use object_dictionary::{ObjectId, Values};

use crate::cob_id::CobId;
use crate::deadline::{Deadline, Moment, Span};
use crate::frame::{CanId, Frame};
use crate::parameter::{number, parameter};
use crate::sdo::AbortCode;

pub(crate) const COB_ID: u16 = 0x1005;
/// The communication cycle period, in microseconds.
pub(crate) const PERIOD: u16 = 0x1006;
/// The synchronous window length, in microseconds.
pub(crate) const WINDOW: u16 = 0x1007;
/// The synchronous counter overflow value.
pub(crate) const OVERFLOW: u16 = 0x1019;

/// The SYNC consumer and producer (CiA 301, section 7.2.5; objects 0x1005, 0x1006, 0x1007 and
/// 0x1019).
///
/// It produces while bit 30 of 0x1005 is set and the period is not 0, in the states that have PDO or
/// SDO; the first SYNC follows one period after the start, with the counter 1. The device itself
/// acts on what it produces. Period and window that were stored and are longer than [`Span::MAX`] are
/// as long as that.
///
/// A product without 0x1019 takes a SYNC with a counter as one without.
#[derive(Debug)]
pub(crate) struct Sync {
    /// None without 0x1005.
    id: CanId,
    /// The value that the counter of a SYNC begins again after; 0 for a SYNC without one that counts.
    overflow: u8,
    /// The fewest and the most data bytes that a SYNC has.
    lens: (u8, u8),
    /// The counter of the last SYNC produced; 0 before the first.
    counter: u8,
    /// None at all for a device that does not produce.
    period: Span,
    due_at: Deadline,
    /// None at all without a window.
    window: Span,
    window_ends_at: Deadline,
    is_window_over: bool,
    length: Length,
}

/// Whether the last SYNC had the expected length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Length {
    Expected,
    Unexpected,
}

/// What a data frame is to the consumer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// A SYNC, with its counter if it has one that counts.
    Sync { counter: Option<u8> },
    /// The first SYNC of the wrong length.
    UnexpectedLength,
    /// A further one.
    Nothing,
}

impl Sync {
    /// As in a product without its objects.
    pub(crate) const fn off() -> Self {
        Self {
            id: CanId::NONE,
            overflow: 0,
            lens: (0, 1),
            counter: 0,
            period: Span::ZERO,
            due_at: Deadline::NEVER,
            window: Span::ZERO,
            window_ends_at: Deadline::NEVER,
            is_window_over: false,
            length: Length::Expected,
        }
    }

    pub(crate) const fn id(&self) -> CanId {
        self.id
    }

    /// Takes its objects over. A producer that is to produce otherwise stands still until
    /// [`Self::start`].
    pub(crate) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>) {
        let Some(cob_id) = parameter(values, COB_ID, 0).map(CobId::from_raw) else { return };
        let (overflow, lens) = match parameter(values, OVERFLOW, 0).map(u32::to_le_bytes) {
            None => (0, (0, 1)),
            Some([0, ..]) => (0, (0, 0)),
            Some([overflow, ..]) => (overflow, (1, 1)),
        };
        let period_us = if cob_id.generates() { number(values, PERIOD, 0) } else { 0 };
        let period = Span::from_micros(period_us);
        let kind = (cob_id.can_id(), overflow, lens, period);
        if kind != (self.id, self.overflow, self.lens, self.period) {
            (self.id, self.overflow, self.lens, self.period) = kind;
            self.due_at = Deadline::NEVER;
            self.length = Length::Expected;
        }
        self.window = Span::from_micros(number(values, WINDOW, 0));
        self.close_window();
    }

    /// Starts a producer that stands still.
    pub(crate) fn start(&mut self, now: Moment) {
        if self.due_at == Deadline::NEVER {
            self.counter = 0;
            self.due_at = Deadline::after(now, self.period);
        }
    }

    /// Produces nothing, and no window is open.
    pub(crate) fn stop(&mut self) {
        self.due_at = Deadline::NEVER;
        self.close_window();
    }

    /// Takes a data frame with its identifier.
    pub(crate) fn receive(&mut self, frame: &Frame) -> Received {
        let (len_min, len_max) = self.lens;
        if !(len_min..=len_max).contains(&frame.dlc()) {
            return match core::mem::replace(&mut self.length, Length::Unexpected) {
                Length::Expected => Received::UnexpectedLength,
                Length::Unexpected => Received::Nothing,
            };
        }
        self.length = Length::Expected;
        let [counter, ..] = frame.padded();
        Received::Sync { counter: (self.overflow != 0).then_some(counter) }
    }

    /// A SYNC came: its window opens. When that ends, if there is one.
    pub(crate) fn open_window(&mut self, now: Moment) -> Option<Deadline> {
        (self.window > Span::ZERO).then(|| {
            self.is_window_over = false;
            self.window_ends_at = Deadline::after(now, self.window);
            self.window_ends_at
        })
    }

    fn close_window(&mut self) {
        self.window_ends_at = Deadline::NEVER;
        self.is_window_over = false;
    }

    /// Whether the window of the last SYNC is over.
    pub(crate) const fn is_window_over(&self) -> bool {
        self.is_window_over
    }

    pub(crate) fn due_at(&self, now: Moment) -> Deadline {
        self.due_at.or_earlier(self.window_ends_at, now)
    }

    /// Whether the window ends now.
    pub(crate) fn take_window_end(&mut self, now: Moment) -> bool {
        let ends = self.window_ends_at.take_due(now);
        self.is_window_over |= ends;
        ends
    }

    /// The SYNC that is to be produced now.
    pub(crate) fn take_due(&mut self, now: Moment) -> Option<Frame> {
        if !self.due_at.is_due(now) {
            return None;
        }
        self.due_at = self.due_at.next(now, self.period);
        if self.overflow == 0 {
            return Some(Frame::empty(self.id));
        }
        self.counter = if self.counter < self.overflow { self.counter + 1 } else { 1 };
        Some(Frame::single(self.id, self.counter))
    }
}

/// Whether a client may write `raw` to one of the objects of SYNC, which its row permits (CiA 301,
/// sections 7.5.2.5 and 7.5.2.22). Only a product with a period can be told to produce, and neither
/// period nor window is longer than 35 minutes and 47 seconds.
pub(crate) fn check<const LEN: usize>(
    values: &Values<LEN>,
    object: ObjectId,
    raw: u32,
) -> Result<(), AbortCode> {
    const OVERFLOW_MAX: u32 = 240;
    match object.index {
        COB_ID => {
            let after = CobId::from_raw(raw);
            let moves = || {
                let before = CobId::from_raw(number(values, COB_ID, 0));
                before.generates() && before.can_id() != after.can_id()
            };
            let may_generate = || parameter(values, PERIOD, 0).is_some() && !moves();
            if after.suits_sync() && (!after.generates() || may_generate()) {
                Ok(())
            } else {
                Err(AbortCode::VALUE_RANGE)
            }
        }
        PERIOD | WINDOW if raw > Span::MAX_US => Err(AbortCode::VALUE_RANGE),
        OVERFLOW if raw == 1 || raw > OVERFLOW_MAX => Err(AbortCode::VALUE_RANGE),
        OVERFLOW if number(values, PERIOD, 0) != 0 => Err(AbortCode::DEVICE_STATE),
        _ => Ok(()),
    }
}
