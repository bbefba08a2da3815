use heapless::Vec;
use object_dictionary::{
    Access, DataType, Missing, ObjectId, OutOfLimits, Row, Slot, Values, WriteState,
};

use super::abort::AbortCode;
use super::message::word;
use crate::application::{Application, Written};
use crate::cob_id::CobId;
use crate::emcy;
use crate::heartbeat;
use crate::nmt::{ERROR_BEHAVIOUR, State};
use crate::parameter::{number, parameter};
use crate::pdo;
use crate::settings::{Expedited, Identifiers, PdoChanges, ProductSettings, Settings};
use crate::sync;
use crate::time;

/// Longest value, in bytes: the length of a text is one byte. In whole segments.
pub(super) const VALUE_MAX: usize = 37 * super::message::SEGMENT_LEN;
const _: () = assert!(VALUE_MAX >= u8::MAX as usize);

/// The objects that store parameters and restore those at delivery.
const STORE: u16 = 0x1010;
const RESTORE: u16 = 0x1011;
/// The commands to do so (CiA 301, sections 7.5.2.13 and 7.5.2.14).
const SAVE: u32 = u32::from_le_bytes(*b"save");
const LOAD: u32 = u32::from_le_bytes(*b"load");

/// The object dictionary as a client meets it. The checks come in one order, so that a request
/// fails for one reason only: index, sub-index, access, NMT state, length, value, application.
pub(crate) struct Objects<'a, A, S, const LEN: usize> {
    values: &'a mut Values<LEN>,
    application: &'a mut A,
    monitored: &'a heartbeat::Consumers,
    settings: S,
    state: State,
    effect: Effect,
}

/// What a request brought about besides its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing, or nothing that the stack has to do with.
    None,
    /// The number at this slot was written.
    Changed(Slot),
    /// A number of the communication was.
    Configured(Slot),
    /// Parameters are to be stored.
    Store {
        /// Which.
        sub: u8,
    },
    /// Parameters at delivery are to be restored.
    Restore {
        /// Which.
        sub: u8,
    },
}

/// An entry that a client may access.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) row: Row,
    pub(super) slot: Slot,
    /// Bytes of its value.
    pub(super) len: u8,
}

/// What a client wants of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    Read,
    Write,
}

impl<'a, A: Application, S: ProductSettings, const LEN: usize> Objects<'a, A, S, LEN> {
    pub(crate) fn new(
        values: &'a mut Values<LEN>,
        application: &'a mut A,
        monitored: &'a heartbeat::Consumers,
        settings: S,
        state: State,
    ) -> Self {
        Self { values, application, monitored, settings, state, effect: Effect::None }
    }

    pub(crate) const fn effect(&self) -> Effect {
        self.effect
    }

    /// The request is refused after all.
    pub(super) const fn give_up(&mut self) {
        self.effect = Effect::None;
    }

