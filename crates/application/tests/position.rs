//! From the shaft to the process data, with everything that changes the position on the way.

mod rig;

use object_dictionary::Object;
use profiles::{nm17x, nm170};
use rig::{CYCLE, MIDDLE, Rig, TURN};

/// Position reported after the shaft rested at `word` for a while.
fn position(rig: &mut Rig, word: u32) -> i32 {
    rig.turn_to(word);
    rig.steps(3 * CYCLE);
    rig.process().position_hundredths_mm
}

/// NM17x POS-01, POS-02, POS-04, OD-6004-1: 4 mm per turn as delivered, zero in the middle of the
/// encoder.
#[test]
fn a_turn_is_a_pitch() {
    let mut rig = Rig::attended();
    for (word, expected) in [
        (MIDDLE, 0),
        (MIDDLE + TURN, 400),
        (MIDDLE - TURN, -400),
        (MIDDLE + 10 * TURN + TURN / 2, 4_200),
        (0, -1_638_400),
        (0x1FF_FFFF, 1_638_400),
    ] {
        assert_eq!(position(&mut rig, word), expected, "{word:#x}");
    }
}

/// NM17x POS-03, POS-05: direction and scaling by object.
#[test]
fn direction_and_scaling_are_parameters() {
    let mut rig = Rig::attended();
    rig.write(&nm17x::SCALING, 10_000_000);
    assert_eq!(position(&mut rig, MIDDLE + TURN), 2_304);
    rig.write(&nm17x::COUNTING_DIRECTION, 1);
    assert_eq!(position(&mut rig, MIDDLE + TURN), -2_304);
    rig.write(&nm17x::SCALING, 0);
    assert_eq!(position(&mut rig, MIDDLE + TURN), 0);
}

/// NM17x POS-08, STORE-02: the position equals the preset, also after a loss of supply and whatever
/// the shaft did meanwhile.
#[test]
fn a_preset_outlives_the_supply() {
    let mut rig = Rig::attended();
    rig.turn_to(MIDDLE + 3 * TURN);
    rig.steps(3 * CYCLE);
    rig.write(&nm17x::PRESET, 50_000);
    assert_eq!(rig.process().position_hundredths_mm, 50_000);
    rig.turn_to(MIDDLE + 7 * TURN);
    rig.restart();
    rig.steps(CYCLE);
    assert_eq!(rig.process().position_hundredths_mm, 51_600);
    assert_eq!(rig.storage[&nm17x::PRESET.id().key()], 50_000);
}

/// NM17x POS-07, POS-08, POS-10, POS-13: 0x6004 does not contain the correction, a preset does.
#[test]
fn the_correction_is_not_in_the_position() {
    let mut rig = Rig::attended();
    rig.write(&nm17x::CORRECTION, -6_250);
    assert_eq!(rig.process().position_hundredths_mm, 0);
    rig.write(&nm17x::PRESET, 20_000);
    assert_eq!(rig.process().position_hundredths_mm, 26_250);
    rig.write(&nm17x::CORRECTION, 100);
    rig.write(&nm17x::CORRECTION_ENABLED, 0);
    assert_eq!(rig.process().position_hundredths_mm, 26_250);
    rig.write(&nm17x::PRESET, 20_000);
    assert_eq!(rig.process().position_hundredths_mm, 20_000);
}

/// NM17x FILTER-01, FILTER-02: a disturbed read is not seen, a shaft that is really elsewhere is
/// seen at the sixth read.
#[test]
fn a_jump_is_filtered() {
    let mut rig = Rig::attended();
    rig.steps(2 * CYCLE);
    rig.turn_to(MIDDLE + TURN);
    rig.steps(5);
    assert_eq!(rig.process().position_hundredths_mm, 0);
    rig.turn_to(MIDDLE);
    rig.step();
    rig.turn_to(MIDDLE + TURN);
    rig.steps(9);
    assert_eq!(rig.process().position_hundredths_mm, 400);
}

