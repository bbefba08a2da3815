use canopen::{Accepted, PdoRules, RemoteRequests, Settings, SyncDivision};
use expect_test::{Expect, expect};

use crate::configurable::node;
use crate::script::transcript;

/// A device that answers remote frames only where its type says so, and goes with every SYNC.
static RESTRICTED: Settings = Settings {
    pdo: PdoRules {
        remote_requests: RemoteRequests::RemoteTypes,
        sync_division: SyncDivision::None,
        ..Settings::CIA_301.pdo
    },
    ..Settings::CIA_301
};

#[track_caller]
fn check(script: &str, expected: Expect) {
    expected.assert_eq(&transcript(node(&Settings::CIA_301), &mut (), script));
}

/// Conformance cases 3.7, 3.13 and 3.19: type 0 goes out with the SYNC that follows a change, or an
/// event of the product, and with no other.
#[test]
fn type_0_waits_for_a_sync_after_an_event() {
    check(
        "
        0 set 1800:02 0
        0 boot
        1 < 080
        2 < 000 01 00
        3 < 080
        4 < 080
        5 set 6000:01 -2
        6 set 6000:01 -3
        7 < 080
        8 < 080
        9 set 6000:03 1
        10 < 080
        11 trigger 0
        12 < 080
        13 < 080
        14 trigger 1
        15 < 080
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 080 [0]
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0003 < 080 [0]
            0003 > 185 [3] 00 00 00
            0004 < 080 [0]
            0007 < 080 [0]
            0007 > 185 [3] FD FF 00
            0008 < 080 [0]
            0010 < 080 [0]
            0012 < 080 [0]
            0012 > 185 [3] FD FF 00
            0013 < 080 [0]
            0015 < 080 [0]
        "#]],
    );
}

/// Conformance cases 3.3 and 3.15; CiA 301, section 7.5.2.37: type 252 answers a remote frame with
/// what the last SYNC found.
#[test]
fn type_252_answers_with_the_data_of_the_last_sync() {
    check(
        "
        0 set 1800:02 252
        0 boot
        1 < 000 01 00
        2 set 6000:02 1
        3 remote 185 3
        4 < 080
        5 set 6000:02 2
        6 remote 185 3
        7 < 080
        8 remote 185 0
        9 trigger 0
        10 < 000 80 00
        11 < 000 01 00
        12 set 6000:02 3
        13 remote 185 3
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0003 < 185 [3] remote
            0003 > 185 [3] 00 00 01
            0004 < 080 [0]
            0006 < 185 [3] remote
            0006 > 185 [3] 00 00 01
            0007 < 080 [0]
            0008 < 185 [0] remote
            0008 > 185 [3] 00 00 02
            0010 < 000 [2] 80 00
            0010 * Operational to PreOperational
            0011 < 000 [2] 01 00
            0011 * PreOperational to Operational
            0013 < 185 [3] remote
            0013 > 185 [3] 00 00 03
        "#]],
    );
}

/// AP04 AP-PDO-05; conformance cases 3.3, 3.9 and 3.15: type 253 answers remote frames in
/// Operational, and does nothing else.
#[test]
fn type_253_answers_in_operational_alone() {
    check(
        "
        0 set 1800:02 253
        0 boot
        1 remote 185 3
        2 < 000 01 00
        3 set 6000:02 1
        4 < 080
        5 remote 185 3
        6 remote 186 3
        7 remote 285 4
        8 < 000 02 00
        9 remote 185 3
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 185 [3] remote
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0004 < 080 [0]
            0005 < 185 [3] remote
            0005 > 185 [3] 00 00 01
            0006 < 186 [3] remote
            0007 < 285 [4] remote
            0008 < 000 [2] 02 00
            0008 * Operational to Stopped
            0009 < 185 [3] remote
        "#]],
    );
}

/// Conformance case 3.15; CiA 301, section 7.5.2.37: a remote frame is answered at once, inside the
/// inhibit time too, and the change that waited has gone out with the answer. Bit 30 forbids it.
#[test]
fn an_event_driven_pdo_answers_remote_frames_at_once() {
    check(
        "
        0 set 1800:03 1000
        0 boot
        1 < 000 01 00
        10 set 6000:02 1
        20 remote 185 3
        110 set 6000:02 2
        200 end
        300 < 605 23 00 18 01 85 01 00 80
        301 < 605 23 00 18 01 85 01 00 40
        302 remote 185 3
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 185 [3] 00 00 00
            0020 < 185 [3] remote
            0020 > 185 [3] 00 00 01
            0120 > 185 [3] 00 00 02
            0300 < 605 [8] 23 00 18 01 85 01 00 80
            0300 > 585 [8] 60 00 18 01 00 00 00 00
            0300 * FiltersChanged
            0301 < 605 [8] 23 00 18 01 85 01 00 40
            0301 > 585 [8] 60 00 18 01 00 00 00 00
            0301 > 185 [3] 00 00 02
            0302 < 185 [3] remote
        "#]],
    );
}

