use object_dictionary::{
    Access, DataType, Default, Missing, ObjectId, OutOfLimits, Row, Slot, Values,
};

use super::abort::AbortCode;
use crate::application::{Application, Written};
use crate::cob_id::CobId;
use crate::emcy;
use crate::heartbeat;
use crate::pdo;
use crate::settings::Settings;
use crate::sync;
use crate::time;

/// The object dictionary as a client meets it. The checks come in one order, so that a request
/// fails for one reason only: index, sub-index, access, length, value, application.
pub(crate) struct Objects<'a, A, const LEN: usize> {
    values: &'a mut Values<LEN>,
    application: &'a mut A,
    settings: &'a Settings,
    changed: Option<Slot>,
}

/// An entry that a client may access.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) slot: Slot,
    pub(super) row: &'static Row,
}

impl<'a, A: Application, const LEN: usize> Objects<'a, A, LEN> {
    pub(crate) fn new(
        values: &'a mut Values<LEN>,
        application: &'a mut A,
        settings: &'a Settings,
    ) -> Self {
        Self { values, application, settings, changed: None }
    }

    /// The number that was written, if that has an effect.
    pub(crate) const fn changed(&self) -> Option<Slot> {
        self.changed
    }

    /// The entry, if it may be read now.
    pub(super) fn readable(&mut self, object: ObjectId) -> Result<Entry, AbortCode> {
        let entry = self.find(object)?;
        match entry.row.access {
            Access::ReadOnly | Access::ReadWrite => {}
            Access::WriteOnly => return Err(AbortCode::WRITE_ONLY),
        }
        if self.is_empty_error(entry.row.id) {
            return Err(AbortCode::NO_DATA);
        }
        self.application.read(entry.slot, entry.row).map_err(AbortCode::of_read)?;
        Ok(entry)
    }

    /// The entry, if it may be written at all.
    pub(super) fn writable(&self, object: ObjectId) -> Result<Entry, AbortCode> {
        let entry = self.find(object)?;
        match entry.row.access {
            Access::WriteOnly | Access::ReadWrite => Ok(entry),
            Access::ReadOnly => Err(AbortCode::READ_ONLY),
        }
    }

    /// The bytes of a value. A number uses `number` as its place.
    pub(super) fn bytes<'b>(&'b self, entry: Entry, number: &'b mut [u8; 4]) -> &'b [u8] {
        if let DataType::VisibleString(_) = entry.row.data_type {
            let default = match entry.row.default() {
                Default::Text(text) => text.as_bytes(),
                Default::Number(_) | Default::NodeIdPlus(_) => &[],
            };
            return self.application.text(entry.slot, entry.row).unwrap_or(default);
        }
        *number = self.values.raw(entry.slot).to_le_bytes();
        number.get(..entry.row.data_type.len()).unwrap_or(&[])
    }

    /// Whether a value of `len` bytes could be written.
    pub(super) fn check_len(&self, row: &Row, len: usize) -> Result<(), AbortCode> {
        if len == row.data_type.len() { Ok(()) } else { Err(self.length_code(row)) }
    }

    /// The code for a length that is not the entry's.
    pub(super) fn length_code(&self, row: &Row) -> AbortCode {
        match row.data_type {
            DataType::VisibleString(_) => self.settings.abort_codes.text_length,
            DataType::Unsigned8
            | DataType::Unsigned16
            | DataType::Unsigned32
            | DataType::Integer8
            | DataType::Integer16
            | DataType::Integer32 => self.settings.abort_codes.number_length,
        }
    }

    /// Whether the bytes sent beyond the value may be there.
    pub(super) fn check_excess(&self, excess: &[u8]) -> Result<(), AbortCode> {
        match self.settings.abort_codes.excess_bytes {
            Some(code) if excess.iter().any(|&byte| byte != 0) => Err(code),
            Some(_) | None => Ok(()),
        }
    }

    pub(super) const fn settings(&self) -> &Settings {
        self.settings
    }

    /// Writes a value after the remaining checks.
    pub(super) fn write(&mut self, entry: Entry, bytes: &[u8]) -> Result<(), AbortCode> {
        let Entry { slot, row } = entry;
        self.check_len(row, bytes.len())?;
        let codes = &self.settings.abort_codes;
        if let DataType::VisibleString(_) = row.data_type {
            let written = self.application.write_text(slot, row, bytes);
            return written.map_err(|error| AbortCode::of_write(error, codes));
        }
        let raw = self.permitted(row, bytes)?;
        let written = self.application.write(slot, row, raw);
        match written.map_err(|error| AbortCode::of_write(error, codes))? {
            Written::Taken if self.values.raw(slot) != raw || acts_again(row.id) => {
                self.values.set_raw(slot, raw);
                self.changed = Some(slot);
            }
            Written::Taken | Written::Ignored => {}
        }
        Ok(())
    }

    /// Whether it is an entry of the pre-defined error field that holds no error.
    fn is_empty_error(&self, object: ObjectId) -> bool {
        let count = ObjectId { index: emcy::HISTORY, sub: 0 };
        object.index == emcy::HISTORY
            && self
                .values
                .dictionary()
                .find(count)
                .is_ok_and(|count| u32::from(object.sub) > self.values.raw(count))
    }

    fn find(&self, object: ObjectId) -> Result<Entry, AbortCode> {
        let dictionary = self.values.dictionary();
        let slot = dictionary.find(object).map_err(|missing| match missing {
            Missing::Object => AbortCode::NO_OBJECT,
            Missing::SubIndex => AbortCode::NO_SUB_INDEX,
        })?;
        let row = dictionary.row(slot).ok_or(AbortCode::NO_OBJECT)?;
        Ok(Entry { slot, row })
    }

    /// The number in 32 bits, if it may be written.
    fn permitted(&self, row: &Row, bytes: &[u8]) -> Result<u32, AbortCode> {
        let codes = &self.settings.abort_codes;
        let mut le = [0; 4];
        for (byte, &sent) in le.iter_mut().zip(bytes) {
            *byte = sent;
        }
        let raw = row.data_type.widen(u32::from_le_bytes(le));
        row.check(raw).map_err(|outside| match outside {
            OutOfLimits::Above => codes.above_maximum,
            OutOfLimits::Below => codes.below_minimum,
            OutOfLimits::Beside => codes.value_range,
        })?;
        if !is_possible(row.id, raw) {
            return Err(codes.value_range);
        }
        if heartbeat::is_doubled(row.id, raw, self.values) {
            return Err(AbortCode::INCOMPATIBLE);
        }
        pdo::check(self.values, &self.settings.pdo, row.id, raw)?;
        sync::check(self.values, row.id, raw)?;
        Ok(raw)
    }
}

/// Whether writing the value that is there already has an effect too.
const fn acts_again(object: ObjectId) -> bool {
    object.index == heartbeat::CONSUMER_TIME
}

/// Whether the stack can act on this value of one of its own objects.
fn is_possible(object: ObjectId, raw: u32) -> bool {
    match (object.index, object.sub) {
        (emcy::HISTORY, 0) => raw == 0,
        (time::COB_ID, 0) => CobId::from_raw(raw).suits_consumer(),
        (0x1014, 0) => CobId::from_raw(raw).suits_emergency(),
        (0x1029, 1) => raw <= 3,
        _ => true,
    }
}
