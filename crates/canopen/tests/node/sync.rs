use expect_test::{Expect, expect};

use crate::cia_301;
use crate::script::transcript;

#[track_caller]
fn check(script: &str, expected: Expect) {
    expected.assert_eq(&transcript(cia_301::node(), &mut (), script));
}

/// Conformance cases 6.2 and 6.4: the device produces SYNC while bit 30 of 0x1005 is set and the
/// period is not 0, in Pre-operational and Operational, and acts on it itself.
#[test]
fn a_producer_keeps_its_period_and_acts_on_its_own_sync() {
    check(
        "
        0 boot
        1 < 605 23 05 10 00 80 00 00 40
        2 < 605 23 06 10 00 10 27 00 00
        25 < 000 01 00
        26 < 205 07
        27 < 605 40 00 62 00 00 00 00 00
        35 < 605 40 00 62 00 00 00 00 00
        36 < 000 02 00
        60 < 000 80 00
        75 < 605 23 06 10 00 00 00 00 00
        100 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 05 10 00 80 00 00 40
            0001 > 585 [8] 60 05 10 00 00 00 00 00
            0002 < 605 [8] 23 06 10 00 10 27 00 00
            0002 > 585 [8] 60 06 10 00 00 00 00 00
            0012 > 080 [0]
            0022 > 080 [0]
            0025 < 000 [2] 01 00
            0025 * PreOperational to Operational
            0026 < 205 [1] 07
            0027 < 605 [8] 40 00 62 00 00 00 00 00
            0027 > 585 [8] 4F 00 62 00 00 00 00 00
            0032 > 080 [0]
            0032 > 185 [4] 00 00 00 00
            0035 < 605 [8] 40 00 62 00 00 00 00 00
            0035 > 585 [8] 4F 00 62 00 07 00 00 00
            0036 < 000 [2] 02 00
            0036 * Operational to Stopped
            0060 < 000 [2] 80 00
            0060 * Stopped to PreOperational
            0070 > 080 [0]
            0075 < 605 [8] 23 06 10 00 00 00 00 00
            0075 > 585 [8] 60 06 10 00 00 00 00 00
        "#]],
    );
}

