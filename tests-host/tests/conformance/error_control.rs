//! Cases 7.1 to 7.207: node guarding and heartbeat.

use crate::Case;
use crate::master::{Master, Sent, Verdict, object};

#[rustfmt::skip]
pub(crate) const CASES: &[Case] = &[
    Case { number: "7.1", intent: "guard time and life time factor at their defaults", clause: "7.5.2.11", run: case_7_1 },
    Case { number: "7.2", intent: "a remote frame is answered with the state", clause: "7.2.8.3.2.1", run: case_7_2 },
    Case { number: "7.3", intent: "the toggle bit", clause: "7.2.8.3.2.1", run: case_7_3 },
    Case { number: "7.4", intent: "remote frames of other nodes", clause: "7.3.3", run: case_7_4 },
    Case { number: "7.5", intent: "guard time and life time factor are written", clause: "7.5.2.12", run: case_7_5 },
    Case { number: "7.6", intent: "a master that stays away is noticed", clause: "7.2.8.2.2.1", run: case_7_6 },
    Case { number: "7.101", intent: "0x1017 is written", clause: "7.5.2.20", run: case_7_101 },
    Case { number: "7.102", intent: "as many heartbeats as 0x1017 says", clause: "7.2.8.3.2.2", run: case_7_102 },
    Case { number: "7.103", intent: "a heartbeat time of 0", clause: "7.5.2.20", run: case_7_103 },
    Case { number: "7.104", intent: "the same node monitored twice", clause: "7.5.2.19", run: case_7_104 },
    Case { number: "7.105", intent: "heartbeats that come in time", clause: "7.2.8.2.2.2", run: case_7_105 },
    Case { number: "7.106", intent: "heartbeats that come too late", clause: "7.2.8.2.2.2", run: case_7_106 },
    Case { number: "7.107", intent: "monitoring begins anew after a reset", clause: "7.2.8.2.2.2", run: case_7_107 },
    Case { number: "7.201", intent: "guarding and heartbeat are both there and both off", clause: "7.2.8.3.2", run: case_7_201 },
    Case { number: "7.202", intent: "the heartbeat is switched off", clause: "7.2.8.3.2", run: case_7_202 },
    Case { number: "7.203", intent: "guarding without heartbeat", clause: "7.2.8.3.2", run: case_7_203 },
    Case { number: "7.204", intent: "heartbeat without guarding", clause: "7.2.8.3.2", run: case_7_204 },
    Case { number: "7.205", intent: "remote frames with heartbeat on, guarding off", clause: "7.2.8.3.2", run: case_7_205 },
    Case { number: "7.206", intent: "heartbeats with both on", clause: "7.2.8.3.2", run: case_7_206 },
    Case { number: "7.207", intent: "remote frames with both on", clause: "7.2.8.3.2", run: case_7_207 },
];

const PRE_OPERATIONAL: u8 = 0x7F;
const TOGGLE: u8 = 0x80;
/// A node that the device monitors.
const MONITORED: u8 = 5;

/// Guarding 01.
fn case_7_1(master: &mut Master) -> Verdict {
    for object in [master.has(0x100C, 0)?, master.has(0x100D, 0)?] {
        assert_eq!(master.number(object), 0);
    }
    Ok(())
}

/// Guarding 02.
fn case_7_2(master: &mut Master) -> Verdict {
    guarded(master)?;
    assert_eq!(states(&ask(master)), [PRE_OPERATIONAL]);
    unguarded(master);
    Ok(())
}

/// Guarding 03: 0 at the first answer, then it alternates.
fn case_7_3(master: &mut Master) -> Verdict {
    guarded(master)?;
    let toggles: Vec<u8> = (0..4).map(|_| ask(master)[0].data[0] & TOGGLE).collect();
    assert_eq!(toggles, [0, TOGGLE, 0, TOGGLE]);
    unguarded(master);
    Ok(())
}

/// Guarding 04.
fn case_7_4(master: &mut Master) -> Verdict {
    guarded(master)?;
    let own = master.device.node_id;
    for node_id in (1..=127).filter(|&node_id| node_id != own) {
        master.send_remote(0x700 + u16::from(node_id));
    }
    assert_eq!(master.watch_ms(200), []);
    unguarded(master);
    Ok(())
}

