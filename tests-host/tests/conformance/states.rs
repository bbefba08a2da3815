//! Cases 9.1 to 10.4: states and transitions of the network management.

use crate::Case;
use crate::master::{Master, Sent, Verdict, initiate, object};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "9.1", intent: "boot-up, and parameters at their defaults", clause: "7.3.2.2.1", run: case_9_1 },
    Case { number: "9.2", intent: "Pre-operational after the boot-up message", clause: "7.3.2.2.2", run: case_9_2 },
    Case { number: "9.3", intent: "Operational", clause: "7.3.2.2.3", run: case_9_3 },
    Case { number: "9.4", intent: "Stopped", clause: "7.3.2.2.4", run: case_9_4 },
    Case { number: "10.1", intent: "Reset Node and Reset Communication", clause: "7.2.8.2.1.4", run: case_10_1 },
    Case { number: "10.2", intent: "Enter Pre-operational from everywhere", clause: "7.2.8.2.1.3", run: case_10_2 },
    Case { number: "10.3", intent: "Start from everywhere", clause: "7.2.8.2.1.1", run: case_10_3 },
    Case { number: "10.4", intent: "Stop from everywhere", clause: "7.2.8.2.1.2", run: case_10_4 },
];

const START: u8 = 0x01;
const STOP: u8 = 0x02;
const ENTER_PRE_OPERATIONAL: u8 = 0x80;
const RESET_NODE: u8 = 0x81;
const RESET_COMMUNICATION: u8 = 0x82;

const OPERATIONAL: u8 = 0x05;
const STOPPED: u8 = 0x04;
const PRE_OPERATIONAL: u8 = 0x7F;

/// State 01.
fn case_9_1(master: &mut Master) -> Verdict {
    let heartbeat = object(0x1017, 0);
    let default = master.number(heartbeat);
    assert_eq!(master.set(heartbeat, 100), Ok(()));
    comes_back(master, RESET_NODE);
    let stored_at_once = master.row(heartbeat).is_some_and(is_stored_at_once);
    assert_eq!(master.number(heartbeat), if stored_at_once { 100 } else { default });
    assert_eq!(master.set(heartbeat, default), Ok(()));
    Ok(())
}

/// State 02.
fn case_9_2(master: &mut Master) -> Verdict {
    comes_back(master, RESET_NODE);
    is_in(master, PRE_OPERATIONAL);
    Ok(())
}

/// State 03: SDO and PDO.
fn case_9_3(master: &mut Master) -> Verdict {
    master.nmt(START);
    is_in(master, OPERATIONAL);
    Ok(())
}

/// State 04: neither SDO nor PDO, but the heartbeat.
fn case_9_4(master: &mut Master) -> Verdict {
    let heartbeat = object(0x1017, 0);
    let before = master.number(heartbeat);
    assert_eq!(master.set(heartbeat, 50), Ok(()));
    master.nmt(STOP);
    is_in(master, STOPPED);
    let frames = master.watch_ms(500);
    let error_control = master.id(0x700);
    assert!(frames.iter().all(|frame| frame.id == error_control && frame.data == [STOPPED]));
    assert!((9..=11).contains(&frames.len()), "a heartbeat each 50 ms: {}", frames.len());
    master.nmt(ENTER_PRE_OPERATIONAL);
    assert_eq!(master.set(heartbeat, before), Ok(()));
    Ok(())
}

/// Transition 01: from each state.
fn case_10_1(master: &mut Master) -> Verdict {
    for reset in [RESET_NODE, RESET_COMMUNICATION] {
        for before in [START, STOP, ENTER_PRE_OPERATIONAL] {
            master.nmt(before);
            comes_back(master, reset);
            is_in(master, PRE_OPERATIONAL);
        }
    }
    Ok(())
}

/// Transition 02.
fn case_10_2(master: &mut Master) -> Verdict {
    from_everywhere(master, ENTER_PRE_OPERATIONAL, PRE_OPERATIONAL)
}

/// Transition 03.
fn case_10_3(master: &mut Master) -> Verdict {
    from_everywhere(master, START, OPERATIONAL)
}

/// Transition 04.
fn case_10_4(master: &mut Master) -> Verdict {
    from_everywhere(master, STOP, STOPPED)
}

fn from_everywhere(master: &mut Master, command: u8, state: u8) -> Verdict {
    for before in [START, STOP, ENTER_PRE_OPERATIONAL] {
        master.nmt(before);
        // What does not concern this device changes nothing.
        let other = if master.device.node_id == 1 { 2 } else { 1 };
        master.send(0, &[command ^ 0x03, other]);
        master.nmt(command);
        is_in(master, state);
    }
    Ok(())
}

/// Whether the device sends exactly one boot-up message after the command.
fn comes_back(master: &mut Master, command: u8) {
    master.watch_ms(0);
    master.send(0, &[command, master.device.node_id]);
    let error_control = master.id(0x700);
    let frames = master.watch_ms(3_000);
    let boot_ups = |sent: &&Sent| sent.id == error_control && sent.data == [0];
    assert_eq!(frames.iter().filter(boot_ups).count(), 1, "one boot-up message");
}

/// Whether the device is in the state: its heartbeat says so, and it serves SDO or not.
pub(crate) fn is_in(master: &mut Master, state: u8) {
    let answer = master.try_request(initiate(0x40, object(0x1000, 0), [0; 4]));
    assert_eq!(answer.is_some(), state != STOPPED, "SDO in state {state:#04x}");
    let heartbeat = object(0x1017, 0);
    if state != STOPPED {
        let before = master.number(heartbeat);
        assert_eq!(master.set(heartbeat, 20), Ok(()));
        let error_control = master.id(0x700);
        let frames = master.watch_ms(50);
        let beats: Vec<_> = frames.iter().filter(|frame| frame.id == error_control).collect();
        assert!(!beats.is_empty() && beats.iter().all(|beat| beat.data == [state]));
        assert_eq!(master.set(heartbeat, before), Ok(()));
    }
}

fn is_stored_at_once(row: object_dictionary::Row) -> bool {
    row.storage() == object_dictionary::Storage::AtOnce
}
