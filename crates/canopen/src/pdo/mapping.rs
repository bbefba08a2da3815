use heapless::Vec;
use object_dictionary::{ObjectId, Slot, Values};

use crate::application::Mapped;
use crate::frame::{CanId, DATA_MAX, Frame};

/// Objects that one PDO may carry.
pub(super) const MAPPED_MAX: usize = 8;

const BITS_MAX: u32 = 64;
const _: () = assert!(BITS_MAX as usize == 8 * DATA_MAX);

/// What a PDO carries, looked up once (CiA 301, section 7.5.2.36).
#[derive(Debug, Default)]
pub(super) struct Mapping {
    fields: Vec<Field, MAPPED_MAX>,
    bits: u32,
}

/// Where the bits of one object lie. Without a slot they are zero when sent and dropped when
/// received: the product does not have the object.
#[derive(Clone, Copy, Debug)]
struct Field {
    slot: Option<Slot>,
    shift: u32,
    mask: u32,
}

impl Mapping {
    /// Reads the mapping object with this index. Entries that would exceed eight bytes, or
    /// [`MAPPED_MAX`], are left out.
    pub(super) fn read<const LEN: usize>(values: &Values<LEN>, index: u16) -> Self {
        let dictionary = values.dictionary();
        let entry = |sub| Some(values.raw(dictionary.find(ObjectId { index, sub }).ok()?));
        let mut mapping = Self::default();
        let [count, ..] = entry(0).unwrap_or(0).to_le_bytes();
        for mapped in (1..=count).map_while(entry) {
            let [bits, sub, index @ ..] = mapped.to_le_bytes();
            let bits = u32::from(bits).min(u32::BITS);
            let object = ObjectId { index: u16::from_le_bytes(index), sub };
            let field = Field {
                slot: dictionary.find(object).ok(),
                shift: mapping.bits,
                mask: u32::MAX.checked_shr(u32::BITS - bits).unwrap_or(0),
            };
            if mapping.bits + bits > BITS_MAX || mapping.fields.push(field).is_err() {
                break;
            }
            mapping.bits += bits;
        }
        mapping
    }

    pub(super) fn carries(&self, slot: Slot) -> bool {
        self.fields.iter().any(|field| field.slot == Some(slot))
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.bits == 0
    }

    /// The frame with the present values, the first object in the lowest bits.
    pub(super) fn frame<const LEN: usize>(&self, id: CanId, values: &Values<LEN>) -> Frame {
        let data = self.fields.iter().fold(0_u64, |data, field| {
            let raw = field.slot.map_or(0, |slot| values.raw(slot));
            data | u64::from(raw & field.mask) << field.shift
        });
        Frame::prefix(id, data.to_le_bytes(), self.byte_len())
    }

    /// Length of the data, 0 to 8 bytes.
    pub(super) const fn byte_len(&self) -> u8 {
        let [len, ..] = self.bits.div_ceil(8).to_le_bytes();
        len
    }

    /// The numbers that the objects would have. `None` when one of them is not permitted.
    pub(super) fn unpack<const LEN: usize>(
        &self,
        bytes: [u8; 8],
        values: &Values<LEN>,
    ) -> Option<Vec<Mapped, MAPPED_MAX>> {
        let data = u64::from_le_bytes(bytes);
        let mut unpacked = Vec::new();
        for field in &self.fields {
            let found = field.slot.and_then(|slot| Some((slot, values.dictionary().row(slot)?)));
            let Some((slot, row)) = found else { continue };
            let [a, b, c, d, ..] = (data >> field.shift).to_le_bytes();
            let raw = row.data_type.widen(u32::from_le_bytes([a, b, c, d]) & field.mask);
            if !row.permits(raw) {
                return None;
            }
            unpacked.push(Mapped { slot, row, raw }).ok()?;
        }
        Some(unpacked)
    }
}
