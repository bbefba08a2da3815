use object_dictionary::{ObjectId, Values};

use super::entry::Entry;
use super::mapping::Mapping;
use super::rpdo::Reception;
use super::transmission::Transmission;
use super::{Direction, MAPPING};
use crate::cob_id::CobId;
use crate::parameter::{number, parameter};
use crate::sdo::AbortCode;
use crate::settings::{Identifiers, PdoChanges, Settings};

/// Whether a client may write `raw` to an object from 0x1400 to 0x1BFF, which its row permits
/// (CiA 301, sections 7.5.2.35 to 7.5.2.38).
pub(crate) fn check<const LEN: usize>(
    values: &Values<LEN>,
    settings: &Settings,
    object: ObjectId,
    raw: u32,
) -> Result<(), AbortCode> {
    let ObjectId { index, sub } = object;
    let present = || CobId::from_raw(number(values, index & !MAPPING, 1));
    let is_on = || present().valid().is_some();
    if index & MAPPING != 0 {
        return if is_on() {
            Err(AbortCode::UNSUPPORTED_ACCESS)
        } else {
            check_mapping(values, object, raw)
        };
    }
    let direction = Direction::of(index);
    let is_known = match (sub, direction) {
        (1, _) => takes(settings.identifiers, CobId::from_raw(raw)),
        (2, Direction::Receive) => Reception::new(raw) != Reception::Never,
        (2, Direction::Transmit) => Transmission::is_known(raw),
        (6, Direction::Transmit) => raw <= 240,
        _ => true,
    };
    let is_fixed = || match (sub, direction) {
        (1, _) => CobId::from_raw(raw).moves(present()),
        (3, _) | (6, Direction::Transmit) => is_on(),
        _ => false,
    };
    if is_known && !(settings.pdo.changes == PdoChanges::WhileOff && is_fixed()) {
        Ok(())
    } else {
        Err(AbortCode::VALUE_RANGE)
    }
}

/// Whether a PDO may have this COB-ID.
fn takes(identifiers: Identifiers, cob_id: CobId) -> bool {
    match identifiers {
        Identifiers::Unrestricted => cob_id.suits_pdo(),
        Identifiers::Any => cob_id.has_eleven_bits(),
    }
}

/// Whether the mapping of a PDO that is switched off takes an entry, or the count of entries.
fn check_mapping<const LEN: usize>(
    values: &Values<LEN>,
    object: ObjectId,
    raw: u32,
) -> Result<(), AbortCode> {
    let ObjectId { index, sub } = object;
    if sub == 0 {
        Mapping::default().read(values, index, raw)
    } else if parameter(values, index, 0) != Some(0) {
        Err(AbortCode::UNSUPPORTED_ACCESS)
    } else if raw == 0 {
        Ok(())
    } else {
        let entry = Entry::from_raw(raw);
        let (_, row) = entry.find(values.dictionary());
        entry.check(row, index)
    }
}
