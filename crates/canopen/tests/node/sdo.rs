use canopen::{BusState, CanId, Frame, Node, Settings};
use expect_test::expect;
use units::Instant;

use crate::device::{self, DICTIONARY, Device, LEN, NODE_ID};
use crate::script::transcript;
use crate::{check, vectors};

/// NM17x SDO-02, SDO-03, SDO-04, SDO-05, SDO-08, SDO-10, BOOT-03.
#[test]
fn every_vector_is_answered_byte_for_byte() {
    assert_eq!(vectors::first_failure(), None);
}

/// NM17x SDO-06, SDO-09; decisions A-19, A-20: one abort code for each request, by the first check
/// that fails.
#[test]
fn each_check_has_its_abort_code() {
    check(
        "
        0 boot
        1 < 67F 41 FF 5F 00 00 00 00 00
        2 < 67F 27 03 20 00 01 00 00 00
        3 < 67F 40 FF 5F 00 00 00 00 00
        4 < 67F 2F 04 60 FF 00 00 00 00
        5 < 67F 2F 04 60 00 00 00 00 00
        6 < 67F 40 08 20 00 00 00 00 00
        7 < 67F 2F 03 20 00 01 00 00 00
        8 < 67F 23 03 20 00 10 27 00 00
        9 < 67F 2B 42 20 03 F0 D8 00 00
        10 < 67F 22 48 20 00 01 01 00 00
        11 < 67F 22 42 20 03 01 00 01 00
        12 < 67F 23 80 1F 00 04 00 00 00
        13 < 67F 2F 48 20 00 01 00 00 00
        14 < 67F 23 10 10 01 00 00 00 00
        15 < 67F 40 03 10 01 00 00 00 00
        16 < 67F 2B 01 21 00 7F 00 00 00
        17 < 67F 23 07 20 00 41 42 43 44
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 41 FF 5F 00 00 00 00 00
            0001 > 5FF [8] 80 FF 5F 00 01 00 04 05
            0002 < 67F [8] 27 03 20 00 01 00 00 00
            0002 > 5FF [8] 80 03 20 00 01 00 04 05
            0003 < 67F [8] 40 FF 5F 00 00 00 00 00
            0003 > 5FF [8] 80 FF 5F 00 00 00 02 06
            0004 < 67F [8] 2F 04 60 FF 00 00 00 00
            0004 > 5FF [8] 80 04 60 FF 11 00 09 06
            0005 < 67F [8] 2F 04 60 00 00 00 00 00
            0005 > 5FF [8] 80 04 60 00 02 00 01 06
            0006 < 67F [8] 40 08 20 00 00 00 00 00
            0006 > 5FF [8] 80 08 20 00 01 00 01 06
            0007 < 67F [8] 2F 03 20 00 01 00 00 00
            0007 > 5FF [8] 80 03 20 00 00 00 01 06
            0008 < 67F [8] 23 03 20 00 10 27 00 00
            0008 > 5FF [8] 80 03 20 00 30 00 09 06
            0009 < 67F [8] 2B 42 20 03 F0 D8 00 00
            0009 > 5FF [8] 80 42 20 03 30 00 09 06
            0010 < 67F [8] 22 48 20 00 01 01 00 00
            0010 > 5FF [8] 80 48 20 00 31 00 09 06
            0011 < 67F [8] 22 42 20 03 01 00 01 00
            0011 > 5FF [8] 80 42 20 03 31 00 09 06
            0012 < 67F [8] 23 80 1F 00 04 00 00 00
            0012 > 5FF [8] 80 80 1F 00 30 00 09 06
            0013 < 67F [8] 2F 48 20 00 01 00 00 00
            0013 > 5FF [8] 80 48 20 00 00 00 06 06
            0014 < 67F [8] 23 10 10 01 00 00 00 00
            0014 > 5FF [8] 80 10 10 01 20 00 00 08
            0015 < 67F [8] 40 03 10 01 00 00 00 00
            0015 > 5FF [8] 80 03 10 01 24 00 00 08
            0016 < 67F [8] 2B 01 21 00 7F 00 00 00
            0016 > 5FF [8] 80 01 21 00 00 00 01 06
            0017 < 67F [8] 23 07 20 00 41 42 43 44
            0017 > 5FF [8] 80 07 20 00 30 00 09 06
        "#]],
    );
}

