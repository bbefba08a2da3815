//! Stored parameters of this controller.

use expect_test::expect;
use interface::NotSaved;
use profiles::nm172::PRODUCT;

use crate::script::Script;

impl Script {
    /// The supply comes back: what was stored as a set is there, and these numbers.
    fn restarted(&self, numbers: &[(u32, u32)]) -> Self {
        let set = self.set.iter().map(|record| (record.key, record.value));
        let stored: Vec<_> = set.chain(numbers.iter().copied()).collect();
        let mut script = Self::powered(&PRODUCT, &stored);
        script.run(500).transcript.clear();
        script
    }
}

/// NM17x STORE-03, STORE-04, STORE-09, OD-1010-1 (D-01, D-03): changed in RAM first, saved as a
/// whole by either signature, and answered when it is.
#[test]
fn communication_parameters_are_saved_on_command() {
    let mut script = Script::booted();
    script.send("67F#2B 17 10 00 E8 03 00 00").send("67F#40 10 10 01 00 00 00 00");
    script.send("67F#23 10 10 01 73 61 76 66").send("67F#23 10 10 01 73 61 76 65");
    script.send("67F#23 29 10 02 02 00 00 00").send("67F#2F 29 10 02 02 00 00 00");
    script
        .send("000#82 7F")
        .send("67F#40 17 10 00 00 00 00 00")
        .send("67F#40 29 10 02 00 00 00 00");
    script.send("67F#2F 29 10 02 02 00 00 00").send("67F#23 10 10 02 73 61 76 65");
    script.expect(expect![[r#"
        500   <-  67F#2B 17 10 00 E8 03 00 00
        500   ->  5FF#60 17 10 00 00 00 00 00
        500   ->  77F#7F
        500   <-  67F#40 10 10 01 00 00 00 00
        500   ->  5FF#43 10 10 01 01 00 00 00
        500   <-  67F#23 10 10 01 73 61 76 66
        500   ->  5FF#80 10 10 01 20 00 00 08
        500   <-  67F#23 10 10 01 73 61 76 65
        500   do  StoreSet
        500   do  Confirm(1)
        500   ->  5FF#60 10 10 01 00 00 00 00
        500   <-  67F#23 29 10 02 02 00 00 00
        500   ->  5FF#80 29 10 02 00 00 01 06
        500   <-  67F#2F 29 10 02 02 00 00 00
        500   ->  5FF#60 29 10 02 00 00 00 00
        500   <-  000#82 7F
        500   ->  77F#00
        500   MSP urgent StateLowered
        500   do  FiltersChanged
        500   <-  67F#40 17 10 00 00 00 00 00
        500   ->  5FF#4B 17 10 00 E8 03 00 00
        500   <-  67F#40 29 10 02 00 00 00 00
        500   ->  5FF#4F 29 10 02 01 00 00 00
        500   <-  67F#2F 29 10 02 02 00 00 00
        500   ->  5FF#60 29 10 02 00 00 00 00
        500   <-  67F#23 10 10 02 73 61 76 65
        500   do  StoreSet
        500   do  Confirm(2)
        500   ->  5FF#60 10 10 02 00 00 00 00
    "#]]);
    let mut restarted = script.restarted(&[]);
    restarted.send("67F#40 17 10 00 00 00 00 00").send("67F#40 29 10 02 00 00 00 00");
    restarted.expect(expect![[r#"
        500   <-  67F#40 17 10 00 00 00 00 00
        500   ->  5FF#4B 17 10 00 E8 03 00 00
        500   <-  67F#40 29 10 02 00 00 00 00
        500   ->  5FF#4F 29 10 02 02 00 00 00
    "#]]);
}

/// NM17x STORE-09: a memory that failed is told after the fact, and the set saved before stays.
#[test]
fn a_failed_save_is_told() {
    let mut script = Script::booted();
    script.memory = Err(NotSaved);
    script.send("67F#2B 17 10 00 E8 03 00 00").send("67F#23 10 10 01 73 61 76 65");
    script.send("67F#23 11 10 01 6C 6F 61 64").send("000#82 7F");
    script.send("67F#40 17 10 00 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  67F#2B 17 10 00 E8 03 00 00
        500   ->  5FF#60 17 10 00 00 00 00 00
        500   ->  77F#7F
        500   <-  67F#23 10 10 01 73 61 76 65
        500   do  StoreSet
        500   do  Confirm(1)
        500   ->  5FF#80 10 10 01 21 00 00 08
        500   <-  67F#23 11 10 01 6C 6F 61 64
        500   do  Forget
        500   do  Confirm(2)
        500   ->  5FF#80 11 10 01 21 00 00 08
        500   <-  000#82 7F
        500   ->  77F#00
        500   MSP urgent StateLowered
        500   do  FiltersChanged
        500   <-  67F#40 17 10 00 00 00 00 00
        500   ->  5FF#4B 17 10 00 00 00 00 00
    "#]]);
}

/// NM17x STORE-05, OD-1011-1 (D-02), A-60: the state at delivery after a restart, node-ID and bit
/// rate included; a save before it keeps the present parameters, but not those two.
#[test]
fn defaults_are_restored_after_a_restart() {
    let mut script = Script::powered(&PRODUCT, &[(0x21_0100, 5), (0x21_0000, 8), (0x10_1700, 100)]);
    script.run(400).send("605#40 11 10 01 00 00 00 00").send("605#23 11 10 02 73 61 76 65");
    script.send("605#23 11 10 02 6C 6F 61 64").send("605#40 17 10 00 00 00 00 00");
    script.send("605#40 01 21 00 00 00 00 00").send("605#40 00 21 00 00 00 00 00");
    script.send("605#23 10 10 01 73 61 76 65");
    script.expect(expect![[r#"
        340   ->  705#00
        400   <-  605#40 11 10 01 00 00 00 00
        400   ->  585#43 11 10 01 01 00 00 00
        400   <-  605#23 11 10 02 73 61 76 65
        400   ->  585#80 11 10 02 20 00 00 08
        400   <-  605#23 11 10 02 6C 6F 61 64
        400   do  Forget
        400   do  Confirm(1)
        400   ->  585#60 11 10 02 00 00 00 00
        400   <-  605#40 17 10 00 00 00 00 00
        400   ->  585#4B 17 10 00 64 00 00 00
        400   <-  605#40 01 21 00 00 00 00 00
        400   ->  585#4F 01 21 00 7F 00 00 00
        400   <-  605#40 00 21 00 00 00 00 00
        400   ->  585#4F 00 21 00 04 00 00 00
        400   <-  605#23 10 10 01 73 61 76 65
        400   do  StoreSet
        400   do  Confirm(2)
        400   ->  585#60 10 10 01 00 00 00 00
    "#]]);
    let mut restarted = script.restarted(&[]);
    restarted.send("67F#40 17 10 00 00 00 00 00").send("67F#40 14 10 00 00 00 00 00");
    restarted.expect(expect![[r#"
        500   <-  67F#40 17 10 00 00 00 00 00
        500   ->  5FF#4B 17 10 00 64 00 00 00
        500   <-  67F#40 14 10 00 00 00 00 00
        500   ->  5FF#43 14 10 00 FF 00 00 00
    "#]]);
}

/// NM17x PDO-11, PDO-07, A-15: saved COB-IDs follow a new node-ID, with their bits 31 and 30; one
/// of the master's own does not, and RxPDO1 never does.
#[test]
fn saved_cob_ids_follow_the_node_id() {
    let mut script = Script::booted();
    script.send("67F#23 00 18 01 FF 01 00 40").send("67F#23 01 18 01 00 03 00 40");
    script.send("67F#23 10 10 01 73 61 76 65");
    let mut restarted = script.restarted(&[(0x21_0100, 5)]);
    for object in ["14 10 00", "00 14 01", "01 14 01", "00 18 01", "01 18 01"] {
        restarted.send(&format!("605#40 {object} 00 00 00 00"));
    }
    restarted.expect(expect![[r#"
        500   <-  605#40 14 10 00 00 00 00 00
        500   ->  585#43 14 10 00 85 00 00 00
        500   <-  605#40 00 14 01 00 00 00 00
        500   ->  585#43 00 14 01 01 02 00 40
        500   <-  605#40 01 14 01 00 00 00 00
        500   ->  585#43 01 14 01 05 03 00 40
        500   <-  605#40 00 18 01 00 00 00 00
        500   ->  585#43 00 18 01 85 01 00 40
        500   <-  605#40 01 18 01 00 00 00 00
        500   ->  585#43 01 18 01 00 03 00 40
    "#]]);
}

/// NM17x BOOT-04, NMT-05, STORE-08, OD-1F80-1: 8 is taken and, once saved, starts the node.
#[test]
fn a_node_starts_itself_when_that_is_saved() {
    let mut script = Script::booted();
    script.send("67F#23 80 1F 00 04 00 00 00").send("67F#23 80 1F 00 08 00 00 00");
    let unsaved = script.restarted(&[]);
    assert_eq!(unsaved.transcript, "");
    script.send("67F#23 10 10 01 73 61 76 65");
    let mut restarted = script.restarted(&[]);
    restarted.send("67F#2B 17 10 00 64 00 00 00").run(100);
    restarted.expect(expect![[r#"
        500   <-  67F#2B 17 10 00 64 00 00 00
        500   ->  5FF#60 17 10 00 00 00 00 00
        500   ->  77F#05
        600   ->  77F#05
    "#]]);
}