/// Guarding 05.
fn case_7_5(master: &mut Master) -> Verdict {
    for (object, value) in [(master.writes(0x100C, 0)?, 250), (master.writes(0x100D, 0)?, 3)] {
        assert_eq!(master.set(object, value), Ok(()));
        assert_eq!(master.number(object), value);
        assert_eq!(master.set(object, 0), Ok(()));
    }
    Ok(())
}

/// Guarding 06: life guarding begins with the first remote frame; three guard times without one
/// are an error.
fn case_7_6(master: &mut Master) -> Verdict {
    guarded(master)?;
    assert_eq!(master.set(object(0x100C, 0), 50), Ok(()));
    assert_eq!(master.set(object(0x100D, 0), 3), Ok(()));
    let emergency = master.id(0x080);
    let errors = |frames: &[Sent]| frames.iter().filter(|sent| sent.id == emergency).count();
    assert_eq!(errors(&master.watch_ms(500)), 0, "no remote frame has come yet");
    for _ in 0..10 {
        assert_eq!(errors(&ask(master)), 0);
        assert_eq!(errors(&master.watch_ms(40)), 0);
    }
    let frames = master.watch_ms(500);
    let lost: Vec<_> = frames.iter().filter(|sent| sent.id == emergency).collect();
    assert_eq!((lost.len(), &lost[0].data[..2]), (1, &[0x30, 0x81][..]));
    ask(master);
    unguarded(master);
    Ok(())
}

/// Heartbeat 01.
fn case_7_101(master: &mut Master) -> Verdict {
    beats_each(master, 200, |master| {
        assert_eq!(master.number(object(0x1017, 0)), 200);
    })
}

/// Heartbeat 02.
fn case_7_102(master: &mut Master) -> Verdict {
    beats_each(master, 100, |master| {
        let beats = beats(master, 1_000);
        assert!((9..=11).contains(&beats.len()), "{beats:02X?}");
        assert!(beats.iter().all(|&state| state == PRE_OPERATIONAL));
    })
}

/// Heartbeat 03.
fn case_7_103(master: &mut Master) -> Verdict {
    beats_each(master, 0, |master| assert!(beats(master, 2_000).is_empty()))
}

/// Heartbeat 04: in the same entry again, and in another one, which is refused.
fn case_7_104(master: &mut Master) -> Verdict {
    let first = master.writes(0x1016, 1)?;
    let entry = u32::from(MONITORED) << 16 | 1_000;
    assert_eq!(master.set(first, entry), Ok(()));
    assert_eq!(master.set(first, entry), Ok(()));
    if let Ok(second) = master.writes(0x1016, 2) {
        assert_eq!(master.set(second, entry), Err(0x0604_0043));
    }
    assert_eq!(master.set(first, 0), Ok(()));
    Ok(())
}

/// Heartbeat 05.
fn case_7_105(master: &mut Master) -> Verdict {
    monitor(master)?;
    for _ in 0..10 {
        master.send(0x700 + u16::from(MONITORED), &[5]);
        let frames = master.watch_ms(50);
        assert!(!frames.iter().any(|sent| sent.id == master.id(0x080)), "{frames:02X?}");
    }
    assert_eq!(master.set(object(0x1016, 1), 0), Ok(()));
    Ok(())
}

/// Heartbeat 06.
fn case_7_106(master: &mut Master) -> Verdict {
    monitor(master)?;
    master.send(0x700 + u16::from(MONITORED), &[5]);
    let frames = master.watch_ms(150);
    let message = frames.iter().find(|sent| sent.id == master.id(0x080)).expect("a message");
    assert_eq!(message.data[..2], [0x30, 0x81]);
    master.send(0x700 + u16::from(MONITORED), &[5]);
    master.run_ms(5);
    assert_eq!(master.set(object(0x1016, 1), 0), Ok(()));
    Ok(())
}

/// Heartbeat 07.
fn case_7_107(master: &mut Master) -> Verdict {
    monitor(master)?;
    master.send(0x700 + u16::from(MONITORED), &[5]);
    master.run_ms(20);
    master.restart();
    let frames = master.watch_ms(500);
    assert!(!frames.iter().any(|sent| sent.id == master.id(0x080)), "{frames:02X?}");
    Ok(())
}