/// NM17x SDO-01; decision A-18: short frames are dropped, longer ones do.
#[test]
fn frames_shorter_than_their_command_are_dropped() {
    check(
        "
        0 boot
        1 < 67F
        2 < 67F 40 00 10
        3 < 67F 40 00 10 00
        4 < 67F 23 03 20 00 09 00 00
        5 < 67F 2F 01 21 00
        6 < 67F 2F 01 21 00 07
        7 < 67F 22 03 20 00 09 00
        8 < 67F 22 01 21 00 09
        9 < 67F 40 01 21 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [0]
            0002 < 67F [3] 40 00 10
            0003 < 67F [4] 40 00 10 00
            0003 > 5FF [8] 43 00 10 00 96 01 02 00
            0004 < 67F [7] 23 03 20 00 09 00 00
            0005 < 67F [4] 2F 01 21 00
            0006 < 67F [5] 2F 01 21 00 07
            0006 > 5FF [8] 60 01 21 00 00 00 00 00
            0007 < 67F [6] 22 03 20 00 09 00
            0008 < 67F [5] 22 01 21 00 09
            0008 > 5FF [8] 60 01 21 00 00 00 00 00
            0009 < 67F [8] 40 01 21 00 00 00 00 00
            0009 > 5FF [8] 4F 01 21 00 09 00 00 00
        "#]],
    );
}

/// NM17x SDO-08; decision A-17: the name of 14 characters takes two segments.
#[test]
fn a_text_is_read_in_segments() {
    check(
        "
        0 boot
        1 < 67F 40 08 10 00 00 00 00 00
        2 < 67F 60 00 00 00 00 00 00 00
        3 < 67F 70 00 00 00 00 00 00 00
        4 < 67F 60 00 00 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 40 08 10 00 00 00 00 00
            0001 > 5FF [8] 41 08 10 00 0E 00 00 00
            0002 < 67F [8] 60 00 00 00 00 00 00 00
            0002 > 5FF [8] 00 4E 4D 31 37 32 20 53
            0003 < 67F [8] 70 00 00 00 00 00 00 00
            0003 > 5FF [8] 11 74 61 6E 64 61 72 64
            0004 < 67F [8] 60 00 00 00 00 00 00 00
            0004 > 5FF [8] 80 00 00 00 01 00 04 05
        "#]],
    );
}

/// NM17x SDO-08, DISP-17; decisions A-17, A-19: exactly twelve characters, with or without a size
/// told before.
#[test]
fn a_text_is_written_in_segments() {
    check(
        "
        0 boot
        1 < 67F 21 07 20 00 0C 00 00 00
        2 < 67F 00 48 45 4C 4C 4F 2D 4E
        3 < 67F 15 4D 31 37 32 5F 00 00
        4 < 67F 40 07 20 00 00 00 00 00
        5 < 67F 60 00 00 00 00 00 00 00
        6 < 67F 70 00 00 00 00 00 00 00
        7 < 67F 21 07 20 00 0B 00 00 00
        8 < 67F 20 07 20 00 00 00 00 00
        9 < 67F 0D 41 00 00 00 00 00 00
        10 < 67F 20 07 20 00 00 00 00 00
        11 < 67F 00 41 41 41 41 41 41 41
        12 < 67F 10 41 41 41 41 41 41 41
        13 < 67F 20 08 10 00 00 00 00 00
        14 < 67F 20 07 20 00 00 00 00 00
        15 < 67F 10 41 41 41 41 41 41 41
        16 < 67F 00 41 41 41 41 41 41 41
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 21 07 20 00 0C 00 00 00
            0001 > 5FF [8] 60 07 20 00 00 00 00 00
            0002 < 67F [8] 00 48 45 4C 4C 4F 2D 4E
            0002 > 5FF [8] 20 00 00 00 00 00 00 00
            0003 < 67F [8] 15 4D 31 37 32 5F 00 00
            0003 > 5FF [8] 30 00 00 00 00 00 00 00
            0004 < 67F [8] 40 07 20 00 00 00 00 00
            0004 > 5FF [8] 41 07 20 00 0C 00 00 00
            0005 < 67F [8] 60 00 00 00 00 00 00 00
            0005 > 5FF [8] 00 48 45 4C 4C 4F 2D 4E
            0006 < 67F [8] 70 00 00 00 00 00 00 00
            0006 > 5FF [8] 15 4D 31 37 32 5F 00 00
            0007 < 67F [8] 21 07 20 00 0B 00 00 00
            0007 > 5FF [8] 80 07 20 00 30 00 09 06
            0008 < 67F [8] 20 07 20 00 00 00 00 00
            0008 > 5FF [8] 60 07 20 00 00 00 00 00
            0009 < 67F [8] 0D 41 00 00 00 00 00 00
            0009 > 5FF [8] 80 07 20 00 30 00 09 06
            0010 < 67F [8] 20 07 20 00 00 00 00 00
            0010 > 5FF [8] 60 07 20 00 00 00 00 00
            0011 < 67F [8] 00 41 41 41 41 41 41 41
            0011 > 5FF [8] 20 00 00 00 00 00 00 00
            0012 < 67F [8] 10 41 41 41 41 41 41 41
            0012 > 5FF [8] 80 07 20 00 30 00 09 06
            0013 < 67F [8] 20 08 10 00 00 00 00 00
            0013 > 5FF [8] 80 08 10 00 02 00 01 06
            0014 < 67F [8] 20 07 20 00 00 00 00 00
            0014 > 5FF [8] 60 07 20 00 00 00 00 00
            0015 < 67F [8] 10 41 41 41 41 41 41 41
            0015 > 5FF [8] 80 07 20 00 00 00 03 05
            0016 < 67F [8] 00 41 41 41 41 41 41 41
            0016 > 5FF [8] 80 41 41 41 01 00 04 05
        "#]],
    );
}

