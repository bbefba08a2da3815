//! Receive PDOs: broadcast and setpoint.

use expect_test::expect;
use profiles::nm170;

use crate::script::Script;

/// In Operational, with the first TxPDO2 sent.
fn operational() -> Script {
    let mut script = Script::booted();
    script.send("000#01 7F").run(200).transcript.clear();
    script
}

/// NM17x PDO-10, PDO-12, PDO-13, PDO-14, PDO-15, OD-2500-1 (V-PDO-BCAST, D-10, D-11): one object on
/// every device, and what came last reads back. Other objects, bad values and short frames change
/// nothing (A-45).
#[test]
fn a_broadcast_writes_one_object() {
    let mut script = operational();
    for frame in [
        "201#00 01 20 00 01 00 00 00",
        "201#00 4D 20 01 02 00 00 00",
        "201#00 4D 20 01 00 00 00 00",
        "201#00 10 20 00 01 00 00 00",
        "201#00 01 20 00 02 00 00 00",
        "201#00 4D 20 02 00 01 00 00",
        "201#00 01 20 00 01 00 00",
    ] {
        script.send(frame).run(20);
    }
    for request in [
        "67F#40 01 20 00 00 00 00 00",
        "67F#40 4D 20 01 00 00 00 00",
        "67F#40 00 25 02 00 00 00 00",
        "67F#40 00 25 03 00 00 00 00",
        "67F#40 00 25 04 00 00 00 00",
    ] {
        script.send(request);
    }
    script.expect(expect![[r#"
        700   <-  201#00 01 20 00 01 00 00 00
        710   MSP write 2001:0 = 1
        720   <-  201#00 4D 20 01 02 00 00 00
        730   MSP write 204d:1 = 2
        740   <-  201#00 4D 20 01 00 00 00 00
        740   MSP urgent MotorStop
        760   <-  201#00 10 20 00 01 00 00 00
        760   ->  0FF#20 82 00 00 00 00 00 01
        780   <-  201#00 01 20 00 02 00 00 00
        780   ->  0FF#20 82 00 00 00 00 00 03
        800   <-  201#00 4D 20 02 00 01 00 00
        800   ->  0FF#20 82 00 00 00 00 00 03
        820   <-  201#00 01 20 00 01 00 00
        820   ->  0FF#10 82 00 00 00 00 00 01
        840   <-  67F#40 01 20 00 00 00 00 00
        840   ->  5FF#43 01 20 00 01 00 00 00
        840   <-  67F#40 4D 20 01 00 00 00 00
        840   ->  5FF#4F 4D 20 01 00 00 00 00
        840   <-  67F#40 00 25 02 00 00 00 00
        840   ->  5FF#4B 00 25 02 4D 20 00 00
        840   <-  67F#40 00 25 03 00 00 00 00
        840   ->  5FF#4F 00 25 03 02 00 00 00
        840   <-  67F#40 00 25 04 00 00 00 00
        840   ->  5FF#43 00 25 04 00 01 00 00
    "#]]);
}

/// NM17x PDO-16, PDO-17, PDO-19, OD-2501-1, POS-12 (D-06): the correction goes ahead of the setpoint
/// that comes into force with it; an equal one is not written again (A-44).
#[test]
fn a_setpoint_comes_with_its_correction() {
    let mut script = operational();
    script.send("37F#8A 66 00 00 96 E7 03 00").run(50);
    script.send("37F#8A 66 00 00 96 E7 03 80").run(50);
    for request in [
        "67F#40 10 20 00 00 00 00 00",
        "67F#40 20 20 02 00 00 00 00",
        "67F#40 01 25 01 00 00 00 00",
        "67F#40 01 25 02 00 00 00 00",
        "67F#40 01 25 03 00 00 00 00",
    ] {
        script.send(request);
    }
    script.expect(expect![[r#"
        700   <-  37F#8A 66 00 00 96 E7 03 00
        700   ->  2FF#20 A1 07 00 96 E7 00 00
        710   MSP write 2010:0 = 4294961046
        720   MSP write 2020:2 = 26250
        750   <-  37F#8A 66 00 00 96 E7 03 80
        760   MSP write 2020:2 = 26250
        800   <-  67F#40 10 20 00 00 00 00 00
        800   ->  5FF#43 10 20 00 96 E7 FF FF
        800   <-  67F#40 20 20 02 00 00 00 00
        800   ->  5FF#43 20 20 02 8A 66 00 00
        800   <-  67F#40 01 25 01 00 00 00 00
        800   ->  5FF#43 01 25 01 8A 66 00 00
        800   <-  67F#40 01 25 02 00 00 00 00
        800   ->  5FF#4B 01 25 02 96 E7 00 00
        800   <-  67F#40 01 25 03 00 00 00 00
        800   ->  5FF#4B 01 25 03 03 80 00 00
    "#]]);
}

/// NM17x PDO-20: each row of the manual's table reaches its object.
#[test]
fn every_row_reaches_its_object() {
    let mut script = operational();
    for control in [
        "21 00", "07 00", "01 00", "03 00", "09 00", "11 00", "19 00", "0B 00", "13 00", "1B 00",
        "89 00", "91 00", "99 00", "09 01", "11 01", "19 01", "01 02", "03 02",
    ] {
        script.send(&format!("37F#E8 03 00 00 00 00 {control}")).run(40);
    }
    script.expect(expect![[r#"
        700   <-  37F#E8 03 00 00 00 00 21 00
        710   MSP write 2045:3 = 1000
        740   <-  37F#E8 03 00 00 00 00 07 00
        750   MSP write 2020:5 = 1000
        780   <-  37F#E8 03 00 00 00 00 01 00
        790   MSP write 2020:1 = 1000
        820   <-  37F#E8 03 00 00 00 00 03 00
        830   MSP write 2020:2 = 1000
        860   <-  37F#E8 03 00 00 00 00 09 00
        870   MSP write 2020:6 = 1000
        900   <-  37F#E8 03 00 00 00 00 11 00
        910   MSP write 2020:8 = 1
        920   MSP write 2020:6 = 1000
        940   <-  37F#E8 03 00 00 00 00 19 00
        950   MSP write 2020:8 = 2
        960   MSP write 2020:6 = 1000
        980   <-  37F#E8 03 00 00 00 00 0B 00
        990   MSP write 2020:8 = 0
        1000  MSP write 2020:7 = 1000
        1020  <-  37F#E8 03 00 00 00 00 13 00
        1030  MSP write 2020:8 = 1
        1040  MSP write 2020:7 = 1000
        1060  <-  37F#E8 03 00 00 00 00 1B 00
        1070  MSP write 2020:8 = 2
        1080  MSP write 2020:7 = 1000
        1100  <-  37F#E8 03 00 00 00 00 89 00
        1110  MSP write 204d:3 = 11
        1140  <-  37F#E8 03 00 00 00 00 91 00
        1150  MSP write 204d:3 = 12
        1180  <-  37F#E8 03 00 00 00 00 99 00
        1190  MSP write 204d:3 = 13
        1220  <-  37F#E8 03 00 00 00 00 09 01
        1230  MSP write 204d:3 = 21
        1260  <-  37F#E8 03 00 00 00 00 11 01
        1270  MSP write 204d:3 = 22
        1300  <-  37F#E8 03 00 00 00 00 19 01
        1310  MSP write 204d:3 = 23
        1340  <-  37F#E8 03 00 00 00 00 01 02
        1350  MSP write 2048:0 = 0
        1380  <-  37F#E8 03 00 00 00 00 03 02
        1390  MSP write 2048:0 = 1
    "#]]);
}

/// NM17x PDO-21, PDO-22, PDO-24, ABORT-01 (D-07 to D-09), A-43, A-45: a stop acts with any other
/// bits, a word without meaning or a setpoint beyond the limits does nothing at all.
#[test]
fn what_is_not_permitted_moves_nothing() {
    let mut script = operational();
    for frame in [
        "37F#00 00 00 00 00 00 00 00",
        "37F#00 00 00 00 00 00 81 01",
        "37F#40 42 0F 00 64 00 03 00",
        "37F#E8 03 00 00 64 00 03",
        "37F#E8 03 00 00 64 00 FF 7F",
    ] {
        script.send(frame).run(20);
    }
    script.send("67F#40 10 20 00 00 00 00 00");
    script.expect(expect![[r#"
        700   <-  37F#00 00 00 00 00 00 00 00
        720   <-  37F#00 00 00 00 00 00 81 01
        720   ->  0FF#30 82 00 00 00 00 00 01
        740   <-  37F#40 42 0F 00 64 00 03 00
        740   ->  0FF#20 82 00 00 00 00 00 03
        760   <-  37F#E8 03 00 00 64 00 03
        760   ->  0FF#10 82 00 00 00 00 00 01
        780   <-  37F#E8 03 00 00 64 00 FF 7F
        780   MSP urgent MotorStop
        800   <-  67F#40 10 20 00 00 00 00 00
        800   ->  5FF#43 10 20 00 00 00 00 00
    "#]]);
}

/// NM17x LINK-07, A-46: a stop overtakes what waits, and starts that wait never happen.
#[test]
fn a_stop_drops_starts_that_wait() {
    let mut script = operational();
    for n in 0..4 {
        script.send(&format!("67F#23 03 20 00 0{n} 00 00 00"));
    }
    script.send("67F#23 20 20 02 E8 03 00 00").send("67F#2F 4D 20 01 01 00 00 00");
    script.send("67F#23 02 20 00 64 00 00 00").send("67F#2F 4D 20 01 00 00 00 00").run(200);
    script.expect(expect![[r#"
        700   <-  67F#23 03 20 00 00 00 00 00
        700   ->  5FF#60 03 20 00 00 00 00 00
        700   <-  67F#23 03 20 00 01 00 00 00
        700   ->  5FF#60 03 20 00 00 00 00 00
        700   <-  67F#23 03 20 00 02 00 00 00
        700   ->  5FF#60 03 20 00 00 00 00 00
        700   <-  67F#23 03 20 00 03 00 00 00
        700   ->  5FF#60 03 20 00 00 00 00 00
        700   <-  67F#23 20 20 02 E8 03 00 00
        700   ->  5FF#60 20 20 02 00 00 00 00
        700   <-  67F#2F 4D 20 01 01 00 00 00
        700   ->  5FF#60 4D 20 01 00 00 00 00
        700   <-  67F#23 02 20 00 64 00 00 00
        700   ->  5FF#60 02 20 00 00 00 00 00
        700   <-  67F#2F 4D 20 01 00 00 00 00
        700   ->  5FF#60 4D 20 01 00 00 00 00
        700   MSP urgent MotorStop
        710   MSP write 2003:0 = 0
        720   MSP write 2003:0 = 1
        730   MSP write 2003:0 = 2
        740   MSP write 2003:0 = 3
        750   MSP write 2002:0 = 100
    "#]]);
}

/// NM17x PDO-18, A-42: TxPDO2 returns what RxPDO2 brought, the value that leaves 0x2010 alone
/// included, until 0x2010 is written; nothing while the correction is off.
#[test]
fn the_correction_returns_with_tpdo2() {
    let mut script = operational();
    script.send("37F#E8 03 00 00 96 E7 01 00").run(100);
    script.send("37F#E8 03 00 00 00 80 01 00").run(100);
    script.send("67F#40 10 20 00 00 00 00 00").send("67F#23 10 20 00 A0 86 01 00").run(100);
    script.send("67F#23 00 20 06 00 00 00 00").run(100);
    script.send("67F#2B 01 25 04 01 00 00 00").run(100).send("67F#40 01 25 04 00 00 00 00");
    script.expect(expect![[r#"
        700   <-  37F#E8 03 00 00 96 E7 01 00
        700   ->  2FF#20 A1 07 00 96 E7 00 00
        710   MSP write 2010:0 = 4294961046
        720   MSP write 2020:1 = 1000
        800   <-  37F#E8 03 00 00 00 80 01 00
        800   ->  2FF#20 A1 07 00 00 80 00 00
        810   MSP write 2020:1 = 1000
        900   <-  67F#40 10 20 00 00 00 00 00
        900   ->  5FF#43 10 20 00 96 E7 FF FF
        900   <-  67F#23 10 20 00 A0 86 01 00
        900   ->  5FF#60 10 20 00 00 00 00 00
        900   ->  2FF#20 A1 07 00 FF 7F 00 00
        910   MSP write 2010:0 = 100000
        1000  <-  67F#23 00 20 06 00 00 00 00
        1000  ->  5FF#60 00 20 06 00 00 00 00
        1000  ->  2FF#20 A1 07 00 00 00 00 00
        1010  MSP write 2000:6 = 0
        1100  <-  67F#2B 01 25 04 01 00 00 00
        1100  ->  5FF#60 01 25 04 00 00 00 00
        1200  <-  67F#40 01 25 04 00 00 00 00
        1200  ->  5FF#4B 01 25 04 00 00 00 00
    "#]]);
}

/// NM17x LINK-05, EMCY-05, A-30: a PDO that finds the queue full is dropped as a whole.
#[test]
fn a_pdo_that_can_not_be_queued_is_reported() {
    let mut script = operational();
    script.partner.connected = false;
    for n in 0..49 {
        script.send(&format!("67F#23 03 20 00 {n:02X} 00 00 00"));
    }
    script.transcript.clear();
    script.send("37F#E8 03 00 00 64 00 09 00").send("201#00 01 20 00 01 00 00 00");
    script.send("67F#40 10 20 00 00 00 00 00");
    script.expect(expect![[r#"
        700   <-  37F#E8 03 00 00 64 00 09 00
        700   ->  0FF#20 82 00 00 00 00 00 02
        700   <-  201#00 01 20 00 01 00 00 00
        700   <-  67F#40 10 20 00 00 00 00 00
        700   ->  5FF#43 10 20 00 00 00 00 00
    "#]]);
}

/// NM17x GEN-01, OD-2006-1, A-37, A-38 (D-13): a device without motor has no motor objects, and takes
/// setpoints alone.
#[test]
fn a_device_without_motor() {
    let mut script = Script::powered(&nm170::PRODUCT, &[]);
    script.run(500).send("000#01 7F").run(200);
    for request in [
        "67F#40 18 10 02 00 00 00 00",
        "67F#40 06 20 02 00 00 00 00",
        "67F#40 4E 20 01 00 00 00 00",
        "67F#40 20 20 00 00 00 00 00",
        "67F#23 20 20 02 E8 03 00 00",
        "67F#23 00 20 03 04 00 00 00",
        "37F#E8 03 00 00 64 00 01 00",
        "37F#E8 03 00 00 64 00 03 00",
        "37F#E8 03 00 00 64 00 00 40",
        "201#00 4D 20 01 01 00 00 00",
    ] {
        script.send(request).run(20);
    }
    script.expect(expect![[r#"
        140   ->  77F#00
        500   <-  000#01 7F
        500   ->  2FF#20 A1 07 00 00 00 00 00
        700   <-  67F#40 18 10 02 00 00 00 00
        700   ->  5FF#43 18 10 02 70 00 00 00
        720   <-  67F#40 06 20 02 00 00 00 00
        720   ->  5FF#43 06 20 02 81 80 00 00
        740   <-  67F#40 4E 20 01 00 00 00 00
        740   ->  5FF#80 4E 20 01 00 00 02 06
        760   <-  67F#40 20 20 00 00 00 00 00
        760   ->  5FF#4F 20 20 00 08 00 00 00
        780   <-  67F#23 20 20 02 E8 03 00 00
        780   ->  5FF#80 20 20 02 11 00 09 06
        800   <-  67F#23 00 20 03 04 00 00 00
        800   ->  5FF#80 00 20 03 30 00 09 06
        820   <-  37F#E8 03 00 00 64 00 01 00
        820   ->  2FF#20 A1 07 00 64 00 00 00
        830   MSP write 2010:0 = 100
        840   MSP write 2020:1 = 1000
        840   <-  37F#E8 03 00 00 64 00 03 00
        840   ->  0FF#30 82 00 00 00 00 00 01
        860   <-  37F#E8 03 00 00 64 00 00 40
        880   <-  201#00 4D 20 01 01 00 00 00
        880   ->  0FF#20 82 00 00 00 00 00 01
    "#]]);
}

/// NM17x PDO-26, BOOT-08, PDO-06: the mappings are fixed, and what PDOs left behind reads 0 after
/// power-up.
#[test]
fn mappings_are_fixed() {
    let mut script = Script::booted();
    for object in [
        "00 16 01", "00 16 02", "00 16 03", "00 16 04", "01 16 01", "01 16 02", "01 16 03",
        "00 1A 01", "00 1A 02", "00 1A 03", "01 1A 01", "01 1A 02", "01 1A 03", "00 18 05",
        "01 18 05", "00 25 01", "00 25 02", "00 25 03", "00 25 04", "01 25 01", "01 25 02",
        "01 25 03", "01 25 04",
    ] {
        script.send(&format!("67F#40 {object} 00 00 00 00"));
    }
    for object in ["00 16 00", "01 16 01", "00 1A 00", "01 1A 03"] {
        script.send(&format!("67F#2F {object} 00 00 00 00"));
    }
    script.expect(expect![[r#"
        500   <-  67F#40 00 16 01 00 00 00 00
        500   ->  5FF#43 00 16 01 08 01 00 25
        500   <-  67F#40 00 16 02 00 00 00 00
        500   ->  5FF#43 00 16 02 10 02 00 25
        500   <-  67F#40 00 16 03 00 00 00 00
        500   ->  5FF#43 00 16 03 08 03 00 25
        500   <-  67F#40 00 16 04 00 00 00 00
        500   ->  5FF#43 00 16 04 20 04 00 25
        500   <-  67F#40 01 16 01 00 00 00 00
        500   ->  5FF#43 01 16 01 20 01 01 25
        500   <-  67F#40 01 16 02 00 00 00 00
        500   ->  5FF#43 01 16 02 10 02 01 25
        500   <-  67F#40 01 16 03 00 00 00 00
        500   ->  5FF#43 01 16 03 10 03 01 25
        500   <-  67F#40 00 1A 01 00 00 00 00
        500   ->  5FF#43 00 1A 01 20 00 04 60
        500   <-  67F#40 00 1A 02 00 00 00 00
        500   ->  5FF#43 00 1A 02 10 01 4E 20
        500   <-  67F#40 00 1A 03 00 00 00 00
        500   ->  5FF#43 00 1A 03 10 02 4E 20
        500   <-  67F#40 01 1A 01 00 00 00 00
        500   ->  5FF#43 01 1A 01 20 00 04 60
        500   <-  67F#40 01 1A 02 00 00 00 00
        500   ->  5FF#43 01 1A 02 10 04 01 25
        500   <-  67F#40 01 1A 03 00 00 00 00
        500   ->  5FF#43 01 1A 03 10 01 4E 20
        500   <-  67F#40 00 18 05 00 00 00 00
        500   ->  5FF#4B 00 18 05 E8 03 00 00
        500   <-  67F#40 01 18 05 00 00 00 00
        500   ->  5FF#4B 01 18 05 01 00 00 00
        500   <-  67F#40 00 25 01 00 00 00 00
        500   ->  5FF#4F 00 25 01 00 00 00 00
        500   <-  67F#40 00 25 02 00 00 00 00
        500   ->  5FF#4B 00 25 02 00 00 00 00
        500   <-  67F#40 00 25 03 00 00 00 00
        500   ->  5FF#4F 00 25 03 00 00 00 00
        500   <-  67F#40 00 25 04 00 00 00 00
        500   ->  5FF#43 00 25 04 00 00 00 00
        500   <-  67F#40 01 25 01 00 00 00 00
        500   ->  5FF#43 01 25 01 00 00 00 00
        500   <-  67F#40 01 25 02 00 00 00 00
        500   ->  5FF#4B 01 25 02 00 00 00 00
        500   <-  67F#40 01 25 03 00 00 00 00
        500   ->  5FF#4B 01 25 03 00 00 00 00
        500   <-  67F#40 01 25 04 00 00 00 00
        500   ->  5FF#4B 01 25 04 00 00 00 00
        500   <-  67F#2F 00 16 00 00 00 00 00
        500   ->  5FF#80 00 16 00 02 00 01 06
        500   <-  67F#2F 01 16 01 00 00 00 00
        500   ->  5FF#80 01 16 01 02 00 01 06
        500   <-  67F#2F 00 1A 00 00 00 00 00
        500   ->  5FF#80 00 1A 00 02 00 01 06
        500   <-  67F#2F 01 1A 03 00 00 00 00
        500   ->  5FF#80 01 1A 03 02 00 01 06
    "#]]);
}
