use canopen::Settings;
use expect_test::expect;

use crate::check;
use crate::device::{DICTIONARY, Device, LEN, NODE_ID};
use crate::script::transcript;

/// NM17x PDO-01, PDO-10, PDO-15: values arrive at once in Operational, and in no other state. What the
/// product keeps for itself, here a broadcast with control FF, is not stored.
#[test]
fn values_are_taken_over_at_once_in_operational() {
    check(
        "
        0 boot
        1 < 37F 8A 66 00 00 96 E7 03 00
        2 < 67F 40 01 25 01 00 00 00 00
        3 < 000 01 00
        4 remote 37F 8
        5 < 37F 8A 66 00 00 96 E7 03 00
        6 < 67F 40 01 25 01 00 00 00 00
        7 < 67F 40 01 25 02 00 00 00 00
        8 < 67F 40 01 25 03 00 00 00 00
        9 < 201 00 01 20 00 01 00 00 00
        10 < 67F 40 00 25 02 00 00 00 00
        11 < 67F 40 00 25 04 00 00 00 00
        12 < 201 FF 01 20 00 02 00 00 00
        13 < 67F 40 00 25 04 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 37F [8] 8A 66 00 00 96 E7 03 00
            0002 < 67F [8] 40 01 25 01 00 00 00 00
            0002 > 5FF [8] 43 01 25 01 00 00 00 00
            0003 < 000 [2] 01 00
            0003 * PreOperational to Operational
            0003 > 2FF [8] 00 00 00 00 00 00 00 00
            0004 < 37F [8] remote
            0005 < 37F [8] 8A 66 00 00 96 E7 03 00
            0006 < 67F [8] 40 01 25 01 00 00 00 00
            0006 > 5FF [8] 43 01 25 01 8A 66 00 00
            0007 < 67F [8] 40 01 25 02 00 00 00 00
            0007 > 5FF [8] 4B 01 25 02 96 E7 00 00
            0008 < 67F [8] 40 01 25 03 00 00 00 00
            0008 > 5FF [8] 4B 01 25 03 03 00 00 00
            0009 < 201 [8] 00 01 20 00 01 00 00 00
            0010 < 67F [8] 40 00 25 02 00 00 00 00
            0010 > 5FF [8] 4B 00 25 02 01 20 00 00
            0011 < 67F [8] 40 00 25 04 00 00 00 00
            0011 > 5FF [8] 43 00 25 04 01 00 00 00
            0012 < 201 [8] FF 01 20 00 02 00 00 00
            0013 < 67F [8] 40 00 25 04 00 00 00 00
            0013 > 5FF [8] 43 00 25 04 01 00 00 00
        "#]],
    );
}

/// Decision A-45: a frame that is too short, or has one value that is not permitted, changes nothing
/// and is answered by an emergency message.
#[test]
fn a_bad_frame_changes_nothing() {
    check(
        "
        0 boot
        1 < 000 01 00
        2 < 37F 01 00 00 00 02 00 03
        3 < 37F 01 00 00 00 02 00 00 02
        4 < 37F 40 42 0F 00 02 00 03 00
        5 < 67F 40 01 25 01 00 00 00 00
        6 < 37F 60 79 FE FF 02 00 03 00
        7 < 37F 61 79 FE FF 02 00 03 00
        8 < 67F 40 01 25 01 00 00 00 00
        9 < 37F
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 2FF [8] 00 00 00 00 00 00 00 00
            0002 < 37F [7] 01 00 00 00 02 00 03
            0002 > 0FF [8] 10 82 00 00 00 00 00 01
            0003 < 37F [8] 01 00 00 00 02 00 00 02
            0004 < 37F [8] 40 42 0F 00 02 00 03 00
            0004 > 0FF [8] 20 82 00 00 00 00 00 03
            0005 < 67F [8] 40 01 25 01 00 00 00 00
            0005 > 5FF [8] 43 01 25 01 01 00 00 00
            0006 < 37F [8] 60 79 FE FF 02 00 03 00
            0006 > 0FF [8] 20 82 00 00 00 00 00 03
            0007 < 37F [8] 61 79 FE FF 02 00 03 00
            0008 < 67F [8] 40 01 25 01 00 00 00 00
            0008 > 5FF [8] 43 01 25 01 61 79 FE FF
            0009 < 37F [0]
            0009 > 0FF [8] 10 82 00 00 00 00 00 01
        "#]],
    );
}