/// Decision A-17: a number may come in segments as well.
#[test]
fn a_number_is_written_in_segments() {
    check(
        "
        0 boot
        1 < 67F 21 03 60 00 04 00 00 00
        2 < 67F 07 9C FF FF FF 00 00 00
        3 < 67F 40 03 60 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 21 03 60 00 04 00 00 00
            0001 > 5FF [8] 60 03 60 00 00 00 00 00
            0002 < 67F [8] 07 9C FF FF FF 00 00 00
            0002 > 5FF [8] 20 00 00 00 00 00 00 00
            0003 < 67F [8] 40 03 60 00 00 00 00 00
            0003 > 5FF [8] 43 03 60 00 9C FF FF FF
        "#]],
    );
}

/// Decisions A-17, A-21: toggle, silence, the client's own abort, a new request in the middle, and
/// segments that belong to nothing.
#[test]
fn a_transfer_that_goes_wrong_ends() {
    check(
        "
        0 boot
        1 < 67F 40 08 10 00 00 00 00 00
        2 < 67F 70 00 00 00 00 00 00 00
        3 < 67F 60 00 00 00 00 00 00 00
        4 < 67F 40 08 10 00 00 00 00 00
        500 < 67F 60 00 00 00 00 00 00 00
        2000 < 67F 40 08 10 00 00 00 00 00
        2001 < 67F 80 08 10 00 00 00 04 05
        2002 < 67F 60 00 00 00 00 00 00 00
        2003 < 67F 40 08 10 00 00 00 00 00
        2004 < 67F 40 00 10 00 00 00 00 00
        2005 < 67F 60 00 00 00 00 00 00 00
        2006 < 67F 40 08 10 00 00 00 00 00
        2007 < 67F 00 41 41 41 41 41 41 41
        2008 < 67F 40 08 10 00 00 00 00 00
        2009 < 000 02 00
        5000 < 000 80 00
        5001 < 67F 60 00 00 00 00 00 00 00
        5002 < 67F A0 08 10 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 40 08 10 00 00 00 00 00
            0001 > 5FF [8] 41 08 10 00 0E 00 00 00
            0002 < 67F [8] 70 00 00 00 00 00 00 00
            0002 > 5FF [8] 80 08 10 00 00 00 03 05
            0003 < 67F [8] 60 00 00 00 00 00 00 00
            0003 > 5FF [8] 80 00 00 00 01 00 04 05
            0004 < 67F [8] 40 08 10 00 00 00 00 00
            0004 > 5FF [8] 41 08 10 00 0E 00 00 00
            0500 < 67F [8] 60 00 00 00 00 00 00 00
            0500 > 5FF [8] 00 4E 4D 31 37 32 20 53
            1500 > 5FF [8] 80 08 10 00 00 00 04 05
            2000 < 67F [8] 40 08 10 00 00 00 00 00
            2000 > 5FF [8] 41 08 10 00 0E 00 00 00
            2001 < 67F [8] 80 08 10 00 00 00 04 05
            2002 < 67F [8] 60 00 00 00 00 00 00 00
            2002 > 5FF [8] 80 00 00 00 01 00 04 05
            2003 < 67F [8] 40 08 10 00 00 00 00 00
            2003 > 5FF [8] 41 08 10 00 0E 00 00 00
            2004 < 67F [8] 40 00 10 00 00 00 00 00
            2004 > 5FF [8] 43 00 10 00 96 01 02 00
            2005 < 67F [8] 60 00 00 00 00 00 00 00
            2005 > 5FF [8] 80 00 00 00 01 00 04 05
            2006 < 67F [8] 40 08 10 00 00 00 00 00
            2006 > 5FF [8] 41 08 10 00 0E 00 00 00
            2007 < 67F [8] 00 41 41 41 41 41 41 41
            2007 > 5FF [8] 80 08 10 00 01 00 04 05
            2008 < 67F [8] 40 08 10 00 00 00 00 00
            2008 > 5FF [8] 41 08 10 00 0E 00 00 00
            2009 < 000 [2] 02 00
            2009 * PreOperational to Stopped
            5000 < 000 [2] 80 00
            5000 * Stopped to PreOperational
            5001 < 67F [8] 60 00 00 00 00 00 00 00
            5001 > 5FF [8] 80 00 00 00 01 00 04 05
            5002 < 67F [8] A0 08 10 00 00 00 00 00
            5002 > 5FF [8] 80 08 10 00 01 00 04 05
        "#]],
    );
}