/// AP04 AP-PDO-04, AP-PDO-05: with types 1 to 240 remote frames are ignored, and every SYNC counts.
#[test]
fn a_product_restricts_remote_frames_and_the_division_of_sync() {
    let script = "
        0 set 1800:02 3
        0 boot
        1 < 000 01 00
        2 remote 185 3
        3 < 080
        4 < 080
        5 < 605 2F 00 18 02 FD 00 00 00
        6 < 080
        7 remote 185 3
        8 < 605 2F 00 18 02 01 00 00 00
        9 remote 185 3
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 000 [2] 01 00
        0001 * PreOperational to Operational
        0002 < 185 [3] remote
        0003 < 080 [0]
        0003 > 185 [3] 00 00 00
        0004 < 080 [0]
        0004 > 185 [3] 00 00 00
        0005 < 605 [8] 2F 00 18 02 FD 00 00 00
        0005 > 585 [8] 60 00 18 02 00 00 00 00
        0005 * FiltersChanged
        0006 < 080 [0]
        0007 < 185 [3] remote
        0007 > 185 [3] 00 00 00
        0008 < 605 [8] 2F 00 18 02 01 00 00 00
        0008 > 585 [8] 60 00 18 02 00 00 00 00
        0008 * FiltersChanged
        0009 < 185 [3] remote
    "#]]
    .assert_eq(&transcript(node(&RESTRICTED), &mut (), script));
}

