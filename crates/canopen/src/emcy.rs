use crate::frame::{CanId, Frame};

/// The emergency message (CiA 301, section 7.2.7.1): what went wrong, the error register with it,
/// and five bytes of the maker's.
pub(crate) fn message(
    id: CanId,
    error_code: u16,
    error_register: u8,
    manufacturer: [u8; 5],
) -> Frame {
    let [low, high] = error_code.to_le_bytes();
    let [a, b, c, d, e] = manufacturer;
    Frame::full(id, [low, high, error_register, a, b, c, d, e])
}
