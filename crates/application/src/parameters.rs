//! The values of the objects, and which of them the storage and the other controller do not have
//! yet.

use core::ops::Range;

use heapless::Vec;
use object_dictionary::{
    Access, Dictionary, Number, Object, ObjectId, Owner, Row, Slot, Storage, Values,
};
use profiles::OBJECTS_MAX;
use shared_proto::limits::SNAPSHOT_VALUES_MAX;

/// Values of consecutive rows, for the link.
pub(crate) type Run = Vec<u32, SNAPSHOT_VALUES_MAX>;

/// All values of a product. Those of the other controller stay at their defaults.
#[derive(Debug)]
pub(crate) struct Parameters {
    values: Values<OBJECTS_MAX>,
    unstored: Marks,
    untold: Marks,
}

/// Why a write from outside is not executed. The CAN interface controller checks the same rows
/// before it answers a master, so on a healthy device none of these happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rejected {
    /// The dictionary has no such entry.
    Missing,
    /// The value belongs to the other controller.
    ForeignOwner,
    /// The entry cannot be written.
    ReadOnly,
    /// The value lies outside the limits.
    OutOfRange,
}

impl Parameters {
    /// The defaults.
    pub(crate) fn new(dictionary: &'static Dictionary) -> Self {
        // The node-ID only matters for rows of the other controller.
        const NO_NODE_ID: u8 = 0;
        Self {
            values: Values::new(dictionary, NO_NODE_ID),
            unstored: Marks::default(),
            untold: Marks::default(),
        }
    }

    /// Takes over a stored value. One that this firmware would not have stored is left out: the
    /// parameter keeps its default.
    pub(crate) fn restore(&mut self, key: u32, raw: u32) {
        let Some(id) = id_of(key) else { return };
        let Ok((slot, row)) = self.find(id) else { return };
        if stores(row) && row.permits(raw) {
            self.values.set_raw(slot, raw);
        }
    }

    /// The value of `object`.
    pub(crate) fn get<T: Number>(&self, object: &Object<T>) -> T {
        self.values.get(object)
    }

    /// Whether a master may write `raw` to an entry.
    pub(crate) fn check(&self, id: ObjectId, raw: u32) -> Result<(), Rejected> {
        let (_, row) = self.find(id)?;
        match row.access() {
            Access::ReadOnly => Err(Rejected::ReadOnly),
            Access::ReadWrite | Access::WriteOnly => {
                if row.permits(raw) {
                    Ok(())
                } else {
                    Err(Rejected::OutOfRange)
                }
            }
        }
    }

    /// Takes over a value that comes from outside and passed [`Self::check`].
    pub(crate) fn write(&mut self, id: ObjectId, raw: u32) {
        if let Ok((slot, row)) = self.find(id) {
            self.take_over(slot, row, raw);
        }
    }

    /// Takes over a value that the application gives itself, and tells the other controller.
    pub(crate) fn change<T: Number>(&mut self, object: &Object<T>, value: T) {
        if let Ok((slot, row)) = self.find(object.id()) {
            self.change_raw(slot, row, value.to_raw());
        }
    }

    /// Sets every stored parameter to its default, apart from those listed.
    pub(crate) fn restore_defaults(&mut self, kept: &[ObjectId]) {
        const NO_NODE_ID: u8 = 0;
        for (slot, row) in self.values.dictionary().slots() {
            if stores(row) && !kept.contains(&row.id()) {
                self.change_raw(slot, row, row.initial(NO_NODE_ID));
            }
        }
    }

    /// Tells the other controller the value of an entry, because its copy may be another.
    pub(crate) fn tell(&mut self, id: ObjectId) {
        if let Ok((slot, _)) = self.find(id) {
            self.untold.set(slot);
        }
    }

    /// The next value to store, with its key.
    pub(crate) fn poll_store(&mut self) -> Option<(u32, u32)> {
        let slot = self.unstored.take_first(self.values.dictionary())?;
        let row = self.values.dictionary().row(slot)?;
        Some((row.id().key(), self.values.raw(slot)))
    }

