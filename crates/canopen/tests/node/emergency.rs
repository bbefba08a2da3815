use canopen::Settings;
use expect_test::expect;

use crate::check;
use crate::cia_301;
use crate::device::{DICTIONARY, Device, LEN, NODE_ID};
use crate::script::transcript;

/// NM17x EMCY-01, EMCY-02, EMCY-03, OD-1014-1; decisions A-31, A-32, A-33: the message, its entry,
/// and the reset when nothing is left.
#[test]
fn an_error_is_sent_and_recorded_and_its_end_is_sent() {
    check(
        "
        0 emergency 8110 00
        0 boot
        1 errors 11
        1 emergency 8120 00
        2 emergency 8310 04
        3 < 67F 40 03 10 00 00 00 00 00
        4 < 67F 40 03 10 01 00 00 00 00
        5 < 67F 40 03 10 02 00 00 00 00
        6 < 67F 40 03 10 03 00 00 00 00
        7 < 67F 40 03 10 04 00 00 00 00
        8 errors 01
        9 errors 00
        10 < 67F 40 03 10 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 > 0FF [8] 20 81 11 A1 A2 00 00 00
            0002 > 0FF [8] 10 83 11 A1 A2 00 00 04
            0003 < 67F [8] 40 03 10 00 00 00 00 00
            0003 > 5FF [8] 4F 03 10 00 02 00 00 00
            0004 < 67F [8] 40 03 10 01 00 00 00 00
            0004 > 5FF [8] 43 03 10 01 10 83 04 00
            0005 < 67F [8] 40 03 10 02 00 00 00 00
            0005 > 5FF [8] 43 03 10 02 20 81 00 00
            0006 < 67F [8] 40 03 10 03 00 00 00 00
            0006 > 5FF [8] 80 03 10 03 24 00 00 08
            0007 < 67F [8] 40 03 10 04 00 00 00 00
            0007 > 5FF [8] 80 03 10 04 11 00 09 06
            0009 > 0FF [8] 00 00 00 00 00 00 00 00
            0010 < 67F [8] 40 03 10 00 00 00 00 00
            0010 > 5FF [8] 4F 03 10 00 02 00 00 00
        "#]],
    );
}

/// NM17x EMCY-03, EMCY-04: the list keeps the newest; writing 0 clears it, and nothing else can be
/// written.
#[test]
fn the_error_field_keeps_the_newest_and_can_be_cleared() {
    check(
        "
        0 boot
        1 emergency 8310 01
        1 emergency 8310 02
        1 emergency 8310 03
        1 emergency 8310 04
        2 < 67F 40 03 10 00 00 00 00 00
        3 < 67F 40 03 10 01 00 00 00 00
        4 < 67F 40 03 10 03 00 00 00 00
        5 < 67F 2F 03 10 00 03 00 00 00
        6 < 67F 2F 03 10 00 FF 00 00 00
        7 < 67F 23 03 10 01 00 00 00 00
        8 < 67F 2F 03 10 00 00 00 00 00
        9 < 67F 40 03 10 00 00 00 00 00
        10 < 67F 40 03 10 01 00 00 00 00
        11 emergency 8110 00
        12 < 67F 40 03 10 01 00 00 00 00
        13 < 67F 40 03 10 02 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 > 0FF [8] 10 83 00 A1 A2 00 00 01
            0001 > 0FF [8] 10 83 00 A1 A2 00 00 02
            0001 > 0FF [8] 10 83 00 A1 A2 00 00 03
            0001 > 0FF [8] 10 83 00 A1 A2 00 00 04
            0002 < 67F [8] 40 03 10 00 00 00 00 00
            0002 > 5FF [8] 4F 03 10 00 03 00 00 00
            0003 < 67F [8] 40 03 10 01 00 00 00 00
            0003 > 5FF [8] 43 03 10 01 10 83 04 00
            0004 < 67F [8] 40 03 10 03 00 00 00 00
            0004 > 5FF [8] 43 03 10 03 10 83 02 00
            0005 < 67F [8] 2F 03 10 00 03 00 00 00
            0005 > 5FF [8] 80 03 10 00 30 00 09 06
            0006 < 67F [8] 2F 03 10 00 FF 00 00 00
            0006 > 5FF [8] 80 03 10 00 30 00 09 06
            0007 < 67F [8] 23 03 10 01 00 00 00 00
            0007 > 5FF [8] 80 03 10 01 02 00 01 06
            0008 < 67F [8] 2F 03 10 00 00 00 00 00
            0008 > 5FF [8] 60 03 10 00 00 00 00 00
            0009 < 67F [8] 40 03 10 00 00 00 00 00
            0009 > 5FF [8] 4F 03 10 00 00 00 00 00
            0010 < 67F [8] 40 03 10 01 00 00 00 00
            0010 > 5FF [8] 80 03 10 01 24 00 00 08
            0011 > 0FF [8] 10 81 00 A1 A2 00 00 00
            0012 < 67F [8] 40 03 10 01 00 00 00 00
            0012 > 5FF [8] 43 03 10 01 10 81 00 00
            0013 < 67F [8] 40 03 10 02 00 00 00 00
            0013 > 5FF [8] 80 03 10 02 24 00 00 08
        "#]],
    );
}