/// CiA 301, section 7.2.2.2: types 0 to 240 wait for the SYNC, the last frame counts, and what waits
/// ends with Operational.
#[test]
fn synchronous_values_wait_for_the_sync() {
    check(
        "
        0 boot
        1 < 67F 2F 01 14 02 F0 00 00 00
        2 < 000 01 00
        3 < 080
        4 < 37F 01 00 00 00 00 00 00 00
        5 < 37F 02 00 00 00 00 00 00 00
        6 < 67F 40 01 25 01 00 00 00 00
        7 < 080
        8 < 67F 40 01 25 01 00 00 00 00
        9 < 37F 03 00 00 00 00 00 00 00
        10 < 000 80 00
        11 < 000 01 00
        12 < 080
        13 < 67F 40 01 25 01 00 00 00 00
        14 < 67F 2F 01 14 02 F1 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2F 01 14 02 F0 00 00 00
            0001 > 5FF [8] 60 01 14 02 00 00 00 00
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0002 > 2FF [8] 00 00 00 00 00 00 00 00
            0003 < 080 [0]
            0004 < 37F [8] 01 00 00 00 00 00 00 00
            0005 < 37F [8] 02 00 00 00 00 00 00 00
            0006 < 67F [8] 40 01 25 01 00 00 00 00
            0006 > 5FF [8] 43 01 25 01 00 00 00 00
            0007 < 080 [0]
            0008 < 67F [8] 40 01 25 01 00 00 00 00
            0008 > 5FF [8] 43 01 25 01 02 00 00 00
            0009 < 37F [8] 03 00 00 00 00 00 00 00
            0010 < 000 [2] 80 00
            0010 * Operational to PreOperational
            0011 < 000 [2] 01 00
            0011 * PreOperational to Operational
            0012 < 080 [0]
            0013 < 67F [8] 40 01 25 01 00 00 00 00
            0013 > 5FF [8] 43 01 25 01 02 00 00 00
            0014 < 67F [8] 2F 01 14 02 F1 00 00 00
            0014 > 5FF [8] 80 01 14 02 30 00 09 06
        "#]],
    );
}

/// NM17x PDO-10: the identifier can be moved and switched off, and the filters follow.
#[test]
fn the_identifier_follows_0x1400() {
    check(
        "
        0 boot
        1 < 000 01 00
        2 < 67F 23 00 14 01 05 02 00 40
        3 < 201 00 01 20 00 01 00 00 00
        4 < 205 00 02 20 00 01 00 00 00
        5 < 67F 40 00 25 02 00 00 00 00
        6 < 67F 23 00 14 01 05 02 00 C0
        7 < 205 00 03 20 00 01 00 00 00
        8 < 67F 40 00 25 02 00 00 00 00
        9 < 67F 23 00 14 01 80 05 00 40
        10 < 67F 23 00 14 01 81 05 00 40
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 2FF [8] 00 00 00 00 00 00 00 00
            0002 < 67F [8] 23 00 14 01 05 02 00 40
            0002 > 5FF [8] 60 00 14 01 00 00 00 00
            0002 * FiltersChanged
            0003 < 201 [8] 00 01 20 00 01 00 00 00
            0004 < 205 [8] 00 02 20 00 01 00 00 00
            0005 < 67F [8] 40 00 25 02 00 00 00 00
            0005 > 5FF [8] 4B 00 25 02 02 20 00 00
            0006 < 67F [8] 23 00 14 01 05 02 00 C0
            0006 > 5FF [8] 60 00 14 01 00 00 00 00
            0006 * FiltersChanged
            0007 < 205 [8] 00 03 20 00 01 00 00 00
            0008 < 67F [8] 40 00 25 02 00 00 00 00
            0008 > 5FF [8] 4B 00 25 02 02 20 00 00
            0009 < 67F [8] 23 00 14 01 80 05 00 40
            0009 > 5FF [8] 60 00 14 01 00 00 00 00
            0009 * FiltersChanged
            0010 < 67F [8] 23 00 14 01 81 05 00 40
            0010 > 5FF [8] 80 00 14 01 30 00 09 06
        "#]],
    );
}

