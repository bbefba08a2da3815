use crate::object::{Object, Value};
use crate::row::{Access, Default, Kind, Line, ObjectId, Row, Storage, WriteState};

/// The rows of a product in ascending order.
#[derive(Debug)]
pub struct Dictionary {
    lines: &'static [Line],
    kinds: &'static [Kind],
    /// The first row of each index, at the hash of the index.
    firsts: &'static [u16],
    multiplier: u32,
}

/// The rows of a product in ascending order, and the kinds they are of, each once.
#[derive(Debug)]
pub struct Table<const LEN: usize, const KINDS: usize> {
    lines: [Line; LEN],
    kinds: [Kind; KINDS],
}

/// Where the rows of each index begin: a hash table without collisions.
#[derive(Debug)]
pub struct Places<const LEN: usize> {
    firsts: [u16; LEN],
    multiplier: u32,
}

/// There is no object at this place.
const VACANT: u16 = u16::MAX;

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
        (usize::from(position) < dictionary.lines.len()).then_some(Self(position))
    }

    /// Position of the row, counted from 0.
    #[must_use]
    pub const fn position(self) -> u16 {
        self.0
    }
}

impl Dictionary {
    /// A dictionary of these rows; [`dictionary!`](crate::dictionary) makes table and places.
    #[must_use]
    pub const fn new<const LEN: usize, const KINDS: usize, const PLACES: usize>(
        table: &'static Table<LEN, KINDS>,
        places: &'static Places<PLACES>,
    ) -> Self {
        let (lines, kinds) = (&table.lines, &table.kinds);
        Self { lines, kinds, firsts: &places.firsts, multiplier: places.multiplier }
    }

    /// All rows, in ascending order.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = Row> + use<> {
        let kinds = self.kinds;
        self.lines.iter().map(move |line| Row::of(line, kinds))
    }

    /// The place of an entry.
    ///
    /// # Errors
    /// Says whether index or sub-index is missing.
    pub fn find(&self, id: ObjectId) -> Result<Slot, Missing> {
        let place = hash(id.index, self.multiplier, self.firsts.len());
        let first = self.firsts.get(place).copied().unwrap_or(VACANT);
        match self.lines.get(usize::from(first)) {
            Some(line) if line.index == id.index => {}
            Some(_) | None => return Err(Missing::Object),
        }
        // It lies before the place that its sub-index says by as many as are left out before it.
        let mut ahead = id.sub;
        loop {
            let slot = Slot(first + u16::from(ahead));
            let line = self.lines.get(usize::from(slot.0));
            if line.is_some_and(|line| (line.index, line.sub) == (id.index, id.sub)) {
                return Ok(slot);
            }
            ahead = ahead.checked_sub(1).ok_or(Missing::SubIndex)?;
        }
    }

    /// The place of an object that is known to be in this dictionary. For constants: panics when
    /// it is not there, which then does not compile.
    #[must_use]
    pub const fn slot<T: Value>(&self, object: &Object<T>) -> Slot {
        let mut slot = Slot(0);
        let ObjectId { index, sub } = object.id();
        let mut left = self.lines;
        while let [line, rest @ ..] = left {
            if line.index == index && line.sub == sub {
                return slot;
            }
            slot.0 += 1;
            left = rest;
        }
        panic!("the product does not have this object")
    }

    /// The row at a slot of this dictionary. `None` for a slot of a longer one.
    #[must_use]
    pub fn row(&self, slot: Slot) -> Option<Row> {
        self.lines.get(usize::from(slot.0)).map(|line| Row::of(line, self.kinds))
    }

    /// All slots, in ascending order of their objects.
    pub fn slots(&self) -> impl Iterator<Item = (Slot, Row)> + use<> {
        (0..VACANT).map(Slot).zip(self.rows())
    }
}

/// How many kinds of rows these are.
#[must_use]
#[expect(clippy::indexing_slicing, reason = "in a constant")]
pub const fn kinds_len(rows: &[Row]) -> usize {
    let mut kinds = [*rows[0].kind; KINDS_MAX];
    let mut count = 0;
    let mut left = rows;
    while let [row, rest @ ..] = left {
        if place_of(row.kind, kinds.split_at(count).0) == count {
            assert!(count < KINDS_MAX, "too many kinds of rows");
            kinds[count] = *row.kind;
            count += 1;
        }
        left = rest;
    }
    count
}

impl<const LEN: usize, const KINDS: usize> Table<LEN, KINDS> {
    /// The table of these `LEN` rows; `KINDS` is their [`kinds_len`]. Panics, at compile time, when
    /// the rows are out of order, doubled, of more than 256 kinds, or have a stored or constant
    /// default outside their limits.
    #[must_use]
    #[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "in a constant")]
    pub const fn of(rows: &[Row]) -> Self {
        assert!(rows.len() == LEN && LEN < VACANT as usize, "another number of rows");
        assert!(KINDS <= KINDS_MAX, "too many kinds of rows");
        let mut lines = [*rows[0].line; LEN];
        let mut kinds = [*rows[0].kind; KINDS];
        let mut count = 0;
        let mut at = 0;
        while at < LEN {
            let row = rows[at];
            check(row);
            if at > 0 {
                let ascends = rows[at - 1].id().key() < row.id().key();
                assert!(ascends, "rows are not in ascending order");
            }
            let kind = place_of(row.kind, kinds.split_at(count).0);
            if kind == count {
                kinds[count] = *row.kind;
                count += 1;
            }
            lines[at] = Line { kind: kind as u8, ..*row.line };
            at += 1;
        }
        assert!(count == KINDS, "another number of kinds");
        Self { lines, kinds }
    }
}