    /// The next values to tell: the position of the first row and the values from there.
    pub(crate) fn poll_tell(&mut self) -> Option<(u16, Run)> {
        let dictionary = self.values.dictionary();
        let first = self.untold.take_first(dictionary)?;
        let mut run = Run::new();
        let mut next = Some(first);
        while let Some(slot) = next
            && run.push(self.values.raw(slot)).is_ok()
        {
            next = Slot::at(dictionary, slot.position() + 1)
                .filter(|_| !run.is_full())
                .filter(|slot| self.untold.take(*slot));
        }
        Some((first.position(), run))
    }

    /// The values from a position of the dictionary on, as many as one message holds. Empty behind
    /// its end.
    pub(crate) fn run(&self, from: u16) -> Run {
        (from..=u16::MAX)
            .map_while(|position| Slot::at(self.values.dictionary(), position))
            .map(|slot| self.values.raw(slot))
            .take(SNAPSHOT_VALUES_MAX)
            .collect()
    }

    /// From the first row of this controller to the end of the dictionary.
    pub(crate) fn own_rows(&self) -> Range<u16> {
        let mut rows = self.values.dictionary().rows();
        let end = rows.len();
        let first = rows.position(|row| row.owner() == Owner::Application);
        position(first.unwrap_or(end))..position(end)
    }

    fn find(&self, id: ObjectId) -> Result<(Slot, Row), Rejected> {
        let dictionary = self.values.dictionary();
        let slot = dictionary.find(id).map_err(|_| Rejected::Missing)?;
        let row = dictionary.row(slot).ok_or(Rejected::Missing)?;
        match row.owner() {
            Owner::Application => Ok((slot, row)),
            Owner::Interface => Err(Rejected::ForeignOwner),
        }
    }

    fn change_raw(&mut self, slot: Slot, row: Row, raw: u32) {
        if self.values.raw(slot) != raw {
            self.take_over(slot, row, raw);
            self.untold.set(slot);
        }
    }

    /// Equal values are not stored again (NM17x STORE-10, A-44).
    fn take_over(&mut self, slot: Slot, row: Row, raw: u32) {
        if self.values.raw(slot) != raw && stores(row) {
            self.unstored.set(slot);
        }
        self.values.set_raw(slot, raw);
    }
}

/// Whether this controller stores the value of a row.
fn stores(row: Row) -> bool {
    match (row.storage(), row.owner()) {
        (Storage::AtOnce, Owner::Application) => true,
        (Storage::Volatile | Storage::OnCommand, Owner::Application)
        | (Storage::Volatile | Storage::OnCommand | Storage::AtOnce, Owner::Interface) => false,
    }
}

/// A dictionary has fewer rows than 16 bits can count.
fn position(row: usize) -> u16 {
    u16::try_from(row).unwrap_or(u16::MAX)
}

/// The entry whose [`ObjectId::key`] this is.
fn id_of(key: u32) -> Option<ObjectId> {
    let [sub, low, high, rest] = key.to_le_bytes();
    (rest == 0).then_some(ObjectId { index: u16::from_le_bytes([low, high]), sub })
}

/// A set of slots.
#[derive(Debug)]
struct Marks([bool; OBJECTS_MAX]);

impl Default for Marks {
    fn default() -> Self {
        Self([false; OBJECTS_MAX])
    }
}

impl Marks {
    fn set(&mut self, slot: Slot) {
        if let Some(mark) = self.0.get_mut(usize::from(slot.position())) {
            *mark = true;
        }
    }

    /// Removes a slot and says whether it was in the set.
    fn take(&mut self, slot: Slot) -> bool {
        self.0.get_mut(usize::from(slot.position())).is_some_and(core::mem::take)
    }

