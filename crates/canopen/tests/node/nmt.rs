use canopen::{Settings, lss};
use expect_test::expect;

use crate::script::transcript;
use crate::{check, configurable, device};

/// NM17x BOOT-03, NMT-03.
#[test]
fn boot_up_is_the_first_and_only_frame() {
    check(
        "
        0 < 000 01 7F
        0 < 67F 40 00 10 00 00 00 00 00
        5 boot
        6 boot
        9000 end
        ",
        expect![[r#"
            0000 < 000 [2] 01 7F
            0000 < 67F [8] 40 00 10 00 00 00 00 00
            0005 * Initialising to PreOperational
            0005 > 77F [1] 00
        "#]],
    );
}

/// NM17x BOOT-04, NMT-05.
#[test]
fn a_self_starting_node_becomes_operational() {
    check(
        "
        0 set 1F80:00 8
        5 boot
        ",
        expect![[r#"
            0005 * Initialising to PreOperational
            0005 * PreOperational to Operational
            0005 > 77F [1] 00
            0005 > 2FF [8] 00 00 00 00 00 00 00 00
        "#]],
    );
}

/// NM17x NMT-01, NMT-02, NMT-04, SDO-07; decision A-36.
#[test]
fn commands_change_the_state_and_the_state_says_what_is_served() {
    check(
        "
        0 boot
        10 < 67F 40 00 10 00 00 00 00 00
        20 < 000 01 7F
        21 < 67F 40 00 10 00 00 00 00 00
        30 < 000 02 00
        31 < 67F 40 00 10 00 00 00 00 00
        32 set 6004:00 5
        40 < 000 80 7F
        41 < 67F 40 00 10 00 00 00 00 00
        50 < 000 80 00
        51 < 000 01 01
        52 < 000 01
        53 < 000 01 7F 00
        54 < 000 7F 7F
        55 remote 000 2
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0010 < 67F [8] 40 00 10 00 00 00 00 00
            0010 > 5FF [8] 43 00 10 00 96 01 02 00
            0020 < 000 [2] 01 7F
            0020 * PreOperational to Operational
            0020 > 2FF [8] 00 00 00 00 00 00 00 00
            0021 < 67F [8] 40 00 10 00 00 00 00 00
            0021 > 5FF [8] 43 00 10 00 96 01 02 00
            0030 < 000 [2] 02 00
            0030 * Operational to Stopped
            0031 < 67F [8] 40 00 10 00 00 00 00 00
            0040 < 000 [2] 80 7F
            0040 * Stopped to PreOperational
            0041 < 67F [8] 40 00 10 00 00 00 00 00
            0041 > 5FF [8] 43 00 10 00 96 01 02 00
            0050 < 000 [2] 80 00
            0051 < 000 [2] 01 01
            0052 < 000 [1] 01
            0053 < 000 [3] 01 7F 00
            0054 < 000 [2] 7F 7F
            0055 < 000 [2] remote
        "#]],
    );
}

/// NM17x NMT-02, NMT-07.
#[test]
fn after_a_reset_command_the_node_is_silent_and_deaf() {
    for (command, event) in [("81", "ResetNode"), ("82", "ResetCommunication")] {
        let script = format!(
            "
            0 set 1017:00 10
            0 boot
            1 < 000 01 00
            5 < 000 {command} 7F
            6 < 000 01 7F
            7 < 67F 40 00 10 00 00 00 00 00
            8 set 6004:00 1
            100 end
            "
        );
        let transcript =
            crate::script::transcript(device::node(), &mut device::Device::new(), &script);
        let end: Vec<&str> = transcript.lines().skip(5).collect();
        let event = format!("0005 * {event}");
        assert_eq!(
            end,
            [
                &format!("0005 < 000 [2] {command} 7F"),
                &event,
                "0006 < 000 [2] 01 7F",
                "0007 < 67F [8] 40 00 10 00 00 00 00 00",
            ]
        );
    }
}

/// NM17x HB-01.
#[test]
fn the_heartbeat_names_the_state_and_a_new_period_acts_at_once() {
    check(
        "
        0 set 1017:00 100
        0 boot
        150 < 000 01 00
        250 < 000 02 00
        350 < 000 80 00
        420 < 67F 2B 17 10 00 1E 00 00 00
        500 < 67F 2B 17 10 00 00 00 00 00
        900 end
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0100 > 77F [1] 7F
            0150 < 000 [2] 01 00
            0150 * PreOperational to Operational
            0150 > 2FF [8] 00 00 00 00 00 00 00 00
            0200 > 77F [1] 05
            0250 < 000 [2] 02 00
            0250 * Operational to Stopped
            0300 > 77F [1] 04
            0350 < 000 [2] 80 00
            0350 * Stopped to PreOperational
            0400 > 77F [1] 7F
            0420 < 67F [8] 2B 17 10 00 1E 00 00 00
            0420 > 5FF [8] 60 17 10 00 00 00 00 00
            0420 > 77F [1] 7F
            0450 > 77F [1] 7F
            0480 > 77F [1] 7F
            0500 < 67F [8] 2B 17 10 00 00 00 00 00
            0500 > 5FF [8] 60 17 10 00 00 00 00 00
        "#]],
    );
}

/// NM17x GEN-04: another node's frames, reserved ones and remote frames mean nothing.
#[test]
fn foreign_frames_mean_nothing() {
    check(
        "
        0 boot
        1 < 67E 40 00 10 00 00 00 00 00
        2 < 601 40 00 10 00 00 00 00 00
        3 < 5FF 40 00 10 00 00 00 00 00
        4 < 77F 05
        5 < 7E5 04 01
        6 remote 67F 8
        7 remote 77F 1
        8 remote 2FF 8
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67E [8] 40 00 10 00 00 00 00 00
            0002 < 601 [8] 40 00 10 00 00 00 00 00
            0003 < 5FF [8] 40 00 10 00 00 00 00 00
            0004 < 77F [1] 05
            0005 < 7E5 [2] 04 01
            0006 < 67F [8] remote
            0007 < 77F [1] remote
            0008 < 2FF [8] remote
        "#]],
    );
}

/// NM17x OD-1005-1; decisions A-03, A-04: a new SYNC identifier is a new acceptance filter.
#[test]
fn a_new_sync_identifier_changes_the_filters() {
    check(
        "
        0 boot
        1 < 67F 23 05 10 00 90 00 00 00
        2 < 67F 23 05 10 00 90 00 00 80
        3 < 67F 23 05 10 00 80 00 00 40
        4 < 67F 23 05 10 00 80 00 00 20
        5 < 67F 23 05 10 00 00 00 00 00
        6 < 67F 40 05 10 00 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 67F [8] 23 05 10 00 90 00 00 00
            0001 > 5FF [8] 60 05 10 00 00 00 00 00
            0001 * FiltersChanged
            0002 < 67F [8] 23 05 10 00 90 00 00 80
            0002 > 5FF [8] 60 05 10 00 00 00 00 00
            0003 < 67F [8] 23 05 10 00 80 00 00 40
            0003 > 5FF [8] 80 05 10 00 30 00 09 06
            0004 < 67F [8] 23 05 10 00 80 00 00 20
            0004 > 5FF [8] 80 05 10 00 30 00 09 06
            0005 < 67F [8] 23 05 10 00 00 00 00 00
            0005 > 5FF [8] 80 05 10 00 30 00 09 06
            0006 < 67F [8] 40 05 10 00 00 00 00 00
            0006 > 5FF [8] 43 05 10 00 90 00 00 80
        "#]],
    );
    let mut node = crate::device::node();
    let accepted = |node: &canopen::Node<{ crate::device::LEN }>| {
        node.accepts().map(|accepted| accepted.id.get()).collect::<Vec<u16>>()
    };
    assert_eq!(accepted(&node), [0x000, 0x080, 0x67F, 0x201, 0x37F, 0x301]);
    let sync = object_dictionary::ObjectId { index: 0x1005, sub: 0 };
    let slot = crate::device::DICTIONARY.find(sync).unwrap();
    node.set_value(units::Instant::ZERO, slot, 0x90);
    assert_eq!(accepted(&node), [0x000, 0x090, 0x67F, 0x201, 0x37F, 0x301]);
}

/// CiA 305: a device whose node-ID was taken away listens to layer setting services, and
/// to nothing else until it has another.
#[test]
fn a_node_waits_for_its_node_id() {
    static SETTINGS: Settings =
        Settings { lss: Some(&lss::Settings::CIA_305), ..Settings::CIA_301 };
    let transcript = transcript(
        configurable::node(&SETTINGS),
        &mut (),
        "
        0 wait
        1 < 000 01 00
        2 < 605 40 00 10 00 00 00 00 00
        3 remote 705 1
        4 < 7E5 4C 00 00 00 00 00 00 00
        5 < 7E5 04 01 00 00 00 00 00 00
        6 < 7E5 5E 00 00 00 00 00 00 00
        7 < 7E5 11 2A 00 00 00 00 00 00
        8 < 7E5 17 00 00 00 00 00 00 00
        9 < 7E5 04 00 00 00 00 00 00 00
        ",
    );
    expect![[r#"
        0001 < 000 [2] 01 00
        0002 < 605 [8] 40 00 10 00 00 00 00 00
        0003 < 705 [1] remote
        0004 < 7E5 [8] 4C 00 00 00 00 00 00 00
        0004 > 7E4 [8] 50 00 00 00 00 00 00 00
        0005 < 7E5 [8] 04 01 00 00 00 00 00 00
        0006 < 7E5 [8] 5E 00 00 00 00 00 00 00
        0006 > 7E4 [8] 5E FF 00 00 00 00 00 00
        0007 < 7E5 [8] 11 2A 00 00 00 00 00 00
        0007 > 7E4 [8] 11 00 00 00 00 00 00 00
        0008 < 7E5 [8] 17 00 00 00 00 00 00 00
        0008 * Lss(Store { node_id: Some(NodeId(42)), bit_rate: None })
        0009 < 7E5 [8] 04 00 00 00 00 00 00 00
        0009 * Lss(Configured { node_id: NodeId(42) })
    "#]]
    .assert_eq(&transcript);
}
