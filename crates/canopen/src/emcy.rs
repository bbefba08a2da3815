use heapless::Deque;
use object_dictionary::{ObjectId, Values};

use crate::cob_id::{CobId, NodeId, Service};
use crate::deadline::{Deadline, Moment, Span};
use crate::frame::{CanId, Frame};
use crate::parameter::{number, parameter};
use crate::settings::{AdditionalInformation, Emergency, Settings};

/// Messages that may wait for the end of the inhibit time.
const WAITING_MAX: usize = 8;

/// One step of 0x1015.
const INHIBIT_UNIT: Span = Span::from_micros(100);

pub(crate) const COB_ID: u16 = 0x1014;
pub(crate) const INHIBIT_TIME: u16 = 0x1015;
pub(crate) const ERROR_REGISTER: u16 = 0x1001;
/// The pre-defined error field; an entry exists as long as its sub-index is not above the count.
pub(crate) const HISTORY: u16 = 0x1003;

/// All errors are over.
pub(crate) const ERROR_RESET: Emergency = Emergency { code: 0x0000, manufacturer: [0; 5] };

/// A monitored heartbeat, or the master that guards the node, is missing.
pub(crate) const PARTNER_LOST: Emergency = Emergency { code: 0x8130, manufacturer: [0; 5] };

/// The emergency producer (CiA 301, section 7.2.7; objects 0x1003, 0x1014 and 0x1015).
///
/// Without 0x1014 it has the identifier of the connection set. Inside the inhibit time messages
/// wait, with the error register of their moment; of too many the oldest is dropped, and stays in
/// the error field.
#[derive(Debug)]
pub(crate) struct Producer {
    /// None while it is switched off.
    id: CanId,
    inhibit_time: Span,
    /// Never while messages may go.
    inhibited_until: Deadline,
    waiting: Deque<[u8; 8], WAITING_MAX>,
}

impl Producer {
    /// As in a product without its objects.
    pub(crate) const fn new(node_id: NodeId) -> Self {
        Self {
            id: Service::Emergency.id(node_id),
            inhibit_time: Span::ZERO,
            inhibited_until: Deadline::NEVER,
            waiting: Deque::new(),
        }
    }

    /// Takes 0x1014 and 0x1015 over. A producer that is switched off forgets what waits.
    pub(crate) fn reread<const LEN: usize>(&mut self, now: Moment, values: &Values<LEN>) {
        if let Some(raw) = parameter(values, COB_ID, 0) {
            self.id = CobId::from_raw(raw).valid().unwrap_or(CanId::NONE);
        }
        self.inhibit_time = INHIBIT_UNIT.times(number(values, INHIBIT_TIME, 0));
        self.inhibited_until = self.inhibited_until.limited(now, self.inhibit_time);
        if self.id == CanId::NONE {
            self.waiting.clear();
        }
    }

    /// Records an error and takes the message for it. It waits for [`Self::take_due`].
    pub(crate) fn raise<const LEN: usize>(
        &mut self,
        emergency: Emergency,
        values: &mut Values<LEN>,
        settings: &Settings,
    ) {
        let [low, high] = emergency.code.to_le_bytes();
        let [a, b, c, d, e] = emergency.manufacturer;
        let register = number(values, ERROR_REGISTER, 0);
        let [register, ..] = register.to_le_bytes();
        let message = [low, high, register, a, b, c, d, e];
        if emergency.code != ERROR_RESET.code {
            record(values, settings.additional_information.entry(message));
        }
        if self.id == CanId::NONE {
            return;
        }
        if self.waiting.is_full() {
            self.waiting.pop_front();
        }
        let _ = self.waiting.push_back(message);
    }

    /// Whether messages never wait for each other.
    pub(crate) fn is_uninhibited(&self) -> bool {
        self.inhibit_time == Span::ZERO
    }

    /// When the inhibit time ends, if it runs.
    pub(crate) const fn inhibited_until(&self) -> Deadline {
        self.inhibited_until
    }

    /// When the inhibit time ends, or the next waiting message may go.
    pub(crate) fn due_at(&self, now: Moment) -> Deadline {
        if self.waiting.is_empty() || self.inhibited_until != Deadline::NEVER {
            self.inhibited_until
        } else {
            Deadline::at(now)
        }
    }

    /// Messages may go again when the inhibit time is over.
    pub(crate) fn end_inhibit_time(&mut self, now: Moment) {
        self.inhibited_until.take_due(now);
    }

    /// The next waiting message that may go.
    pub(crate) fn take(&mut self, now: Moment) -> Option<Frame> {
        if self.inhibited_until != Deadline::NEVER {
            return None;
        }
        let data = self.waiting.pop_front()?;
        self.inhibited_until = Deadline::after(now, self.inhibit_time);
        Some(Frame::full(self.id, data))
    }
}

impl AdditionalInformation {
    /// An entry of the pre-defined error field for an emergency message.
    const fn entry(self, [low, high, register, first, second, _, _, last]: [u8; 8]) -> u32 {
        let (third, fourth) = match self {
            Self::None => (0, 0),
            Self::FirstTwoBytes => (first, second),
            Self::LastByte => (last, 0),
            Self::RegisterAndFirstByte => (register, first),
        };
        u32::from_le_bytes([low, high, third, fourth])
    }
}

/// Puts an entry in front of the others; the oldest of a full list goes.
fn record<const LEN: usize>(values: &mut Values<LEN>, entry: u32) {
    let dictionary = values.dictionary();
    let Ok(count) = dictionary.find(ObjectId { index: HISTORY, sub: 0 }) else { return };
    let mut carried = entry;
    let mut entries = 0;
    for sub in 1..u8::MAX {
        let Ok(slot) = dictionary.find(ObjectId { index: HISTORY, sub }) else { break };
        let before = values.raw(slot);
        values.set_raw(slot, carried);
        carried = before;
        entries += 1;
    }
    values.set_raw(count, entries.min(values.raw(count) + 1));
}
