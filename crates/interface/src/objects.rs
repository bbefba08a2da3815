//! How a master's access to an object reaches the controller that holds it (manual 3.7.1; decisions
//!

use canopen::{Application, ReadError, WriteError, Written};
use object_dictionary::{ObjectId, Owner, Row, Slot, Storage};
use profiles::nm17x::{ERRORS, POSITION_VALUE, STATUS, STATUS_REGISTER};

use crate::interface::Record;
use crate::link::{Link, QueueError};

/// What process data carry: known only as long as they arrive.
const LIVE: [ObjectId; 4] = [POSITION_VALUE.id(), STATUS.id(), ERRORS.id(), STATUS_REGISTER.id()];

/// Whether process data carry the object.
pub(crate) fn is_live(object: ObjectId) -> bool {
    LIVE.contains(&object)
}

/// The way to the holder of an object, for as long as one frame is handled.
#[derive(Debug)]
pub(crate) struct Objects<'a> {
    link: &'a mut Link,
    values_known: bool,
    outcome: Outcome,
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
    pub(crate) const fn new(link: &'a mut Link, values_known: bool) -> Self {
        Self { link, values_known, outcome: Outcome::Nothing }
    }

    pub(crate) const fn outcome(&self) -> Outcome {
        self.outcome
    }
}

impl Application for Objects<'_> {
    fn read(&mut self, _slot: Slot, row: &Row) -> Result<(), ReadError> {
        let known = if is_live(row.id) {
            self.link.in_service()
        } else {
            row.owner == Owner::Interface || self.values_known
        };
        if known { Ok(()) } else { Err(ReadError::NoData) }
    }

    fn write(&mut self, _slot: Slot, row: &Row, raw: u32) -> Result<Written, WriteError> {
        match (row.owner, row.storage) {
            (Owner::Application, _) => {
                if let Err(error) = self.link.write(row.id.index, row.id.sub, raw) {
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
