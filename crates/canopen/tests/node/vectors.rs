//! Telegrams that must come out byte for byte. Plain data and one function, so that a test binary
//! without the standard library can include it too; it needs the module `device` beside it.

use canopen::{CanId, Event, Frame};
use object_dictionary::ObjectId;
use units::Instant;

use crate::device::{DICTIONARY, Device, node};

/// One telegram and what it brings.
pub(crate) struct Vector {
    /// Its name in the requirements.
    pub(crate) name: &'static str,
    /// CAN-ID and data of the telegram.
    pub(crate) request: (u16, &'static [u8]),
    /// CAN-ID and data of the answer.
    pub(crate) response: (u16, &'static [u8]),
}

const fn sdo(name: &'static str, request: &'static [u8], response: &'static [u8]) -> Vector {
    Vector { name, request: (0x67F, request), response: (0x5FF, response) }
}

/// In order, on one node with node-ID 127 in Pre-operational whose position is 5000.00 mm.
#[rustfmt::skip]
pub(crate) const VECTORS: &[Vector] = &[
    // NM17x SDO-10: the examples of the manual, section 4.3.3.3.
    sdo("V-SDO-1", b"\x40\x04\x60\x00\xAA\x55\xAA\x55", b"\x43\x04\x60\x00\x20\xA1\x07\x00"),
    sdo("V-SDO-2", b"\x23\x03\x20\x00\x40\x01\x00\x00", b"\x60\x03\x20\x00\x00\x00\x00\x00"),
    sdo("V-SDO-3", b"\x40\x01\x21\x00\xAA\x55\xAA\x55", b"\x4F\x01\x21\x00\x7F\x00\x00\x00"),
    sdo("V-SDO-4", b"\x23\x00\x20\x05\x01\x00\x00\x00", b"\x60\x00\x20\x05\x00\x00\x00\x00"),
    sdo("V-SDO-5", b"\x23\x00\x20\x05\x02\x00\x00\x00", b"\x80\x00\x20\x05\x30\x00\x09\x06"),
    // NM17x SDO-02: 0x22 writes without saying how much.
    sdo("0x22", b"\x22\x03\x20\x00\x05\x00\x00\x00", b"\x60\x03\x20\x00\x00\x00\x00\x00"),
    sdo("0x22, a byte", b"\x22\x01\x21\x00\x05\x00\x00\x00", b"\x60\x01\x21\x00\x00\x00\x00\x00"),
    sdo("what it wrote", b"\x40\x01\x21\x00\x00\x00\x00\x00", b"\x4F\x01\x21\x00\x05\x00\x00\x00"),
    // NM17x SDO-06 and SDO-08.
    sdo("0x1009", b"\x40\x09\x10\x00\x00\x00\x00\x00", b"\x4B\x09\x10\x00\x2F\x41\x00\x00"),
    sdo("0x100A", b"\x40\x0A\x10\x00\x00\x00\x00\x00", b"\x43\x0A\x10\x00\x31\x2E\x30\x35"),
    sdo("D-03", b"\x23\x10\x10\x01\x00\x00\x00\x00", b"\x80\x10\x10\x01\x20\x00\x00\x08"),
    sdo("D-01", b"\x23\x10\x10\x01\x73\x61\x76\x65", b"\x60\x10\x10\x01\x00\x00\x00\x00"),
    sdo("D-14", b"\x40\x08\x20\x00\x00\x00\x00\x00", b"\x80\x08\x20\x00\x01\x00\x01\x06"),
];

/// The first vector that the node does not answer as it must.
pub(crate) fn first_failure() -> Option<&'static str> {
    let mut node = node();
    let mut device = Device::new();
    let now = Instant::ZERO;
    let position = ObjectId { index: 0x6004, sub: 0 };
    match DICTIONARY.find(position) {
        Ok(slot) => node.set_value(now, slot, 500_000),
        Err(_) => return Some("the position"),
    }
    node.boot(now);
    if node.take_transmit().is_none_or(|frame| frame.data() != [0]) {
        return Some("V-BOOTUP");
    }
    VECTORS.iter().find_map(
        |Vector { name, request: (id, data), response: (answer_id, answer) }| {
            let frame = Frame::new(CanId::new(*id)?, data)?;
            node.handle_frame(now, &frame, &mut device);
            while let Some(event) = node.poll_event() {
                if event == (Event::Store { sub: 1 }) {
                    node.handle_stored(Ok(()));
                }
            }
            let right = node
                .take_transmit()
                .is_some_and(|frame| frame.id().get() == *answer_id && frame.data() == *answer);
            (!right || node.peek_transmit().is_some()).then_some(*name)
        },
    )
}