/// CiA 301, section 7.5.2.35, sub-index 5: a PDO that stays away is reported once, from the first
/// one on.
#[test]
fn the_deadline_runs_from_the_first_frame() {
    check(
        "
        0 boot
        1 < 67F 2B 01 14 05 14 00 00 00
        2 < 000 01 00
        100 < 37F 01 00 00 00 00 00 00 00
        115 < 37F 01 00 00 00 00 00 00 00
        200 < 37F 01 00 00 00 00 00 00 00
        210 < 000 80 00
        300 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2B 01 14 05 14 00 00 00
            0001 > 5FF [8] 60 01 14 05 00 00 00 00
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0002 > 2FF [8] 00 00 00 00 00 00 00 00
            0100 < 37F [8] 01 00 00 00 00 00 00 00
            0115 < 37F [8] 01 00 00 00 00 00 00 00
            0135 * PdoOverdue { number: 1 }
            0135 > 0FF [8] 50 82 00 00 00 00 00 00
            0200 < 37F [8] 01 00 00 00 00 00 00 00
            0210 < 000 [2] 80 00
            0210 * Operational to PreOperational
        "#]],
    );
}

/// A transmit PDO that carries a received object follows it.
#[test]
fn a_received_value_is_a_change() {
    check(
        "
        0 boot
        1 < 67F 2B 01 18 03 00 00 00 00
        2 < 000 01 00
        3 < 301 07 00
        4 < 301 07 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2B 01 18 03 00 00 00 00
            0001 > 5FF [8] 60 01 18 03 00 00 00 00
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0002 > 2FF [8] 00 00 00 00 00 00 00 00
            0003 < 301 [2] 07 00
            0003 > 2FF [8] 00 00 00 00 07 00 00 00
            0004 < 301 [2] 07 00
        "#]],
    );
}

/// CiA 301, section 7.2.2.5: of a frame that is too long the first bytes count.
#[test]
fn cia_301_takes_the_first_bytes_of_a_long_frame() {
    let node = canopen::Node::<LEN>::new(&DICTIONARY, NODE_ID, &Settings::CIA_301);
    let script = "
        0 boot
        1 < 000 01 00
        90 < 301 07 00 01
        91 < 67F 40 01 25 04 00 00 00 00
        92 < 301 08
        93 < 37F 40 42 0F 00 02 00 03 00
        94 < 67F 40 01 25 01 00 00 00 00
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 77F [1] 00
        0001 < 000 [2] 01 00
        0001 * PreOperational to Operational
        0001 > 2FF [8] 00 00 00 00 00 00 00 00
        0009 > 2FF [8] 00 00 00 00 00 00 00 00
        0017 > 2FF [8] 00 00 00 00 00 00 00 00
        0025 > 2FF [8] 00 00 00 00 00 00 00 00
        0033 > 2FF [8] 00 00 00 00 00 00 00 00
        0041 > 2FF [8] 00 00 00 00 00 00 00 00
        0049 > 2FF [8] 00 00 00 00 00 00 00 00
        0057 > 2FF [8] 00 00 00 00 00 00 00 00
        0065 > 2FF [8] 00 00 00 00 00 00 00 00
        0073 > 2FF [8] 00 00 00 00 00 00 00 00
        0081 > 2FF [8] 00 00 00 00 00 00 00 00
        0089 > 2FF [8] 00 00 00 00 00 00 00 00
        0090 < 301 [3] 07 00 01
        0090 > 0FF [8] 20 82 00 00 00 00 00 00
        0091 < 67F [8] 40 01 25 04 00 00 00 00
        0091 > 5FF [8] 4B 01 25 04 07 00 00 00
        0092 < 301 [1] 08
        0092 > 0FF [8] 10 82 00 00 00 00 00 00
        0093 < 37F [8] 40 42 0F 00 02 00 03 00
        0094 < 67F [8] 40 01 25 01 00 00 00 00
        0094 > 5FF [8] 43 01 25 01 00 00 00 00
    "#]]
    .assert_eq(&transcript(node, &mut Device::new(), script));
}
