use canopen::Settings;
use expect_test::expect;

use crate::check;
use crate::device::{DICTIONARY, Device, LEN, NODE_ID};
use crate::script::transcript;

/// NM17x PDO-01, PDO-04, PDO-05, PDO-09; decisions A-10, A-12: type 255 with an inhibit time of
/// 80 ms. The event timer of 1 ms means nothing.
#[test]
fn changes_go_out_at_once_or_when_the_inhibit_time_ends() {
    check(
        "
        0 boot
        10 set 6004:00 1
        20 < 000 01 00
        150 set 6004:00 2, 204E:01 4096, 2501:04 -1
        160 set 6004:00 3
        170 set 6004:00 4
        400 set 6004:00 4
        405 < 67F 2B 01 25 04 FF FF 00 00
        410 set 204E:02 7
        415 < 67F 2B 01 25 04 01 00 00 00
        420 set 6004:00 -5
        430 < 000 80 00
        440 set 6004:00 6
        900 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0020 < 000 [2] 01 00
            0020 * PreOperational to Operational
            0020 > 2FF [8] 01 00 00 00 00 00 00 00
            0150 > 2FF [8] 02 00 00 00 FF FF 00 10
            0230 > 2FF [8] 04 00 00 00 FF FF 00 10
            0405 < 67F [8] 2B 01 25 04 FF FF 00 00
            0405 > 5FF [8] 60 01 25 04 00 00 00 00
            0415 < 67F [8] 2B 01 25 04 01 00 00 00
            0415 > 5FF [8] 60 01 25 04 00 00 00 00
            0415 > 2FF [8] 04 00 00 00 01 00 00 10
            0430 < 000 [2] 80 00
            0430 * Operational to PreOperational
        "#]],
    );
}

/// NM17x PDO-03, PDO-05; decision A-12: type 254 repeats with the longer of both times; changes do
/// not matter.
#[test]
fn the_event_timer_is_held_back_by_the_inhibit_time() {
    check(
        "
        0 set 1801:02 254
        0 boot
        0 < 000 01 00
        100 set 6004:00 1
        170 < 67F 2B 01 18 03 00 00 00 00
        170 < 67F 2B 01 18 05 14 00 00 00
        215 < 67F 2B 01 18 05 00 00 00 00
        300 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0000 < 000 [2] 01 00
            0000 * PreOperational to Operational
            0001 > 2FF [8] 00 00 00 00 00 00 00 00
            0081 > 2FF [8] 00 00 00 00 00 00 00 00
            0161 > 2FF [8] 01 00 00 00 00 00 00 00
            0170 < 67F [8] 2B 01 18 03 00 00 00 00
            0170 > 5FF [8] 60 01 18 03 00 00 00 00
            0170 < 67F [8] 2B 01 18 05 14 00 00 00
            0170 > 5FF [8] 60 01 18 05 00 00 00 00
            0190 > 2FF [8] 01 00 00 00 00 00 00 00
            0210 > 2FF [8] 01 00 00 00 00 00 00 00
            0215 < 67F [8] 2B 01 18 05 00 00 00 00
            0215 > 5FF [8] 60 01 18 05 00 00 00 00
        "#]],
    );
}

/// NM17x PDO-02, PDO-25; decision A-05: every third SYNC, with or without a data byte. Longer
/// frames are none.
#[test]
fn every_nth_sync_is_answered() {
    check(
        "
        0 set 1801:02 3, 1800:02 1
        0 set 1800:01 1073742335
        0 boot
        1 < 080
        2 < 000 01 00
        3 < 080
        4 < 080 00
        5 set 6004:00 9
        6 < 080 2A
        7 < 080 00 00
        8 remote 080 0
        9 < 080
        10 < 000 02 00
        11 < 080
        12 < 000 01 00
        13 < 080
        14 < 080
        15 < 080
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 080 [0]
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0003 < 080 [0]
            0003 > 1FF [8] 00 00 00 00 00 00 00 00
            0004 < 080 [1] 00
            0004 > 1FF [8] 00 00 00 00 00 00 00 00
            0006 < 080 [1] 2A
            0006 > 1FF [8] 09 00 00 00 00 00 00 00
            0006 > 2FF [8] 09 00 00 00 00 00 00 00
            0007 < 080 [2] 00 00
            0008 < 080 [0] remote
            0009 < 080 [0]
            0009 > 1FF [8] 09 00 00 00 00 00 00 00
            0010 < 000 [2] 02 00
            0010 * Operational to Stopped
            0011 < 080 [0]
            0012 < 000 [2] 01 00
            0012 * Stopped to Operational
            0013 < 080 [0]
            0013 > 1FF [8] 09 00 00 00 00 00 00 00
            0014 < 080 [0]
            0014 > 1FF [8] 09 00 00 00 00 00 00 00
            0015 < 080 [0]
            0015 > 1FF [8] 09 00 00 00 00 00 00 00
            0015 > 2FF [8] 09 00 00 00 00 00 00 00
        "#]],
    );
}

