use object_dictionary::Values;
use units::{Duration, Instant};

use super::mapping::{Bytes, Mapping};
use super::target::Target;
use crate::application::Application;
use crate::cob_id::CobId;
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};
use crate::parameter::parameter;
use crate::settings::{Emergency, ReceiveErrors};

/// A receive PDO (CiA 301, section 7.2.2; objects 0x1400 and 0x1600 and following).
///
/// Of several that arrive before a SYNC the last one counts. The event timer is a deadline: it runs
/// from the first PDO on, and once it has elapsed, not before the next one.
#[derive(Debug)]
pub(super) struct Rpdo {
    number: u16,
    /// The identifier it listens to, or [`NOTHING`].
    listens_to: u16,
    parameters: Parameters,
    mapping: Mapping,
    /// Bytes that wait for a SYNC.
    waiting: Option<Bytes>,
    expires_at: Deadline,
}

/// No identifier: of a PDO that is switched off or carries nothing.
const NOTHING: u16 = u16::MAX;

/// The communication parameter as the stack uses it.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    cob_id: CobId,
    reception: Reception,
    event_time_ms: u16,
}

/// When the values of a receive PDO are taken over (CiA 301, section 7.5.2.35, sub-index 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reception {
    /// At once: types 254 and 255.
    AtOnce,
    /// With the next SYNC: types 0 to 240.
    WithSync,
    /// Never: a transmission type the stack does not know.
    Never,
}

/// What a received frame brought about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Outcome {
    /// What is wrong with it.
    pub(crate) fault: Option<Fault>,
    /// Whether anything else may be due now, or at another time than before.
    pub(crate) goes_on: bool,
}

/// What is wrong with a received frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    TooShort,
    TooLong,
    Value,
}

impl Rpdo {
    /// The PDO 0x1400 + `number`. `None` when the product does not have it.
    pub(super) fn new<const LEN: usize>(number: u16, values: &Values<LEN>) -> Option<Self> {
        let parameters = Parameters::read(number, values)?;
        let mapping = Mapping::read(values, MAPPING + number);
        let id = parameters.cob_id.valid().filter(|_| mapping.byte_len() > 0);
        Some(Self {
            number,
            listens_to: id.map_or(NOTHING, CanId::get),
            parameters,
            mapping,
            waiting: None,
            expires_at: Deadline::NEVER,
        })
    }

    /// The identifier it listens to, while it is switched on.
    pub(super) const fn id(&self) -> Option<CanId> {
        CanId::new(self.listens_to)
    }

    pub(super) const fn listens_to(&self, id: CanId) -> bool {
        self.listens_to == id.get()
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
        self.waiting = None;
        self.expires_at = Deadline::NEVER;
    }

    /// Takes a frame with its identifier.
    pub(super) fn handle<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        frame: &Frame,
        target: &mut Target<'_, A, LEN>,
    ) -> Outcome {
        let (sent, len) = (frame.dlc(), self.mapping.byte_len());
        let mut outcome = Outcome::default();
        if sent < len {
            return Outcome { fault: Some(Fault::TooShort), ..outcome };
        }
        if self.parameters.event_time_ms > 0 {
            let event_time = Duration::from_millis(u64::from(self.parameters.event_time_ms));
            self.expires_at = Deadline::after(now, event_time);
            outcome.goes_on = true;
        }
        let bytes = padded(frame);
        if !self.mapping.permits(&bytes, target.values.dictionary()) {
            return Outcome { fault: Some(Fault::Value), ..outcome };
        }
        match self.parameters.reception {
            Reception::AtOnce => {
                outcome.goes_on |= target.take_over(self.number, self.mapping.scatter(&bytes));
            }
            Reception::WithSync => {
                self.waiting = Some(bytes);
                outcome.goes_on = true;
            }
            Reception::Never => {}
        }
        outcome.fault = (sent > len).then_some(Fault::TooLong);
        outcome
    }

    /// Takes over what waited for a SYNC.
    pub(super) fn handle_sync<A: Application, const LEN: usize>(
        &mut self,
        target: &mut Target<'_, A, LEN>,
    ) {
        if let Some(bytes) = self.waiting.take() {
            target.take_over(self.number, self.mapping.scatter(&bytes));
        }
    }

    /// Whether bytes wait for a SYNC.
    pub(super) const fn waits(&self) -> bool {
        self.waiting.is_some()
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
        let value = |sub| parameter(values, index, sub);
        let [low, high, ..] = value(5).unwrap_or(0).to_le_bytes();
        Some(Self {
            cob_id: CobId::from_raw(value(1)?),
            reception: Reception::new(value(2)?),
            event_time_ms: u16::from_le_bytes([low, high]),
        })
    }
}

impl Fault {
    /// What is to be said about it.
    pub(crate) const fn emergency(self, errors: &ReceiveErrors) -> Option<Emergency> {
        match self {
            Self::TooShort => errors.too_short,
            Self::TooLong => errors.too_long,
            Self::Value => errors.value,
        }
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
    let mut bytes: Bytes = [0; _];
    if let Some(data) = bytes.first_chunk_mut() {
        *data = frame.padded();
    }
    bytes
}