/// CiA 301, section 7.5.2.17: it stays what it is while there are emergency messages, unless the product
/// lets it change at any time.
#[test]
fn the_identifier_is_moved_while_it_is_off() {
    let script = "
        0 boot
        1 < 605 23 14 10 00 86 00 00 00
        2 < 605 23 14 10 00 85 00 00 00
        3 < 605 23 14 10 00 86 00 00 80
        4 < 605 23 14 10 00 86 00 00 00
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 23 14 10 00 86 00 00 00
        0001 > 585 [8] 80 14 10 00 30 00 09 06
        0002 < 605 [8] 23 14 10 00 85 00 00 00
        0002 > 585 [8] 60 14 10 00 00 00 00 00
        0003 < 605 [8] 23 14 10 00 86 00 00 80
        0003 > 585 [8] 60 14 10 00 00 00 00 00
        0004 < 605 [8] 23 14 10 00 86 00 00 00
        0004 > 585 [8] 60 14 10 00 00 00 00 00
    "#]]
    .assert_eq(&transcript(cia_301::node(), &mut (), script));
}

/// CiA 301, section 7.5.2.17: the identifier can be moved and switched off; errors are recorded all
/// the same.
#[test]
fn the_identifier_follows_0x1014() {
    check(
        "
        0 boot
        1 < 67F 23 14 10 00 81 00 00 00
        2 emergency 8110 00
        3 < 67F 23 14 10 00 81 00 00 80
        4 emergency 8310 01
        5 < 67F 40 03 10 01 00 00 00 00
        6 < 67F 23 14 10 00 00 01 00 00
        7 < 67F 23 14 10 00 FF 00 00 00
        8 emergency 8310 02
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 14 10 00 81 00 00 00
            0001 > 5FF [8] 60 14 10 00 00 00 00 00
            0002 > 081 [8] 10 81 00 A1 A2 00 00 00
            0003 < 67F [8] 23 14 10 00 81 00 00 80
            0003 > 5FF [8] 60 14 10 00 00 00 00 00
            0005 < 67F [8] 40 03 10 01 00 00 00 00
            0005 > 5FF [8] 43 03 10 01 10 83 01 00
            0006 < 67F [8] 23 14 10 00 00 01 00 00
            0006 > 5FF [8] 80 14 10 00 30 00 09 06
            0007 < 67F [8] 23 14 10 00 FF 00 00 00
            0007 > 5FF [8] 60 14 10 00 00 00 00 00
            0008 > 0FF [8] 10 83 00 A1 A2 00 00 02
        "#]],
    );
}

/// CiA 301, section 7.5.2.18: messages inside the inhibit time, here 20 ms, wait, in Stopped as
/// well. A shorter time lets them go earlier.
#[test]
fn messages_keep_their_distance() {
    check(
        "
        0 boot
        1 < 67F 2B 15 10 00 C8 00 00 00
        2 errors 01
        2 emergency 8310 01
        3 emergency 8310 02
        4 emergency 8310 03
        5 errors 00
        30 < 000 02 7F
        70 < 000 80 7F
        75 < 67F 2B 15 10 00 0A 00 00 00
        100 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2B 15 10 00 C8 00 00 00
            0001 > 5FF [8] 60 15 10 00 00 00 00 00
            0002 > 0FF [8] 10 83 01 A1 A2 00 00 01
            0022 > 0FF [8] 10 83 01 A1 A2 00 00 02
            0030 < 000 [2] 02 7F
            0030 * PreOperational to Stopped
            0070 < 000 [2] 80 7F
            0070 * Stopped to PreOperational
            0070 > 0FF [8] 10 83 01 A1 A2 00 00 03
            0075 < 67F [8] 2B 15 10 00 0A 00 00 00
            0075 > 5FF [8] 60 15 10 00 00 00 00 00
            0076 > 0FF [8] 00 00 00 00 00 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.18: of more messages than can wait the oldest are dropped; they stay in the
/// error field.
#[test]
fn of_too_many_that_wait_the_newest_go_out() {
    check(
        "
        0 boot
        1 < 67F 2B 15 10 00 0A 00 00 00
        2 emergency 8310 01
        2 emergency 8310 02
        2 emergency 8310 03
        2 emergency 8310 04
        2 emergency 8310 05
        2 emergency 8310 06
        2 emergency 8310 07
        2 emergency 8310 08
        2 emergency 8310 09
        2 emergency 8310 0A
        2 emergency 8310 0B
        20 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2B 15 10 00 0A 00 00 00
            0001 > 5FF [8] 60 15 10 00 00 00 00 00
            0002 > 0FF [8] 10 83 00 A1 A2 00 00 01
            0003 > 0FF [8] 10 83 00 A1 A2 00 00 04
            0004 > 0FF [8] 10 83 00 A1 A2 00 00 05
            0005 > 0FF [8] 10 83 00 A1 A2 00 00 06
            0006 > 0FF [8] 10 83 00 A1 A2 00 00 07
            0007 > 0FF [8] 10 83 00 A1 A2 00 00 08
            0008 > 0FF [8] 10 83 00 A1 A2 00 00 09
            0009 > 0FF [8] 10 83 00 A1 A2 00 00 0A
            0010 > 0FF [8] 10 83 00 A1 A2 00 00 0B
        "#]],
    );
}

/// CiA 301, section 7.5.2.4: the additional information of an entry are the first of the maker's
/// bytes, and a number that is not 0 is no permitted one.
#[test]
fn cia_301_keeps_the_first_bytes() {
    let node = canopen::Node::<LEN>::new(&DICTIONARY, NODE_ID, &Settings::CIA_301);
    let script = "
        0 boot
        1 emergency 8310 05
        2 < 67F 40 03 10 01 00 00 00 00
        3 < 67F 2F 03 10 00 01 00 00 00
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 77F [1] 00
        0001 > 0FF [8] 10 83 00 A1 A2 00 00 05
        0002 < 67F [8] 40 03 10 01 00 00 00 00
        0002 > 5FF [8] 43 03 10 01 10 83 A1 A2
        0003 < 67F [8] 2F 03 10 00 01 00 00 00
        0003 > 5FF [8] 80 03 10 00 30 00 09 06
    "#]]
    .assert_eq(&transcript(node, &mut Device::new(), script));
}