/// Heartbeat versus guarding 01.
fn case_7_201(master: &mut Master) -> Verdict {
    for object in [master.has(0x100C, 0)?, master.has(0x100D, 0)?] {
        assert_eq!(master.number(object), 0);
    }
    let heartbeat = master.has(0x1017, 0)?;
    let default = master.row(heartbeat).map(|row| row.initial(master.device.node_id));
    assert_eq!(Some(master.number(heartbeat)), default);
    Ok(())
}

/// Heartbeat versus guarding 02.
fn case_7_202(master: &mut Master) -> Verdict {
    master.has(0x100C, 0)?;
    case_7_103(master)
}

/// Heartbeat versus guarding 03.
fn case_7_203(master: &mut Master) -> Verdict {
    case_7_3(master)
}

/// Heartbeat versus guarding 04.
fn case_7_204(master: &mut Master) -> Verdict {
    master.has(0x100C, 0)?;
    case_7_102(master)
}

/// Heartbeat versus guarding 05.
fn case_7_205(master: &mut Master) -> Verdict {
    master.has(0x100C, 0)?;
    beats_each(master, 1_000, |master| assert_eq!(ask(master), []))
}

/// Heartbeat versus guarding 06: the heartbeat is what counts then.
fn case_7_206(master: &mut Master) -> Verdict {
    let guard_time = master.writes(0x100C, 0)?;
    assert_eq!(master.set(guard_time, 50), Ok(()));
    case_7_102(master)?;
    assert_eq!(master.set(guard_time, 0), Ok(()));
    Ok(())
}

/// Heartbeat versus guarding 07.
fn case_7_207(master: &mut Master) -> Verdict {
    let guard_time = master.writes(0x100C, 0)?;
    assert_eq!(master.set(guard_time, 50), Ok(()));
    beats_each(master, 1_000, |master| assert_eq!(ask(master), []))?;
    assert_eq!(master.set(guard_time, 0), Ok(()));
    Ok(())
}

/// Guarding instead of a heartbeat, in a device that has just come up.
fn guarded(master: &mut Master) -> Verdict {
    let guard_time = master.writes(0x100C, 0)?;
    let factor = master.writes(0x100D, 0)?;
    assert_eq!(master.set(object(0x1017, 0), 0), Ok(()));
    master.restart();
    for (object, value) in [(object(0x1017, 0), 0), (guard_time, 100), (factor, 0)] {
        assert_eq!(master.set(object, value), Ok(()));
    }
    Ok(())
}

fn unguarded(master: &mut Master) {
    for index in [0x100C, 0x100D] {
        assert_eq!(master.set(object(index, 0), 0), Ok(()));
    }
    master.restart();
}

/// The answers to a remote frame of the error control.
fn ask(master: &mut Master) -> Vec<Sent> {
    master.watch_ms(0);
    master.send_remote(master.id(0x700));
    let id = master.id(0x700);
    let mut frames = master.watch_ms(5);
    frames.retain(|sent| sent.id == id);
    frames
}

fn states(answers: &[Sent]) -> Vec<u8> {
    answers.iter().map(|sent| sent.data[0] & !TOGGLE).collect()
}

/// Does something while the device has this heartbeat time, in milliseconds.
fn beats_each(master: &mut Master, ms: u32, then: impl FnOnce(&mut Master)) -> Verdict {
    let heartbeat = master.writes(0x1017, 0)?;
    let before = master.number(heartbeat);
    assert_eq!(master.set(heartbeat, ms), Ok(()));
    master.run_ms(5);
    then(master);
    assert_eq!(master.set(heartbeat, before), Ok(()));
    Ok(())
}

fn beats(master: &mut Master, ms: u64) -> Vec<u8> {
    let id = master.id(0x700);
    let frames = master.watch_ms(ms);
    frames.iter().filter(|sent| sent.id == id).map(|sent| sent.data[0]).collect()
}

/// A node is monitored with 100 ms.
fn monitor(master: &mut Master) -> Verdict {
    let entry = master.writes(0x1016, 1)?;
    assert_eq!(master.set(entry, u32::from(MONITORED) << 16 | 100), Ok(()));
    Ok(())
}
