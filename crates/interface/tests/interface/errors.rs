//! Emergencies, the error list, and what follows from an error.

use expect_test::expect;

use crate::script::Script;

/// NM17x HB-02, HB-03, HB-04, EMCY-06, OD-1029-1, OD-1029-2, ABORT-05 (D-04, D-12), A-31, A-33, A-35:
/// a producer that is watched stays away and comes back.
#[test]
fn a_heartbeat_is_missed() {
    let mut script = Script::booted();
    script.send("67F#23 16 10 01 64 00 01 00").send("000#01 7F").run(150);
    script.send("701#05").run(120).send("67F#40 01 10 00 00 00 00 00").send("701#05");
    script.send("67F#40 03 10 00 00 00 00 00").send("67F#40 03 10 02 00 00 00 00");
    script.send("67F#40 03 10 03 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  67F#23 16 10 01 64 00 01 00
        500   ->  5FF#60 16 10 01 00 00 00 00
        500   do  FiltersChanged
        500   <-  000#01 7F
        500   ->  2FF#20 A1 07 00 00 00 00 00
        650   <-  701#05
        750   ->  0FF#30 81 11 00 00 00 00 00
        750   MSP urgent HeartbeatLost
        750   MSP urgent StateLowered
        770   <-  67F#40 01 10 00 00 00 00 00
        770   ->  5FF#4F 01 10 00 11 00 00 00
        770   <-  701#05
        770   ->  0FF#00 00 00 00 00 00 00 00
        770   <-  67F#40 03 10 00 00 00 00 00
        770   ->  5FF#4F 03 10 00 01 00 00 00
        770   <-  67F#40 03 10 02 00 00 00 00
        770   ->  5FF#80 03 10 02 24 00 00 08
        770   <-  67F#40 03 10 03 00 00 00 00
        770   ->  5FF#80 03 10 03 24 00 00 08
    "#]]);
}

/// NM17x OD-1029-1, OD-1029-3, NMT-06, OD-1001-1, EMCY-07, A-31, A-34: an application error is no
/// emergency; it sets bit 7 of the error register, and in Operational what 0x1029:02 says happens.
#[test]
fn an_application_error_changes_the_state() {
    for behaviour in [0, 1, 2] {
        let mut script = Script::booted();
        script.send(&format!("67F#2F 29 10 02 0{behaviour} 00 00 00")).send("000#01 7F").run(100);
        script.send("67F#2B 17 10 00 0A 00 00 00").transcript.clear();
        script.partner.process.errors = 1;
        script.run(25);
        let (heartbeat, register) = (["7F", "05", "04"][behaviour], "4F 01 10 00 81");
        assert!(script.transcript.contains(&format!("77F#{heartbeat}")), "{}", script.transcript);
        assert!(!script.transcript.contains("0FF#"), "{}", script.transcript);
        script.send("000#80 7F").send("67F#40 01 10 00 00 00 00 00");
        assert!(script.transcript.contains(register), "{}", script.transcript);
    }
}

/// NM17x EMCY-01, EMCY-03, EMCY-04, OD-1003-1, OD-1014-1, BOOT-09, A-32: the newest error first, no
/// more than eight, cleared by 0 and by a restart; messages go to the identifier of 0x1014.
#[test]
fn errors_are_listed() {
    let mut script = Script::booted();
    script.send("67F#23 14 10 00 85 00 00 00").send("000#01 7F").run(100);
    for control in ["02 00", "04 00", "08 00", "10 00", "20 00", "40 00", "80 00", "00 01"] {
        script.send(&format!("37F#00 00 00 00 00 00 {control}"));
    }
    script.send("201#00 10 20 00 00 00 00 00").transcript.clear();
    script.send("37F#00 00 00 00 00 00 00");
    for sub in ["00", "01", "02", "03", "08"] {
        script.send(&format!("67F#40 03 10 {sub} 00 00 00 00"));
    }
    script.send("67F#2F 03 10 00 01 00 00 00").send("67F#2F 03 10 00 00 00 00 00");
    script.send("67F#40 03 10 00 00 00 00 00").send("67F#40 03 10 01 00 00 00 00");
    script.expect(expect![[r#"
        600   <-  37F#00 00 00 00 00 00 00
        600   ->  085#10 82 00 00 00 00 00 01
        600   <-  67F#40 03 10 00 00 00 00 00
        600   ->  5FF#4F 03 10 00 08 00 00 00
        600   <-  67F#40 03 10 01 00 00 00 00
        600   ->  5FF#43 03 10 01 10 82 01 00
        600   <-  67F#40 03 10 02 00 00 00 00
        600   ->  5FF#43 03 10 02 20 82 01 00
        600   <-  67F#40 03 10 03 00 00 00 00
        600   ->  5FF#43 03 10 03 30 82 01 00
        600   <-  67F#40 03 10 08 00 00 00 00
        600   ->  5FF#43 03 10 08 30 82 01 00
        600   <-  67F#2F 03 10 00 01 00 00 00
        600   ->  5FF#80 03 10 00 30 00 09 06
        600   <-  67F#2F 03 10 00 00 00 00 00
        600   ->  5FF#60 03 10 00 00 00 00 00
        600   <-  67F#40 03 10 00 00 00 00 00
        600   ->  5FF#4F 03 10 00 00 00 00 00
        600   <-  67F#40 03 10 01 00 00 00 00
        600   ->  5FF#80 03 10 01 24 00 00 08
    "#]]);
    let mut restarted = Script::booted();
    restarted.send("67F#40 03 10 00 00 00 00 00");
    restarted.expect(expect![[r#"
        500   <-  67F#40 03 10 00 00 00 00 00
        500   ->  5FF#4F 03 10 00 00 00 00 00
    "#]]);
}