    #[inline]
    pub(super) fn settings(&self) -> &'static Settings {
        self.settings.settings()
    }

    /// The entry, if it may be read or written now.
    #[inline]
    pub(super) fn find(&mut self, object: ObjectId, to: Purpose) -> Result<Entry, AbortCode> {
        let dictionary = self.values.dictionary();
        let slot = dictionary.find(object).map_err(|missing| match missing {
            Missing::Object => AbortCode::NO_OBJECT,
            Missing::SubIndex => AbortCode::NO_SUB_INDEX,
        })?;
        let row = dictionary.row(slot).ok_or(AbortCode::NO_OBJECT)?;
        match to {
            Purpose::Read => self.check_readable(slot, row)?,
            Purpose::Write => self.check_writable(row)?,
        }
        let [len, ..] = row.data_type().len().to_le_bytes();
        Ok(Entry { slot, row, len })
    }

    fn check_readable(&mut self, slot: Slot, row: Row) -> Result<(), AbortCode> {
        match row.access() {
            Access::ReadOnly | Access::ReadWrite => {}
            Access::WriteOnly => return Err(AbortCode::WRITE_ONLY),
        }
        let ObjectId { index, sub } = row.id();
        if index == emcy::HISTORY && self.is_empty_error(sub) {
            return Err(AbortCode::NO_DATA);
        }
        self.application.read(slot, &row).map_err(AbortCode::of_read)
    }

    /// The number at an entry, in 32 bits.
    pub(super) fn number(&self, entry: Entry) -> u32 {
        entry.row.data_type().widen(self.values.raw(entry.slot))
    }

    /// Puts the bytes of a value into `place`.
    pub(super) fn load(
        &self,
        entry: Entry,
        place: &mut Vec<u8, VALUE_MAX>,
    ) -> Result<(), AbortCode> {
        let number = self.number(entry).to_le_bytes();
        let bytes = match entry.row.data_type() {
            DataType::VisibleString(_) => self
                .application
                .text(entry.slot, &entry.row)
                .unwrap_or_else(|| entry.row.text().as_bytes()),
            DataType::Unsigned8
            | DataType::Unsigned16
            | DataType::Unsigned32
            | DataType::Integer8
            | DataType::Integer16
            | DataType::Integer32 => number.get(..usize::from(entry.len)).unwrap_or(&[]),
        };
        place.clear();
        place.extend_from_slice(bytes).map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    /// The code for a length that is not the entry's.
    pub(super) fn length_code(&self, row: Row) -> AbortCode {
        match row.data_type() {
            DataType::VisibleString(_) => self.settings().abort_codes.text_length,
            DataType::Unsigned8
            | DataType::Unsigned16
            | DataType::Unsigned32
            | DataType::Integer8
            | DataType::Integer16
            | DataType::Integer32 => self.settings().abort_codes.number_length,
        }
    }

    /// Whether an expedited download may have a length that is not the entry's: `data` with as many
    /// bytes as indicated.
    pub(super) fn check_other_len(
        &self,
        entry: Entry,
        indicated: Option<u32>,
        data: u32,
    ) -> Result<(), AbortCode> {
        let (expedited, codes) = (self.settings().expedited, &self.settings().abort_codes);
        let Entry { row, len, .. } = entry;
        let (len, is_text) = (u32::from(len), row.data_type().is_text());
        let fits = match (expedited, indicated) {
            (Expedited::FourOnly, indicated) => indicated == Some(4) && (len == 4 || !is_text),
            (Expedited::LongerToo, Some(indicated)) => indicated >= len,
            (Expedited::AnyLength | Expedited::OneTwoOrFour, Some(indicated)) => indicated == len,
            (Expedited::LongerToo | Expedited::AnyLength | Expedited::OneTwoOrFour, None) => {
                len <= 4
            }
        };
        if !fits {
            return Err(self.length_code(row));
        }
        if expedited == Expedited::FourOnly && !is_text && row.data_type().widen(data) != data {
            return Err(codes.above_maximum);
        }
        match codes.excess_bytes {
            Some(code) if indicated.is_none() && data.checked_shr(8 * len).unwrap_or(0) != 0 => {
                Err(code)
            }
            Some(_) | None => Ok(()),
        }
    }

    /// Writes a value after the remaining checks.
    pub(super) fn write(&mut self, entry: Entry, bytes: &[u8]) -> Result<(), AbortCode> {
        let Entry { slot, row, len } = entry;
        self.check_writable(row)?;
        if bytes.len() != usize::from(len) {
            return Err(self.length_code(row));
        }
        if row.data_type().is_text() {
            let written = self.application.write_text(slot, &row, bytes);
            return written
                .map_err(|error| AbortCode::of_write(error, &self.settings().abort_codes));
        }
        self.write_number(entry, word(bytes))
    }

    /// Writes the number that the low bytes of `raw` are after the remaining checks.
    #[inline]
    pub(super) fn write_number(&mut self, entry: Entry, raw: u32) -> Result<(), AbortCode> {
        let Entry { slot, row, .. } = entry;
        let codes = self.settings().abort_codes;
        let raw = row.data_type().widen(raw);
        row.check(raw).map_err(|outside| match outside {
            OutOfLimits::Above => codes.above_maximum,
            OutOfLimits::Below => codes.below_minimum,
            OutOfLimits::Beside => codes.value_range,
        })?;
        let (mut effect, mut acts_again) = (Effect::Changed(slot), false);
        if row.id().index < COMMUNICATION_END {
            match row.id().index {
                STORE | RESTORE => {
                    self.effect = command(row.id(), raw)?;
                    return Ok(());
                }
                index => acts_again = index == heartbeat::CONSUMER_TIME,
            }
            self.check_communication(row.id(), raw)?;
            effect = Effect::Configured(slot);
        }
        match self.application.write(slot, &row, raw) {
            Ok(Written::Taken) if self.values.raw(slot) != raw || acts_again => {
                self.values.set_raw(slot, raw);
                self.effect = effect;
                Ok(())
            }
            Ok(Written::Taken | Written::Ignored) => Ok(()),
            Err(error) => Err(AbortCode::of_write(error, &codes)),
        }
    }

    /// Whether a master may write the entry, now and with SDO.
    fn check_writable(&self, row: Row) -> Result<(), AbortCode> {
        match (row.access(), row.write_state()) {
            (_, WriteState::NotWithSdo) => Err(AbortCode::UNSUPPORTED_ACCESS),
            (Access::ReadOnly, _) => Err(AbortCode::READ_ONLY),
            (Access::WriteOnly | Access::ReadWrite, WriteState::PreOperational)
                if self.state != State::PreOperational =>
            {
                Err(AbortCode::DEVICE_STATE)
            }
            (
                Access::WriteOnly | Access::ReadWrite,
                WriteState::Any | WriteState::PreOperational,
            ) => Ok(()),
        }
    }

    /// Whether an entry of the pre-defined error field holds no error.
    fn is_empty_error(&self, sub: u8) -> bool {
        parameter(self.values, emcy::HISTORY, 0).is_some_and(|count| u32::from(sub) > count)
    }

    /// Whether the stack can act on this value of an object of the communication.
    #[inline(never)]
    fn check_communication(&self, object: ObjectId, raw: u32) -> Result<(), AbortCode> {
        let settings = self.settings();
        let possible = match (object.index, object.sub) {
            (0x1400..=0x1BFF, _) => return pdo::check(self.values, settings, object, raw),
            (heartbeat::CONSUMER_TIME, sub) if self.monitored.is_doubled(sub, raw) => {
                return Err(AbortCode::INCOMPATIBLE);
            }
            (heartbeat::CONSUMER_TIME, _) => true,
            (emcy::HISTORY, 0) => raw == 0,
            (time::COB_ID, 0) => CobId::from_raw(raw).suits_consumer(),
            // The row is all there is to check.
            (sync::COB_ID | emcy::COB_ID, 0) if settings.identifiers == Identifiers::Any => true,
            (emcy::COB_ID, 0) => {
                let before = || CobId::from_raw(number(self.values, emcy::COB_ID, 0));
                let after = CobId::from_raw(raw);
                let may_move = settings.pdo.changes == PdoChanges::AnyTime;
                after.suits_emergency() && (may_move || !after.moves(before()))
            }
            (ERROR_BEHAVIOUR, 1) => raw <= 3,
            _ => return sync::check(self.values, object, raw),
        };
        if possible { Ok(()) } else { Err(settings.abort_codes.value_range) }
    }
}

/// The first index behind the objects of the communication.
const COMMUNICATION_END: u16 = 0x2000;

/// The command to store or restore, if that is what was written.
const fn command(object: ObjectId, signature: u32) -> Result<Effect, AbortCode> {
    let sub = object.sub;
    match (object.index, signature) {
        (STORE, SAVE) => Ok(Effect::Store { sub }),
        (RESTORE, LOAD) => Ok(Effect::Restore { sub }),
        _ => Err(AbortCode::NOT_STORED),
    }
}
