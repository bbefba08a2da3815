use crate::object::{Object, Value};
use crate::row::{Access, Default, ObjectId, Row, Storage, WriteState};

/// The rows of a product in ascending order.
#[derive(Debug)]
pub struct Dictionary {
    rows: &'static [Row],
}

/// The place of an entry in its dictionary. Looked up once, it saves the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Slot(u16);

/// Why an entry was not found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// No entry has the index.
    Object,
    /// The index exists, the sub-index does not.
    SubIndex,
}

impl Slot {
    /// A place that no dictionary has: there is nothing to read, and nothing is kept.
    pub const NOWHERE: Self = Self(u16::MAX);

    /// The slot with this position, if `dictionary` is that long.
    #[must_use]
    pub fn at(dictionary: &Dictionary, position: u16) -> Option<Self> {
        (usize::from(position) < dictionary.rows.len()).then_some(Self(position))
    }

    /// Position of the row, counted from 0.
    #[must_use]
    pub const fn position(self) -> u16 {
        self.0
    }
}

impl Dictionary {
    /// A dictionary of these rows. Panics, at compile time, when they are out of order, doubled, or
    /// have a stored or constant default outside
    /// their limits.
    #[must_use]
    pub const fn new(rows: &'static [Row]) -> Self {
        assert!(rows.len() <= u16::MAX as usize, "too many rows");
        let mut left = rows;
        while let [row, rest @ ..] = left {
            check(row);
            if let [next, ..] = rest {
                assert!(row.id.key() < next.id.key(), "rows are not in ascending order");
            }
            left = rest;
        }
        Self { rows }
    }

    /// All rows, in ascending order.
    #[must_use]
    pub const fn rows(&self) -> &'static [Row] {
        self.rows
    }

    /// The place of an entry.
    ///
    /// # Errors
    /// Says whether index or sub-index is missing.
    pub fn find(&self, id: ObjectId) -> Result<Slot, Missing> {
        let first = self.rows.partition_point(|row| row.id.index < id.index);
        let object = self.rows.get(first..).unwrap_or(&[]);
        let sub = usize::from(id.sub);
        let offset = match object.get(sub) {
            Some(row) if row.id == id => sub,
            Some(_) | None => search(object, id)?,
        };
        Ok(Slot(u16::try_from(first + offset).unwrap_or(u16::MAX)))
    }

    /// The place of an object that is known to be in this dictionary. For constants: panics when
    /// it is not there, which then does not compile.
    #[must_use]
    pub const fn slot<T: Value>(&self, object: &Object<T>) -> Slot {
        let mut slot = Slot(0);
        let mut left = self.rows;
        while let [row, rest @ ..] = left {
            if row.id.key() == object.id().key() {
                return slot;
            }
            slot.0 += 1;
            left = rest;
        }
        panic!("the product does not have this object")
    }

    /// The row at a slot of this dictionary. `None` for a slot of a longer one.
    #[must_use]
    pub fn row(&self, slot: Slot) -> Option<&'static Row> {
        self.rows.get(usize::from(slot.0))
    }

    /// All slots, in ascending order of their objects.
    pub fn slots(&self) -> impl Iterator<Item = (Slot, &'static Row)> + use<> {
        (0..=u16::MAX).map(Slot).zip(self.rows)
    }

    /// A number that sets two dictionaries apart when any index, type, access, default or limit
    /// differs (FNV-1a). Two controllers built from different tables recognise it.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a hash")]
    pub const fn fingerprint(&self) -> u32 {
        let mut hash = 0x811C_9DC5;
        let mut left = self.rows;
        while let [row, rest @ ..] = left {
            hash = mix(hash, row.id.key());
            hash = mix(hash, (row.data_type.len() as u32) << 16 | access_word(row));
            hash = mix(hash, (row.storage as u32) << 8 | row.owner as u32);
            hash = match row.default() {
                Default::Number(value) => mix(hash, value),
                Default::NodeIdPlus(base) => mix(mix(hash, base), 1),
                Default::Text(text) => mix(hash, text.len() as u32),
            };
            let limits = row.limits();
            hash = mix(mix(hash, limits.min as u32), limits.max as u32);
            left = rest;
        }
        hash
    }
}

/// How far behind the first entry of its object an entry lies whose sub-index does not say it,
/// since others are left out before it.
#[cold]
fn search(object: &[Row], id: ObjectId) -> Result<usize, Missing> {
    let mut entries = object.iter().take_while(|row| row.id.index == id.index);
    match entries.clone().next() {
        Some(_) => entries.position(|row| row.id.sub == id.sub).ok_or(Missing::SubIndex),
        None => Err(Missing::Object),
    }
}

