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

/// The ways to the holders of the objects.
#[derive(Debug)]
pub(crate) struct Objects {
    pub(crate) slots: Slots,
    pub(crate) link: Link,
    pub(crate) message: Message,
    /// The application's values have been read.
    pub(crate) values_known: bool,
    /// The application has a scaling, without which nothing can be preset. Kept here, since no
    /// answer waits for a look at its value.
    pub(crate) has_scaling: bool,
    /// What the last frame brought about, until that is followed.
    pub(crate) outcome: Outcome,
}

/// What a frame brought about besides its answer. One frame writes one object.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Outcome {
    #[default]
    Nothing,
    /// An object that is saved at once was written.
    Store(Record),
    /// A write is to go to the application.
    Write(ApplicationWrite),
    /// The text for the display is to go there.
    Text,
    /// A write found no room on the way there.
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
    /// A stop does not wait for its turn (NM17x LINK-07).
    fn is_stop(&self) -> bool {
        self.id == POSITIONING_COMMAND.id() && self.raw == 0
    }
}

impl Objects {
    pub(crate) fn new(slots: Slots, link: Link) -> Self {
        Self {
            slots,
            link,
            message: Message::default(),
            values_known: false,
            has_scaling: false,
            outcome: Outcome::default(),
        }
    }

    /// Hands a write on. Nothing has taken its room since it was answered.
    pub(crate) fn hand_on(&mut self, write: ApplicationWrite) {
        let ApplicationWrite { id, raw, .. } = write;
        if write.is_stop() {
            self.link.stop(Urgency::MotorStop);
            self.end_message();
        } else if self.link.write(id, raw, kind(id)).is_ok() {
            self.message.note_write();
        }
    }

    pub(crate) fn show_message(&mut self) {
        self.message.show(&mut self.link);
    }

    pub(crate) fn end_message(&mut self) {
        self.message.end(&mut self.link);
    }

    fn write_application(
        &mut self,
        slot: Slot,
        row: &Row,
        raw: u32,
    ) -> Result<Written, WriteError> {
        let id = row.id();
        if id == PRESET.id() && !self.has_scaling {
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

impl Application for Objects {
    fn read(&mut self, slot: Slot, row: &Row) -> Result<(), ReadError> {
        let known = match row.owner() {
            Owner::Interface if self.slots.status_register == Some(slot) => self.link.in_service(),
            Owner::Interface => true,
            Owner::Application if self.slots.is_live(slot) => self.link.in_service(),
            Owner::Application => self.values_known,
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
        self.end_message();
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
        let room = self.message.set(&self.link, text);
        self.note_queued(room)?;
        self.outcome = Outcome::Text;
        Ok(())
    }
}