/// CiA 301 gives lengths and limits codes of their own, and ignores bytes beyond the object when no
/// length is told.
#[test]
fn the_standard_has_other_abort_codes() {
    let node = canopen::Node::<LEN>::new(&DICTIONARY, NODE_ID, &Settings::CIA_301);
    let script = "
        0 boot
        1 < 67F 27 03 20 00 01 00 00 00
        2 < 67F 2F 03 20 00 01 00 00 00
        3 < 67F 2B 42 20 03 10 27 00 00
        4 < 67F 2B 42 20 03 F0 D8 00 00
        5 < 67F 22 42 20 03 01 00 01 00
        6 < 67F 23 80 1F 00 04 00 00 00
        7 < 67F 21 07 20 00 0B 00 00 00
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 77F [1] 00
        0001 < 67F [8] 27 03 20 00 01 00 00 00
        0001 > 5FF [8] 80 03 20 00 10 00 07 06
        0002 < 67F [8] 2F 03 20 00 01 00 00 00
        0002 > 5FF [8] 80 03 20 00 10 00 07 06
        0003 < 67F [8] 2B 42 20 03 10 27 00 00
        0003 > 5FF [8] 80 42 20 03 31 00 09 06
        0004 < 67F [8] 2B 42 20 03 F0 D8 00 00
        0004 > 5FF [8] 80 42 20 03 32 00 09 06
        0005 < 67F [8] 22 42 20 03 01 00 01 00
        0005 > 5FF [8] 60 42 20 03 00 00 00 00
        0006 < 67F [8] 23 80 1F 00 04 00 00 00
        0006 > 5FF [8] 80 80 1F 00 30 00 09 06
        0007 < 67F [8] 21 07 20 00 0B 00 00 00
        0007 > 5FF [8] 80 07 20 00 10 00 07 06
    "#]]
    .assert_eq(&transcript(node, &mut Device::new(), script));
}

/// What a master wrote is due at once, whatever the device says between the answer and that.
#[test]
fn nothing_the_device_says_delays_what_a_master_wrote() {
    type Says = fn(&mut Node<LEN>);
    let says: [(&str, Says); 7] = [
        ("an emergency", |node| node.send_emergency(0x8310, [0; 5])),
        ("no errors", |node| node.set_error_register(Instant::ZERO, 0)),
        ("errors", |node| node.set_error_register(Instant::ZERO, 0x81)),
        ("no bus", |node| node.handle_bus(Instant::ZERO, BusState::Off)),
        ("lost frames", |node| node.handle_overrun()),
        ("it is stored", |node| node.handle_stored(Ok(()))),
        ("an event", |node| node.trigger_tpdo(Instant::ZERO, 0)),
    ];
    let heartbeat_time = [0x2B, 0x17, 0x10, 0x00, 0x64, 0x00, 0x00, 0x00];
    let request = Frame::full(CanId::new(0x67F).unwrap(), heartbeat_time);
    for (what, say) in says {
        let mut node = device::node();
        node.boot(Instant::ZERO);
        node.handle_frame(Instant::ZERO, &request, &mut Device::new());
        say(&mut node);
        assert_eq!(node.poll_timeout(), Some(Instant::ZERO), "{what}");
    }
}