const fn access_word(row: &Row) -> u32 {
    (row.write_state as u32) << 8 | row.access as u32
}

/// A value that may be written but is not stored answers with a state of the device, which may
/// differ from what commands it: a drive at rest reads 0 and takes a direction.
const fn check(row: &Row) {
    let answers_with_state =
        matches!((row.access, row.storage), (Access::ReadWrite, Storage::Volatile));
    if matches!(row.access, Access::WriteOnly) || answers_with_state {
        return;
    }
    if matches!(row.access, Access::ReadOnly) {
        let in_some_state = matches!(row.write_state, WriteState::PreOperational);
        assert!(!in_some_state, "written, but read only");
    }
    if let Default::Number(value) = row.default() {
        let number = row.data_type.number(value);
        let limits = row.limits();
        let mut fits = limits.min <= number && number <= limits.max;
        let mut also = limits.also;
        while let [(first, last), rest @ ..] = also {
            fits = fits || *first <= number && number <= *last;
            also = rest;
        }
        assert!(fits, "a default outside its own limits");
    }
}

const fn mix(hash: u32, word: u32) -> u32 {
    let mut hash = hash;
    let mut shift = 0;
    while shift < 32 {
        hash = (hash ^ (word >> shift & 0xFF)).wrapping_mul(0x0100_0193);
        shift += 8;
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row;

    const FIRST: Object<u8> = Object::highest_sub_index(0x2000, "First", 2);
    const FIRST_ONE: Object<u32> = Object::new(0x2000, 1, "One").read_write().within(0, 1);
    const TEXT: Object<[u8; 4]> = Object::new(0x2007, 0, "Text").default_text("1.05");
    const LAST: Object<i16> = Object::new(0x6004, 0, "Last").within(-5, 5).default(-5);

    crate::product! { FIRST, FIRST_ONE, TEXT, LAST }

    #[test]
    fn names_stay_beside_the_rows() {
        assert_eq!((LEN, TEXTS.len()), (4, 4));
        assert_eq!(TEXTS.get(2).map(|text| text.name), Some("Text"));
        assert_eq!(FINGERPRINT, DICTIONARY.fingerprint());
    }

    #[test]
    fn missing_index_and_missing_sub_index_are_told_apart() {
        for (index, sub, expected) in [
            (0x1000, 0, Err(Missing::Object)),
            (0x2000, 0, Ok(0)),
            (0x2000, 1, Ok(1)),
            (0x2000, 2, Err(Missing::SubIndex)),
            (0x2001, 0, Err(Missing::Object)),
            (0x2007, 1, Err(Missing::SubIndex)),
            (0x6004, 0, Ok(3)),
            (0x6004, 255, Err(Missing::SubIndex)),
            (0x6005, 0, Err(Missing::Object)),
            (0xFFFF, 255, Err(Missing::Object)),
        ] {
            let found = DICTIONARY.find(ObjectId { index, sub }).map(Slot::position);
            assert_eq!(found, expected, "{index:#06x}:{sub}");
        }
        assert_eq!(DICTIONARY.slot(&LAST).position(), 3);
    }

    #[test]
    fn a_command_may_answer_with_what_can_not_be_written() {
        const JOG_COMMAND: Object<u8> = Object::new(0x204D, 3, "Jog").read_write().within(11, 13);
        static JOG: Row = row!(JOG_COMMAND);
        assert_eq!((JOG.initial(1), JOG.permits(0), JOG.permits(11)), (0, false, true));
        assert_eq!(Dictionary::new(core::slice::from_ref(&JOG)).rows().len(), 1);
    }

    #[test]
    fn the_fingerprint_follows_every_field() {
        static ROWS: [Row; 9] = [
            row!(FIRST_ONE.written_in_pre_operational()),
            row!(FIRST_ONE),
            row!(Object::<u32>::new(0x2001, 1, "").read_write().within(0, 1)),
            row!(Object::<u16>::new(0x2000, 1, "").read_write().within(0, 1)),
            row!(Object::<u32>::new(0x2000, 1, "").within(0, 1)),
            row!(FIRST_ONE.stored_at_once()),
            row!(FIRST_ONE.held_by_interface()),
            row!(FIRST_ONE.default(1)),
            row!(FIRST_ONE.within(0, 2)),
        ];
        let alone = |row: &'static Row| Dictionary::new(core::slice::from_ref(row)).fingerprint();
        let variants = ROWS.each_ref().map(alone);
        for (n, a) in variants.iter().enumerate() {
            for b in variants.iter().skip(n + 1) {
                assert_ne!(a, b);
            }
        }
    }
}
