//! The internal link, seen from the application controller.

mod rig;

use application::MotorOutputs;
use expect_test::{Expect, expect};
use profiles::{nm17x, nm172};
use proptest::prelude::*;
use rig::{CYCLE, OWN_NONCE, PARTNER_NONCE, Rig, SUPERVISION, TURN, stop, write};
use shared_proto::{Hello, ToApplication, ToInterface, encode};

#[track_caller]
fn check(rig: &mut Rig, expected: Expect) {
    expected.assert_eq(&rig.said());
}

/// NM17x LINK-01, LINK-02: greetings every 10 ms until the other side answers, then process data
/// every 10 ms.
#[test]
fn two_controllers_meet() {
    let mut rig = Rig::new();
    rig.steps(2 * CYCLE);
    rig.partner.heard = 0;
    rig.partner.in_service = false;
    rig.greet();
    rig.steps(CYCLE);
    rig.partner.heard = OWN_NONCE;
    rig.greet();
    rig.partner.in_service = true;
    rig.greet();
    rig.idle();
    rig.steps(3 * CYCLE);
    check(
        &mut rig,
        expect![[r#"
            hello from a0, heard 0, out of service
            hello from a0, heard 0, out of service
            hello from a0, heard b0, out of service
            hello from a0, heard b0, in service
            process 1: at 0, write 0, stop 0
            process 2: at 0, write 0, stop 0
            process 3: at 0, write 0, stop 0
        "#]],
    );
}

/// NM17x LINK-03, LINK-04: a write is acknowledged with the next process data. One that comes
/// again is acknowledged again and not executed again: the preset stays where the shaft was.
#[test]
fn a_repeated_write_is_executed_once() {
    let mut rig = Rig::in_service();
    rig.step();
    rig.said();
    let preset = ToApplication::Write(SUPERVISION, write(1, &nm17x::PRESET, 5_000));
    rig.say(&preset);
    rig.turn_to(rig::MIDDLE + TURN);
    rig.steps(8 * CYCLE);
    rig.say(&preset);
    rig.say(&preset);
    rig.steps(CYCLE);
    rig.say(&ToApplication::Write(SUPERVISION, write(2, &nm17x::PRESET, 0)));
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
            values from 68: 10
            process 1: at 5000, write 1, stop 0
            process 2: at 5400, write 1, stop 0
            process 3: at 5400, write 1, stop 0
            process 4: at 5400, write 1, stop 0
            process 5: at 5400, write 1, stop 0
            process 6: at 5400, write 1, stop 0
            process 7: at 5400, write 1, stop 0
            process 8: at 5400, write 1, stop 0
            values from 78: 10
            process 9: at 5400, write 1, stop 0
            process 10: at 0, write 2, stop 0
        "#]],
    );
}

/// NM17x LINK-02: the values that the other controller has no copy of yet, one message in each
/// cycle, from any position of the dictionary to its end.
#[test]
fn values_are_sent_when_they_are_asked_for() {
    let mut rig = Rig::in_service();
    rig.said();
    rig.say(&ToApplication::RequestSnapshot { supervision: SUPERVISION, from: 60 });
    rig.steps(3 * CYCLE);
    rig.say(&ToApplication::RequestSnapshot { supervision: SUPERVISION, from: u16::MAX });
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
            values from 60: 10
            process 1: at 0, write 0, stop 0
            values from 70: 10
            process 2: at 0, write 0, stop 0
            values from 80: 10
            process 3: at 0, write 0, stop 0
            process 4: at 0, write 0, stop 0
        "#]],
    );

    let mut rig = Rig::attended();
    rig.write(&nm17x::LOOP_LENGTH, 321);
    rig.steps(CYCLE);
    rig.said();
    rig.say(&ToApplication::RequestSnapshot { supervision: SUPERVISION, from: 0 });
    rig.steps(16 * CYCLE);
    let mut values = Vec::new();
    for message in rig.heard {
        match message {
            ToInterface::Snapshot { from, values: run } => {
                assert_eq!(usize::from(from), values.len());
                values.extend(run);
            }
            ToInterface::Hello(_) | ToInterface::Process(_) | ToInterface::Touched { .. } => {}
        }
    }
    assert_eq!(values.len(), nm172::LEN);
    let slot = nm172::DICTIONARY.slot(&nm17x::LOOP_LENGTH);
    assert_eq!(values[usize::from(slot.position())], 321);
}

