use expect_test::{Expect, expect};

use crate::script::transcript;
use crate::{check, cia_301};

#[track_caller]
fn check_cia_301(script: &str, expected: Expect) {
    expected.assert_eq(&transcript(cia_301::node(), &mut (), script));
}

/// NM17x HB-02, HB-03, HB-04, EMCY-06; decisions A-31, A-33, A-35: nothing happens before the first
/// heartbeat; then each loss is one event, and the next heartbeat ends it.
#[test]
fn a_lost_heartbeat_is_one_event_and_the_next_one_ends_it() {
    check(
        "
        0 boot
        1 < 67F 23 16 10 01 32 00 05 00
        1000 < 705 00
        1040 < 705 7F
        1089 < 705 05
        1090 < 706 05
        1100 remote 705 1
        2000 < 67F 40 01 10 00 00 00 00 00
        2001 < 67F 40 03 10 01 00 00 00 00
        2002 errors 80
        2003 < 705 05
        2004 errors 00
        3000 < 67F 40 01 10 00 00 00 00 00
        3001 < 705 05
        3002 < 67F 40 01 10 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 16 10 01 32 00 05 00
            0001 > 5FF [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            1000 < 705 [1] 00
            1040 < 705 [1] 7F
            1089 < 705 [1] 05
            1090 < 706 [1] 05
            1100 < 705 [1] remote
            1139 * HeartbeatLost { producer: NodeId(5) }
            1139 > 0FF [8] 30 81 11 00 00 00 00 00
            2000 < 67F [8] 40 01 10 00 00 00 00 00
            2000 > 5FF [8] 4F 01 10 00 11 00 00 00
            2001 < 67F [8] 40 03 10 01 00 00 00 00
            2001 > 5FF [8] 43 03 10 01 30 81 00 00
            2003 < 705 [1] 05
            2003 * HeartbeatRecovered { producer: NodeId(5) }
            2004 > 0FF [8] 00 00 00 00 00 00 00 00
            2053 * HeartbeatLost { producer: NodeId(5) }
            2053 > 0FF [8] 30 81 11 00 00 00 00 00
            3000 < 67F [8] 40 01 10 00 00 00 00 00
            3000 > 5FF [8] 4F 01 10 00 11 00 00 00
            3001 < 705 [1] 05
            3001 * HeartbeatRecovered { producer: NodeId(5) }
            3001 > 0FF [8] 00 00 00 00 00 00 00 00
            3002 < 67F [8] 40 01 10 00 00 00 00 00
            3002 > 5FF [8] 4F 01 10 00 00 00 00 00
        "#]],
    );
}

/// NM17x HB-02; decision A-35: writing an entry, be it the same value, starts it anew.
#[test]
fn writing_the_entry_starts_it_anew() {
    check(
        "
        0 boot
        1 < 67F 23 16 10 01 32 00 05 00
        2 < 705 05
        30 < 67F 23 16 10 01 32 00 05 00
        100 < 705 05
        200 < 67F 23 16 10 01 32 00 05 00
        300 < 705 05
        310 < 67F 23 16 10 01 00 00 05 00
        400 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 16 10 01 32 00 05 00
            0001 > 5FF [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 705 [1] 05
            0030 < 67F [8] 23 16 10 01 32 00 05 00
            0030 > 5FF [8] 60 16 10 01 00 00 00 00
            0100 < 705 [1] 05
            0150 * HeartbeatLost { producer: NodeId(5) }
            0150 > 0FF [8] 30 81 11 00 00 00 00 00
            0200 < 67F [8] 23 16 10 01 32 00 05 00
            0200 > 5FF [8] 60 16 10 01 00 00 00 00
            0200 > 0FF [8] 00 00 00 00 00 00 00 00
            0300 < 705 [1] 05
            0310 < 67F [8] 23 16 10 01 00 00 05 00
            0310 > 5FF [8] 60 16 10 01 00 00 00 00
            0310 * FiltersChanged
        "#]],
    );
}

/// CiA 301, section 7.5.2.19: several producers, but each in one entry only.
#[test]
fn entries_monitor_different_producers() {
    check(
        "
        0 boot
        1 < 67F 23 16 10 01 32 00 05 00
        2 < 67F 23 16 10 02 64 00 05 00
        3 < 67F 23 16 10 02 00 00 05 00
        4 < 67F 23 16 10 02 64 00 06 00
        5 < 67F 23 16 10 01 64 00 06 00
        6 < 67F 23 16 10 01 1E 00 05 00
        10 < 705 05
        10 < 706 05
        150 < 706 05
        160 < 705 05
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 16 10 01 32 00 05 00
            0001 > 5FF [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 67F [8] 23 16 10 02 64 00 05 00
            0002 > 5FF [8] 80 16 10 02 43 00 04 06
            0003 < 67F [8] 23 16 10 02 00 00 05 00
            0003 > 5FF [8] 60 16 10 02 00 00 00 00
            0004 < 67F [8] 23 16 10 02 64 00 06 00
            0004 > 5FF [8] 60 16 10 02 00 00 00 00
            0004 * FiltersChanged
            0005 < 67F [8] 23 16 10 01 64 00 06 00
            0005 > 5FF [8] 80 16 10 01 43 00 04 06
            0006 < 67F [8] 23 16 10 01 1E 00 05 00
            0006 > 5FF [8] 60 16 10 01 00 00 00 00
            0010 < 705 [1] 05
            0010 < 706 [1] 05
            0040 * HeartbeatLost { producer: NodeId(5) }
            0040 > 0FF [8] 30 81 11 00 00 00 00 00
            0110 * HeartbeatLost { producer: NodeId(6) }
            0110 > 0FF [8] 30 81 11 00 00 00 00 00
            0150 < 706 [1] 05
            0150 * HeartbeatRecovered { producer: NodeId(6) }
            0160 < 705 [1] 05
            0160 * HeartbeatRecovered { producer: NodeId(5) }
            0160 > 0FF [8] 00 00 00 00 00 00 00 00
        "#]],
    );
}

/// NM17x NMT-06, OD-1029-1; decision A-34: what 0x1029:01 says happens in Operational only.
#[test]
fn the_error_behaviour_says_what_follows_from_a_lost_heartbeat() {
    check(
        "
        0 boot
        1 < 67F 23 16 10 01 0A 00 05 00
        2 < 705 05
        19 < 67F 2F 29 10 01 03 00 00 00
        20 < 000 01 00
        21 < 705 05
        40 < 67F 2F 29 10 01 01 00 00 00
        41 < 000 01 00
        42 < 705 05
        60 < 67F 2F 29 10 01 02 00 00 00
        61 < 705 05
        80 < 705 05
        100 < 000 80 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 16 10 01 0A 00 05 00
            0001 > 5FF [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 705 [1] 05
            0012 * HeartbeatLost { producer: NodeId(5) }
            0012 > 0FF [8] 30 81 11 00 00 00 00 00
            0019 < 67F [8] 2F 29 10 01 03 00 00 00
            0019 > 5FF [8] 80 29 10 01 30 00 09 06
            0020 < 000 [2] 01 00
            0020 * PreOperational to Operational
            0020 > 2FF [8] 00 00 00 00 00 00 00 00
            0021 < 705 [1] 05
            0021 * HeartbeatRecovered { producer: NodeId(5) }
            0021 > 0FF [8] 00 00 00 00 00 00 00 00
            0031 * HeartbeatLost { producer: NodeId(5) }
            0031 * Operational to PreOperational
            0031 > 0FF [8] 30 81 11 00 00 00 00 00
            0040 < 67F [8] 2F 29 10 01 01 00 00 00
            0040 > 5FF [8] 60 29 10 01 00 00 00 00
            0041 < 000 [2] 01 00
            0041 * PreOperational to Operational
            0042 < 705 [1] 05
            0042 * HeartbeatRecovered { producer: NodeId(5) }
            0042 > 0FF [8] 00 00 00 00 00 00 00 00
            0052 * HeartbeatLost { producer: NodeId(5) }
            0052 > 0FF [8] 30 81 11 00 00 00 00 00
            0060 < 67F [8] 2F 29 10 01 02 00 00 00
            0060 > 5FF [8] 60 29 10 01 00 00 00 00
            0061 < 705 [1] 05
            0061 * HeartbeatRecovered { producer: NodeId(5) }
            0061 > 0FF [8] 00 00 00 00 00 00 00 00
            0071 * HeartbeatLost { producer: NodeId(5) }
            0071 * Operational to Stopped
            0071 > 0FF [8] 30 81 11 00 00 00 00 00
            0080 < 705 [1] 05
            0080 * HeartbeatRecovered { producer: NodeId(5) }
            0090 * HeartbeatLost { producer: NodeId(5) }
            0100 < 000 [2] 80 00
            0100 * Stopped to PreOperational
        "#]],
    );
}

/// NM17x OD-1029-2; decision A-34: bit 7 of the error register acts as 0x1029:02 says, when it comes.
#[test]
fn the_error_behaviour_says_what_follows_from_an_error_of_the_device() {
    check(
        "
        0 boot
        1 < 67F 2F 29 10 02 02 00 00 00
        2 errors 81
        3 < 000 01 00
        4 errors 91
        5 errors 11
        6 errors 91
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 2F 29 10 02 02 00 00 00
            0001 > 5FF [8] 60 29 10 02 00 00 00 00
            0003 < 000 [2] 01 00
            0003 * PreOperational to Operational
            0003 > 2FF [8] 00 00 00 00 00 00 00 00
            0006 * Operational to Stopped
        "#]],
    );
}

/// CiA 301, section 7.2.8.3.2.2: a heartbeat that is due with the loss of a producer tells the state
/// that follows from it, as it leaves behind the emergency message.
#[test]
fn a_heartbeat_tells_the_state_after_a_loss() {
    check_cia_301(
        "
        0 boot
        1 < 605 23 16 10 01 64 00 07 00
        2 < 605 2F 29 10 01 00 00 00 00
        3 < 000 01 05
        10 < 605 2B 17 10 00 64 00 00 00
        10 < 707 05
        150 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 16 10 01 64 00 07 00
            0001 > 585 [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 2F 29 10 01 00 00 00 00
            0002 > 585 [8] 60 29 10 01 00 00 00 00
            0003 < 000 [2] 01 05
            0003 * PreOperational to Operational
            0010 < 605 [8] 2B 17 10 00 64 00 00 00
            0010 > 585 [8] 60 17 10 00 00 00 00 00
            0010 > 705 [1] 05
            0010 < 707 [1] 05
            0110 * HeartbeatLost { producer: NodeId(7) }
            0110 * Operational to PreOperational
            0110 > 085 [8] 30 81 11 00 00 00 00 00
            0110 > 705 [1] 7F
        "#]],
    );
}

/// What was due with the loss of a producer that resets the node is not: SYNC and heartbeat.
#[test]
fn a_node_that_a_loss_resets_is_silent() {
    check_cia_301(
        "
        0 boot
        1 < 605 23 16 10 01 64 00 07 00
        2 < 605 2F 29 10 01 03 00 00 00
        3 < 605 23 06 10 00 A0 86 01 00
        4 < 000 01 05
        10 < 605 23 05 10 00 80 00 00 40
        10 < 605 2B 17 10 00 64 00 00 00
        10 < 707 05
        400 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 23 16 10 01 64 00 07 00
            0001 > 585 [8] 60 16 10 01 00 00 00 00
            0001 * FiltersChanged
            0002 < 605 [8] 2F 29 10 01 03 00 00 00
            0002 > 585 [8] 60 29 10 01 00 00 00 00
            0003 < 605 [8] 23 06 10 00 A0 86 01 00
            0003 > 585 [8] 60 06 10 00 00 00 00 00
            0004 < 000 [2] 01 05
            0004 * PreOperational to Operational
            0010 < 605 [8] 23 05 10 00 80 00 00 40
            0010 > 585 [8] 60 05 10 00 00 00 00 00
            0010 < 605 [8] 2B 17 10 00 64 00 00 00
            0010 > 585 [8] 60 17 10 00 00 00 00 00
            0010 > 705 [1] 05
            0010 < 707 [1] 05
            0110 * HeartbeatLost { producer: NodeId(7) }
            0110 * ResetNode
        "#]],
    );
}
