//! How a master's access to an object reaches the controller that holds it (manual 3.7.1; decisions
//!

use canopen::{Application, Mapped, ReadError, WriteError, Written};
use object_dictionary::{ObjectId, Owner, Row, Slot, Storage};
use profiles::nm17x::{
    COMMANDS, DISPLAY_MESSAGE, JOG_COMMAND, OSCILLATION_COMMAND, PDO_SETPOINT_CORRECTION_SENT,
    POSITIONING_COMMAND, PRESET, RESET_FUNCTION, START_DIMENSION_SETPOINT, START_DIRECT_SETPOINT,
    START_SAW_IN_SETPOINT, START_STANDARD_SETPOINT,
};
use shared_proto::Urgency;

use crate::interface::Received;
use crate::link::{Kind, Link, QueueError};
use crate::message::Message;
use crate::record::Record;
use crate::slots::Slots;

/// Writes that make something happen at the moment they are executed.
const ACTIONS: [ObjectId; 2] = [PRESET.id(), RESET_FUNCTION.id()];

/// Writes that move the axis.
const STARTS: [ObjectId; 7] = [
    START_STANDARD_SETPOINT.id(),
    START_DIMENSION_SETPOINT.id(),
    START_DIRECT_SETPOINT.id(),
    START_SAW_IN_SETPOINT.id(),
    POSITIONING_COMMAND.id(),
    OSCILLATION_COMMAND.id(),
    JOG_COMMAND.id(),
];

/// The way to the holder of an object, for as long as one frame is handled.
#[derive(Debug)]
pub(crate) struct Objects<'a> {
    pub(crate) link: &'a mut Link,
    pub(crate) message: &'a mut Message,
    pub(crate) slots: &'a Slots,
    pub(crate) known: Known,
    pub(crate) outcome: Outcome,
}

/// What is known of the application when a frame arrives.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// Its values have been read.
    pub(crate) values: bool,
    /// It has a scaling, without which nothing can be preset.
    pub(crate) scaling: bool,
}

/// What a frame brought about besides its answer. One frame writes one object.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outcome {
    Nothing,
    /// An object that is saved at once was written.
    Store(Record),
    /// A write is to go to the application.
    Write(ApplicationWrite),
    /// Too many writes are.
    QueueFull,
    /// A receive PDO arrived.
    Received(Received),
}

/// A write of a master to an object of the application, which has room for it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ApplicationWrite {
    pub(crate) slot: Slot,
    id: ObjectId,
    raw: u32,
}

impl ApplicationWrite {
    /// Hands it on. Nothing has taken its room since it was answered.
    pub(crate) fn hand_on(self, link: &mut Link, message: &mut Message) {
        if self.is_stop() {
            link.stop(Urgency::MotorStop);
            message.end(link);
        } else if link.write(self.id, self.raw, kind(self.id)).is_ok() {
            message.note_write();
        }
    }

    /// A stop does not wait for its turn (NM17x LINK-07).
    fn is_stop(&self) -> bool {
        self.id == POSITIONING_COMMAND.id() && self.raw == 0
    }
}

impl Objects<'_> {
    fn write_application(
        &mut self,
        slot: Slot,
        row: &Row,
        raw: u32,
    ) -> Result<Written, WriteError> {
        let id = row.id();
        if id == PRESET.id() && !self.known.scaling {
            return Err(WriteError::Failed);
        }
        let write = ApplicationWrite { slot, id, raw };
        let room = self.link.check_room(if write.is_stop() { 0 } else { 1 });
        self.note_queued(room)?;
        self.outcome = Outcome::Write(write);
        Ok(if COMMANDS.contains(&id) { Written::Ignored } else { Written::Taken })
    }

    fn note_queued(&mut self, queued: Result<(), QueueError>) -> Result<(), WriteError> {
        queued.map_err(|error| {
            if error == QueueError::Full {
                self.outcome = Outcome::QueueFull;
            }
            WriteError::Hardware
        })
    }
}

/// What a write to the application controller does.
pub(crate) fn kind(id: ObjectId) -> Kind {
    if STARTS.contains(&id) {
        Kind::Start
    } else if ACTIONS.contains(&id) {
        Kind::Action
    } else {
        Kind::Value
    }
}

impl Application for Objects<'_> {
    fn read(&mut self, slot: Slot, row: &Row) -> Result<(), ReadError> {
        let known = if self.slots.is_live(slot) {
            self.link.in_service()
        } else {
            row.owner() == Owner::Interface || self.known.values
        };
        if known { Ok(()) } else { Err(ReadError::NoData) }
    }

    fn text(&self, _slot: Slot, row: &Row) -> Option<&[u8]> {
        self.message.text().filter(|_| row.id() == DISPLAY_MESSAGE.id())
    }

    fn write(&mut self, slot: Slot, row: &Row, raw: u32) -> Result<Written, WriteError> {
        match (row.owner(), row.storage()) {
            (Owner::Application, _) => return self.write_application(slot, row, raw),
            (Owner::Interface, Storage::AtOnce) => {
                self.outcome = Outcome::Store(Record { key: row.id().key(), value: raw });
            }
            (Owner::Interface, Storage::Volatile | Storage::OnCommand) => {}
        }
        self.message.end(self.link);
        // What TxPDO2 returns follows the correction alone.
        let ignored = row.id() == PDO_SETPOINT_CORRECTION_SENT.id();
        Ok(if ignored { Written::Ignored } else { Written::Taken })
    }

    fn receive(&mut self, number: u16, values: &Mapped<'_>) -> Written {
        let mut fields = [[0; 4]; 4];
        for (field, (_, raw)) in fields.iter_mut().zip(values.iter()) {
            *field = raw.to_le_bytes();
        }
        let [first, second, third, fourth] = fields;
        let low_word = |[a, b, ..]: [u8; 4]| u16::from_le_bytes([a, b]);
        let [sub, ..] = third;
        self.outcome = Outcome::Received(match number {
            0 => Received::Broadcast {
                object: low_word(second),
                sub,
                data: u32::from_le_bytes(fourth),
            },
            _ => Received::Setpoint {
                setpoint: u32::from_le_bytes(first),
                correction: low_word(second),
                control: low_word(third),
            },
        });
        Written::Taken
    }

    fn write_text(&mut self, _slot: Slot, _row: &Row, text: &[u8]) -> Result<(), WriteError> {
        let queued = self.message.show(self.link, text);
        self.note_queued(queued)
    }
}
