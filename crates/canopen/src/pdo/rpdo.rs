use heapless::Vec;
use object_dictionary::{ObjectId, Slot, Values};
use units::{Duration, Instant};

use super::mapping::{MAPPED_MAX, Mapping};
use crate::application::Mapped;
use crate::cob_id::CobId;
use crate::frame::{CanId, Frame};

/// Receive PDOs of a device.
pub(crate) const RPDO_MAX: usize = 4;

/// A receive PDO (CiA 301, section 7.2.2; objects 0x1400 and 0x1600 and following).
///
/// Of several that arrive before a SYNC the last one counts. The event timer is a deadline: it runs
/// from the first PDO on, and once it has elapsed, not before the next one.
#[derive(Debug)]
pub(crate) struct Rpdo {
    number: u16,
    parameters: Parameters,
    mapping: Mapping,
    /// Bytes that wait for a SYNC.
    waiting: Option<[u8; 8]>,
    expires_at: Option<Instant>,
}

/// The communication parameter as the stack uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Parameters {
    id: Option<CanId>,
    reception: Reception,
    deadline: Duration,
}

/// When the values of a receive PDO are taken over (CiA 301, section 7.5.2.35, sub-index 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reception {
    /// With the next SYNC: types 0 to 240.
    WithSync,
    /// At once: types 254 and 255.
    AtOnce,
    /// Never: a transmission type the stack does not know.
    Never,
}

/// What a frame is to a receive PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Received {
    /// A frame for others, or one that is dropped.
    Nothing,
    /// Values to be taken over now.
    Values([u8; 8]),
    /// Values that wait for the next SYNC.
    Waits,
    /// Fewer bytes than the objects have.
    TooShort,
}

impl Rpdo {
    /// The PDO 0x1400 + `number`. `None` when the product does not have it.
    pub(crate) fn new<const LEN: usize>(number: u16, values: &Values<LEN>) -> Option<Self> {
        Some(Self {
            number,
            parameters: Parameters::read(number, values)?,
            mapping: Mapping::read(values, MAPPING + number),
            waiting: None,
            expires_at: None,
        })
    }

    /// Its place among the receive PDOs, from 0.
    pub(crate) const fn number(&self) -> u16 {
        self.number
    }

    /// The identifier it listens to, while it is switched on.
    pub(crate) const fn id(&self) -> Option<CanId> {
        self.parameters.id
    }

    /// Whether `index` is its communication parameter.
    pub(crate) const fn is_described_by(&self, index: u16) -> bool {
        index == COMMUNICATION + self.number
    }

    /// Takes the communication parameter over again, and forgets what waits. Whether another
    /// identifier is listened to.
    pub(crate) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>) -> bool {
        let Some(parameters) = Parameters::read(self.number, values) else { return false };
        let before = core::mem::replace(&mut self.parameters, parameters);
        self.stop();
        before.id != parameters.id
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.waiting = None;
        self.expires_at = None;
    }

    /// Takes a frame with its identifier.
    pub(crate) fn handle(&mut self, now: Instant, frame: &Frame) -> Received {
        if self.mapping.is_empty() || self.parameters.id != Some(frame.id()) {
            return Received::Nothing;
        }
        if frame.dlc() < self.mapping.byte_len() {
            return Received::TooShort;
        }
        let deadline = self.parameters.deadline;
        self.expires_at = (deadline > Duration::ZERO).then(|| now + deadline);
        let mut bytes = [0; 8];
        for (byte, &sent) in bytes.iter_mut().zip(frame.data()) {
            *byte = sent;
        }
        match self.parameters.reception {
            Reception::AtOnce => Received::Values(bytes),
            Reception::WithSync => {
                self.waiting = Some(bytes);
                Received::Waits
            }
            Reception::Never => Received::Nothing,
        }
    }

    /// Whether a frame of this length has bytes that no object takes.
    pub(crate) const fn is_exceeded_by(&self, len: u8) -> bool {
        len > self.mapping.byte_len()
    }

    /// The bytes that waited for a SYNC.
    pub(crate) fn take_waiting(&mut self) -> Option<[u8; 8]> {
        self.waiting.take()
    }

    /// The numbers that the objects would have. `None` when one of them is not permitted.
    pub(crate) fn unpack<const LEN: usize>(
        &self,
        bytes: [u8; 8],
        values: &Values<LEN>,
    ) -> Option<Vec<Mapped, MAPPED_MAX>> {
        self.mapping.unpack(bytes, values)
    }

    /// When the next PDO is overdue.
    pub(crate) const fn due_at(&self) -> Option<Instant> {
        self.expires_at
    }

    /// Whether the PDO is overdue; it then is no more.
    pub(crate) fn take_due(&mut self, now: Instant) -> bool {
        self.expires_at.take_if(|expires_at| *expires_at <= now).is_some()
    }
}

const COMMUNICATION: u16 = 0x1400;
const MAPPING: u16 = 0x1600;

impl Parameters {
    /// `None` when the product has no such PDO.
    fn read<const LEN: usize>(number: u16, values: &Values<LEN>) -> Option<Self> {
        let index = COMMUNICATION + number;
        let slot = |sub| -> Option<Slot> { values.dictionary().find(ObjectId { index, sub }).ok() };
        let value = |sub| slot(sub).map(|slot| values.raw(slot));
        Some(Self {
            id: CobId::from_raw(value(1)?).valid(),
            reception: Reception::new(value(2)?),
            deadline: Duration::from_millis(u64::from(value(5).unwrap_or(0))),
        })
    }
}

impl Reception {
    /// The meaning of a transmission type.
    pub(crate) const fn new(transmission_type: u32) -> Self {
        match transmission_type {
            0..=240 => Self::WithSync,
            254 | 255 => Self::AtOnce,
            _ => Self::Never,
        }
    }
}
