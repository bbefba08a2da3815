use canopen::{Node, NodeId, Settings};
use expect_test::{Expect, expect};

use crate::cia_301;
use crate::script::transcript;

#[track_caller]
fn check(script: &str, expected: Expect) {
    expected.assert_eq(&transcript(cia_301::node(), &mut (), script));
}

/// Conformance cases 7.2, 7.3 and 7.203; encoder EN-NG-01: every request is answered, in every
/// state, and the toggle bit alternates from 0 on.
#[test]
fn every_request_is_answered_with_the_state_and_a_toggle_bit() {
    check(
        "
        0 boot
        10 remote 705 1
        20 remote 705 1
        30 remote 705 0
        40 < 000 02 05
        50 remote 705 1
        60 < 000 01 00
        70 remote 705 8
        80 remote 706 1
        90 < 705 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0010 < 705 [1] remote
            0010 > 705 [1] 7F
            0020 < 705 [1] remote
            0020 > 705 [1] FF
            0030 < 705 [0] remote
            0030 > 705 [1] 7F
            0040 < 000 [2] 02 05
            0040 * PreOperational to Stopped
            0050 < 705 [1] remote
            0050 > 705 [1] 84
            0060 < 000 [2] 01 00
            0060 * Stopped to Operational
            0070 < 705 [8] remote
            0070 > 705 [1] 05
            0080 < 706 [1] remote
            0090 < 705 [1] 00
        "#]],
    );
}

/// CiA 305: a device without a node-ID is not guarded, also by the one it had. This one shares its low
/// bits with the identifier of layer setting services, which it listens to.
#[test]
fn nobody_guards_a_device_without_a_node_id() {
    let node_id = NodeId::new(0x65).expect("101 is a node-ID");
    let node = Node::<{ cia_301::LEN }>::new(&cia_301::DICTIONARY, node_id, &Settings::CIA_301);
    expect![[r#"
        0010 < 765 [1] remote
    "#]]
    .assert_eq(&transcript(node, &mut (), "0 wait\n10 remote 765 1"));
}

/// Conformance cases 7.5 and 7.6; encoder EN-NG-02, decision B-30: life guarding starts with the
/// first request, every request renews it, and the next one ends the loss.
#[test]
fn a_master_that_stays_away_is_an_event() {
    check(
        "
        0 boot
        1 < 605 2B 0C 10 00 64 00 00 00
        2 < 605 2F 0D 10 00 02 00 00 00
        3 < 605 40 0C 10 00 00 00 00 00
        4 < 605 40 0D 10 00 00 00 00 00
        1000 remote 705 1
        1150 remote 705 1
        1349 end
        2000 < 605 40 01 10 00 00 00 00 00
        2100 remote 705 1
        2150 < 605 2F 0D 10 00 00 00 00 00
        4000 remote 705 1
        9000 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2B 0C 10 00 64 00 00 00
            0001 > 585 [8] 60 0C 10 00 00 00 00 00
            0002 < 605 [8] 2F 0D 10 00 02 00 00 00
            0002 > 585 [8] 60 0D 10 00 00 00 00 00
            0003 < 605 [8] 40 0C 10 00 00 00 00 00
            0003 > 585 [8] 4B 0C 10 00 64 00 00 00
            0004 < 605 [8] 40 0D 10 00 00 00 00 00
            0004 > 585 [8] 4F 0D 10 00 02 00 00 00
            1000 < 705 [1] remote
            1000 > 705 [1] 7F
            1150 < 705 [1] remote
            1150 > 705 [1] FF
            1350 * GuardingLost
            1350 > 085 [8] 30 81 11 00 00 00 00 00
            2000 < 605 [8] 40 01 10 00 00 00 00 00
            2000 > 585 [8] 4F 01 10 00 11 00 00 00
            2100 < 705 [1] remote
            2100 * GuardingRecovered
            2100 > 085 [8] 00 00 00 00 00 00 00 00
            2100 > 705 [1] 7F
            2150 < 605 [8] 2F 0D 10 00 00 00 00 00
            2150 > 585 [8] 60 0D 10 00 00 00 00 00
            4000 < 705 [1] remote
            4000 > 705 [1] FF
        "#]],
    );
}

/// Conformance cases 7.202 to 7.207: a node that sends heartbeats answers no request, and its
/// master may stop asking.
#[test]
fn heartbeats_go_before_guarding() {
    check(
        "
        0 boot
        1 < 605 2B 0C 10 00 64 00 00 00
        2 < 605 2F 0D 10 00 02 00 00 00
        100 remote 705 1
        200 < 605 2B 17 10 00 C8 00 00 00
        300 remote 705 1
        650 < 605 2B 17 10 00 00 00 00 00
        900 remote 705 1
        1200 end
        1300 < 605 2B 17 10 00 F4 01 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2B 0C 10 00 64 00 00 00
            0001 > 585 [8] 60 0C 10 00 00 00 00 00
            0002 < 605 [8] 2F 0D 10 00 02 00 00 00
            0002 > 585 [8] 60 0D 10 00 00 00 00 00
            0100 < 705 [1] remote
            0100 > 705 [1] 7F
            0200 < 605 [8] 2B 17 10 00 C8 00 00 00
            0200 > 585 [8] 60 17 10 00 00 00 00 00
            0200 > 705 [1] 7F
            0300 < 705 [1] remote
            0400 > 705 [1] 7F
            0600 > 705 [1] 7F
            0650 < 605 [8] 2B 17 10 00 00 00 00 00
            0650 > 585 [8] 60 17 10 00 00 00 00 00
            0900 < 705 [1] remote
            0900 > 705 [1] FF
            1100 * GuardingLost
            1100 > 085 [8] 30 81 11 00 00 00 00 00
            1300 < 605 [8] 2B 17 10 00 F4 01 00 00
            1300 > 585 [8] 60 17 10 00 00 00 00 00
            1300 > 085 [8] 00 00 00 00 00 00 00 00
            1300 > 705 [1] 7F
        "#]],
    );
}

/// Encoder EN-ERR-02: what 0x1029:01 says happens when the master stays away.
#[test]
fn the_error_behaviour_says_what_follows() {
    check(
        "
        0 boot
        1 < 605 2B 0C 10 00 0A 00 00 00
        2 < 605 2F 0D 10 00 01 00 00 00
        3 < 605 2F 29 10 01 02 00 00 00
        10 < 000 01 00
        11 remote 705 1
        50 remote 705 1
        100 < 000 82 00
        150 remote 705 1
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2B 0C 10 00 0A 00 00 00
            0001 > 585 [8] 60 0C 10 00 00 00 00 00
            0002 < 605 [8] 2F 0D 10 00 01 00 00 00
            0002 > 585 [8] 60 0D 10 00 00 00 00 00
            0003 < 605 [8] 2F 29 10 01 02 00 00 00
            0003 > 585 [8] 60 29 10 01 00 00 00 00
            0010 < 000 [2] 01 00
            0010 * PreOperational to Operational
            0011 < 705 [1] remote
            0011 > 705 [1] 05
            0021 * GuardingLost
            0021 * Operational to Stopped
            0021 > 085 [8] 30 81 11 00 00 00 00 00
            0050 < 705 [1] remote
            0050 * GuardingRecovered
            0050 > 705 [1] 84
            0060 * GuardingLost
            0100 < 000 [2] 82 00
            0100 * ResetCommunication
            0150 < 705 [1] remote
        "#]],
    );
}
