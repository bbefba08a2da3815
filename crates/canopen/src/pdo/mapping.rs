use heapless::Vec;
use object_dictionary::{Dictionary, Slot, Values};

use super::entry::Entry;
use super::field::Field;
use super::slots::Slots;
use crate::cob_id::CobId;
use crate::frame::{CanId, DATA_MAX};
use crate::parameter::{number, parameter};
use crate::sdo::AbortCode;

/// Objects that one PDO may carry.
const MAPPED_MAX: u8 = 8;

/// Bytes that one PDO may carry.
pub(super) const LEN_MAX: u8 = 8;
const _: () = assert!(LEN_MAX as usize == DATA_MAX);

/// The bytes of a PDO, followed by as many as the longest number has: four can be read or written
/// wherever a field begins.
pub(super) type Bytes = [u8; DATA_MAX + size_of::<u32>()];

/// What a PDO carries, looked up once (CiA 301, section 7.5.2.36).
#[derive(Debug, Default)]
pub(super) struct Mapping {
    fields: Vec<Field, { MAPPED_MAX as usize }, u8>,
    slots: Slots,
    len: u8,
    /// Whether an object takes fewer numbers than its type has.
    limited: bool,
}

/// The numbers that a receive PDO brings.
#[derive(Clone, Copy, Debug)]
pub struct Mapped<'a> {
    mapping: &'a Mapping,
    bytes: &'a Bytes,
}

impl Mapping {
    /// Takes the mapping object with this index over. A product's own need not be one that a master
    /// could write: it may share its PDOs with a product that has more objects.
    pub(super) fn reread<const LEN: usize>(&mut self, values: &Values<LEN>, index: u16) {
        let count = number(values, index, 0);
        let _ = self.read(values, index, count);
    }

    /// Takes the first `count` entries of the mapping object with this index, as far as they are
    /// whole bytes and have room. Whether a master may have them mapped.
    pub(super) fn read<const LEN: usize>(
        &mut self,
        values: &Values<LEN>,
        index: u16,
        count: u32,
    ) -> Result<(), AbortCode> {
        *self = Self::default();
        if count > u32::from(MAPPED_MAX) {
            return Err(AbortCode::MAPPING_LENGTH);
        }
        let dictionary = values.dictionary();
        let (mut end, mut verdict) = (0, Ok(()));
        for (sub, _) in (1..).zip(0..count) {
            let Some(entry) = parameter(values, index, sub).map(Entry::from_raw) else {
                return verdict.and(Err(AbortCode::MAPPING_LENGTH));
            };
            let (slot, row) = entry.find(dictionary);
            verdict = verdict.and(entry.check(row, index));
            let Some(len) = entry.byte_len() else { return verdict };
            let field = Field::new(entry, end, slot, row);
            end += len;
            if end <= LEN_MAX && self.fields.push(field).is_ok() {
                self.len = end;
                self.slots = self.slots.join(Slots::of(slot));
                self.limited |= row.is_some_and(|row| !row.is_unlimited());
            }
        }
        verdict.and(if end <= LEN_MAX { Ok(()) } else { Err(AbortCode::MAPPING_LENGTH) })
    }

    /// The identifier of a PDO with this mapping: none when it is switched off or carries nothing.
    pub(super) fn id(&self, cob_id: CobId) -> CanId {
        cob_id.valid().filter(|_| self.len > 0).unwrap_or(CanId::NONE)
    }

    /// The slots that it carries.
    pub(super) const fn slots(&self) -> Slots {
        self.slots
    }

    /// The fields, with a bound that loops over them can be unrolled by.
    fn fields(&self) -> impl Iterator<Item = &Field> {
        self.fields.iter().take(MAPPED_MAX.into())
    }

    pub(super) fn carries(&self, slot: Slot) -> bool {
        self.fields.iter().any(|field| field.slot == slot)
    }

    /// Length of the data, 0 to 8 bytes.
    pub(super) const fn byte_len(&self) -> u8 {
        self.len
    }

    /// The present values, the first object in the lowest bytes, and zeros behind the last.
    #[inline(never)]
    pub(super) fn gather<const LEN: usize>(&self, values: &Values<LEN>) -> u64 {
        match *self.fields {
            // Two whole words need not be put together byte by byte.
            [low, high] if (high.at, self.len) == (4, 8) => {
                u64::from(values.raw(low.slot)) | u64::from(values.raw(high.slot)) << 32
            }
            _ => self.gather_bytes(values),
        }
    }

    /// What a word has more than its field is overwritten by what follows.
    fn gather_bytes<const LEN: usize>(&self, values: &Values<LEN>) -> u64 {
        let mut bytes: Bytes = [0; _];
        for field in self.fields() {
            put(&mut bytes, field.at % LEN_MAX, values.raw(field.slot));
        }
        put(&mut bytes, self.len, 0);
        u64::from_le_bytes(bytes.first_chunk().copied().unwrap_or_default())
    }

    /// Whether all numbers in `bytes` may be written.
    #[inline]
    pub(super) fn permits(&self, bytes: &Bytes, dictionary: &Dictionary) -> bool {
        !self.limited || self.rows_permit(bytes, dictionary)
    }

    #[inline(never)]
    fn rows_permit(&self, bytes: &Bytes, dictionary: &Dictionary) -> bool {
        let permitted = |(slot, raw)| dictionary.row(slot).is_none_or(|row| row.permits(raw));
        self.scatter(bytes).iter().all(permitted)
    }

    /// The numbers in `bytes`.
    pub(super) fn scatter<'a>(&'a self, bytes: &'a Bytes) -> Mapped<'a> {
        Mapped { mapping: self, bytes }
    }
}

impl Mapped<'_> {
    /// Each object with its number in 32 bits, in the order of the mapping.
    pub fn iter(&self) -> impl Iterator<Item = (Slot, u32)> {
        self.mapping.fields().map(|field| (field.slot, field.number(self.bytes)))
    }

    pub(super) const fn slots(&self) -> Slots {
        self.mapping.slots
    }

    /// The number for the object at `slot`. `None` when the PDO does not carry it.
    #[must_use]
    pub fn get(&self, slot: Slot) -> Option<u32> {
        self.iter().find_map(|(mapped, raw)| (mapped == slot).then_some(raw))
    }
}

fn put(bytes: &mut Bytes, at: u8, word: u32) {
    let at = usize::from(at);
    if let Some(place) = bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
        *place = word.to_le_bytes();
    }
}
