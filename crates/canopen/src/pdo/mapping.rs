use heapless::Vec;
use object_dictionary::{DataType, Dictionary, Slot, Values};

use super::entry::Entry;
use super::span::Span;
use crate::frame::DATA_MAX;
use crate::parameter::parameter;

/// Objects that one PDO may carry.
pub(super) const MAPPED_MAX: u8 = 8;

/// Bytes that one PDO may carry.
pub(super) const LEN_MAX: u8 = 8;
const _: () = assert!(LEN_MAX as usize == DATA_MAX);

/// The bytes of a PDO, followed by as many as the longest number has: four can be read or written
/// wherever a field begins.
pub(super) type Bytes = [u8; DATA_MAX + size_of::<u32>()];

/// What a PDO carries, looked up once (CiA 301, section 7.5.2.36).
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Mapping {
    fields: Vec<Field, { MAPPED_MAX as usize }, u8>,
    /// Where the slots of the fields lie.
    span: Span,
    len: u8,
    /// Whether an object takes fewer numbers than its type has.
    limited: bool,
}

/// Where the bytes of one object lie. Those of an object that the product does not have are zero
/// when sent and dropped when received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Field {
    slot: Slot,
    at: u8,
    width: Width,
}

/// How much of 32 bits a number is: the bits above it, and whether they repeat its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Width(u8);

/// The numbers that a receive PDO brings.
#[derive(Clone, Copy, Debug)]
pub struct Mapped<'a> {
    mapping: &'a Mapping,
    bytes: &'a Bytes,
}

impl Mapping {
    /// Reads the mapping object with this index, up to the first entry that does not fit.
    pub(super) fn read<const LEN: usize>(values: &Values<LEN>, index: u16) -> Self {
        let dictionary = values.dictionary();
        let value = |sub| parameter(values, index, sub);
        let mut mapping = Self::default();
        let count = value(0).unwrap_or(0).min(u32::from(MAPPED_MAX));
        for entry in (1..).zip(0..count).map_while(|(sub, _)| value(sub)).map(Entry::from_raw) {
            let at = mapping.len;
            let Some(len) = entry.byte_len().filter(|len| at + len <= LEN_MAX) else { break };
            mapping.len += len;
            let slot = dictionary.find(entry.object).unwrap_or(Slot::NOWHERE);
            let row = dictionary.row(slot);
            let width = Width::new(len, row.map(|row| row.data_type()));
            let _ = mapping.fields.push(Field { slot, at, width });
            if let Some(row) = row {
                mapping.span = mapping.span.join(Span::of(slot));
                mapping.limited |= !row.is_unlimited();
            }
        }
        mapping
    }

    /// Where the slots lie that it carries.
    pub(super) const fn span(&self) -> Span {
        self.span
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

    /// What a word has more than its field is overwritten by the next one.
    fn gather_bytes<const LEN: usize>(&self, values: &Values<LEN>) -> u64 {
        let mut bytes: Bytes = [0; _];
        for field in self.fields() {
            put(&mut bytes, field.at % LEN_MAX, values.raw(field.slot));
        }
        let data = u64::from_le_bytes(bytes.first_chunk().copied().unwrap_or_default());
        match self.len {
            LEN_MAX.. => data,
            len => data & !(u64::MAX << (8 * len)),
        }
    }

    /// Whether all numbers in `bytes` may be written.
    #[inline]
    pub(super) fn permits(&self, bytes: &Bytes, dictionary: &Dictionary) -> bool {
        !self.limited || self.rows_permit(bytes, dictionary)
    }

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

    /// Where the slots lie.
    pub(super) const fn span(&self) -> Span {
        self.mapping.span
    }

    /// The number for the object at `slot`. `None` when the PDO does not carry it.
    #[must_use]
    pub fn get(&self, slot: Slot) -> Option<u32> {
        self.iter().find_map(|(mapped, raw)| (mapped == slot).then_some(raw))
    }
}

impl Field {
    fn number(self, bytes: &Bytes) -> u32 {
        let word = bytes.get(usize::from(self.at % LEN_MAX)..).and_then(<[u8]>::first_chunk);
        self.width.number(word.map_or(0, |word| u32::from_le_bytes(*word)))
    }
}

impl Width {
    const SIGNED: u8 = 1 << 7;

    const fn new(len: u8, data_type: Option<DataType>) -> Self {
        let spare_bits = 32_u8.saturating_sub(8 * len);
        match data_type {
            Some(DataType::Integer8 | DataType::Integer16 | DataType::Integer32) => {
                Self(Self::SIGNED | spare_bits)
            }
            Some(
                DataType::Unsigned8
                | DataType::Unsigned16
                | DataType::Unsigned32
                | DataType::VisibleString(_),
            )
            | None => Self(spare_bits),
        }
    }

    const fn spare_bits(self) -> u32 {
        (self.0 % 32) as u32
    }

    /// The low bytes of `word` as a number.
    const fn number(self, word: u32) -> u32 {
        let shifted = word << self.spare_bits();
        if self.0 & Self::SIGNED == 0 {
            shifted >> self.spare_bits()
        } else {
            (shifted.cast_signed() >> self.spare_bits()).cast_unsigned()
        }
    }
}

fn put(bytes: &mut Bytes, at: u8, word: u32) {
    if let Some(place) = bytes.get_mut(usize::from(at)..).and_then(<[u8]>::first_chunk_mut) {
        *place = word.to_le_bytes();
    }
}
