use object_dictionary::{Dictionary, ObjectId, Values};
use units::{Duration, Instant};

use super::mapping::{Bytes, Mapped, Mapping};
use crate::cob_id::CobId;
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};
use crate::settings::{Emergency, ReceiveErrors};

/// A receive PDO (CiA 301, section 7.2.2; objects 0x1400 and 0x1600 and following).
///
/// Of several that arrive before a SYNC the last one counts. The event timer is a deadline: it runs
/// from the first PDO on, and once it has elapsed, not before the next one.
#[derive(Debug)]
pub(super) struct Rpdo {
    number: u16,
    parameters: Parameters,
    mapping: Mapping,
    received: Bytes,
    /// Whether the received bytes are still to be taken over.
    waits: bool,
    expires_at: Deadline,
}

/// The communication parameter as the stack uses it.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    cob_id: CobId,
    reception: Reception,
    event_time: Duration,
}

/// When the values of a receive PDO are taken over (CiA 301, section 7.5.2.35, sub-index 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reception {
    /// With the next SYNC: types 0 to 240.
    WithSync,
    /// At once: types 254 and 255.
    AtOnce,
    /// Never: a transmission type the stack does not know.
    Never,
}

impl Rpdo {
    /// The PDO 0x1400 + `number`. `None` when the product does not have it.
    pub(super) fn new<const LEN: usize>(number: u16, values: &Values<LEN>) -> Option<Self> {
        Some(Self {
            number,
            parameters: Parameters::read(number, values)?,
            mapping: Mapping::read(values, MAPPING + number),
            received: [0; _],
            waits: false,
            expires_at: Deadline::NEVER,
        })
    }

    /// Its place among the receive PDOs, from 0.
    pub(super) const fn number(&self) -> u16 {
        self.number
    }

    /// The identifier it listens to, while it is switched on.
    pub(super) const fn id(&self) -> Option<CanId> {
        self.parameters.cob_id.valid()
    }

    pub(super) fn listens_to(&self, id: CanId) -> bool {
        self.parameters.cob_id.is_valid_with(id)
    }

    /// Whether its values wait for a SYNC.
    pub(super) fn waits_for_sync(&self) -> bool {
        self.parameters.reception == Reception::WithSync
    }

    /// Whether `index` is its communication parameter or its mapping.
    pub(super) const fn is_described_by(&self, index: u16) -> bool {
        index == COMMUNICATION + self.number || index == MAPPING + self.number
    }

    /// Takes its objects over again, and forgets what waits.
    pub(super) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>) {
        if let Some(again) = Self::new(self.number, values) {
            *self = again;
        }
    }

    /// The node is no longer Operational.
    pub(super) fn stop(&mut self) {
        self.waits = false;
        self.expires_at = Deadline::NEVER;
    }

    /// Takes a frame with its identifier. Comes back with what is to be said about it.
    pub(super) fn handle(
        &mut self,
        now: Instant,
        frame: &Frame,
        dictionary: &Dictionary,
        errors: &ReceiveErrors,
    ) -> Option<Emergency> {
        let len = self.mapping.byte_len();
        if len == 0 {
            return None;
        }
        if frame.dlc() < len {
            return errors.too_short;
        }
        self.expires_at = Deadline::after(now, self.parameters.event_time);
        let received = padded(frame);
        if !self.mapping.permits(&received, dictionary) {
            return errors.value;
        }
        self.received = received;
        self.waits = true;
        if frame.dlc() > len { errors.too_long } else { None }
    }

    /// The received values that are to be taken over at `moment`, once.
    pub(super) fn take(&mut self, moment: Reception) -> Option<Mapped<'_>> {
        let goes = self.waits && self.parameters.reception == moment;
        self.waits &= !goes;
        goes.then(|| self.mapping.scatter(&self.received))
    }

    /// When the next PDO is overdue.
    pub(super) const fn expires_at(&self) -> Deadline {
        self.expires_at
    }

    /// Its number if it is overdue; it then is no more.
    pub(super) fn take_expired(&mut self, now: Instant) -> Option<u16> {
        let expired = self.expires_at.is_due(now);
        expired.then(|| {
            self.expires_at = Deadline::NEVER;
            self.number
        })
    }
}

const COMMUNICATION: u16 = 0x1400;
const MAPPING: u16 = 0x1600;

impl Parameters {
    /// `None` when the product has no such PDO.
    fn read<const LEN: usize>(number: u16, values: &Values<LEN>) -> Option<Self> {
        let index = COMMUNICATION + number;
        let value = |sub| Some(values.raw(values.dictionary().find(ObjectId { index, sub }).ok()?));
        Some(Self {
            cob_id: CobId::from_raw(value(1)?),
            reception: Reception::new(value(2)?),
            event_time: Duration::from_millis(u64::from(value(5).unwrap_or(0))),
        })
    }
}

impl Reception {
    /// The meaning of a transmission type.
    pub(super) const fn new(transmission_type: u32) -> Self {
        match transmission_type {
            0..=240 => Self::WithSync,
            254 | 255 => Self::AtOnce,
            _ => Self::Never,
        }
    }
}

/// The data of a frame with room behind it.
fn padded(frame: &Frame) -> Bytes {
    let [a, b, c, d, e, f, g, h] = frame.bytes();
    [a, b, c, d, e, f, g, h, 0, 0, 0, 0]
}
