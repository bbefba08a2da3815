use object_dictionary::{ObjectId, Values};

/// The number at an object of the communication. `None` when the product does not have it.
#[inline(never)]
pub(crate) fn parameter<const LEN: usize>(
    values: &Values<LEN>,
    index: u16,
    sub: u8,
) -> Option<u32> {
    let slot = values.dictionary().find(ObjectId { index, sub }).ok()?;
    Some(values.raw(slot))
}

/// The number at an object of the communication; 0 when the product does not have it.
#[inline(never)]
pub(crate) fn number<const LEN: usize>(values: &Values<LEN>, index: u16, sub: u8) -> u32 {
    parameter(values, index, sub).unwrap_or(0)
}
