//! A frame on the wire, against known answers: ISO 11898-1.

use world::can::{Frame, Id, Wire, crc15};

#[test]
fn the_check_sequence_has_its_catalogued_value() {
    let bits: Vec<bool> =
        b"123456789".iter().flat_map(|b| (0..8).rev().map(move |n| b >> n & 1 == 1)).collect();
    assert_eq!(crc15(&bits), 0x059E, "CRC-15/CAN of the digits 1 to 9");
}

/// Bits from start of frame to the end of end of frame, worked out by long division and by hand
/// counting of stuff bits, apart from this code.
#[rustfmt::skip]
#[test]
fn frames_have_their_lengths() {
    let data = |id: u16, bytes: &[u8]| Frame::new(Id::Standard(id), bytes).unwrap();
    let wide = |id: u32, bytes: &[u8]| Frame::new(Id::Extended(id), bytes).unwrap();
    for (frame, bits) in [
        (data(0x000, &[]), 50),
        (data(0x014, &[1]), 55),
        (data(0x77F, &[0]), 57),
        (data(0x100, &[0x12, 0x34]), 63),
        (data(0x555, &[0x55; 8]), 109),
        (data(0x67F, &[0x40, 0x18, 0x10, 1, 0, 0, 0, 0]), 120),
        (data(0x7FF, &[0xFF; 8]), 123),
        (data(0x000, &[0; 8]), 124),
        (data(0x078, &[0x3C; 8]), 128),
        (Frame::remote(Id::Standard(0x123), 4).unwrap(), 44),
        (Frame::remote(Id::Extended(0), 0).unwrap(), 70),
        (wide(0x1FFF_FFFF, &[]), 71),
        (wide(0x1234_5678, &[1, 2, 3, 4, 5, 6, 7, 8]), 137),
        (wide(0, &[0; 8]), 147),
    ] {
        assert_eq!(Wire::of(&frame).len(), bits, "{frame:?}");
    }
}

#[test]
fn no_six_equal_bits_stand_in_the_stuffed_part() {
    for id in 0..=Id::STANDARD_MAX {
        let wire = Wire::of(&Frame::new(Id::Standard(id), &id.to_be_bytes()).unwrap());
        let mut run = 0;
        for place in 0..wire.ack_slot() - 1 {
            run = if place > 0 && wire.bit(place) == wire.bit(place - 1) { run + 1 } else { 1 };
            assert!(run <= 5, "{id:#x} at {place}");
        }
    }
}

#[test]
fn no_frame_is_shorter_than_the_quantum_allows() {
    let shortest = (0..=Id::STANDARD_MAX)
        .flat_map(|id| (0..=8).map(move |dlc| Frame::remote(Id::Standard(id), dlc).unwrap()))
        .map(|frame| Wire::of(&frame).len())
        .min();
    assert_eq!(shortest, Some(44));
    const { assert!(world::can::EARLIEST_OUTCOME_BITS < 44 - 1) };
}

#[test]
fn a_frame_keeps_to_its_format() {
    assert!(Frame::new(Id::Standard(0x800), &[]).is_err());
    assert!(Frame::new(Id::Extended(0x2000_0000), &[]).is_err());
    assert!(Frame::new(Id::Standard(0), &[0; 9]).is_err());
    assert!(Frame::remote(Id::Standard(0), 9).is_err());
    assert_eq!(Frame::remote(Id::Standard(0), 8).unwrap().data(), []);
}