    fn take_first(&mut self, dictionary: &Dictionary) -> Option<Slot> {
        let first = self.0.iter().position(|mark| *mark)?;
        let slot = Slot::at(dictionary, u16::try_from(first).ok()?)?;
        self.take(slot).then_some(slot)
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use profiles::{nm17x, nm172};

    use super::*;

    fn id(index: u16, sub: u8) -> ObjectId {
        ObjectId { index, sub }
    }

    fn to_store(parameters: &mut Parameters) -> Vec<(u32, u32)> {
        core::iter::from_fn(|| parameters.poll_store()).collect()
    }

    #[test]
    fn a_write_is_checked_like_that_of_a_master() {
        let parameters = Parameters::new(&nm172::DICTIONARY);
        for (index, sub, value, expected) in [
            (0x2002, 0, 9_999, Ok(())),
            (0x2002, 0, 10_000, Err(Rejected::OutOfRange)),
            (0x2010, 0, 0xFFFE_795F, Err(Rejected::OutOfRange)),
            (0x2010, 0, 0xFFFE_7961, Ok(())),
            (0x2015, 0, 6, Ok(())),
            (0x2015, 0, 0, Err(Rejected::OutOfRange)),
            (0x6004, 0, 0, Err(Rejected::ReadOnly)),
            (0x2000, 0, 8, Err(Rejected::ReadOnly)),
            (0x2000, 9, 0, Err(Rejected::Missing)),
            (0x7000, 0, 0, Err(Rejected::Missing)),
            (0x1017, 0, 0, Err(Rejected::ForeignOwner)),
            (0x2101, 0, 5, Err(Rejected::ForeignOwner)),
        ] {
            assert_eq!(parameters.check(id(index, sub), value), expected, "{index:#x}:{sub}");
        }
    }

    /// NM17x STORE-02, STORE-10: stored right after a change, and only then.
    #[test]
    fn a_value_is_stored_once_and_only_when_it_changed() {
        let mut parameters = Parameters::new(&nm172::DICTIONARY);
        parameters.write(id(0x2002, 0), 100);
        assert_eq!(to_store(&mut parameters), []);
        parameters.write(id(0x2002, 0), 200);
        parameters.write(id(0x2002, 0), 300);
        parameters.write(id(0x2000, 1), 1);
        assert_eq!(to_store(&mut parameters), [(0x20_0001, 1), (0x20_0200, 300)]);
        assert_eq!(to_store(&mut parameters), []);
    }

    #[test]
    fn stored_values_that_are_not_permitted_are_left_out() {
        for (key, value, expected) in [
            (0x20_0200, 250, 250),
            (0x20_0200, 10_000, 100),
            (0x0120_0200, 250, 100),
            (0x20_0201, 250, 100),
        ] {
            let mut parameters = Parameters::new(&nm172::DICTIONARY);
            parameters.restore(key, value);
            assert_eq!(parameters.get(&nm17x::LOOP_LENGTH), expected, "{key:#x} {value}");
            assert_eq!(to_store(&mut parameters), []);
        }
        let mut parameters = Parameters::new(&nm172::DICTIONARY);
        parameters.restore(0x60_0400, 5);
        parameters.restore(0x21_0100, 5);
        assert_eq!(parameters.get(&nm17x::POSITION_VALUE), 0);
        assert_eq!(parameters.get(&nm17x::NODE_ID), 127);
    }

    #[test]
    fn what_changes_by_itself_is_told() {
        let mut parameters = Parameters::new(&nm172::DICTIONARY);
        for (index, sub, value) in [(0x2000, 1, 1), (0x2000, 2, 1), (0x2000, 5, 1), (0x2010, 0, 7)]
        {
            parameters.write(id(index, sub), value);
        }
        assert_eq!(parameters.poll_tell(), None);
        parameters.restore_defaults(&[id(0x2010, 0)]);
        let direction = nm172::DICTIONARY.slot(&nm17x::POSITIONING_DIRECTION).position();
        let told: Vec<_> = core::iter::from_fn(|| parameters.poll_tell()).collect();
        assert_eq!(
            told,
            [
                (direction, Run::from_slice(&[0, 0]).unwrap()),
                (direction + 4, Run::from_slice(&[0]).unwrap())
            ]
        );
        assert_eq!(parameters.get(&nm17x::CORRECTION), 7);
    }

    #[test]
    fn runs_cover_the_dictionary_and_end_with_it() {
        let parameters = Parameters::new(&nm172::DICTIONARY);
        let mut from = 0;
        while !parameters.run(from).is_empty() {
            from += u16::try_from(parameters.run(from).len()).unwrap();
        }
        assert_eq!(usize::from(from), nm172::LEN);
        assert!(parameters.run(u16::MAX).is_empty());
    }
}
