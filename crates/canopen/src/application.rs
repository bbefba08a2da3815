use object_dictionary::{Row, Slot};

use crate::pdo::Mapped;
use crate::settings::BlockTransfer;

/// The product behind the object dictionary. Every hook has a default that leaves all to the stack.
///
/// The stack calls a hook only after all of its own checks have passed, at most one per request.
pub trait Application {
    /// Whether clients may transfer values in blocks. Where they may not, the image has no code for
    /// it.
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Unknown;

    /// Asked before the value at `slot` is read by a client.
    ///
    /// # Errors
    /// Says why there is nothing to read now.
    fn read(&mut self, slot: Slot, row: &Row) -> Result<(), ReadError> {
        let _ = (slot, row);
        Ok(())
    }

    /// The text at `slot`, for texts that are not the default of their row. `None` takes the
    /// default.
    fn text(&self, slot: Slot, row: &Row) -> Option<&[u8]> {
        let _ = (slot, row);
        None
    }

    /// Asked before the number `raw`, which the row permits, is stored at `slot`. Commands to store
    /// and to restore are none: they are [`Event::Store`](crate::Event::Store) and
    /// [`Event::Restore`](crate::Event::Restore).
    ///
    /// # Errors
    /// Says why it cannot be written now.
    fn write(&mut self, slot: Slot, row: &Row, raw: u32) -> Result<Written, WriteError> {
        let _ = (slot, row, raw);
        Ok(Written::Taken)
    }

    /// Asked before the numbers of the receive PDO 0x1400 + `number`, which their rows permit, are
    /// stored, all or none.
    fn receive(&mut self, number: u16, values: &Mapped<'_>) -> Written {
        let _ = (number, values);
        Written::Taken
    }

    /// Takes a text of the row's length over; the stack keeps no texts.
    ///
    /// # Errors
    /// Says why it cannot be written; the default has no place for texts.
    fn write_text(&mut self, slot: Slot, row: &Row, text: &[u8]) -> Result<(), WriteError> {
        let _ = (slot, row, text);
        Err(WriteError::Failed)
    }
}

/// A product without hooks: what the dictionary says is all.
impl Application for () {}

/// What becomes of a written number. The client sees success either way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// The stack stores it.
    Taken,
    /// The value stays what it was: the write was a command, or has no effect now.
    Ignored,
}

/// Why a value cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// There is no value now.
    NoData,
    /// Whoever holds the value cannot be reached, or is overloaded.
    Hardware,
    /// Not in the present state of the device.
    DeviceState,
    /// Anything else.
    Failed,
}

/// Why a value cannot be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WriteError {
    /// The row permits the value, the product does not.
    ValueRange,
    /// The non-volatile memory did not take it.
    NotStored,
    /// Whoever holds the value cannot be reached, or is overloaded.
    Hardware,
    /// Not in the present state of the device.
    DeviceState,
    /// The row permits the value, which lies above what the product takes now.
    AboveMaximum,
    /// Anything else.
    Failed,
}
