//! Acceptance filters: RM0090, 32.7.4.

use crate::rig::{F0R1, FA1R, FM1R, FMR, FilterBank, Rig, ext_frame, std_frame};
use world::can::{Frame, Id};

/// Sends frames past the filters; the transcript says FIFO and filter number for each, `-` where
/// it was not received.
#[track_caller]
fn check(banks: &[FilterBank], cases: &[(Frame, &str)]) {
    let mut rig = Rig::running(1);
    rig.filters(0, banks);
    let master = rig.attach(1_000_000);
    for (frame, expected) in cases {
        rig.bus.send(master, *frame).unwrap();
        rig.run_us(300);
        let seen = match (rig.take(0, 0), rig.take(0, 1)) {
            (Some((got, index)), None) if got == *frame => format!("0/{index}"),
            (None, Some((got, index))) if got == *frame => format!("1/{index}"),
            (None, None) => "-".to_owned(),
            other => format!("{other:?}"),
        };
        assert_eq!(seen, *expected, "{frame:?}");
    }
}

const fn bank(bank: u32, fifo: u32, values: [u32; 2]) -> FilterBank {
    FilterBank { bank, fifo, wide: true, list: false, values }
}

const fn wide_list(b: u32, fifo: u32, values: [u32; 2]) -> FilterBank {
    FilterBank { list: true, ..bank(b, fifo, values) }
}

const fn narrow_mask(b: u32, fifo: u32, values: [u32; 2]) -> FilterBank {
    FilterBank { wide: false, ..bank(b, fifo, values) }
}

const fn narrow_list(b: u32, fifo: u32, values: [u32; 2]) -> FilterBank {
    FilterBank { wide: false, ..wide_list(b, fifo, values) }
}

fn remote(id: Id) -> Frame {
    Frame::remote(id, 0).unwrap()
}

#[test]
fn a_32_bit_mask_compares_identifier_ide_and_rtr() {
    // 0x600..0x60F, standard, data only.
    let banks = [bank(0, 0, [0x600 << 21, 0x7F0 << 21 | 0b110])];
    check(
        &banks,
        &[
            (std_frame(0x600, &[1]), "0/0"),
            (std_frame(0x60F, &[]), "0/0"),
            (std_frame(0x610, &[]), "-"),
            (remote(Id::Standard(0x600)), "-"),
            (ext_frame(0x600 << 18, &[]), "-"),
        ],
    );
}

#[test]
fn a_32_bit_mask_of_zero_lets_everything_pass() {
    check(
        &[bank(0, 0, [0, 0])],
        &[
            (std_frame(0, &[]), "0/0"),
            (std_frame(0x7FF, &[1, 2, 3, 4, 5, 6, 7, 8]), "0/0"),
            (ext_frame(0x1FFF_FFFF, &[0xAA]), "0/0"),
            (remote(Id::Extended(0x123)), "0/0"),
        ],
    );
}

#[test]
fn a_32_bit_list_holds_two_identifiers() {
    let banks = [wide_list(0, 0, [0x123 << 21, 0x1234_5678 << 3 | 1 << 2])];
    check(
        &banks,
        &[
            (std_frame(0x123, &[]), "0/0"),
            (ext_frame(0x1234_5678, &[]), "0/1"),
            (std_frame(0x124, &[]), "-"),
            (ext_frame(0x1234_5679, &[]), "-"),
            (remote(Id::Standard(0x123)), "-"),
        ],
    );
}

#[test]
fn a_16_bit_bank_holds_two_masks() {
    // Identifier in the lower, mask in the upper half: STID 15:5, RTR 4, IDE 3.
    let mask = (0x7F0 << 5 | 0b11 << 3) << 16;
    let banks = [narrow_mask(0, 0, [mask | 0x200 << 5, mask | 0x300 << 5])];
    check(
        &banks,
        &[
            (std_frame(0x20A, &[]), "0/0"),
            (std_frame(0x305, &[]), "0/1"),
            (std_frame(0x400, &[]), "-"),
            (remote(Id::Standard(0x20A)), "-"),
            (ext_frame(0x200 << 18, &[]), "-"),
        ],
    );
}

#[test]
fn a_16_bit_bank_holds_a_list_of_four() {
    let pair = |a: u32, b: u32| a << 5 | b << 21;
    let banks = [narrow_list(0, 0, [pair(0x000, 0x080), pair(0x600 + 5, 0x7E5)])];
    check(
        &banks,
        &[
            (std_frame(0x000, &[]), "0/0"),
            (std_frame(0x080, &[]), "0/1"),
            (std_frame(0x605, &[]), "0/2"),
            (std_frame(0x7E5, &[]), "0/3"),
            (std_frame(0x081, &[]), "-"),
        ],
    );
}

#[test]
fn a_16_bit_filter_sees_the_three_upper_bits_of_the_extension() {
    let id = 0x155 << 18 | 0b101 << 15;
    let banks = [narrow_list(0, 0, [0x155 << 5 | 1 << 3 | 0b101, 0x155 << 5 | 1 << 3 | 0b101])];
    check(
        &banks,
        &[
            (ext_frame(id, &[]), "0/0"),
            (ext_frame(id | 0x7FFF, &[]), "0/0"),
            (ext_frame(id ^ 1 << 15, &[]), "-"),
            (std_frame(0x155, &[]), "-"),
        ],
    );
}

