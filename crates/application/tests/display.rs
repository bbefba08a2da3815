//! What the operator sees.

mod rig;

use expect_test::{Expect, expect};
use lcd::Glyph;
use profiles::nm17x;
use profiles::nm17x::between_controllers::{MESSAGE_END, OFFER};
use rig::{CYCLE, MIDDLE, Rig, TURN};

/// Both lines and the arrows as text. Letters that look like digits read as digits.
fn shown(rig: &Rig) -> String {
    let view = rig.application.view();
    assert_eq!(rig.application.picture(), view.ram());
    let mut text = String::new();
    for line in [view.upper, view.lower] {
        text.push('[');
        for glyph in line.glyphs {
            let plain = glyph.without(Glyph::POINT);
            let known = b" 0123456789-_ABCDEFGHIJLNOPQRTUY";
            let character = known.iter().find(|c| Glyph::of(**c) == plain);
            text.push(character.map_or('?', |c| char::from(*c)));
            text.extend(glyph.shows(Glyph::POINT).then_some('.'));
        }
        text.push_str("] ");
    }
    text.extend(view.arrows.left.then_some('<'));
    text.extend(view.arrows.right.then_some('>'));
    text.trim_end().to_owned()
}

#[track_caller]
fn check(rig: &Rig, expected: &str) {
    assert_eq!(shown(rig), expected);
}

#[track_caller]
fn check_picture(rig: &Rig, expected: Expect) {
    expected.assert_eq(&rig.application.view().to_string());
}

fn in_operation() -> Rig {
    let mut rig = Rig::attended();
    rig.run_until_ms(6_000);
    rig
}