/// Conformance cases 6.5 to 6.7 and 6.9; CiA 301, section 7.5.2.22: the counter runs from 1 to the
/// overflow value, and begins anew when SYNC stopped; the value stays while there is a period.
#[test]
fn a_counter_runs_from_one_to_its_overflow_value() {
    check(
        "
        0 boot
        1 < 605 2F 19 10 00 01 00 00 00
        1 < 605 2F 19 10 00 F1 00 00 00
        1 < 605 2F 19 10 00 03 00 00 00
        2 < 605 23 05 10 00 80 00 00 40
        2 < 605 23 06 10 00 10 27 00 00
        3 < 605 2F 19 10 00 00 00 00 00
        4 < 605 40 19 10 00 00 00 00 00
        65 < 000 02 00
        70 < 000 01 00
        95 < 605 23 06 10 00 00 00 00 00
        96 < 605 2F 19 10 00 00 00 00 00
        97 < 605 40 19 10 00 00 00 00 00
        98 < 605 23 06 10 00 10 27 00 00
        118 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2F 19 10 00 01 00 00 00
            0001 > 585 [8] 80 19 10 00 30 00 09 06
            0001 < 605 [8] 2F 19 10 00 F1 00 00 00
            0001 > 585 [8] 80 19 10 00 30 00 09 06
            0001 < 605 [8] 2F 19 10 00 03 00 00 00
            0001 > 585 [8] 60 19 10 00 00 00 00 00
            0002 < 605 [8] 23 05 10 00 80 00 00 40
            0002 > 585 [8] 60 05 10 00 00 00 00 00
            0002 < 605 [8] 23 06 10 00 10 27 00 00
            0002 > 585 [8] 60 06 10 00 00 00 00 00
            0003 < 605 [8] 2F 19 10 00 00 00 00 00
            0003 > 585 [8] 80 19 10 00 22 00 00 08
            0004 < 605 [8] 40 19 10 00 00 00 00 00
            0004 > 585 [8] 4F 19 10 00 03 00 00 00
            0012 > 080 [1] 01
            0022 > 080 [1] 02
            0032 > 080 [1] 03
            0042 > 080 [1] 01
            0052 > 080 [1] 02
            0062 > 080 [1] 03
            0065 < 000 [2] 02 00
            0065 * PreOperational to Stopped
            0070 < 000 [2] 01 00
            0070 * Stopped to Operational
            0080 > 080 [1] 01
            0080 > 185 [4] 00 00 00 00
            0090 > 080 [1] 02
            0090 > 185 [4] 00 00 00 00
            0095 < 605 [8] 23 06 10 00 00 00 00 00
            0095 > 585 [8] 60 06 10 00 00 00 00 00
            0096 < 605 [8] 2F 19 10 00 00 00 00 00
            0096 > 585 [8] 60 19 10 00 00 00 00 00
            0097 < 605 [8] 40 19 10 00 00 00 00 00
            0097 > 585 [8] 4F 19 10 00 00 00 00 00
            0098 < 605 [8] 23 06 10 00 10 27 00 00
            0098 > 585 [8] 60 06 10 00 00 00 00 00
            0108 > 080 [0]
            0108 > 185 [4] 00 00 00 00
            0118 > 080 [0]
            0118 > 185 [4] 00 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.5: eleven bits, no restricted identifier, and none other while it
/// produces.
#[test]
fn a_producer_keeps_its_identifier() {
    check(
        "
        0 boot
        1 < 605 23 05 10 00 80 00 00 20
        1 < 605 23 05 10 00 05 06 00 00
        1 < 605 23 05 10 00 81 00 00 40
        2 < 605 23 05 10 00 82 00 00 40
        3 < 605 23 05 10 00 82 00 00 00
        4 < 605 40 05 10 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 05 10 00 80 00 00 20
            0001 > 585 [8] 80 05 10 00 30 00 09 06
            0001 < 605 [8] 23 05 10 00 05 06 00 00
            0001 > 585 [8] 80 05 10 00 30 00 09 06
            0001 < 605 [8] 23 05 10 00 81 00 00 40
            0001 > 585 [8] 60 05 10 00 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 23 05 10 00 82 00 00 40
            0002 > 585 [8] 80 05 10 00 30 00 09 06
            0003 < 605 [8] 23 05 10 00 82 00 00 00
            0003 > 585 [8] 60 05 10 00 00 00 00 00
            0003 * FiltersChanged
            0004 < 605 [8] 40 05 10 00 00 00 00 00
            0004 > 585 [8] 43 05 10 00 82 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.2.5 and table 26: with an overflow value a SYNC has one byte, without one
/// none; others are not taken, and the first of them is told.
#[test]
fn a_sync_of_another_length_is_an_error() {
    check(
        "
        0 boot
        1 < 000 01 00
        2 < 080
        3 < 080 01
        3 < 080 01
        4 < 605 2F 19 10 00 0A 00 00 00
        5 < 080
        6 < 080 01
        7 < 080 01 02
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0002 < 080 [0]
            0002 > 185 [4] 00 00 00 00
            0003 < 080 [1] 01
            0003 > 085 [8] 40 82 00 00 00 00 00 00
            0003 < 080 [1] 01
            0004 < 605 [8] 2F 19 10 00 0A 00 00 00
            0004 > 585 [8] 60 19 10 00 00 00 00 00
            0005 < 080 [0]
            0005 > 085 [8] 40 82 00 00 00 00 00 00
            0006 < 080 [1] 01
            0006 > 185 [4] 00 00 00 00
            0007 < 080 [2] 01 02
            0007 > 085 [8] 40 82 00 00 00 00 00 00
        "#]],
    );
}

/// Conformance cases 3.8, 3.14 and 3.20: a PDO with a start value begins with the SYNC that has it.
#[test]
fn the_counter_starts_a_pdo() {
    check(
        "
        0 boot
        1 < 605 2F 19 10 00 0A 00 00 00
        2 < 605 23 00 18 01 85 01 00 C0
        2 < 605 2F 00 18 02 02 00 00 00
        2 < 605 2F 00 18 06 03 00 00 00
        2 < 605 23 00 18 01 85 01 00 40
        3 < 000 01 00
        4 < 080 01
        5 < 080 02
        6 < 080 03
        7 < 080 04
        8 < 080 05
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2F 19 10 00 0A 00 00 00
            0001 > 585 [8] 60 19 10 00 00 00 00 00
            0002 < 605 [8] 23 00 18 01 85 01 00 C0
            0002 > 585 [8] 60 00 18 01 00 00 00 00
            0002 < 605 [8] 2F 00 18 02 02 00 00 00
            0002 > 585 [8] 60 00 18 02 00 00 00 00
            0002 < 605 [8] 2F 00 18 06 03 00 00 00
            0002 > 585 [8] 60 00 18 06 00 00 00 00
            0002 < 605 [8] 23 00 18 01 85 01 00 40
            0002 > 585 [8] 60 00 18 01 00 00 00 00
            0003 < 000 [2] 01 00
            0003 * PreOperational to Operational
            0004 < 080 [1] 01
            0005 < 080 [1] 02
            0006 < 080 [1] 03
            0007 < 080 [1] 04
            0007 > 185 [4] 00 00 00 00
            0008 < 080 [1] 05
        "#]],
    );
}

/// CiA 301, section 7.5.2.7: what comes behind the window of a SYNC is late.
#[test]
fn receive_pdos_behind_the_window_are_late() {
    check(
        "
        0 boot
        1 < 605 23 07 10 00 88 13 00 00
        2 < 000 01 00
        10 < 080
        14 < 205 01
        20 < 080
        26 < 205 02
        30 < 080
        31 < 605 40 00 62 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 07 10 00 88 13 00 00
            0001 > 585 [8] 60 07 10 00 00 00 00 00
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0010 < 080 [0]
            0010 > 185 [4] 00 00 00 00
            0014 < 205 [1] 01
            0020 < 080 [0]
            0020 > 185 [4] 00 00 00 00
            0026 < 205 [1] 02
            0030 < 080 [0]
            0030 > 185 [4] 00 00 00 00
            0031 < 605 [8] 40 00 62 00 00 00 00 00
            0031 > 585 [8] 4F 00 62 00 01 00 00 00
        "#]],
    );
}

/// Neither the period nor the window is longer than a deadline lies ahead, 35 minutes and 47 seconds.
#[test]
fn spans_that_are_too_long_are_refused() {
    check(
        "
        0 boot
        1 < 605 23 06 10 00 FF FF FF 7F
        2 < 605 23 07 10 00 FF FF FF 7F
        3 < 605 23 07 10 00 FF FF FF FF
        4 < 605 23 06 10 00 FE FF FF 7F
        5 < 605 23 07 10 00 FE FF FF 7F
        6 < 605 23 05 10 00 80 00 00 40
        2147600 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 06 10 00 FF FF FF 7F
            0001 > 585 [8] 80 06 10 00 30 00 09 06
            0002 < 605 [8] 23 07 10 00 FF FF FF 7F
            0002 > 585 [8] 80 07 10 00 30 00 09 06
            0003 < 605 [8] 23 07 10 00 FF FF FF FF
            0003 > 585 [8] 80 07 10 00 30 00 09 06
            0004 < 605 [8] 23 06 10 00 FE FF FF 7F
            0004 > 585 [8] 60 06 10 00 00 00 00 00
            0005 < 605 [8] 23 07 10 00 FE FF FF 7F
            0005 > 585 [8] 60 07 10 00 00 00 00 00
            0006 < 605 [8] 23 05 10 00 80 00 00 40
            0006 > 585 [8] 60 05 10 00 00 00 00 00
            2147489 > 080 [0]
        "#]],
    );
}

/// CiA 301, section 7.5.2.7: a transmit PDO that found no mailbox in the window does not follow
/// later.
#[test]
fn transmit_pdos_behind_the_window_are_dropped() {
    use canopen::{CanId, Frame};
    use units::{Duration, Instant};

    let mut node = cia_301::node();
    let at = |ms| Instant::ZERO + Duration::from_millis(ms);
    node.boot(at(0));
    let mut receive = |ms, id, data: &[u8]| {
        let frame = Frame::new(CanId::new(id).unwrap(), data).unwrap();
        node.handle_frame(at(ms), &frame, &mut ());
    };
    receive(1, 0x605, &[0x23, 0x07, 0x10, 0, 0x88, 0x13, 0, 0]);
    receive(2, 0, &[1, 0]);
    receive(10, 0x080, &[]);
    assert_eq!(node.take_transmit().map(|frame| frame.id().get()), Some(0x705));
    assert_eq!(node.peek_transmit().map(|frame| frame.id().get()), Some(0x185));
    assert_eq!(node.poll_timeout(), Some(at(15)));
    node.handle_timeout(at(15), &mut ());
    assert_eq!(node.peek_transmit().map(|frame| frame.id().get()), Some(0x585));
}
