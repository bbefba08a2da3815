//! Layer setting services on the whole controller.

use expect_test::expect;
use interface::NotSaved;
use profiles::nm172::PRODUCT;

use crate::script::Script;

/// The steps of the manual's example that select the device.
fn select(script: &mut Script) -> &mut Script {
    script
        .send("7E5#04 01")
        .send("7E5#40 EC 00 00 00 00 00 00")
        .send("7E5#41 71 00 00 00 00 00 00");
    script.send("7E5#42 01 00 01 00 00 00 00").send("7E5#43 67 F5 52 4D 00 00 00")
}

/// NM17x ADDR-03 to ADDR-06, ADDR-11, LSS-01 to LSS-06, LSS-09 (V-LSSADR-01 to V-LSSADR-11), A-22,
/// A-25, A-27: the printed sequence, in Stopped; the node-ID is stored before it is confirmed, and
/// acts with the next reset of the communication.
#[test]
fn the_printed_sequence_gives_a_node_id() {
    let mut script = Script::booted();
    select(script.send("000#02 00")).send("7E5#11 25").send("7E5#17 00").send("7E5#04 00");
    script.send("000#82 7F").run(10).send("625#40 01 21 00 00 00 00 00");
    script.send("625#40 01 18 01 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  000#02 00
        500   MSP urgent StateLowered
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 71 00 00 00 00 00 00
        500   <-  7E5#42 01 00 01 00 00 00 00
        500   <-  7E5#43 67 F5 52 4D 00 00 00
        500   ->  7E4#44 00 00 00 00 00 00 00
        500   <-  7E5#11 25
        500   ->  7E4#11 00 00 00 00 00 00 00
        500   <-  7E5#17 00
        500   do  Store(Record { key: 210100, value: 25 })
        500   do  Confirm(1)
        500   ->  7E4#17 00 00 00 00 00 00 00
        500   <-  7E5#04 00
        500   <-  000#82 7F
        500   ->  725#00
        500   MSP urgent StateLowered
        500   do  FiltersChanged
        510   <-  625#40 01 21 00 00 00 00 00
        510   ->  5A5#4F 01 21 00 25 00 00 00
        510   <-  625#40 01 18 01 00 00 00 00
        510   ->  5A5#43 01 18 01 A5 02 00 40
    "#]]);
}

/// NM17x LSS-06: what could not be stored is told, and the stored number stays.
#[test]
fn a_failed_store_is_told() {
    let mut script = Script::booted();
    script.memory = Err(NotSaved);
    select(&mut script).send("7E5#11 25").send("7E5#17 00").send("7E5#04 00");
    script.send("67F#40 01 21 00 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 71 00 00 00 00 00 00
        500   <-  7E5#42 01 00 01 00 00 00 00
        500   <-  7E5#43 67 F5 52 4D 00 00 00
        500   ->  7E4#44 00 00 00 00 00 00 00
        500   <-  7E5#11 25
        500   ->  7E4#11 00 00 00 00 00 00 00
        500   <-  7E5#17 00
        500   do  Store(Record { key: 210100, value: 25 })
        500   do  Confirm(1)
        500   ->  7E4#17 02 00 00 00 00 00 00
        500   <-  7E5#04 00
        500   <-  67F#40 01 21 00 00 00 00 00
        500   ->  5FF#4F 01 21 00 7F 00 00 00
    "#]]);
}

/// NM17x LSS-05, LSS-07, A-02, A-26: silence, the new rate, silence, boot-up; stored or not.
#[test]
fn a_bit_rate_is_activated() {
    let mut script = Script::booted();
    select(&mut script).send("7E5#13 00 02").send("7E5#17 00").send("67F#40 00 21 00 00 00 00 00");
    assert_eq!(script.interface.bit_rate(), 125_000);
    script.send("7E5#15 64 00").send("67F#40 00 21 00 00 00 00 00").run(99);
    assert_eq!(script.interface.bit_rate(), 125_000);
    script.run(2).send("67F#40 00 21 00 00 00 00 00");
    assert_eq!(script.interface.bit_rate(), 500_000);
    script.run(100).send("67F#40 00 21 00 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 71 00 00 00 00 00 00
        500   <-  7E5#42 01 00 01 00 00 00 00
        500   <-  7E5#43 67 F5 52 4D 00 00 00
        500   ->  7E4#44 00 00 00 00 00 00 00
        500   <-  7E5#13 00 02
        500   ->  7E4#13 00 00 00 00 00 00 00
        500   <-  7E5#17 00
        500   do  Store(Record { key: 210100, value: 7F })
        500   do  Store(Record { key: 210000, value: 6 })
        500   do  Confirm(1)
        500   ->  7E4#17 00 00 00 00 00 00 00
        500   <-  67F#40 00 21 00 00 00 00 00
        500   ->  5FF#4F 00 21 00 06 00 00 00
        500   <-  7E5#15 64 00
        500   MSP urgent StateLowered
        500   <-  67F#40 00 21 00 00 00 00 00
        600   do  FiltersChanged
        601   <-  67F#40 00 21 00 00 00 00 00
        700   ->  77F#00
        701   <-  67F#40 00 21 00 00 00 00 00
        701   ->  5FF#4F 00 21 00 06 00 00 00
    "#]]);
    let restarted = Script::powered(&PRODUCT, &[(0x21_0000, 6)]);
    assert_eq!(restarted.interface.bit_rate(), 500_000);
}

/// NM17x LSS-08, LSS-09, A-28: inquiries answer in configuration only.
#[test]
fn inquiries_of_the_selected_device() {
    let mut script = Script::booted();
    for _ in 0..2 {
        for request in ["7E5#5A", "7E5#5B", "7E5#5C", "7E5#5D", "7E5#5E"] {
            script.send(request);
        }
        select(&mut script);
    }
    script.expect(expect![[r#"
        500   <-  7E5#5A
        500   <-  7E5#5B
        500   <-  7E5#5C
        500   <-  7E5#5D
        500   <-  7E5#5E
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 71 00 00 00 00 00 00
        500   <-  7E5#42 01 00 01 00 00 00 00
        500   <-  7E5#43 67 F5 52 4D 00 00 00
        500   ->  7E4#44 00 00 00 00 00 00 00
        500   <-  7E5#5A
        500   ->  7E4#5A EC 00 00 00 00 00 00
        500   <-  7E5#5B
        500   ->  7E4#5B 71 00 00 00 00 00 00
        500   <-  7E5#5C
        500   ->  7E4#5C 01 00 01 00 00 00 00
        500   <-  7E5#5D
        500   ->  7E4#5D 67 F5 52 4D 00 00 00
        500   <-  7E5#5E
        500   ->  7E4#5E 7F 00 00 00 00 00 00
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 71 00 00 00 00 00 00
        500   <-  7E5#42 01 00 01 00 00 00 00
        500   <-  7E5#43 67 F5 52 4D 00 00 00
        500   ->  7E4#44 00 00 00 00 00 00 00
    "#]]);
}

/// NM17x ADDR-07 to ADDR-10, LSS-10, DISP-15 (V-DEVADR-01 to V-DEVADR-10), A-49: every offer is told
/// to the application controller; the one that is touched is stored and answered once, an earlier
/// one not at all.
#[test]
fn the_user_takes_an_offer() {
    let mut script = Script::booted();
    script.send("000#02 00").send("7E5#04 01").send("7E5#40 EC 00 00 00 00 00 00");
    script.send("7E5#41 FF FF FF FF 00 00 00").send("7E5#42 FF FF FF FF 00 00 00");
    script.send("7E5#43 FF FF FF FF 00 00 00");
    script.send("7E5#11 02 00 00 00 00 00 00").run(20);
    script.send("7E5#11 03 00 00 00 00 00 00").run(20);
    script.touch(1).run(20);
    script.touch(2).run(20);
    script.touch(2).run(20);
    script.send("7E5#04 00").touch(2).run(20);
    script.send("000#81 00");
    script.expect(expect![[r#"
        500   <-  000#02 00
        500   MSP urgent StateLowered
        500   <-  7E5#04 01
        500   <-  7E5#40 EC 00 00 00 00 00 00
        500   <-  7E5#41 FF FF FF FF 00 00 00
        500   <-  7E5#42 FF FF FF FF 00 00 00
        500   <-  7E5#43 FF FF FF FF 00 00 00
        500   <-  7E5#11 02 00 00 00 00 00 00
        510   MSP write 2101:1 = 258
        520   <-  7E5#11 03 00 00 00 00 00 00
        530   MSP write 2101:1 = 515
        540   MSP touched during offer 1
        560   MSP touched during offer 2
        560   do  Store(Record { key: 210100, value: 3 })
        560   do  Confirm(1)
        560   ->  7E4#11 00 00 00 00 00 00 00
        570   MSP write 2101:1 = 3
        580   MSP touched during offer 2
        590   MSP write 2101:1 = 3
        600   <-  7E5#04 00
        600   MSP touched during offer 2
        610   MSP write 2101:1 = 0
        620   <-  000#81 00
        620   MSP urgent StateLowered
        620   do  Restart
    "#]]);
}
