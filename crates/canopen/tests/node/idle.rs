//! A node that was left alone for long is as one that was left alone for a second. Deadlines have 32
//! bits of microseconds: what stayed behind from before would seem to lie ahead after 36 minutes,
//! and to be over again after 72.

use std::fmt::Write as _;

use canopen::{Application, Node};
use expect_test::{Expect, expect};

use crate::script::transcript;
use crate::{cia_301, device};

const MINUTE_MS: u64 = 60_000;

/// When the idle time begins.
const IDLE_FROM_MS: u64 = 10_000;

/// How long the node is left alone. An interpreter takes minutes for each hour of heartbeats, and
/// sees no other accesses to memory in the second one.
const IDLE_MINUTES: &[u64] = if cfg!(miri) { &[1] } else { &[1, 35, 36, 50, 71, 72, 100, 108] };

/// What a node does after the idle time, in milliseconds from its end. Both parts of the script begin
/// at 0.
fn after<A: Application, const LEN: usize>(
    mut application: A,
    node: Node<LEN>,
    idle_ms: u64,
    before: &str,
    after: &str,
) -> String {
    let from_ms = IDLE_FROM_MS + idle_ms;
    let mut script = before.to_owned();
    for line in after.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (ms, step) = line.split_once(' ').unwrap();
        writeln!(script, "\n{} {step}", from_ms + ms.parse::<u64>().unwrap()).unwrap();
    }
    let all = transcript(node, &mut application, &script);
    let mut shown = String::new();
    for line in all.lines() {
        let (ms, what) = line.split_once(' ').unwrap();
        if let Some(ms) = ms.parse::<u64>().unwrap().checked_sub(from_ms) {
            writeln!(shown, "{ms:04} {what}").unwrap();
        }
    }
    shown
}

#[track_caller]
fn check<A: Application, const LEN: usize>(
    parts: impl Fn() -> (A, Node<LEN>),
    before: &str,
    then: &str,
    expected: Expect,
) {
    let idle = |idle_ms| {
        let (application, node) = parts();
        after(application, node, idle_ms, before, then)
    };
    let short = idle(1_000);
    for minutes in IDLE_MINUTES {
        assert_eq!(idle(minutes * MINUTE_MS), short, "after {minutes} minutes");
    }
    expected.assert_eq(&short);
}

fn nm17x() -> (device::Device, Node<{ device::LEN }>) {
    (device::Device::new(), device::node())
}

fn standard() -> ((), Node<{ cia_301::LEN }>) {
    ((), cia_301::node())
}