/// NM17x LINK-07, ABORT-01: a stop has numbers of its own.
#[test]
fn a_stop_is_acknowledged() {
    let mut rig = Rig::in_service();
    rig.steps(CYCLE);
    rig.said();
    rig.say(&stop(7));
    rig.say(&stop(7));
    rig.steps(CYCLE);
    rig.say(&stop(8));
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
            process 2: at 0, write 0, stop 7
            process 3: at 0, write 0, stop 8
        "#]],
    );
    assert_eq!(rig.application.motor(), MotorOutputs::OFF);
}

/// NM17x ABORT-11, A-48: after 100 ms without a frame the link is lost, the motor off. The two meet
/// again without a restart, and what was executed before is not executed again.
#[test]
fn a_lost_link_is_noticed_and_found_again() {
    let mut rig = Rig::in_service();
    let preset = ToApplication::Write(SUPERVISION, write(1, &nm17x::PRESET, 5_000));
    rig.say(&preset);
    rig.steps(9 * CYCLE);
    rig.idle();
    rig.said();
    rig.steps(10 * CYCLE);
    assert!(rig.application.in_service());
    rig.step();
    assert!(!rig.application.in_service());
    assert_eq!(rig.application.motor(), MotorOutputs::OFF);
    rig.said();
    rig.say(&ToApplication::Write(SUPERVISION, write(2, &nm17x::PRESET, 0)));
    rig.turn_to(rig::MIDDLE + TURN);
    rig.steps(10 * CYCLE);
    rig.said();
    rig.greet();
    rig.say(&preset);
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
        process 20: at 5400, write 1, stop 0
    "#]],
    );
}

/// NM17x LINK-04: after a restart of the other controller the numbers start anew.
#[test]
fn the_other_controller_may_restart() {
    let mut rig = Rig::in_service();
    rig.write(&nm17x::LOOP_LENGTH, 200);
    rig.said();
    rig.partner = Hello { nonce: PARTNER_NONCE + 1, heard: 0, in_service: false, ..rig.partner };
    rig.greet();
    assert!(!rig.application.in_service());
    rig.steps(CYCLE);
    rig.partner.heard = OWN_NONCE;
    rig.greet();
    rig.steps(CYCLE);
    rig.say(&ToApplication::Write(SUPERVISION, write(1, &nm17x::LOOP_LENGTH, 300)));
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
        hello from a0, heard b1, out of service
        hello from a0, heard b1, in service
        process 2: at 0, write 0, stop 0
        process 3: at 0, write 1, stop 0
    "#]],
    );
    assert_eq!(rig.storage[&nm17x::LOOP_LENGTH.id().key()], 300);
}