/// NM17x OD-2015-1, OD-2015-2, OD-2015-3, OD-2015-4, OD-2015-6, STORE-06, A-52.
#[test]
fn each_reset_function_resets_its_part() {
    const LENGTH: Object<u32> = nm17x::LOOP_LENGTH;
    for (function, loop_length, correction, setpoint, position) in [
        (1, 100, 50, 2_000, 1_350),
        (2, 200, 50, 2_000, 150),
        (3, 100, 0, 1_000, 1_200),
        (4, 200, 0, 2_000, 1_350),
        (6, 200, 50, 2_000, 1_200),
    ] {
        let mut rig = Rig::attended();
        rig.turn_to(MIDDLE + 3 * TURN);
        rig.steps(3 * CYCLE);
        rig.write(&LENGTH, 200);
        rig.write(&nm17x::CORRECTION, 50);
        rig.write(&nm17x::STANDARD_SETPOINT, 2_000);
        rig.write(&nm17x::PRESET, 1_400);
        rig.write(&nm17x::RESET_FUNCTION, function);
        assert_eq!(rig.process().position_hundredths_mm, position, "function {function}");
        let stored = |rig: &Rig, key| rig.storage.get(&key).copied();
        assert_eq!(stored(&rig, LENGTH.id().key()), Some(loop_length), "function {function}");
        assert_eq!(stored(&rig, nm17x::CORRECTION.id().key()), Some(correction));
        assert_eq!(stored(&rig, nm17x::STANDARD_SETPOINT.id().key()), Some(setpoint));
        rig.restart();
        rig.steps(CYCLE);
        assert_eq!(rig.process().position_hundredths_mm, position, "function {function}");
    }
}

/// NM17x OD-2015-5: the order is acknowledged before the controller restarts.
#[test]
fn a_restart_waits_for_its_acknowledgement() {
    let mut rig = Rig::attended();
    assert!(!rig.application.restart_due());
    rig.write(&nm17x::RESET_FUNCTION, 5);
    assert!(!rig.application.restart_due());
    rig.steps(3 * CYCLE);
    assert!(rig.application.restart_due());
}

/// NM17x STORE-10: nothing is stored again that is the same.
#[test]
fn a_repeated_preset_is_stored_once() {
    let mut rig = Rig::attended();
    rig.write(&nm17x::PRESET, 1_400);
    rig.write(&nm17x::PRESET, 1_400);
    rig.write(&nm17x::LOOP_LENGTH, 200);
    rig.write(&nm17x::LOOP_LENGTH, 200);
    assert_eq!(rig.stores.len(), 3);
}

/// NM17x STAT-01, ERR-01, ERR-08: keys, arrows and errors in the process data.
#[test]
fn the_status_word_follows_keys_arrows_and_errors() {
    let mut rig = Rig::attended();
    rig.steps(20);
    assert_eq!((rig.process().status, rig.process().errors), (0x1000, 0));
    rig.inputs.left_key = true;
    rig.steps(20);
    assert_eq!(rig.process().status, 0x1020);
    rig.inputs.left_key = false;
    rig.inputs.right_key = true;
    rig.steps(20);
    assert_eq!(rig.process().status, 0x1040);
    rig.inputs.right_key = false;
    rig.write(&nm17x::STANDARD_SETPOINT, 3);
    rig.steps(20);
    assert_eq!(rig.process().status, 0);
    rig.turn_to(0x1FF_FFFF);
    rig.steps(20);
    assert_eq!((rig.process().status, rig.process().errors), (0x5000, 1));
    rig.turn_to(0);
    rig.steps(20);
    assert_eq!((rig.process().status, rig.process().errors), (0x5000, 2));
}

/// NM17x GEN-03, STAT-13, OD-1002-1, A-37: a device without keys and motor says of itself whether its
/// arrows are visible, and nothing else, beyond its range and with keys down that it does not have.
#[test]
fn a_device_without_motor_has_its_arrows() {
    let mut rig = Rig::of(&nm170::PRODUCT);
    rig.step();
    rig.greet();
    rig.inputs.left_key = true;
    rig.write(&nm17x::PRESET, 999_999);
    rig.turn_to(MIDDLE + TURN);
    rig.steps(4 * CYCLE);
    let process = rig.process();
    assert_eq!(process.position_hundredths_mm, 1_000_399);
    assert_eq!((process.status, process.errors), (0x1000, 0));
    rig.write(&nm17x::STANDARD_SETPOINT, 999_999);
    rig.turn_to(MIDDLE);
    rig.steps(4 * CYCLE);
    assert_eq!(rig.process().status, 0);
}