/// The inhibit time, 80 ms, is over.
#[test]
fn a_change_goes_out_at_once() {
    check(
        nm17x,
        "
        0 boot
        1 < 000 01 7F
        100 set 6004:00 5
        ",
        "
        0 set 6004:00 6
        1 set 6004:00 7
        200 end
        ",
        expect![[r#"
            0000 > 2FF [8] 06 00 00 00 00 00 00 00
            0080 > 2FF [8] 07 00 00 00 00 00 00 00
        "#]],
    );
}

/// The inhibit time runs in Pre-operational as well.
#[test]
fn a_pdo_goes_out_when_the_node_becomes_operational() {
    check(
        nm17x,
        "
        0 boot
        1 < 000 01 7F
        2 < 000 80 7F
        ",
        "
        0 < 000 01 7F
        1 set 6004:00 7
        200 end
        ",
        expect![[r#"
            0000 < 000 [2] 01 7F
            0000 * PreOperational to Operational
            0000 > 2FF [8] 00 00 00 00 00 00 00 00
            0080 > 2FF [8] 07 00 00 00 00 00 00 00
        "#]],
    );
}

#[test]
fn an_emergency_goes_out_at_once() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 2B 15 10 00 C8 00 00 00
        2 emergency 8310 01
        ",
        "
        0 emergency 8310 02
        1 emergency 8310 03
        200 end
        ",
        expect![[r#"
            0000 > 0FF [8] 10 83 00 A1 A2 00 00 02
            0020 > 0FF [8] 10 83 00 A1 A2 00 00 03
        "#]],
    );
}

/// The inhibit time runs in Stopped as well.
#[test]
fn an_emergency_goes_out_after_stopped() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 2B 15 10 00 C8 00 00 00
        2 emergency 8310 01
        3 emergency 8310 02
        4 < 000 02 7F
        ",
        "
        0 < 000 80 7F
        1 emergency 8310 03
        200 end
        ",
        expect![[r#"
            0000 < 000 [2] 80 7F
            0000 * Stopped to PreOperational
            0000 > 0FF [8] 10 83 00 A1 A2 00 00 02
            0020 > 0FF [8] 10 83 00 A1 A2 00 00 03
        "#]],
    );
}

#[test]
fn a_transfer_ends_and_the_next_one_waits_as_long() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 40 08 10 00 00 00 00 00
        ",
        "
        0 < 67F 60 00 00 00 00 00 00 00
        1 < 67F 40 08 10 00 00 00 00 00
        2000 end
        ",
        expect![[r#"
            0000 < 67F [8] 60 00 00 00 00 00 00 00
            0000 > 5FF [8] 80 00 00 00 01 00 04 05
            0001 < 67F [8] 40 08 10 00 00 00 00 00
            0001 > 5FF [8] 41 08 10 00 0E 00 00 00
            1001 > 5FF [8] 80 08 10 00 00 00 04 05
        "#]],
    );
}

#[test]
fn a_transfer_that_ended_leaves_nothing() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 40 08 10 00 00 00 00 00
        2 < 67F 60 00 00 00 00 00 00 00
        3 < 67F 70 00 00 00 00 00 00 00
        ",
        "
        0 < 67F 40 00 10 00 00 00 00 00
        2000 end
        ",
        expect![[r#"
            0000 < 67F [8] 40 00 10 00 00 00 00 00
            0000 > 5FF [8] 43 00 10 00 96 01 02 00
        "#]],
    );
}

#[test]
fn a_receive_pdo_is_overdue_again() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 2B 01 14 05 64 00 00 00
        2 < 000 01 7F
        3 < 37F 00 00 00 00 00 00 00 00
        ",
        "
        0 < 37F 01 00 00 00 00 00 00 00
        200 end
        ",
        expect![[r#"
            0000 < 37F [8] 01 00 00 00 00 00 00 00
            0100 * PdoOverdue { number: 1 }
            0100 > 0FF [8] 50 82 00 00 00 00 00 00
        "#]],
    );
}

#[test]
fn a_producer_is_lost_again() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 23 16 10 01 64 00 05 00
        2 < 705 05
        ",
        "
        0 < 705 05
        200 end
        ",
        expect![[r#"
            0000 < 705 [1] 05
            0000 * HeartbeatRecovered { producer: NodeId(5) }
            0000 > 0FF [8] 00 00 00 00 00 00 00 00
            0100 * HeartbeatLost { producer: NodeId(5) }
            0100 > 0FF [8] 30 81 11 00 00 00 00 00
        "#]],
    );
}

#[test]
fn a_master_is_lost_again() {
    check(
        standard,
        "
        0 boot
        1 < 605 2B 0C 10 00 64 00 00 00
        2 < 605 2F 0D 10 00 02 00 00 00
        3 remote 705 1
        ",
        "
        0 remote 705 1
        300 end
        ",
        expect![[r#"
            0000 < 705 [1] remote
            0000 * GuardingRecovered
            0000 > 085 [8] 00 00 00 00 00 00 00 00
            0000 > 705 [1] FF
            0200 * GuardingLost
            0200 > 085 [8] 30 81 11 00 00 00 00 00
        "#]],
    );
}

#[test]
fn a_sync_opens_a_window() {
    check(
        standard,
        "
        0 boot
        1 < 605 23 07 10 00 88 13 00 00
        2 < 000 01 00
        3 < 080
        4 < 205 01
        5 < 080
        ",
        "
        0 < 205 02
        1 < 080
        2 < 205 03
        10 < 080
        11 < 605 40 00 62 00 00 00 00 00
        ",
        expect![[r#"
            0000 < 205 [1] 02
            0001 < 080 [0]
            0001 > 185 [4] 00 00 00 00
            0002 < 205 [1] 03
            0010 < 080 [0]
            0010 > 185 [4] 00 00 00 00
            0011 < 605 [8] 40 00 62 00 00 00 00 00
            0011 > 585 [8] 4F 00 62 00 03 00 00 00
        "#]],
    );
}

#[test]
fn a_producer_of_sync_begins_one_period_after_the_start() {
    check(
        standard,
        "
        0 boot
        1 < 605 23 06 10 00 10 27 00 00
        2 < 605 23 05 10 00 80 00 00 40
        50 < 000 02 00
        ",
        "
        0 < 000 80 00
        25 end
        ",
        expect![[r#"
            0000 < 000 [2] 80 00
            0000 * Stopped to PreOperational
            0010 > 080 [0]
            0020 > 080 [0]
        "#]],
    );
}

/// Heartbeats, SYNC and the event timer keep their step all the time.
#[test]
fn periods_go_on_in_step() {
    check(
        nm17x,
        "
        0 boot
        1 < 67F 2B 17 10 00 F4 01 00 00
        ",
        "
        0 end
        1200 end
        ",
        expect![[r#"
            0001 > 77F [1] 7F
            0501 > 77F [1] 7F
            1001 > 77F [1] 7F
        "#]],
    );
    check(
        standard,
        "
        0 boot
        1 < 605 23 06 10 00 20 A1 07 00
        2 < 605 23 05 10 00 80 00 00 40
        ",
        "
        0 end
        1200 end
        ",
        expect![[r#"
            0002 > 080 [0]
            0502 > 080 [0]
            1002 > 080 [0]
        "#]],
    );
}

/// The longest life time: 65.535 s × 255 would be more than four hours.
#[test]
fn the_life_time_ends_at_half_a_round_of_the_clock() {
    let script = "
        0 boot
        1 < 605 2B 0C 10 00 FF FF 00 00
        2 < 605 2F 0D 10 00 FF 00 00 00
        3 remote 705 1
        16000000 end
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 2B 0C 10 00 FF FF 00 00
        0001 > 585 [8] 60 0C 10 00 00 00 00 00
        0002 < 605 [8] 2F 0D 10 00 FF 00 00 00
        0002 > 585 [8] 60 0D 10 00 00 00 00 00
        0003 < 705 [1] remote
        0003 > 705 [1] 7F
        2147486 * GuardingLost
        2147486 > 085 [8] 30 81 11 00 00 00 00 00
    "#]]
    .assert_eq(&transcript(cia_301::node(), &mut (), script));
}
