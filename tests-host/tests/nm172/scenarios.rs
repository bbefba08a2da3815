//! The NM172 seen from outside, whatever it is made of.

use expect_test::{Expect, expect};
use serde_json::{Value, json};
use tests_host::{Bench, Scene};

use crate::ENGINE;

/// One turn of the encoder in its own steps.
const TURN: i64 = 4_096;

fn on_this_engine<'a>(options: &[&'a str]) -> Vec<&'a str> {
    [&["--engine", ENGINE], options].concat()
}

fn powered(options: &[&str]) -> Scene {
    Scene::powered("nm172", &on_this_engine(options))
}

fn booted(options: &[&str]) -> Scene {
    Scene::booted("nm172", &on_this_engine(options))
}

fn running(options: &[&str]) -> Scene {
    Scene::running("nm172", &on_this_engine(options))
}

fn step(options: &[&str]) -> Bench {
    Bench::step("nm172", &on_this_engine(options))
}

/// How long an answer or a memory takes is its own affair: what follows begins on a full half second.
fn run_to_half_second(scene: &mut Scene) {
    const HALF_SECOND_US: u64 = 500_000;
    let now = scene.bench.tell("now", json!({}));
    let now_us = now.get("us").and_then(Value::as_u64).expect("a time");
    scene.bench.advance(HALF_SECOND_US - now_us % HALF_SECOND_US);
}

#[track_caller]
fn check(scene: &Scene, expected: Expect) {
    expected.assert_eq(scene.transcript());
}

