use object_dictionary::Values;

use super::MAPPING;
use super::communication::Communication;
use super::mapping::{Bytes, Mapping};
use super::target::Target;
use crate::application::Application;
use crate::deadline::{Deadline, Moment, Span};
use crate::frame::{CanId, Frame};
use crate::settings::{Emergency, ReceiveErrors};

/// A receive PDO (CiA 301, section 7.2.2; objects 0x1400 and 0x1600 and following).
///
/// Of several that arrive before a SYNC the last one counts. The event timer is a deadline: it runs
/// from the first PDO on, and once it has elapsed, not before the next one.
#[derive(Debug)]
pub(super) struct Rpdo {
    /// None while it is switched off or carries nothing.
    id: CanId,
    reception: Reception,
    event_time: Span,
    mapping: Mapping,
    /// Bytes that wait for a SYNC.
    waiting: Option<Bytes>,
    expires_at: Deadline,
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
    /// One that is switched off.
    pub(super) fn off() -> Self {
        Self {
            id: CanId::NONE,
            reception: Reception::Never,
            event_time: Span::ZERO,
            mapping: Mapping::default(),
            waiting: None,
            expires_at: Deadline::NEVER,
        }
    }

    /// The identifier it listens to; none while it is switched off.
    pub(super) const fn id(&self) -> CanId {
        self.id
    }

    /// Takes its objects over, and forgets what waits.
    pub(super) fn reread<const LEN: usize>(
        &mut self,
        index: u16,
        values: &Values<LEN>,
        communication: &Communication,
    ) {
        self.mapping.reread(values, index | MAPPING);
        self.id = self.mapping.id(communication.cob_id);
        self.reception = Reception::new(communication.transmission_type);
        self.event_time = Span::from_millis(communication.event_time_ms);
        self.stop();
    }

    /// The node is no longer Operational.
    pub(super) fn stop(&mut self) {
        self.waiting = None;
        self.expires_at = Deadline::NEVER;
    }

    /// Takes a frame with its identifier; `number` is its own.
    pub(super) fn handle<A: Application, const LEN: usize>(
        &mut self,
        now: Moment,
        number: u16,
        frame: &Frame,
        target: &mut Target<'_, A, LEN>,
    ) -> Outcome {
        let (sent, len) = (frame.dlc(), self.mapping.byte_len());
        let mut outcome = Outcome::default();
        if target.is_late && self.reception == Reception::WithSync {
            return outcome;
        }
        if sent < len {
            return Outcome { fault: Some(Fault::TooShort), ..outcome };
        }
        if self.event_time > Span::ZERO {
            self.expires_at = Deadline::after(now, self.event_time);
            outcome.goes_on = true;
        }
        let bytes = padded(frame);
        if !self.mapping.permits(&bytes, target.values.dictionary()) {
            return Outcome { fault: Some(Fault::Value), ..outcome };
        }
        match self.reception {
            Reception::AtOnce => {
                outcome.goes_on |= target.take_over(number, self.mapping.scatter(&bytes));
            }
            Reception::WithSync => self.waiting = Some(bytes),
            Reception::Never => {}
        }
        outcome.fault = (sent > len).then_some(Fault::TooLong);
        outcome
    }

    /// Takes over what waited for a SYNC; `number` is its own.
    pub(super) fn handle_sync<A: Application, const LEN: usize>(
        &mut self,
        number: u16,
        target: &mut Target<'_, A, LEN>,
    ) {
        if let Some(bytes) = self.waiting.take() {
            target.take_over(number, self.mapping.scatter(&bytes));
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

    /// Whether it is overdue; it then is no more.
    pub(super) fn take_expired(&mut self, now: Moment) -> bool {
        self.expires_at.take_due(now)
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