/// A line has a byte for its kind.
const KINDS_MAX: usize = 256;

/// The place of a kind among others; their number where it is new.
#[expect(clippy::indexing_slicing, reason = "in a constant")]
const fn place_of(kind: &Kind, kinds: &[Kind]) -> usize {
    let mut at = 0;
    while at < kinds.len() && !kinds[at].is(kind) {
        at += 1;
    }
    at
}

/// A number that sets two dictionaries apart when any index, type, access, default or limit
/// differs (FNV-1a). Two controllers built from different tables recognise it.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a hash")]
pub const fn fingerprint(rows: &[Row]) -> u32 {
    let mut hash = 0x811C_9DC5;
    let mut left = rows;
    while let [row, rest @ ..] = left {
        hash = mix(hash, row.id().key());
        hash = mix(hash, (row.data_type().len() as u32) << 16 | access_word(*row));
        hash = mix(hash, (row.storage() as u32) << 8 | row.owner() as u32);
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

/// How many places these rows take.
#[must_use]
pub const fn places_len(rows: &[Row]) -> usize {
    let (len, _) = spread(rows);
    len
}

impl<const LEN: usize> Places<LEN> {
    /// The places of these rows. `LEN` is their [`places_len`].
    #[must_use]
    #[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "in a constant")]
    pub const fn of(rows: &[Row]) -> Self {
        let (len, multiplier) = spread(rows);
        assert!(len == LEN, "another number of places");
        let mut firsts = [VACANT; LEN];
        let mut at = rows.len();
        while at > 0 {
            at -= 1;
            firsts[hash(rows[at].line.index, multiplier, LEN)] = at as u16;
        }
        Self { firsts, multiplier }
    }
}

/// Objects of the largest product at most.
const OBJECTS_MAX: usize = 256;
/// Places that these may take.
const PLACES_MAX: usize = 1 << 12;
/// Multipliers to try before the number of places is doubled.
const TRIES: u32 = 400;

/// The smallest number of places, a power of two, and a multiplier with which every index has one of
/// its own.
#[expect(clippy::indexing_slicing, reason = "in a constant")]
const fn spread(rows: &[Row]) -> (usize, u32) {
    let mut indices = [0; OBJECTS_MAX];
    let mut count = 0;
    let mut at = 0;
    while at < rows.len() {
        if at == 0 || rows[at - 1].line.index != rows[at].line.index {
            indices[count] = rows[at].line.index;
            count += 1;
        }
        at += 1;
    }
    let (indices, _) = indices.split_at(count);
    let mut taken_in = [0; PLACES_MAX];
    let mut len = count.next_power_of_two();
    let mut attempt = 1;
    loop {
        let multiplier = (attempt * 2 + 1_u32).wrapping_mul(0x9E37_79B1);
        let mut at = 0;
        while at < count {
            let place = hash(indices[at], multiplier, len);
            if taken_in[place] == attempt {
                break;
            }
            taken_in[place] = attempt;
            at += 1;
        }
        if at == count {
            return (len, multiplier);
        }
        if attempt % TRIES == 0 {
            len *= 2;
        }
        attempt += 1;
    }
}

/// One of `len` places, a power of two.
const fn hash(index: u16, multiplier: u32, len: usize) -> usize {
    (index as u32).wrapping_mul(multiplier) as usize >> 16 & (len - 1)
}

const fn access_word(row: Row) -> u32 {
    (row.write_state() as u32) << 8 | row.access() as u32
}

/// A value that may be written but is not stored answers with a state of the device, which may
/// differ from what commands it: a drive at rest reads 0 and takes a direction.
const fn check(row: Row) {
    let answers_with_state =
        matches!((row.access(), row.storage()), (Access::ReadWrite, Storage::Volatile));
    if matches!(row.access(), Access::WriteOnly) || answers_with_state {
        return;
    }
    if matches!(row.access(), Access::ReadOnly) {
        let in_some_state = matches!(row.write_state(), WriteState::PreOperational);
        assert!(!in_some_state, "written, but read only");
    }
    if let Default::Number(value) = row.default() {
        let number = row.data_type().number(value);
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
    use crate::row::Particulars;

    const FIRST: Object<u8> = Object::highest_sub_index(0x2000, "First", 2);
    const FIRST_ONE: Object<u32> = Object::new(0x2000, 1, "One").read_write().within(0, 1);
    const TEXT: Object<[u8; 4]> = Object::new(0x2007, 0, "Text").default_text("1.05");
    const LAST: Object<i16> = Object::new(0x6004, 0, "Last").within(-5, 5).default(-5);

    crate::product! { FIRST, FIRST_ONE, TEXT, LAST }

    #[test]
    fn names_stay_beside_the_rows() {
        assert_eq!((LEN, TEXTS.len()), (4, 4));
        assert_eq!(TEXTS.get(2).map(|text| text.name), Some("Text"));
        assert_eq!(FINGERPRINT, fingerprint(ROWS));
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
    fn whatever_is_looked_for_is_found_where_it_is() {
        // The first rows are enough for an interpreter.
        let indices = if cfg!(miri) { 0x1FFF..=0x2008 } else { 0..=u16::MAX };
        for index in indices {
            for sub in [0, 1, 2, 255] {
                let id = ObjectId { index, sub };
                let position = DICTIONARY.slots().find(|(_, row)| row.id() == id);
                let known = DICTIONARY.rows().any(|row| row.id().index == index);
                let missing = if known { Missing::SubIndex } else { Missing::Object };
                let expected = position.map(|(slot, _)| slot).ok_or(missing);
                assert_eq!(DICTIONARY.find(id), expected, "{id:?}");
            }
        }
    }

    #[test]
    fn rows_share_kinds_and_keep_what_they_are() {
        const ROWS: &[Row] = &[
            row!(FIRST_ONE),
            row!(Object::<u32>::new(0x2001, 1, "").read_write().within(0, 1).default(1)),
            row!(Object::<u32>::new(0x2002, 1, "").read_write().within(0, 2)),
            row!(Object::<u32>::new(0x2003, 1, "").read_write().default(1)),
            row!(Object::<u32>::new(0x2004, 1, "").read_write().default_node_id_plus(1)),
            row!(Object::<i32>::new(0x2005, 1, "").read_write().default(1)),
            row!(Object::<u32>::new(0x2006, 1, "").read_write().within(0, 1).or_within(&[(5, 6)])),
            row!(TEXT),
            row!(Object::<[u8; 4]>::new(0x2008, 0, "Other text").default_text("1.06")),
        ];
        static DICTIONARY: Dictionary = crate::dictionary!(ROWS);
        assert_eq!(kinds_len(ROWS), 8);
        for (row, stays) in DICTIONARY.rows().zip(ROWS) {
            assert_eq!((row.id(), row.kind), (stays.id(), stays.kind));
            assert_eq!(row.default(), stays.default());
        }
    }

    /// One kind more than a line can name.
    const MANY: usize = KINDS_MAX + 1;

    /// Each has limits of its own.
    const fn object_of_many(n: u16) -> Object<u16> {
        Object::new(0x2000 + n / 16, (n % 16) as u8, "").within(0, n as i64)
    }

    macro_rules! many {
        ($n:ident => $value:expr) => {{
            let $n = 0_u16;
            let mut all = [$value; MANY];
            let mut $n = 1_u16;
            while ($n as usize) < MANY {
                all[$n as usize] = $value;
                $n += 1;
            }
            all
        }};
    }

    static PARTICULARS: [Particulars; MANY] = many!(n => object_of_many(n).particulars());
    static KINDS: [Kind; MANY] = many!(n => object_of_many(n).kind(&PARTICULARS[n as usize]));
    static LINES: [Line; MANY] = many!(n => object_of_many(n).line());
    static MANY_ROWS: [Row; MANY] = many!(n => Row::new(&LINES[n as usize], &KINDS[n as usize]));

    #[test]
    fn a_line_names_one_of_256_kinds() {
        const MOST: &[Row] = MANY_ROWS.split_at(KINDS_MAX).0;
        static DICTIONARY: Dictionary = crate::dictionary!(MOST);
        assert_eq!(kinds_len(MOST), 256);
        for (n, row) in (0..).zip(DICTIONARY.rows()) {
            assert_eq!((row.id(), row.limits().max), (object_of_many(n).id(), n.into()));
        }
    }

    /// Where a dictionary is made, this is an error of the compiler.
    #[test]
    #[should_panic(expected = "too many kinds of rows")]
    fn rows_of_257_kinds_are_not_counted() {
        let _ = kinds_len(&MANY_ROWS);
    }

    #[test]
    #[should_panic(expected = "too many kinds of rows")]
    fn rows_of_257_kinds_make_no_table() {
        let _ = Table::<MANY, MANY>::of(&MANY_ROWS);
    }

    #[test]
    fn a_command_may_answer_with_what_can_not_be_written() {
        const JOG_COMMAND: Object<u8> = Object::new(0x204D, 3, "Jog").read_write().within(11, 13);
        const JOG: Row = row!(JOG_COMMAND);
        static DICTIONARY: Dictionary = crate::dictionary!(&[JOG]);
        assert_eq!((JOG.initial(1), JOG.permits(0), JOG.permits(11)), (0, false, true));
        assert_eq!(DICTIONARY.rows().len(), 1);
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
        let alone = |row: &'static Row| fingerprint(core::slice::from_ref(row));
        let variants = ROWS.each_ref().map(alone);
        for (n, a) in variants.iter().enumerate() {
            for b in variants.iter().skip(n + 1) {
                assert_ne!(a, b);
            }
        }
    }
}
