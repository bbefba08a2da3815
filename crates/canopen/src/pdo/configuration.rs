use object_dictionary::{ObjectId, Values};

use super::Direction;
use super::entry::Entry;
use super::mapping::{LEN_MAX, MAPPED_MAX};
use super::rpdo::Reception;
use super::transmission::Transmission;
use crate::cob_id::CobId;
use crate::parameter::parameter;
use crate::sdo::AbortCode;
use crate::settings::{PdoChanges, PdoIdentifiers, PdoRules};

/// The four areas of 0x200 indices each that describe PDOs.
const AREA: u16 = 0x200;

/// What an index in these areas is about.
#[derive(Clone, Copy, Debug)]
enum Record {
    Communication,
    Mapping,
}

/// Whether a client may write `raw` to an object from 0x1400 to 0x1BFF, which its row permits
/// (CiA 301, sections 7.5.2.35 to 7.5.2.38).
pub(crate) fn check<const LEN: usize>(
    values: &Values<LEN>,
    rules: &PdoRules,
    object: ObjectId,
    raw: u32,
) -> Result<(), AbortCode> {
    let (direction, record) = match object.index {
        0x1400..=0x15FF => (Direction::Receive, Record::Communication),
        0x1600..=0x17FF => (Direction::Receive, Record::Mapping),
        0x1800..=0x19FF => (Direction::Transmit, Record::Communication),
        0x1A00..=0x1BFF => (Direction::Transmit, Record::Mapping),
        _ => return Ok(()),
    };
    let present = Present { values, object, direction };
    match record {
        Record::Communication => present.check_parameter(rules, raw),
        Record::Mapping => present.check_mapping(raw),
    }
}

/// A PDO as it is before one of its objects is written.
struct Present<'a, const LEN: usize> {
    values: &'a Values<LEN>,
    object: ObjectId,
    direction: Direction,
}

impl<const LEN: usize> Present<'_, LEN> {
    fn check_parameter(&self, rules: &PdoRules, raw: u32) -> Result<(), AbortCode> {
        let frozen = match rules.changes {
            PdoChanges::WhileOff => self.is_on(self.object.index),
            PdoChanges::AnyTime => false,
        };
        let is_possible = match (self.object.sub, self.direction) {
            (1, _) => self.takes_cob_id(rules.identifiers, frozen, CobId::from_raw(raw)),
            (2, Direction::Receive) => Reception::new(raw) != Reception::Never,
            (2, Direction::Transmit) => Transmission::is_known(raw),
            (3, _) => !frozen,
            (6, Direction::Transmit) => !frozen && raw <= 240,
            _ => true,
        };
        if is_possible { Ok(()) } else { Err(AbortCode::VALUE_RANGE) }
    }

    fn takes_cob_id(&self, identifiers: PdoIdentifiers, frozen: bool, cob_id: CobId) -> bool {
        let is_free = match identifiers {
            PdoIdentifiers::Unrestricted => cob_id.suits_pdo(),
            PdoIdentifiers::Any => cob_id.has_eleven_bits(),
        };
        let stays = self
            .value(self.object)
            .is_some_and(|before| CobId::from_raw(before).can_id() == cob_id.can_id());
        is_free && (!frozen || stays || cob_id.valid().is_none())
    }

    fn check_mapping(&self, raw: u32) -> Result<(), AbortCode> {
        let ObjectId { index, sub } = self.object;
        if self.is_on(index - AREA) {
            return Err(AbortCode::UNSUPPORTED_ACCESS);
        }
        match sub {
            0 => self.check_entries(raw),
            _ if self.value(ObjectId { index, sub: 0 }) != Some(0) => {
                Err(AbortCode::UNSUPPORTED_ACCESS)
            }
            _ if raw == 0 => Ok(()),
            _ => self.check_entry(raw).map(|_| ()),
        }
    }

    fn check_entries(&self, count: u32) -> Result<(), AbortCode> {
        let count = u8::try_from(count).ok().filter(|&count| count <= MAPPED_MAX);
        let mut len = 0;
        for sub in 1..=count.ok_or(AbortCode::MAPPING_LENGTH)? {
            let entry = self.value(ObjectId { index: self.object.index, sub });
            len += self.check_entry(entry.ok_or(AbortCode::MAPPING_LENGTH)?)?;
        }
        if len <= LEN_MAX { Ok(()) } else { Err(AbortCode::MAPPING_LENGTH) }
    }

    fn check_entry(&self, raw: u32) -> Result<u8, AbortCode> {
        Entry::from_raw(raw).check(self.values.dictionary(), self.direction)
    }

    /// Whether the PDO with this communication parameter is switched on.
    fn is_on(&self, index: u16) -> bool {
        let cob_id = self.value(ObjectId { index, sub: 1 });
        cob_id.is_some_and(|raw| CobId::from_raw(raw).valid().is_some())
    }

    fn value(&self, object: ObjectId) -> Option<u32> {
        parameter(self.values, object.index, object.sub)
    }
}
