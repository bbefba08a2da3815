//! Position sensors as a master meets them.

use canopen::WriteError;
use expect_test::{Expect, expect};

mod ap04;
mod encoder;
mod script;

use script::Script;

#[track_caller]
fn check(script: &mut Script, expected: Expect) {
    expected.assert_eq(&script.transcript());
}

/// AP04 AP-BOOT-02, encoder EN-BOOT-01, EN-GEN-02: every model boots as node 1.
#[test]
fn every_model_boots() {
    for model in position_sensor::MODELS {
        let mut script = Script::new(model.slug);
        script.power_cycle();
        assert_eq!(script.transcript(), "supply\n< 701#00\n", "{}", model.slug);
    }
}

/// Encoder EN-SDO-04, EN-STO-01: the memory does not take what is to be stored.
#[test]
fn a_failed_store_is_told() {
    let mut script = Script::new("gxmm");
    script.memory_fails(Some(WriteError::NotStored));
    script.ask(&["2B 00 23 01 34 12 00 00", "23 10 10 01 73 61 76 65"]);
    script.ask(&["23 11 10 01 6C 6F 61 64", "40 00 23 01 00 00 00 00"]);
    check(
        &mut script,
        expect![[r#"
        > 601#2B 00 23 01 34 12 00 00
        < 581#60 00 23 01 00 00 00 00
        > 601#23 10 10 01 73 61 76 65
        < 581#80 10 10 01 21 00 00 08
        > 601#23 11 10 01 6C 6F 61 64
        < 581#80 11 10 01 21 00 00 08
        > 601#40 00 23 01 00 00 00 00
        < 581#4B 00 23 01 34 12 00 00
    "#]],
    );
}

/// AP04 A-45, encoder EN-PDO-10: SYNC and emergency messages take every identifier but that of NMT.
#[test]
fn identifiers_are_not_restricted() {
    for model in ["ap04", "gxmm"] {
        let mut script = Script::new(model);
        script.ask(&["23 05 10 00 7F 06 00 00", "23 14 10 00 01 07 00 00"]);
        script.ask(&["23 05 10 00 00 00 00 00", "23 14 10 00 00 08 00 00"]);
        script.send("000#01 00").send("67F#").send("67F#");
        let transcript = script.transcript();
        assert!(transcript.contains("581#60 05 10 00"), "{model}\n{transcript}");
        assert!(transcript.contains("581#60 14 10 00"), "{model}\n{transcript}");
        assert_eq!(transcript.matches("< 581#80").count(), 2, "{model}\n{transcript}");
        assert!(transcript.contains("< 281#"), "{model}\n{transcript}");
    }
}