/// NM17x BOOT-01, BOOT-03, NMT-03, DISP-01, DISP-14: who it is, which node it is, then the
/// setpoint over the actual value, with one boot-up message on the bus.
#[test]
fn a_device_is_powered() {
    let mut scene = powered(&[]);
    scene.run_ms(1_000).note_frames().note_display();
    scene.run_ms(2_000).note_display();
    scene.run_ms(3_000).note_display().note_frames();
    check(
        &scene,
        expect![[r#"
        1000   ms  77F#00
        1000   ms  [172.A01]
        1000   ms  [   1.05]
        3000   ms  [      ]
        3000   ms  [   127]
        6000   ms  [  10.00]  >
        6000   ms  [   0.00]
    "#]],
    );
}

/// NM17x SDO-10: the examples of the manual, byte for byte (V-SDO-1 to V-SDO-5).
#[test]
fn the_examples_of_the_manual() {
    let mut scene = running(&[]);
    // 5000.00 mm on the display and on the bus.
    scene.sdo("23 03 60 00 20 A1 07 00").run_ms(50);
    for request in [
        "40 04 60 00 00 00 00 00",
        "23 03 20 00 40 01 00 00",
        "40 01 21 00 00 00 00 00",
        "23 00 20 05 01 00 00 00",
        "23 00 20 05 02 00 00 00",
    ] {
        scene.sdo(request);
    }
    check(
        &scene,
        expect![[r#"
        6002   ms  23 03 60 00 20 A1 07 00 -> 60 03 60 00 00 00 00 00
        6054   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 20 A1 07 00
        6056   ms  23 03 20 00 40 01 00 00 -> 60 03 20 00 00 00 00 00
        6058   ms  40 01 21 00 00 00 00 00 -> 4F 01 21 00 7F 00 00 00
        6060   ms  23 00 20 05 01 00 00 00 -> 60 00 20 05 00 00 00 00
        6062   ms  23 00 20 05 02 00 00 00 -> 80 00 20 05 30 00 09 06
    "#]],
    );
}

/// NM17x GEN-01, OD-1000-1, OD-1008-1, OD-1018-1, SDO-08: who a master finds.
#[test]
fn a_master_identifies_the_device() {
    let mut scene = booted(&[]);
    for request in [
        "40 00 10 00 00 00 00 00",
        "40 08 10 00 00 00 00 00",
        "60 00 00 00 00 00 00 00",
        "70 00 00 00 00 00 00 00",
        "40 09 10 00 00 00 00 00",
        "40 0A 10 00 00 00 00 00",
        "40 18 10 01 00 00 00 00",
        "40 18 10 02 00 00 00 00",
        "40 18 10 03 00 00 00 00",
    ] {
        scene.sdo(request);
    }
    check(
        &scene,
        expect![[r#"
        1002   ms  40 00 10 00 00 00 00 00 -> 43 00 10 00 96 01 02 00
        1004   ms  40 08 10 00 00 00 00 00 -> 41 08 10 00 0E 00 00 00
        1006   ms  60 00 00 00 00 00 00 00 -> 00 4E 4D 31 37 32 20 53
        1008   ms  70 00 00 00 00 00 00 00 -> 11 74 61 6E 64 61 72 64
        1010   ms  40 09 10 00 00 00 00 00 -> 4B 09 10 00 2F 41 00 00
        1012   ms  40 0A 10 00 00 00 00 00 -> 43 0A 10 00 31 2E 30 35
        1014   ms  40 18 10 01 00 00 00 00 -> 43 18 10 01 EC 00 00 00
        1016   ms  40 18 10 02 00 00 00 00 -> 43 18 10 02 71 00 00 00
        1018   ms  40 18 10 03 00 00 00 00 -> 43 18 10 03 01 00 01 00
    "#]],
    );
    let serial = scene.request("40 18 10 04 00 00 00 00");
    assert_ne!(serial, "43 18 10 04 00 00 00 00", "a serial number is never zero");
}

/// NM17x GEN-02, POS-02, POS-04, PDO-04, PDO-09, DISP-02: a turn of the shaft is four millimetres
/// on the display and in TxPDO2; backwards past zero the sixth place is the sign.
#[test]
fn the_shaft_turns() {
    let mut scene = running(&[]);
    scene.send("000#01 7F").run_ms(200).note_frames();
    scene.tell("shaft", json!({ "steps": TURN })).run_ms(200).note_frames().note_display();
    scene.tell("shaft", json!({ "steps": -3 * TURN })).run_ms(200).note_frames().note_display();
    scene.tell("shaft", json!({ "steps_per_s": TURN })).run_ms(1_000);
    scene.tell("shaft", json!({ "steps_per_s": 0 })).run_ms(200).note_display();
    scene.sdo("40 04 60 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        6200   ms  2FF#00 00 00 00 00 00 00 10
        6400   ms  2FF#90 01 00 00 00 00 00 10
        6400   ms  [  10.00]  >
        6400   ms  [   4.00]
        6600   ms  2FF#E0 FC FF FF 00 00 00 10
        6600   ms  [  10.00]  >
        6600   ms  [-  8.00]
        7800   ms  [  10.00]  >
        7800   ms  [-  4.00]
        7802   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 70 FE FF FF
    "#]],
    );
}

/// NM17x GEN-02: what happens to the shaft without supply is known when the supply is back; a sensor
/// that is not there is seen on the display, and nothing is invented in its place.
#[test]
fn the_shaft_turns_without_supply() {
    let mut scene = booted(&[]);
    scene.sdo("40 04 60 00 00 00 00 00");
    scene.tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("shaft", json!({ "steps": -200 * TURN })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(6_000).note_display();
    scene.sdo("40 04 60 00 00 00 00 00");
    scene.tell("sensor", json!({ "connected": false })).run_ms(100).note_display();
    scene.tell("sensor", json!({ "connected": true })).run_ms(100).note_display();
    check(
        &scene,
        expect![[r#"
        1002   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 00 00 00 00
        7202   ms  [  10.00]  >
        7202   ms  [-800.00]
        7204   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 80 C7 FE FF
        7304   ms  [  10.00]
        7304   ms  [------]
        7404   ms  [  10.00]  >
        7404   ms  [-800.00]
    "#]],
    );
}

/// NM17x POS-03, POS-06, POS-08, POS-10, POS-13, A-50, A-51: direction, preset and correction, on
/// the display (with correction) and on the bus (without).
#[test]
fn direction_preset_and_correction() {
    let mut scene = running(&[]);
    let reads = "40 04 60 00 00 00 00 00";
    scene.tell("shaft", json!({ "steps": TURN })).run_ms(100).sdo(reads).note_display();
    scene.note("counts down").sdo("23 00 20 02 01 00 00 00").run_ms(100).sdo(reads);
    scene.note("preset 100.00").sdo("23 03 60 00 10 27 00 00").run_ms(100).sdo(reads);
    scene.note("correction -62.50").sdo("23 10 20 00 96 E7 FF FF").run_ms(100).sdo(reads);
    scene.note_display();
    scene.note("correction off").sdo("23 00 20 06 00 00 00 00").run_ms(100).sdo(reads);
    scene.note_display();
    scene.note("both turns back").tell("shaft", json!({ "steps": -2 * TURN })).run_ms(100);
    scene.sdo(reads).note_display();
    check(
        &scene,
        expect![[r#"
        6102   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 90 01 00 00
        6102   ms  [  10.00]  >
        6102   ms  [   4.00]
        6102   ms  counts down
        6104   ms  23 00 20 02 01 00 00 00 -> 60 00 20 02 00 00 00 00
        6206   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 70 FE FF FF
        6206   ms  preset 100.00
        6208   ms  23 03 60 00 10 27 00 00 -> 60 03 60 00 00 00 00 00
        6310   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 10 27 00 00
        6310   ms  correction -62.50
        6312   ms  23 10 20 00 96 E7 FF FF -> 60 10 20 00 00 00 00 00
        6414   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 10 27 00 00
        6414   ms  [  10.00] <
        6414   ms  [  37.50]
        6414   ms  correction off
        6416   ms  23 00 20 06 00 00 00 00 -> 60 00 20 06 00 00 00 00
        6518   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 10 27 00 00
        6518   ms  [  10.00] <
        6518   ms  [ 100.00]
        6518   ms  both turns back
        6620   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 30 2A 00 00
        6620   ms  [  10.00] <
        6620   ms  [ 108.00]
    "#]],
    );
}

/// NM17x DISP-03, POS-07, A-58: beyond the places of the display the bus still has the value.
#[test]
fn the_display_overflows() {
    let mut scene = running(&[]);
    scene.note("9999.99").sdo("23 03 60 00 3F 42 0F 00").run_ms(100).note_display();
    scene.tell("shaft", json!({ "steps": 64 })).run_ms(100).note_display();
    scene.sdo("40 04 60 00 00 00 00 00");
    scene.note("-999.99").sdo("23 03 60 00 61 79 FE FF").run_ms(100).note_display();
    scene.tell("shaft", json!({ "steps": -64 })).run_ms(100).note_display();
    scene.sdo("40 04 60 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        6000   ms  9999.99
        6002   ms  23 03 60 00 3F 42 0F 00 -> 60 03 60 00 00 00 00 00
        6102   ms  [  10.00] <
        6102   ms  [9999.99]
        6202   ms  [Er 1  ] <
        6202   ms  [0000.05]
        6204   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 45 42 0F 00
        6204   ms  -999.99
        6206   ms  23 03 60 00 61 79 FE FF -> 60 03 60 00 00 00 00 00
        6306   ms  [  10.00]  >
        6306   ms  [-999.99]
        6406   ms  [Er 2  ]  >
        6406   ms  [-000.05]
        6408   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 5B 79 FE FF
    "#]],
    );
}

/// NM17x PDO-02, PDO-03, PDO-05, PDO-25: with every third SYNC; by the event timer, held
/// back by the inhibit time.
#[test]
fn the_position_is_sent_with_sync_and_by_timer() {
    let mut scene = booted(&[]);
    scene.sdo("2F 01 18 02 03 00 00 00").send("000#01 7F").run_ms(100).note_frames();
    for sync in ["080#", "080#00", "080#", "080#", "080#", "080#"] {
        scene.send(sync).run_ms(10).note(sync).note_frames();
    }
    scene.note("type 254, event timer 1 ms, inhibit time 80 ms").sdo("2F 01 18 02 FE 00 00 00");
    scene.frames();
    let sent = scene.run_ms(1_000).frames().len();
    scene.note(&format!("{sent} in a second"));
    scene.note("inhibit time 0, event timer 20 ms");
    assert_eq!(scene.request("2B 01 18 03 00 00 00 00"), "60 01 18 03 00 00 00 00");
    assert_eq!(scene.request("2B 01 18 05 14 00 00 00"), "60 01 18 05 00 00 00 00");
    run_to_half_second(&mut scene);
    scene.frames();
    let sent = scene.run_ms(1_000).frames().len();
    scene.note(&format!("{sent} in a second"));
    check(
        &scene,
        expect![[r#"
            1002   ms  2F 01 18 02 03 00 00 00 -> 60 01 18 02 00 00 00 00
            1112   ms  080#
            1122   ms  080#00
            1132   ms  080#
            1132   ms  2FF#00 00 00 00 00 00 00 10
            1142   ms  080#
            1152   ms  080#
            1162   ms  080#
            1162   ms  2FF#00 00 00 00 00 00 00 10
            1162   ms  type 254, event timer 1 ms, inhibit time 80 ms
            1164   ms  2F 01 18 02 FE 00 00 00 -> 60 01 18 02 00 00 00 00
            2164   ms  13 in a second
            2164   ms  inhibit time 0, event timer 20 ms
            3500   ms  50 in a second
        "#]],
    );
}

/// NM17x HB-01, NMT-01, NMT-02, NMT-04, SDO-07: every state in the heartbeat, SDO in two of them.
#[test]
fn states_and_heartbeats() {
    let mut scene = booted(&[]);
    scene.sdo("2B 17 10 00 64 00 00 00").run_ms(90).note_frames();
    for command in ["01 00", "02 7F", "80 7F", "01 05"] {
        scene.note(command).send(&format!("000#{command}")).run_ms(100).note_frames();
        scene.send("67F#40 00 10 00 00 00 00 00").run_ms(10).note_frames();
    }
    scene.note("82 7F").send("000#82 7F").run_ms(500).note_frames();
    scene.sdo("40 17 10 00 00 00 00 00");
    scene.note("81 7F").send("000#81 7F").run_ms(1_000).note_frames();
    check(
        &scene,
        expect![[r#"
        1002   ms  2B 17 10 00 64 00 00 00 -> 60 17 10 00 00 00 00 00
        1092   ms  77F#7F
        1092   ms  01 00
        1192   ms  2FF#00 00 00 00 00 00 00 10
        1192   ms  77F#05
        1202   ms  5FF#43 00 10 00 96 01 02 00
        1202   ms  77F#05
        1202   ms  02 7F
        1302   ms  77F#04
        1312   ms  80 7F
        1412   ms  77F#7F
        1422   ms  5FF#43 00 10 00 96 01 02 00
        1422   ms  01 05
        1522   ms  77F#7F
        1532   ms  5FF#43 00 10 00 96 01 02 00
        1532   ms  82 7F
        2032   ms  77F#00
        2034   ms  40 17 10 00 00 00 00 00 -> 4B 17 10 00 00 00 00 00
        2034   ms  81 7F
        3034   ms  77F#00
    "#]],
    );
}

/// NM17x SDO-05, SDO-06, SDO-09, BOOT-10: one abort code for each request, in the order of the
/// checks.
#[test]
fn one_abort_code_for_each_request() {
    let mut scene = booted(&[]);
    for request in [
        "FF 04 60 00 00 00 00 00",
        "40 FF 5F 00 00 00 00 00",
        "40 04 60 01 00 00 00 00",
        "40 15 20 00 00 00 00 00",
        "23 04 60 00 00 00 00 00",
        "2B 04 60 00 00 00 00 00",
        "2B 03 20 00 05 00 00 00",
        "23 03 20 00 10 27 00 00",
        "23 04 20 00 FF E0 F5 05",
        "23 04 20 00 00 E1 F5 05",
        "22 17 10 00 00 00 01 00",
        "2F 01 21 00 00 00 00 00",
        "2F 00 18 02 00 00 00 00",
        "2F 00 18 02 F1 00 00 00",
        "40 06 20 01 00 00 00 00",
        "40 06 20 02 00 00 00 00",
    ] {
        scene.sdo(request);
    }
    check(
        &scene,
        expect![[r#"
        1002   ms  FF 04 60 00 00 00 00 00 -> 80 04 60 00 01 00 04 05
        1004   ms  40 FF 5F 00 00 00 00 00 -> 80 FF 5F 00 00 00 02 06
        1006   ms  40 04 60 01 00 00 00 00 -> 80 04 60 01 11 00 09 06
        1008   ms  40 15 20 00 00 00 00 00 -> 80 15 20 00 01 00 01 06
        1010   ms  23 04 60 00 00 00 00 00 -> 80 04 60 00 02 00 01 06
        1012   ms  2B 04 60 00 00 00 00 00 -> 80 04 60 00 02 00 01 06
        1014   ms  2B 03 20 00 05 00 00 00 -> 80 03 20 00 00 00 01 06
        1016   ms  23 03 20 00 10 27 00 00 -> 80 03 20 00 30 00 09 06
        1018   ms  23 04 20 00 FF E0 F5 05 -> 60 04 20 00 00 00 00 00
        1020   ms  23 04 20 00 00 E1 F5 05 -> 80 04 20 00 30 00 09 06
        1022   ms  22 17 10 00 00 00 01 00 -> 80 17 10 00 31 00 09 06
        1024   ms  2F 01 21 00 00 00 00 00 -> 80 01 21 00 30 00 09 06
        1026   ms  2F 00 18 02 00 00 00 00 -> 80 00 18 02 30 00 09 06
        1028   ms  2F 00 18 02 F1 00 00 00 -> 80 00 18 02 30 00 09 06
        1030   ms  40 06 20 01 00 00 00 00 -> 43 06 20 01 69 00 00 00
        1032   ms  40 06 20 02 00 00 00 00 -> 43 06 20 02 81 82 00 00
    "#]],
    );
}

/// NM17x STORE-01, STORE-02, STORE-07, BOOT-05, POS-08: parameters of both controllers outlive the
/// supply, and the next program run with the same state directory.
#[test]
fn parameters_outlive_the_supply() {
    let state = tempdir();
    let state_option = ["--state", state.to_str().expect("a temporary path")];
    {
        let mut scene = running(&state_option);
        scene.tell("shaft", json!({ "steps": TURN / 2 })).run_ms(50);
        scene.sdo("23 03 60 00 10 27 00 00").sdo("23 20 20 01 40 9C 00 00");
        scene.sdo("23 03 20 00 40 01 00 00").sdo("2F 01 21 00 25 00 00 00").run_ms(500);
        scene.tell("power", json!({ "on": false })).run_ms(100);
        scene.tell("power", json!({ "on": true })).run_ms(6_000).node_id(0x25);
        scene.note("supply back").note_frames().note_display();
        scene.sdo("40 04 60 00 00 00 00 00").sdo("40 20 20 01 00 00 00 00");
        scene.sdo("40 03 20 00 00 00 00 00");
        check(
            &scene,
            expect![[r#"
        6052   ms  23 03 60 00 10 27 00 00 -> 60 03 60 00 00 00 00 00
        6054   ms  23 20 20 01 40 9C 00 00 -> 60 20 20 01 00 00 00 00
        6056   ms  23 03 20 00 40 01 00 00 -> 60 03 20 00 00 00 00 00
        6058   ms  2F 01 21 00 25 00 00 00 -> 60 01 21 00 00 00 00 00
        12658  ms  supply back
        12658  ms  725#00
        12658  ms  [ 400.00]  >
        12658  ms  [ 100.00]
        12660  ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 10 27 00 00
        12662  ms  40 20 20 01 00 00 00 00 -> 43 20 20 01 40 9C 00 00
        12664  ms  40 03 20 00 00 00 00 00 -> 43 03 20 00 40 01 00 00
    "#]],
        );
        let (status, errors) = scene.bench.stop();
        assert!(status.success(), "{errors}");
    }
    let mut scene = running(&state_option);
    scene.node_id(0x25).sdo("40 20 20 01 00 00 00 00").sdo("40 03 20 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        6002   ms  40 20 20 01 00 00 00 00 -> 43 20 20 01 40 9C 00 00
        6004   ms  40 03 20 00 00 00 00 00 -> 43 03 20 00 40 01 00 00
    "#]],
    );
    let _ = std::fs::remove_dir_all(state);
}

/// NM17x STORE-02, LINK-05, NMT-02: writes are confirmed faster than the link takes them; none is lost
/// when a reset follows at once.
#[test]
fn a_reset_loses_nothing_that_was_confirmed() {
    let mut scene = booted(&[]);
    for length in 1..=30 {
        let answer = scene.request(&format!("23 02 20 00 {length:02X} 00 00 00"));
        assert_eq!(answer, "60 02 20 00 00 00 00 00");
    }
    scene.request("23 03 20 00 07 00 00 00");
    scene.send("000#81 7F").run_ms(2_000);
    assert!(scene.frames().contains(&"77F#00".to_owned()), "it restarts");
    assert_eq!(scene.request("40 02 20 00 00 00 00 00"), "43 02 20 00 1E 00 00 00");
    assert_eq!(scene.request("40 03 20 00 00 00 00 00"), "43 03 20 00 07 00 00 00");
}

/// NM17x OD-2015-5: the application controller restarts when it is told to, and it alone; the node
/// stays on the bus.
#[test]
fn the_application_controller_restarts() {
    let mut scene = booted(&[]);
    scene.sdo("23 15 20 00 05 00 00 00").run_ms(2_000).note_frames();
    scene.sdo("40 04 60 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        1002   ms  23 15 20 00 05 00 00 00 -> 60 15 20 00 00 00 00 00
        3004   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 00 00 00 00
    "#]],
    );
    assert_eq!(resets(&mut scene.bench), [1, 2]);
}

/// NM17x LINK-06, EMCY-05: the line between the controllers is cut and mended; no
/// controller restarts for it.
#[test]
fn the_link_is_cut_and_mended() {
    let mut scene = booted(&[]);
    scene.tell("link", json!({ "cut": true })).run_ms(200).note_frames();
    scene.sdo("40 04 60 00 00 00 00 00").sdo("23 03 20 00 40 01 00 00");
    scene.tell("link", json!({ "cut": false })).run_ms(1_000).note_frames();
    scene.sdo("40 04 60 00 00 00 00 00").sdo("23 03 20 00 40 01 00 00");
    check(
        &scene,
        expect![[r#"
        1200   ms  0FF#10 83 00 00 00 00 00 01
        1200   ms  0FF#10 83 01 00 00 00 00 04
        1202   ms  40 04 60 00 00 00 00 00 -> 80 04 60 00 24 00 00 08
        1204   ms  23 03 20 00 40 01 00 00 -> 80 03 20 00 00 00 06 06
        2204   ms  0FF#00 00 00 00 00 00 00 00
        2206   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 00 00 00 00
        2208   ms  23 03 20 00 40 01 00 00 -> 60 03 20 00 00 00 00 00
    "#]],
    );
    assert_eq!(resets(&mut scene.bench), [1, 1]);
}

/// NM17x LINK-06: with one wrong bit in a thousand and lost bytes every write still arrives, once
/// the line is good the copies agree, and nobody restarts.
#[test]
fn the_link_is_noisy() {
    let mut scene = booted(&["--seed", "7"]);
    scene.tell("link", json!({ "bit_error_rate": 1e-3, "drop_rate": 1e-3 }));
    for value in 0..40_u32 {
        let bytes = [0x23, 0x03, 0x20, 0x00, value.to_le_bytes()[0], 1, 0, 0];
        let hex: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
        scene.request(&hex.join(" "));
        scene.run_ms(100);
    }
    scene.tell("link", json!({ "bit_error_rate": 0.0, "drop_rate": 0.0 })).run_ms(2_000);
    assert_eq!(scene.request("40 03 20 00 00 00 00 00"), "43 03 20 00 27 01 00 00");
    scene.tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000);
    assert_eq!(scene.request("40 03 20 00 00 00 00 00"), "43 03 20 00 27 01 00 00");
    assert_eq!(resets(&mut scene.bench), [2, 2], "power-on twice, nothing else");
}

/// NM17x EMCY-02, EMCY-05, A-31: half of all frames fail, then all of them until the device is
/// bus-off, and it is back without a restart.
#[test]
fn the_bus_is_disturbed() {
    let mut scene = booted(&[]);
    scene.sdo("2B 17 10 00 0A 00 00 00").note("half of all frames fail");
    scene.tell("can_fault", json!({ "error_rate": 0.5 })).run_ms(1_000);
    scene.tell("can_fault", json!({ "error_rate": 0.0 })).run_ms(200);
    let heartbeats = scene.frames().iter().filter(|frame| *frame == "77F#7F").count();
    assert!((80..=122).contains(&heartbeats), "{heartbeats} heartbeats in 1.2 s");
    scene.note("all frames fail").tell("can_fault", json!({ "error_rate": 1.0 })).run_ms(500);
    scene.tell("can_fault", json!({ "error_rate": 0.0 })).run_ms(500);
    let emergencies: Vec<_> =
        scene.frames().into_iter().filter(|frame| frame.starts_with("0FF#")).collect();
    assert_eq!(emergencies.last().map(String::as_str), Some("0FF#00 00 00 00 00 00 00 00"));
    assert!(emergencies.iter().any(|frame| frame.starts_with("0FF#40 81 11")), "{emergencies:?}");
    scene.sdo("2B 17 10 00 00 00 00 00").sdo("40 01 10 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
            1002   ms  2B 17 10 00 0A 00 00 00 -> 60 17 10 00 00 00 00 00
            1002   ms  half of all frames fail
            2202   ms  all frames fail
            3204   ms  2B 17 10 00 00 00 00 00 -> 60 17 10 00 00 00 00 00
            3206   ms  40 01 10 00 00 00 00 00 -> 4F 01 10 00 00 00 00 00
        "#]],
    );
    assert_eq!(resets(&mut scene.bench), [1, 1]);
}

/// NM17x EMCY-05, A-31: a device that has nothing to send while the bus is held dominant is
/// error-passive, and stays so until it has received a frame (ISO 11898-1, fault confinement).
#[test]
fn the_bus_is_held_dominant() {
    let mut scene = booted(&[]);
    scene.note("held dominant").tell("can_fault", json!({ "stuck_dominant": true })).run_ms(500);
    scene.tell("can_fault", json!({ "stuck_dominant": false })).run_ms(500).note_frames();
    scene.sdo("40 01 10 00 00 00 00 00").run_ms(10).note_frames().sdo("40 01 10 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
            1000   ms  held dominant
            2000   ms  0FF#00 81 00 00 00 00 00 00
            2000   ms  0FF#20 81 11 00 00 00 00 00
            2003   ms  40 01 10 00 00 00 00 00 -> 4F 01 10 00 11 00 00 00
            2015   ms  40 01 10 00 00 00 00 00 -> 4F 01 10 00 00 00 00 00
        "#]],
    );
    assert_eq!(resets(&mut scene.bench), [1, 1]);
}

/// NM17x ADDR-01, ADDR-02: two devices on one bus, told apart once one has another node-ID.
#[test]
fn two_devices_share_a_bus() {
    let mut scene = powered(&["--nodes", "2"]);
    scene.tell("power", json!({ "node": 1, "on": false })).run_ms(1_000).note_frames();
    scene.request("2F 01 21 00 02 00 00 00");
    scene.run_ms(300).tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).tell("power", json!({ "node": 1, "on": true }));
    scene.run_ms(1_000).note_frames();
    scene.tell("shaft", json!({ "node": 1, "steps": TURN })).run_ms(100);
    scene.sdo("40 04 60 00 00 00 00 00");
    let other = scene.request("40 18 10 04 00 00 00 00");
    scene.node_id(2).sdo("40 04 60 00 00 00 00 00");
    assert_ne!(scene.request("40 18 10 04 00 00 00 00"), other, "serial numbers differ");
    check(
        &scene,
        expect![[r#"
        1000   ms  77F#00
        2402   ms  702#00
        2402   ms  77F#00
        2504   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 90 01 00 00
        2508   ms  40 04 60 00 00 00 00 00 -> 43 04 60 00 00 00 00 00
    "#]],
    );
}

/// NM17x GEN-05, OD-2100-1: all nine bit rates, each after a restart.
#[test]
fn all_nine_bit_rates() {
    let mut scene = booted(&[]);
    for rate in [8, 0, 7, 1, 6, 2, 5, 3, 4] {
        scene.request(&format!("2F 00 21 00 {rate:02X} 00 00 00"));
        scene.run_ms(500).tell("power", json!({ "on": false })).run_ms(100);
        scene.tell("power", json!({ "on": true })).run_ms(1_000);
        scene.note_frames().sdo("40 00 21 00 00 00 00 00");
    }
    check(
        &scene,
        expect![[r#"
        2602   ms  77F#00
        2602   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 08 00 00 00
        4203   ms  77F#00
        4227   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 00 00 00 00
        5852   ms  77F#00
        5852   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 07 00 00 00
        7453   ms  77F#00
        7465   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 01 00 00 00
        9078   ms  77F#00
        9078   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 06 00 00 00
        10679  ms  77F#00
        10684  ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 02 00 00 00
        12289  ms  77F#00
        12290  ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 05 00 00 00
        13891  ms  77F#00
        13893  ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 03 00 00 00
        15496  ms  77F#00
        15498  ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 04 00 00 00
    "#]],
    );
}

/// NM17x ADDR-01, ADDR-03 to ADDR-06, ADDR-11, LSS-01 to LSS-04, LSS-06 (V-LSSADR-01 to
/// V-LSSADR-11): the manual's sequence in Stopped; the node-ID outlives the supply.
#[test]
fn a_node_id_is_set_with_layer_setting_services() {
    let mut scene = booted(&[]);
    let serial = scene.request("40 18 10 04 00 00 00 00");
    let serial = serial.strip_prefix("43 18 10 04 ").expect("a serial number");
    for frame in [
        "000#02 00",
        "7E5#04 01",
        "7E5#40 EC 00 00 00 00 00 00",
        "7E5#41 71 00 00 00 00 00 00",
        "7E5#42 01 00 01 00 00 00 00",
        &format!("7E5#43 {serial} 00 00 00"),
        "7E5#11 25",
        "7E5#17 00",
        "7E5#04 00",
    ] {
        scene.send(frame).run_ms(100).note_frames();
    }
    scene.note("supply").tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000).note_frames();
    scene.node_id(0x25).sdo("40 01 21 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        1602   ms  7E4#44 00 00 00 00 00 00 00
        1702   ms  7E4#11 00 00 00 00 00 00 00
        1802   ms  7E4#17 00 00 00 00 00 00 00
        1902   ms  supply
        3002   ms  725#00
        3004   ms  40 01 21 00 00 00 00 00 -> 4F 01 21 00 25 00 00 00
    "#]],
    );
}

/// NM17x ADDR-07 to ADDR-10, LSS-10, DISP-15 (V-DEVADR-01 to V-DEVADR-10): an offer on the display is
/// taken with a key, the next one with the shaft; Reset Node ends it.
#[test]
fn a_node_id_is_taken_by_touch() {
    let mut scene = running(&[]);
    for frame in [
        "000#02 00",
        "7E5#04 01",
        "7E5#40 EC 00 00 00 00 00 00",
        "7E5#41 FF FF FF FF 00 00 00",
        "7E5#42 FF FF FF FF 00 00 00",
        "7E5#43 FF FF FF FF 00 00 00",
        "7E5#11 02 00 00 00 00 00 00",
    ] {
        scene.send(frame).run_ms(50).note_frames();
    }
    scene.note_display();
    scene.note("key").tell("key", json!({ "name": "left", "down": true })).run_ms(200);
    scene.tell("key", json!({ "name": "left", "down": false })).run_ms(200).note_frames();
    scene.send("7E5#11 03 00 00 00 00 00 00").run_ms(100).note_display();
    scene.note("shaft").tell("shaft", json!({ "steps": TURN / 4 + 2 })).run_ms(200).note_frames();
    scene.note("81 00").send("000#81 00").run_ms(1_000).note_frames().note_display();
    check(
        &scene,
        expect![[r#"
        6350   ms  [    02]
        6350   ms  [   0.00]
        6350   ms  key
        6750   ms  7E4#11 00 00 00 00 00 00 00
        6850   ms  [    03]
        6850   ms  [   0.00]
        6850   ms  shaft
        7050   ms  7E4#11 00 00 00 00 00 00 00
        7050   ms  81 00
        8050   ms  703#00
        8050   ms  [  10.00]  >
        8050   ms  [   1.00]
    "#]],
    );
}

/// NM17x LSS-05, LSS-07, A-26: silence, the new bit rate, silence, boot-up. Without a store command
/// the old rate is back after a restart.
#[test]
fn a_bit_rate_is_activated() {
    let mut scene = booted(&[]);
    let serial = scene.request("40 18 10 04 00 00 00 00");
    let serial = serial.strip_prefix("43 18 10 04 ").expect("a serial number");
    for frame in [
        "7E5#04 01",
        "7E5#40 EC 00 00 00 00 00 00",
        "7E5#41 71 00 00 00 00 00 00",
        "7E5#42 01 00 01 00 00 00 00",
        &format!("7E5#43 {serial} 00 00 00"),
        "7E5#13 00 00",
    ] {
        scene.send(frame).run_ms(10).note_frames();
    }
    scene.note("activate").send("7E5#15 64 00").run_ms(150).note("silent").note_frames();
    scene.run_ms(100).note_frames().sdo("40 00 21 00 00 00 00 00");
    scene.note("81 7F").send("000#81 7F").run_ms(1_000).note_frames();
    scene.sdo("40 00 21 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        1052   ms  7E4#44 00 00 00 00 00 00 00
        1062   ms  7E4#13 00 00 00 00 00 00 00
        1062   ms  activate
        1212   ms  silent
        1312   ms  77F#00
        1312   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 04 00 00 00
        1312   ms  81 7F
        2312   ms  77F#00
        2314   ms  40 00 21 00 00 00 00 00 -> 4F 00 21 00 04 00 00 00
    "#]],
    );
}

/// NM17x STORE-03 to STORE-06, STORE-08, STORE-09, BOOT-04, NMT-05, PDO-06 (D-01 to D-03): saved and
/// restored with the signatures, answered when it is done, and in force after a restart.
#[test]
fn communication_parameters_are_saved_and_restored() {
    let mut scene = booted(&[]);
    let restart = |scene: &mut Scene| {
        run_to_half_second(scene);
        scene.tell("power", json!({ "on": false })).run_ms(100).frames();
        scene.tell("power", json!({ "on": true })).run_ms(1_000).note("supply back");
        let mut frames = scene.frames();
        frames.sort();
        frames.iter().for_each(|frame| {
            scene.note(frame);
        });
    };
    scene.sdo("2B 17 10 00 F4 01 00 00").sdo("23 80 1F 00 08 00 00 00");
    scene.sdo("23 10 10 01 00 00 00 00");
    restart(&mut scene);
    scene.sdo("2B 17 10 00 F4 01 00 00").sdo("23 80 1F 00 08 00 00 00");
    scene.sdo("23 02 20 00 07 00 00 00");
    assert_eq!(scene.request("23 10 10 01 73 61 76 65"), "60 10 10 01 00 00 00 00");
    restart(&mut scene);
    scene.sdo("40 17 10 00 00 00 00 00");
    assert_eq!(scene.request("23 11 10 01 6C 6F 61 64"), "60 11 10 01 00 00 00 00");
    restart(&mut scene);
    scene.sdo("40 02 20 00 00 00 00 00");
    scene.sdo("40 17 10 00 00 00 00 00").sdo("40 00 18 01 00 00 00 00");
    scene.sdo("40 01 18 05 00 00 00 00");
    check(
        &scene,
        expect![[r#"
            1002   ms  2B 17 10 00 F4 01 00 00 -> 60 17 10 00 00 00 00 00
            1004   ms  23 80 1F 00 08 00 00 00 -> 60 80 1F 00 00 00 00 00
            1006   ms  23 10 10 01 00 00 00 00 -> 80 10 10 01 20 00 00 08
            2600   ms  supply back
            2600   ms  77F#00
            2602   ms  2B 17 10 00 F4 01 00 00 -> 60 17 10 00 00 00 00 00
            2604   ms  23 80 1F 00 08 00 00 00 -> 60 80 1F 00 00 00 00 00
            2606   ms  23 02 20 00 07 00 00 00 -> 60 02 20 00 00 00 00 00
            4100   ms  supply back
            4100   ms  2FF#00 00 00 00 00 00 00 10
            4100   ms  77F#00
            4100   ms  77F#05
            4102   ms  40 17 10 00 00 00 00 00 -> 4B 17 10 00 F4 01 00 00
            5600   ms  supply back
            5600   ms  77F#00
            5602   ms  40 02 20 00 00 00 00 00 -> 43 02 20 00 07 00 00 00
            5604   ms  40 17 10 00 00 00 00 00 -> 4B 17 10 00 00 00 00 00
            5606   ms  40 00 18 01 00 00 00 00 -> 43 00 18 01 FF 01 00 C0
            5608   ms  40 01 18 05 00 00 00 00 -> 4B 01 18 05 01 00 00 00
        "#]],
    );
}

/// NM17x OD-2007-1, OD-2008-1, DISP-16, DISP-17, DISP-19, SDO-08: a text, then the node-ID.
#[test]
fn a_master_writes_on_the_display() {
    let mut scene = running(&[]);
    for request in ["21 07 20 00 0C 00 00 00", "00 53 54 4F 50 20 20 31", "15 32 2E 33 34 5F 00 00"]
    {
        scene.sdo(request);
    }
    scene.run_ms(100).note_display();
    scene.sdo("2B 17 10 00 00 00 00 00").run_ms(100).note_display();
    scene.sdo("23 08 20 00 01 00 00 00").run_ms(100).note_display();
    check(
        &scene,
        expect![[r#"
        6002   ms  21 07 20 00 0C 00 00 00 -> 60 07 20 00 00 00 00 00
        6004   ms  00 53 54 4F 50 20 20 31 -> 20 00 00 00 00 00 00 00
        6006   ms  15 32 2E 33 34 5F 00 00 -> 30 00 00 00 00 00 00 00
        6106   ms  [5toP  ]
        6106   ms  [12 34_]
        6108   ms  2B 17 10 00 00 00 00 00 -> 60 17 10 00 00 00 00 00
        6208   ms  [  10.00]  >
        6208   ms  [   0.00]
        6210   ms  23 08 20 00 01 00 00 00 -> 60 08 20 00 00 00 00 00
        6310   ms  [      ]
        6310   ms  [   127]
    "#]],
    );
}

/// NM17x PDO-12 to PDO-17, PDO-21, PDO-22, POS-12, OD-2020-2 (V-PDO-BCAST, D-06 to D-10): a broadcast,
/// a setpoint with its correction, and words that mean nothing. No line of the motor moves.
#[test]
fn process_data_of_a_master() {
    let mut scene = running(&[]);
    scene.send("000#01 7F").run_ms(200).frames();
    for frame in [
        "201#00 01 20 00 01 00 00 00",
        "201#00 01 20 00 00 00 00 00",
        "201#00 10 20 00 01 00 00 00",
        "37F#8A 66 00 00 96 E7 03 00",
        "37F#00 00 00 00 00 00 00 40",
        "37F#00 00 00 00 00 00 00 00",
        "37F#00 00 00 00 00 00 81 01",
    ] {
        scene.note(frame).send(frame).run_ms(200).note_frames().note_display();
    }
    scene.sdo("40 10 20 00 00 00 00 00").sdo("40 01 25 01 00 00 00 00");
    let motor = scene.bench.tell("motor", json!({}));
    for line in ["in1", "in2", "in3", "in4"] {
        assert_eq!(motor[line], false, "{line}");
    }
    check(
        &scene,
        expect![[r#"
        6200   ms  201#00 01 20 00 01 00 00 00
        6400   ms  [  0.394]  >
        6400   ms  [  0.000]
        6400   ms  201#00 01 20 00 00 00 00 00
        6600   ms  [  10.00]  >
        6600   ms  [   0.00]
        6600   ms  201#00 10 20 00 01 00 00 00
        6800   ms  0FF#20 82 00 00 00 00 00 01
        6800   ms  [  10.00]  >
        6800   ms  [   0.00]
        6800   ms  37F#8A 66 00 00 96 E7 03 00
        7000   ms  2FF#00 00 00 00 96 E7 00 10
        7000   ms  [ 200.00]  >
        7000   ms  [- 62.50]
        7000   ms  37F#00 00 00 00 00 00 00 40
        7200   ms  [ 200.00]  >
        7200   ms  [- 62.50]
        7200   ms  37F#00 00 00 00 00 00 00 00
        7400   ms  [ 200.00]  >
        7400   ms  [- 62.50]
        7400   ms  37F#00 00 00 00 00 00 81 01
        7600   ms  0FF#30 82 00 00 00 00 00 01
        7600   ms  [ 200.00]  >
        7600   ms  [- 62.50]
        7602   ms  40 10 20 00 00 00 00 00 -> 43 10 20 00 96 E7 FF FF
        7604   ms  40 01 25 01 00 00 00 00 -> 43 01 25 01 00 00 00 00
    "#]],
    );
}

/// NM17x LINK-01, LINK-02: the position of a shaft that turns all the time is another one in every
/// cycle. A master sees each of them, for longer than anything in the device takes to come round.
#[test]
fn no_cycle_is_missed() {
    const CYCLE_US: u64 = 10_000;
    /// A byte of the link takes 22 µs, and frames of process data differ by a few.
    const JITTER_US: u64 = 100;
    const SECONDS: u64 = 20;
    let mut scene = booted(&[]);
    scene.request("2F 00 21 00 08 00 00 00");
    scene.run_ms(500).tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000);
    scene.request("2B 01 18 03 00 00 00 00");
    scene.send("000#01 7F").tell("shaft", json!({ "steps_per_s": TURN })).run_ms(100).frames();
    let mut sent_us = Vec::new();
    for _ in 0..SECONDS {
        let log = scene.run_ms(1_000).bench.tell("can_log", json!({}));
        let frames = log.get("frames").and_then(Value::as_array).expect("frames");
        sent_us.extend(frames.iter().filter_map(|frame| frame.get("us").and_then(Value::as_u64)));
    }
    let distances = sent_us.iter().zip(sent_us.iter().skip(1)).map(|(from, to)| to - from);
    let odd: Vec<u64> =
        distances.filter(|distance| distance.abs_diff(CYCLE_US) > JITTER_US).collect();
    assert!(odd.is_empty(), "{odd:?}");
    assert!(sent_us.len() > 1_990, "{}", sent_us.len());
}

/// Any frame of any kind, to any identifier: the device lives, answers as before, and never
/// restarts. A failure names its seed.
#[test]
fn any_frame_leaves_the_device_alive() {
    for seed in 1..=3_u64 {
        println!("seed {seed}");
        let mut random = seed;
        let mut next = || {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            random
        };
        let mut scene = booted(&["--seed", &seed.to_string()]);
        scene.send("000#01 7F");
        for _ in 0..1_500 {
            let extended = next() % 4 == 0;
            let id = next() % if extended { 1 << 29 } else { 0x800 };
            // Half of them to the node itself; no reset, no node-ID, no bit rate.
            let id = if next() % 2 == 0 && !extended { 0x67F } else { id };
            let dlc = next() % 9;
            let data: String = (0..dlc).map(|_| format!("{:02x}", next() % 256)).collect();
            let blocked =
                id == 0 || (id == 0x67F && data.get(2..6).is_some_and(|index| index == "0021"));
            if blocked {
                continue;
            }
            let frame = if next() % 8 == 0 {
                json!({ "id": id, "data": "", "rtr": true, "extended": extended })
            } else {
                json!({ "id": id, "data": data, "extended": extended })
            };
            scene.tell("can_send", frame);
            if next() % 16 == 0 {
                scene.run_ms(20);
            }
        }
        scene.run_ms(2_000).frames();
        assert_eq!(scene.request("40 00 10 00 00 00 00 00"), "43 00 10 00 96 01 02 00", "{seed}");
        assert_eq!(resets(&mut scene.bench), [1, 1], "seed {seed}");
    }
}

/// NM17x GEN-04: foreign traffic does not even interrupt the controller.
#[test]
fn foreign_traffic_is_filtered_in_hardware() {
    let mut scene = booted(&[]);
    let before = scene.bench.tell("stats", json!({}))["stm"]["can_interrupts"].clone();
    for id in
        (0x001..0x7FF).filter(|id| ![0x080, 0x201, 0x37F, 0x67F, 0x7E5].contains(id)).step_by(7)
    {
        scene.tell("can_send", json!({ "id": id, "data": "0102030405060708" })).run_ms(2);
    }
    let after = scene.bench.tell("stats", json!({}))["stm"]["can_interrupts"].clone();
    assert_eq!(before, after);
}

/// The same seed and the same requests give the same answers, bit for bit.
#[test]
fn a_run_repeats_itself() {
    let run = || {
        let mut bench = step(&["--seed", "11"]);
        let mut answers = Vec::new();
        bench.tell("link", json!({ "bit_error_rate": 1e-4 }));
        bench.tell("shaft", json!({ "steps_per_s": 777 }));
        bench.advance_ms(1_000);
        bench.tell("can_send", json!({ "id": 0, "data": "0100" }));
        for _ in 0..10 {
            bench.advance_ms(100);
            for verb in ["can_log", "display", "stats", "log", "now"] {
                answers.push(bench.tell(verb, json!({})).to_string());
            }
        }
        answers
    };
    assert_eq!(run(), run());
}

/// How often each controller started.
fn resets(bench: &mut Bench) -> [usize; 2] {
    let stats = bench.tell("stats", json!({}));
    ["/stm/resets", "/msp/resets"]
        .map(|path| stats.pointer(path).and_then(Value::as_array).map_or(0, Vec::len))
}

/// A new directory for this process alone.
fn tempdir() -> std::path::PathBuf {
    let path = std::env::temp_dir().join(format!("spindle-{ENGINE}-state-{}", std::process::id()));
    let _ = std::fs::remove_dir_all(&path);
    path
}

/// The fields of an answer that a client relies on.
#[test]
fn answers_have_the_fields_of_the_interface() {
    let mut bench = step(&[]);
    let fields = |answer: &Value| -> Vec<String> {
        answer.as_object().map(|map| map.keys().cloned().collect()).unwrap_or_default()
    };
    let mut listed = String::new();
    for verb in ["now", "motor", "display", "can_log", "log", "stats"] {
        let answer = bench.tell(verb, json!({}));
        listed += &format!("{verb}: {}\n", fields(&answer).join(" "));
    }
    expect![[r#"
        now: id ok us
        motor: id in1 in2 in3 in4 ok steps_per_s
        display: ascii id left_arrow lower ok right_arrow segments upper
        can_log: frames id ok
        log: id lines ok
        stats: id msp ok stm
    "#]]
    .assert_eq(&listed);
}