/// An image with another protocol, product or dictionary is not served, and the display says so
/// until a fitting one greets.
#[test]
fn images_that_do_not_fit_stay_out_of_service() {
    let fitting = Rig::new().partner;
    for partner in [
        Hello { protocol: fitting.protocol + 1, ..fitting },
        Hello { product: 0x70, ..fitting },
        Hello { dictionary: fitting.dictionary ^ 1, ..fitting },
    ] {
        let mut rig = Rig::in_service();
        rig.partner = Hello { nonce: PARTNER_NONCE + 1, in_service: false, ..partner };
        rig.greet();
        rig.say(&ToApplication::Write(SUPERVISION, write(1, &nm17x::LOOP_LENGTH, 300)));
        rig.run_until_ms(6_000);
        assert!(!rig.application.in_service());
        assert_eq!(rig.stores, []);
        assert_eq!(rig.application.motor(), MotorOutputs::OFF);
        expect![[r#"
            ┌────────────────────────┐
            │ _                      │
            │|_   _   _   _   _      │
            │|_  |   |   |_| |       │
            │ _   _                  │
            │|_| |_| |    _          │
            │|   | | |   |           │
            │                        │
            └────────────────────────┘"#]]
        .assert_eq(&rig.application.view().to_string());
        rig.partner = Hello { nonce: PARTNER_NONCE + 2, ..fitting };
        rig.greet();
        assert!(rig.application.in_service());
        assert_ne!(rig.application.view().to_string().matches('_').count(), 0);
    }
}

/// NM17x LINK-06: a value that cannot be taken over is acknowledged, and the true one is told.
#[test]
fn a_write_that_is_not_possible_is_undone_in_the_copy() {
    let mut rig = Rig::in_service();
    rig.write(&nm17x::SCALING, 0);
    rig.steps(CYCLE);
    rig.said();
    rig.write(&nm17x::PRESET, 700);
    rig.write(&nm17x::ARROWS, 6);
    rig.write(&nm17x::NODE_ID, 5);
    rig.write(&nm17x::POSITION_VALUE, 5);
    rig.steps(CYCLE);
    check(
        &mut rig,
        expect![[r#"
            values from 150: 1
            process 3: at 0, write 2, stop 0
            values from 71: 1
            process 4: at 0, write 3, stop 0
            process 5: at 0, write 4, stop 0
            values from 151: 1
            process 6: at 0, write 5, stop 0
            process 7: at 0, write 5, stop 0
        "#]],
    );
    let keys: Vec<_> = rig.stores.iter().map(|(key, _)| *key).collect();
    assert_eq!(keys, [nm17x::SCALING.id().key()]);
}

/// Every single bit error in a frame drops the frame.
#[test]
fn no_damaged_frame_is_executed() {
    let frame = encode(&ToApplication::Write(SUPERVISION, write(1, &nm17x::LOOP_LENGTH, 200)));
    for bit in 0..frame.len() * 8 {
        let mut rig = Rig::in_service();
        let mut damaged = frame.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        rig.say_bytes(&damaged);
        rig.say_bytes(&[0]);
        rig.steps(CYCLE);
        assert_eq!(rig.stores, [], "bit {bit}");
        assert_eq!(rig.process().acknowledged, 0, "bit {bit}");
    }
}

/// What a line does to a frame.
#[derive(Clone, Copy, Debug)]
enum Fault {
    None,
    Lost,
    Doubled,
    Truncated(usize),
    Flipped(usize),
}

fn any_fault() -> impl Strategy<Value = Fault> {
    prop_oneof![
        4 => Just(Fault::None),
        1 => Just(Fault::Lost),
        1 => Just(Fault::Doubled),
        1 => any::<usize>().prop_map(Fault::Truncated),
        1 => any::<usize>().prop_map(Fault::Flipped),
    ]
}

fn disturbed(message: &ToApplication, fault: Fault) -> Vec<u8> {
    let mut bytes = encode(message).to_vec();
    match fault {
        Fault::None => {}
        Fault::Lost => bytes.clear(),
        Fault::Doubled => bytes.extend_from_within(..),
        Fault::Truncated(len) => bytes.truncate(len % bytes.len()),
        Fault::Flipped(bit) => {
            let byte = bit / 8 % bytes.len();
            bytes.iter_mut().skip(byte).take(1).for_each(|byte| *byte ^= 1 << (bit % 8));
        }
    }
    bytes
}

proptest! {
    /// NM17x LINK-03: repeated until acknowledged, each write is executed once and in order,
    /// whatever the line does.
    #[test]
    fn writes_arrive_once_and_in_order(faults in proptest::collection::vec(any_fault(), 1..200)) {
        let mut rig = Rig::in_service();
        let mut sequence = 1;
        for fault in faults {
            let value = 1_000 + u32::from(sequence);
            let message = ToApplication::Write(SUPERVISION, write(sequence, &nm17x::LOOP_LENGTH, value));
            rig.say_bytes(&disturbed(&message, fault));
            rig.steps(CYCLE);
            if !rig.application.in_service() {
                rig.say_bytes(&[0]);
                rig.greet();
                rig.steps(CYCLE);
            }
            if rig.process().acknowledged == sequence {
                sequence += 1;
            }
        }
        let executed: Vec<_> = rig.stores.iter().map(|(_, value)| *value).collect();
        let sent: Vec<_> = (1..sequence).map(|sequence| 1_000 + u32::from(sequence)).collect();
        prop_assert_eq!(executed, sent);
    }

    /// Any byte on the line leaves the device alive, the motor off and every parameter alone.
    #[test]
    fn any_bytes_are_survived(
        portions in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..100), 0..20),
    ) {
        let mut rig = Rig::in_service();
        for bytes in &portions {
            rig.say_bytes(bytes);
            rig.step();
            prop_assert_eq!(rig.application.motor(), MotorOutputs::OFF);
        }
        prop_assert_eq!(&rig.stores, &vec![]);
    }

    /// Nor does any well-formed message with any content.
    #[test]
    fn any_write_is_survived(index: u16, sub: u8, value: u32, sequence: u8) {
        let mut rig = Rig::in_service();
        for index in [index, 0x2000, 0x2005, 0x2010, 0x2015, 0x6003, 0x2020] {
            let write = shared_proto::Write { sequence, index, sub, value };
            rig.say(&ToApplication::Write(SUPERVISION, write));
            rig.step();
        }
        rig.steps(3 * CYCLE);
        prop_assert!(rig.application.in_service());
    }
}