#[test]
fn filters_are_numbered_per_fifo_over_all_banks_active_or_not() {
    // FIFO 0: banks 0 (list, 2 filters), 2 (four), 4 (one). FIFO 1: banks 1 (two), 3 (one).
    let banks = [
        wide_list(0, 0, [0x100 << 21, 0x101 << 21]),
        narrow_mask(1, 1, [0xFFFF_0000 | 0x110 << 5, 0xFFFF_0000 | 0x111 << 5]),
        narrow_list(2, 0, [0x120 << 5 | 0x121 << 21, 0x122 << 5 | 0x123 << 21]),
        bank(3, 1, [0x130 << 21, 0x7FF << 21]),
        bank(4, 0, [0x140 << 21, 0x7FF << 21]),
    ];
    check(
        &banks,
        &[
            (std_frame(0x100, &[]), "0/0"),
            (std_frame(0x101, &[]), "0/1"),
            (std_frame(0x110, &[]), "1/0"),
            (std_frame(0x111, &[]), "1/1"),
            (std_frame(0x123, &[]), "0/5"),
            (std_frame(0x130, &[]), "1/2"),
            (std_frame(0x140, &[]), "0/6"),
        ],
    );
    let mut rig = Rig::running(1);
    rig.filters(0, &banks);
    rig.write(0, FA1R, 0b10000);
    let master = rig.attach(1_000_000);
    rig.bus.send(master, std_frame(0x140, &[])).unwrap();
    rig.run_us(200);
    assert_eq!(rig.take(0, 0), Some((std_frame(0x140, &[]), 6)), "inactive banks count");
}

#[test]
fn a_wide_filter_comes_before_a_narrow_a_list_before_a_mask_a_low_bank_before_a_high() {
    let any = 0x7FF << 21;
    let id = 0x222;
    let narrow = id << 5 | id << 21;
    // Numbers in FIFO 0: bank 0 -> 0, 1; bank 1 -> 2..5; bank 2 -> 6; bank 3 -> 7, 8.
    let all = [
        narrow_mask(0, 0, [0, 0]),
        narrow_list(1, 0, [narrow, narrow]),
        bank(2, 0, [id << 21, any]),
        wide_list(3, 0, [id << 21, id << 21]),
    ];
    let frame = std_frame(0x222, &[]);
    check(&all, &[(frame, "0/7")]);
    check(&all[..3], &[(frame, "0/6")]);
    check(&all[..2], &[(frame, "0/2")]);
    check(&all[..1], &[(frame, "0/0")]);
    // Banks 0 to 3 are left as after reset: two 16 bit masks each, in FIFO 0.
    check(&[bank(5, 1, [0, 0]), bank(4, 0, [0, 0])], &[(frame, "0/8")]);
}

#[test]
fn nothing_is_received_while_filters_are_set_up() {
    let mut rig = Rig::running(1);
    rig.write(0, FMR, 28 << 8 | 1);
    let master = rig.attach(1_000_000);
    rig.bus.send(master, std_frame(0x100, &[])).unwrap();
    rig.run_us(200);
    assert_eq!(rig.take(0, 0), None);
    assert_eq!(rig.bus.status(master).unwrap().sent, 1, "acknowledged all the same");
    rig.write(0, FMR, 28 << 8);
    rig.bus.send(master, std_frame(0x101, &[])).unwrap();
    rig.run_us(200);
    assert_eq!(rig.take_all(0, 0), [std_frame(0x101, &[])]);
}

#[test]
fn mode_and_active_banks_are_protected_outside_of_set_up() {
    let mut rig = Rig::running(1);
    rig.write(0, FM1R, 1);
    assert_eq!(rig.read(0, FM1R), 0, "FINIT is 0");
    rig.write(0, F0R1, 0xFFFF_FFFF);
    assert_eq!(rig.read(0, F0R1), 0, "bank 0 is active");
    rig.write(0, F0R1 + 8, 0x55);
    assert_eq!(rig.read(0, F0R1 + 8), 0x55, "bank 1 is not");
}

#[test]
fn banks_of_the_second_controller_let_nothing_pass() {
    let mut rig = Rig::running(1);
    rig.filters(0, &[bank(14, 0, [0, 0])]);
    let master = rig.attach(1_000_000);
    rig.write(0, FMR, 14 << 8);
    rig.bus.send(master, std_frame(0x100, &[])).unwrap();
    rig.run_us(200);
    assert_eq!(rig.take(0, 0), None, "CAN2SB is 14: bank 14 belongs to CAN2");
    rig.write(0, FMR, 15 << 8);
    rig.bus.send(master, std_frame(0x100, &[])).unwrap();
    rig.run_us(200);
    assert!(rig.take(0, 0).is_some(), "CAN2SB is 15");
}