/// NM17x BOOT-01, A-99, A-104: designation and version for 2.5 s, node-ID for 2.5 s, then the
/// normal display.
#[test]
fn a_device_introduces_itself() {
    let mut rig = Rig::new();
    rig.step();
    check(&rig, "[172.A01] [      ]");
    let mut rig = Rig::attended();
    check(&rig, "[172.A01] [   1.05]");
    check_picture(
        &rig,
        expect![[r#"
        ┌────────────────────────┐
        │     _   _   _   _      │
        │  |   |  _| |_| | |   | │
        │  |   | |_ .| | |_|   | │
        │                 _   _  │
        │              | | | |_  │
        │              |.|_|  _| │
        │                        │
        └────────────────────────┘"#]],
    );
    rig.run_until_ms(2_500);
    check(&rig, "[172.A01] [   1.05]");
    rig.step();
    check(&rig, "[      ] [   127]");
    rig.run_until_ms(5_000);
    check(&rig, "[      ] [   127]");
    rig.step();
    check(&rig, "[  10.00] [   0.00] >");
    check_picture(
        &rig,
        expect![[r#"
        ┌────────────────────────┐
        │             _   _   _  │
        │          | | | | | | | │
        │          | |_|.|_| |_| │
        │             _   _   _  │
        │            | | | | | | │
        │            |_|.|_| |_| │
        │                       ►│
        └────────────────────────┘"#]],
    );
}

/// NM17x BOOT-02: position, writes and storage work from the first cycle on.
#[test]
fn the_device_works_while_it_introduces_itself() {
    let mut rig = Rig::attended();
    rig.turn_to(MIDDLE + TURN);
    rig.steps(3 * CYCLE);
    assert_eq!(rig.process().position_hundredths_mm, 400);
    rig.write(&nm17x::PRESET, 700);
    assert_eq!(rig.process().position_hundredths_mm, 700);
    check(&rig, "[172.A01] [   1.05]");
}

/// NM17x DISP-01, DISP-02, DISP-03, DISP-04, DISP-07: setpoint above, actual value below, arrows
/// until the setpoint is reached.
#[test]
fn setpoint_and_actual_value_in_operation() {
    let mut rig = in_operation();
    for (preset, expected) in [
        (0, "[  10.00] [   0.00] >"),
        (994, "[  10.00] [   9.94] >"),
        (995, "[      ] [   9.95]"),
        (1_005, "[      ] [  10.05]"),
        (1_006, "[  10.00] [  10.06] <"),
        (-5, "[  10.00] [-  0.05] >"),
        (-99_999, "[  10.00] [-999.99] >"),
        (999_999, "[  10.00] [9999.99] <"),
    ] {
        rig.write(&nm17x::PRESET, preset);
        check(&rig, expected);
    }
}

/// NM17x DISP-05, DISP-06, DISP-12, DISP-13, OD-2001-1, OD-2020-1.
#[test]
fn the_display_follows_its_parameters() {
    let mut rig = in_operation();
    rig.write(&nm17x::STANDARD_SETPOINT, 20_000);
    check(&rig, "[ 200.00] [   0.00] >");
    rig.write(&nm17x::ARROWS, 1);
    check(&rig, "[ 200.00] [   0.00] <");
    rig.write(&nm17x::HIDE_LAST_DIGIT, 1);
    check(&rig, "[ 200.0 ] [   0.0 ] <");
    rig.write(&nm17x::LENGTH_UNIT, 1);
    check(&rig, "[  7.87 ] [  0.00 ] <");
    assert_eq!(rig.process().position_hundredths_mm, 0);
    rig.write(&nm17x::HIDE_LAST_DIGIT, 0);
    rig.write(&nm17x::HIDE_SETPOINT, 2);
    check(&rig, "[      ] [  0.000]");
    rig.write(&nm17x::RESET_FUNCTION, 1);
    check(&rig, "[ 200.00] [   0.00] >");
}

/// NM17x POS-06, POS-10, POS-11, POS-12, POS-13: a change of the correction moves the actual value
/// at once, the setpoint when it is set again.
#[test]
fn the_correction_is_on_the_display() {
    let mut rig = in_operation();
    rig.write(&nm17x::CORRECTION, -6_250);
    check(&rig, "[  10.00] [- 62.50] >");
    rig.write(&nm17x::STANDARD_SETPOINT, 26_250);
    check(&rig, "[ 200.00] [- 62.50] >");
    rig.write(&nm17x::CORRECTION, 100);
    check(&rig, "[ 200.00] [   1.00] >");
    rig.write(&nm17x::CORRECTION_ENABLED, 0);
    check(&rig, "[ 262.50] [   0.00] >");
}

/// NM17x BOOT-05: the stored setpoint is in force after power-up.
#[test]
fn the_setpoint_outlives_the_supply() {
    let mut rig = in_operation();
    rig.write(&nm17x::CORRECTION, -6_250);
    rig.write(&nm17x::STANDARD_SETPOINT, 26_250);
    rig.restart();
    rig.run_until_ms(6_000);
    check(&rig, "[ 200.00] [- 62.50] >");
}

/// NM17x DISP-11, V-SDO-4: the same picture upside down.
#[test]
fn the_picture_can_be_turned_round() {
    let mut rig = in_operation();
    let upright = rig.application.view();
    rig.write(&nm17x::ROTATE_DISPLAY, 1);
    assert_eq!(rig.application.view(), upright.upside_down());
    rig.write(&nm17x::ROTATE_DISPLAY, 0);
    assert_eq!(rig.application.view(), upright);
}

/// NM17x DISP-09, DISP-10: in the window the display shows the setpoint after 3 s, until a key is
/// pressed.
#[test]
fn a_reached_setpoint_is_shown_rounded() {
    let mut rig = in_operation();
    rig.write(&nm17x::ROUND_ACTUAL_VALUE, 1);
    rig.write(&nm17x::PRESET, 997);
    check(&rig, "[      ] [   9.97]");
    rig.run_until_ms(8_950);
    check(&rig, "[      ] [   9.97]");
    rig.run_until_ms(9_100);
    check(&rig, "[      ] [  10.00]");
    assert_eq!(rig.process().position_hundredths_mm, 997);
    rig.inputs.right_key = true;
    rig.run_until_ms(9_200);
    check(&rig, "[      ] [   9.97]");
    rig.inputs.right_key = false;
    rig.run_until_ms(12_300);
    check(&rig, "[      ] [  10.00]");
    rig.write(&nm17x::HIDE_SETPOINT, 2);
    check(&rig, "[      ] [   9.97]");
}

/// NM17x ERR-03, ERR-04, DISP-03, A-101: an error and the setpoint in turns, a second each, above a
/// value that has lost its first digits.
#[test]
fn an_error_blinks_in_the_upper_line() {
    let mut rig = in_operation();
    rig.turn_to(0x1FF_FFFF);
    rig.run_until_ms(6_500);
    check(&rig, "[ER 1  ] [6384.00] <");
    rig.run_until_ms(7_500);
    check(&rig, "[  10.00] [6384.00] <");
    rig.turn_to(0);
    rig.run_until_ms(8_500);
    check(&rig, "[ER 2  ] [-384.00] >");
}

/// NM17x A-107: a sensor that says nothing is not a position; the last one stays on the bus.
#[test]
fn a_silent_sensor_is_seen() {
    let mut rig = in_operation();
    rig.write(&nm17x::PRESET, 700);
    for line in [[0; 4], [0xFF; 4]] {
        rig.inputs.ssi = line;
        rig.steps(3 * CYCLE);
        check(&rig, "[  10.00] [------]");
        assert_eq!(rig.process().position_hundredths_mm, 700);
        rig.turn_to(MIDDLE);
        rig.steps(CYCLE);
        check(&rig, "[  10.00] [   7.00] >");
    }
}

/// NM17x OD-2008-1, DISP-16, A-104: the node-ID in the lower line, until 0 is written.
#[test]
fn the_node_id_is_shown_on_demand() {
    let mut rig = in_operation();
    rig.write(&nm17x::SHOW_NODE_ID, 1);
    check(&rig, "[      ] [   127]");
    rig.write(&nm17x::LOOP_LENGTH, 5);
    check(&rig, "[      ] [   127]");
    rig.write(&nm17x::SHOW_NODE_ID, 0);
    check(&rig, "[  10.00] [   0.00] >");
}

/// NM17x OD-2007-1, DISP-17, DISP-18, DISP-19: a text on both lines; what seven segments can not
/// show is blank, the point included. It ends with any write and with a restart of the other
/// controller.
#[test]
fn a_text_of_the_master_is_shown() {
    let mut rig = in_operation();
    rig.show(b"HALT-_1.Kx42");
    check(&rig, "[HALT-_] [1   42]");
    rig.write(&nm17x::LOOP_LENGTH, 5);
    check(&rig, "[  10.00] [   0.00] >");
    rig.show(b"            ");
    check(&rig, "[      ] [      ]");
    rig.write_to(MESSAGE_END, 0);
    check(&rig, "[  10.00] [   0.00] >");
    rig.show(b"STOP  12  34");
    rig.partner.nonce += 1;
    rig.greet();
    check(&rig, "[  10.00] [   0.00] >");
}

/// NM17x ADDR-08, ADDR-09, ADDR-10, DISP-15, A-49, A-104: an offer in the upper line; a quarter of a
/// turn or a key takes it, once. It is gone when the other controller withdraws it or restarts.
#[test]
fn a_node_id_is_offered() {
    let mut rig = in_operation();
    rig.write_to(OFFER, 0x0102);
    check(&rig, "[    02] [   0.00]");
    rig.turn_to(MIDDLE + TURN / 4 - 8);
    rig.steps(CYCLE);
    assert!(!rig.said().contains("touched"));
    rig.turn_to(MIDDLE + TURN / 4);
    rig.steps(CYCLE);
    assert!(rig.said().contains("touched during offer 1\n"));
    rig.write_to(OFFER, 0x0002);
    rig.said();
    rig.steps(CYCLE);
    assert!(!rig.said().contains("touched"));
    check(&rig, "[    02] [   1.00]");
    rig.inputs.left_key = true;
    rig.steps(2 * CYCLE);
    rig.write_to(OFFER, 0x0203);
    rig.steps(4 * CYCLE);
    assert!(!rig.said().contains("touched"), "a key that was down before");
    rig.inputs.left_key = false;
    rig.steps(4 * CYCLE);
    rig.inputs.left_key = true;
    rig.steps(4 * CYCLE);
    assert!(rig.said().contains("touched during offer 2\n"));
    rig.write_to(OFFER, 0);
    check(&rig, "[  10.00] [   1.00] >");
    rig.write_to(OFFER, 0x0304);
    rig.partner.nonce += 1;
    rig.greet();
    check(&rig, "[  10.00] [   1.00] >");
}

/// NM17x OD-2020-2 to OD-2020-8, A-71: every setpoint is shown as soon as it is written; the two
/// standard ones are one, and all others start from it.
#[test]
fn every_setpoint_comes_into_force() {
    let mut rig = in_operation();
    for (object, value, shown) in [
        (nm17x::STANDARD_SETPOINT, 1_100, "[  11.00] [   0.00] >"),
        (nm17x::START_STANDARD_SETPOINT, 1_200, "[  12.00] [   0.00] >"),
        (nm17x::DIMENSION_SETPOINT, -1_300, "[- 13.00] [   0.00] <"),
        (nm17x::START_DIMENSION_SETPOINT, 1_400, "[  14.00] [   0.00] >"),
        (nm17x::START_DIRECT_SETPOINT, 1_500, "[  15.00] [   0.00] >"),
        (nm17x::SAW_IN_SETPOINT, 1_600, "[  16.00] [   0.00] >"),
        (nm17x::START_SAW_IN_SETPOINT, 1_700, "[  17.00] [   0.00] >"),
    ] {
        rig.write(&object, value);
        check(&rig, shown);
    }
    assert_eq!(rig.stores, [(0x20_2001, 1_100), (0x20_2001, 1_200), (0x20_2002, 1_200)]);
    rig.restart();
    rig.run_until_ms(6_000);
    check(&rig, "[  12.00] [   0.00] >");
}