/// NM17x PDO-07, PDO-08; decision A-14: TxPDO1 is off at delivery and needs no further step than
/// its COB-ID; it may have any free identifier.
#[test]
fn a_pdo_switched_on_in_operational_goes_out_once() {
    check(
        "
        0 boot
        0 < 000 01 00
        10 < 67F 40 00 18 01 00 00 00 00
        20 < 67F 23 00 18 01 FF 01 00 40
        30 set 204E:02 16384
        90 < 67F 23 00 18 01 23 04 00 40
        200 set 204E:02 1
        300 < 67F 23 00 18 01 FF 01 00 C0
        400 set 204E:02 2
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0000 < 000 [2] 01 00
            0000 * PreOperational to Operational
            0000 > 2FF [8] 00 00 00 00 00 00 00 00
            0010 < 67F [8] 40 00 18 01 00 00 00 00
            0010 > 5FF [8] 43 00 18 01 FF 01 00 C0
            0020 < 67F [8] 23 00 18 01 FF 01 00 40
            0020 > 5FF [8] 60 00 18 01 00 00 00 00
            0020 > 1FF [8] 00 00 00 00 00 00 00 00
            0090 < 67F [8] 23 00 18 01 23 04 00 40
            0090 > 5FF [8] 60 00 18 01 00 00 00 00
            0100 > 423 [8] 00 00 00 00 00 00 00 40
            0200 > 423 [8] 00 00 00 00 00 00 01 00
            0300 < 67F [8] 23 00 18 01 FF 01 00 C0
            0300 > 5FF [8] 60 00 18 01 00 00 00 00
        "#]],
    );
}

/// NM17x PDO-02; decisions A-11 and A-14: reserved identifiers, 29-bit ones and unknown
/// transmission types are refused and change nothing.
#[test]
fn what_a_pdo_cannot_be_is_refused() {
    check(
        "
        0 boot
        1 < 67F 23 01 18 01 80 01 00 40
        2 < 67F 23 01 18 01 80 05 00 40
        3 < 67F 23 01 18 01 81 01 00 20
        4 < 67F 23 01 18 01 80 00 00 00
        5 < 67F 2F 01 18 02 00 00 00 00
        6 < 67F 2F 01 18 02 F1 00 00 00
        7 < 67F 2F 01 18 02 FD 00 00 00
        8 < 67F 40 01 18 04 00 00 00 00
        9 < 67F 40 01 18 01 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 01 18 01 80 01 00 40
            0001 > 5FF [8] 80 01 18 01 30 00 09 06
            0002 < 67F [8] 23 01 18 01 80 05 00 40
            0002 > 5FF [8] 80 01 18 01 30 00 09 06
            0003 < 67F [8] 23 01 18 01 81 01 00 20
            0003 > 5FF [8] 80 01 18 01 30 00 09 06
            0004 < 67F [8] 23 01 18 01 80 00 00 00
            0004 > 5FF [8] 80 01 18 01 30 00 09 06
            0005 < 67F [8] 2F 01 18 02 00 00 00 00
            0005 > 5FF [8] 80 01 18 02 30 00 09 06
            0006 < 67F [8] 2F 01 18 02 F1 00 00 00
            0006 > 5FF [8] 80 01 18 02 30 00 09 06
            0007 < 67F [8] 2F 01 18 02 FD 00 00 00
            0007 > 5FF [8] 80 01 18 02 30 00 09 06
            0008 < 67F [8] 40 01 18 04 00 00 00 00
            0008 > 5FF [8] 80 01 18 04 11 00 09 06
            0009 < 67F [8] 40 01 18 01 00 00 00 00
            0009 > 5FF [8] 43 01 18 01 FF 02 00 40
        "#]],
    );
}

/// CiA 301: the inhibit time counts 100 µs, and both event-driven types follow changes and timer.
#[test]
fn the_standard_follows_changes_and_the_event_timer() {
    let node = canopen::Node::<LEN>::new(&DICTIONARY, NODE_ID, &Settings::CIA_301);
    let script = "
        0 set 1801:02 254, 1801:05 100
        0 boot
        0 < 000 01 00
        1 set 6004:00 1
        50 set 6004:00 2
        300 end
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 77F [1] 00
        0000 < 000 [2] 01 00
        0000 * PreOperational to Operational
        0000 > 2FF [8] 00 00 00 00 00 00 00 00
        0008 > 2FF [8] 01 00 00 00 00 00 00 00
        0050 > 2FF [8] 02 00 00 00 00 00 00 00
        0150 > 2FF [8] 02 00 00 00 00 00 00 00
        0250 > 2FF [8] 02 00 00 00 00 00 00 00
    "#]]
    .assert_eq(&transcript(node, &mut Device::new(), script));
}
