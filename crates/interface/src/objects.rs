//! How a master's access to an object reaches the controller that holds it (manual 3.7.1; decisions
//!

use canopen::{Application, ReadError, WriteError, Written};
use object_dictionary::{ObjectId, Owner, Row, Slot, Storage};
use profiles::nm17x::{PRESET, RESET_FUNCTION};

use crate::link::{Kind, Link, QueueError};
use crate::record::Record;
use crate::slots::Slots;

/// Writes that make something happen at the moment they are executed.
const ACTIONS: [ObjectId; 2] = [PRESET.id(), RESET_FUNCTION.id()];

/// The way to the holder of an object, for as long as one frame is handled.
#[derive(Debug)]
pub(crate) struct Objects<'a> {
    link: &'a mut Link,
    slots: &'a Slots,
    known: Known,
    outcome: Outcome,
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
    /// A write is on its way to the application.
    ApplicationWritten,
    /// Too many writes are.
    QueueFull,
}

impl<'a> Objects<'a> {
    pub(crate) const fn new(link: &'a mut Link, slots: &'a Slots, known: Known) -> Self {
        Self { link, slots, known, outcome: Outcome::Nothing }
    }

    pub(crate) const fn outcome(&self) -> Outcome {
        self.outcome
    }
}

impl Application for Objects<'_> {
    fn read(&mut self, slot: Slot, row: &Row) -> Result<(), ReadError> {
        let known = if self.slots.is_live(slot) {
            self.link.in_service()
        } else {
            row.owner == Owner::Interface || self.known.values
        };
        if known { Ok(()) } else { Err(ReadError::NoData) }
    }

    fn write(&mut self, _slot: Slot, row: &Row, raw: u32) -> Result<Written, WriteError> {
        match (row.owner, row.storage) {
            (Owner::Application, _) if row.id == PRESET.id() && !self.known.scaling => {
                return Err(WriteError::Failed);
            }
            (Owner::Application, _) => {
                let kind = if ACTIONS.contains(&row.id) { Kind::Action } else { Kind::Value };
                if let Err(error) = self.link.write(row.id, raw, kind) {
                    if error == QueueError::Full {
                        self.outcome = Outcome::QueueFull;
                    }
                    return Err(WriteError::Hardware);
                }
                self.outcome = Outcome::ApplicationWritten;
            }
            (Owner::Interface, Storage::AtOnce) => {
                self.outcome = Outcome::Store(Record { key: row.id.key(), value: raw });
            }
            (Owner::Interface, Storage::Volatile | Storage::OnCommand) => {}
        }
        Ok(Written::Taken)
    }
}