/// Conformance cases 3.8, 3.14 and 3.20; CiA 301, section 7.5.2.37, sub-index 6: the SYNC with the
/// start value counts as the first, each time the node becomes Operational.
#[test]
fn the_start_value_says_which_sync_is_the_first() {
    check(
        "
        0 set 1800:02 2, 1800:06 3, 1019:00 4
        0 boot
        1 < 000 01 00
        2 < 080 02
        3 < 080 03
        4 < 080 04
        5 < 080 01
        6 < 080 02
        7 < 000 80 00
        8 < 000 01 00
        9 < 080 04
        10 < 080 01
        11 < 080 03
        12 < 080 04
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0002 < 080 [1] 02
            0003 < 080 [1] 03
            0004 < 080 [1] 04
            0004 > 185 [3] 00 00 00
            0005 < 080 [1] 01
            0006 < 080 [1] 02
            0006 > 185 [3] 00 00 00
            0007 < 000 [2] 80 00
            0007 * Operational to PreOperational
            0008 < 000 [2] 01 00
            0008 * PreOperational to Operational
            0009 < 080 [1] 04
            0010 < 080 [1] 01
            0011 < 080 [1] 03
            0012 < 080 [1] 04
            0012 > 185 [3] 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.37, sub-index 6: a SYNC without a counter counts from the start.
#[test]
fn the_start_value_means_nothing_without_a_counter() {
    check(
        "
        0 set 1800:02 2, 1800:06 3
        0 boot
        1 < 000 01 00
        2 < 080
        3 < 080
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0002 < 080 [0]
            0003 < 080 [0]
            0003 > 185 [3] 00 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.37: an event of the product goes out like a change, when the inhibit time
/// permits it.
#[test]
fn an_event_of_the_product_needs_no_change() {
    check(
        "
        0 set 1800:03 100
        0 boot
        1 trigger 0
        2 < 000 01 00
        3 trigger 0
        50 trigger 0
        60 trigger 3
        70 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0002 < 000 [2] 01 00
            0002 * PreOperational to Operational
            0002 > 185 [3] 00 00 00
            0012 > 185 [3] 00 00 00
            0050 > 185 [3] 00 00 00
        "#]],
    );
}

/// Conformance cases 3.4 to 3.8; CiA 301, sections 7.5.2.35 and 7.5.2.37: what a valid PDO keeps,
/// and what none can be. Each refusal leaves the value as it was.
#[test]
fn parameters_change_while_the_pdo_is_off() {
    check(
        "
        0 boot
        1 < 605 2B 00 18 03 01 00 00 00
        2 < 605 2F 00 18 06 01 00 00 00
        3 < 605 23 00 18 01 86 01 00 00
        4 < 605 23 00 18 01 85 01 00 40
        5 < 605 23 00 18 01 00 00 00 80
        6 < 605 23 00 18 01 80 01 00 00
        7 < 605 23 00 18 01 86 01 00 A0
        8 < 605 2B 00 18 03 01 00 00 00
        9 < 605 2F 00 18 06 F0 00 00 00
        10 < 605 2F 00 18 06 F1 00 00 00
        11 < 605 23 00 18 01 86 01 00 00
        12 < 605 40 00 18 01 00 00 00 00
        20 < 605 2F 00 18 02 F1 00 00 00
        21 < 605 2F 00 18 02 FB 00 00 00
        22 < 605 2F 00 18 02 00 00 00 00
        23 < 605 2F 00 18 02 FC 00 00 00
        24 < 605 2F 00 18 02 FD 00 00 00
        30 < 605 2B 00 14 03 01 00 00 00
        31 < 605 23 00 14 01 06 02 00 00
        32 < 605 2F 00 14 02 FD 00 00 00
        33 < 605 23 00 14 01 05 02 00 80
        34 < 605 2B 00 14 03 01 00 00 00
        35 < 605 23 00 14 01 06 02 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 705 [1] 00
            0001 < 605 [8] 2B 00 18 03 01 00 00 00
            0001 > 585 [8] 80 00 18 03 30 00 09 06
            0002 < 605 [8] 2F 00 18 06 01 00 00 00
            0002 > 585 [8] 80 00 18 06 30 00 09 06
            0003 < 605 [8] 23 00 18 01 86 01 00 00
            0003 > 585 [8] 80 00 18 01 30 00 09 06
            0004 < 605 [8] 23 00 18 01 85 01 00 40
            0004 > 585 [8] 60 00 18 01 00 00 00 00
            0004 * FiltersChanged
            0005 < 605 [8] 23 00 18 01 00 00 00 80
            0005 > 585 [8] 60 00 18 01 00 00 00 00
            0006 < 605 [8] 23 00 18 01 80 01 00 00
            0006 > 585 [8] 80 00 18 01 30 00 09 06
            0007 < 605 [8] 23 00 18 01 86 01 00 A0
            0007 > 585 [8] 80 00 18 01 30 00 09 06
            0008 < 605 [8] 2B 00 18 03 01 00 00 00
            0008 > 585 [8] 60 00 18 03 00 00 00 00
            0009 < 605 [8] 2F 00 18 06 F0 00 00 00
            0009 > 585 [8] 60 00 18 06 00 00 00 00
            0010 < 605 [8] 2F 00 18 06 F1 00 00 00
            0010 > 585 [8] 80 00 18 06 30 00 09 06
            0011 < 605 [8] 23 00 18 01 86 01 00 00
            0011 > 585 [8] 60 00 18 01 00 00 00 00
            0011 * FiltersChanged
            0012 < 605 [8] 40 00 18 01 00 00 00 00
            0012 > 585 [8] 43 00 18 01 86 01 00 00
            0020 < 605 [8] 2F 00 18 02 F1 00 00 00
            0020 > 585 [8] 80 00 18 02 30 00 09 06
            0021 < 605 [8] 2F 00 18 02 FB 00 00 00
            0021 > 585 [8] 80 00 18 02 30 00 09 06
            0022 < 605 [8] 2F 00 18 02 00 00 00 00
            0022 > 585 [8] 60 00 18 02 00 00 00 00
            0023 < 605 [8] 2F 00 18 02 FC 00 00 00
            0023 > 585 [8] 60 00 18 02 00 00 00 00
            0024 < 605 [8] 2F 00 18 02 FD 00 00 00
            0024 > 585 [8] 60 00 18 02 00 00 00 00
            0030 < 605 [8] 2B 00 14 03 01 00 00 00
            0030 > 585 [8] 80 00 14 03 30 00 09 06
            0031 < 605 [8] 23 00 14 01 06 02 00 00
            0031 > 585 [8] 80 00 14 01 30 00 09 06
            0032 < 605 [8] 2F 00 14 02 FD 00 00 00
            0032 > 585 [8] 80 00 14 02 30 00 09 06
            0033 < 605 [8] 23 00 14 01 05 02 00 80
            0033 > 585 [8] 60 00 14 01 00 00 00 00
            0033 * FiltersChanged
            0034 < 605 [8] 2B 00 14 03 01 00 00 00
            0034 > 585 [8] 60 00 14 03 00 00 00 00
            0035 < 605 [8] 23 00 14 01 06 02 00 00
            0035 > 585 [8] 60 00 14 01 00 00 00 00
            0035 * FiltersChanged
        "#]],
    );
}

/// AP04 AP-PDO-05: controllers filter for the remote frames that are answered, and no others.
#[test]
fn remote_frames_are_accepted_where_they_are_answered() {
    let remote = |settings| -> Vec<u16> {
        let node = node(settings);
        let remote = node.accepts().filter(|&Accepted { remote, .. }| remote);
        remote.map(|accepted| accepted.id.get()).collect()
    };
    assert_eq!(remote(&Settings::CIA_301), [0x185]);
    assert_eq!(remote(&RESTRICTED), []);
}
