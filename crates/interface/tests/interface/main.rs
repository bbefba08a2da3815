//! The devices of the family as masters see them.

mod display;
mod errors;
mod lss;
mod pdo;
mod script;
mod store;

use canopen::BusState;
use expect_test::expect;
use interface::{Event, Record};
use object_dictionary::Slot;
use profiles::nm172::PRODUCT;
use script::Script;

/// NM17x BOOT-03, NMT-03, V-BOOTUP: boot-up behind the application's values, then Pre-operational.
#[test]
fn a_device_boots() {
    let mut script = Script::new();
    script.run(400).send("67F#40 00 10 00 00 00 00 00").send("67F#40 18 10 04 00 00 00 00");
    script.expect(expect![[r#"
        340   ->  77F#00
        400   <-  67F#40 00 10 00 00 00 00 00
        400   ->  5FF#43 00 10 00 96 01 02 00
        400   <-  67F#40 18 10 04 00 00 00 00
        400   ->  5FF#43 18 10 04 67 F5 52 4D
    "#]]);
}

/// NM17x SDO-10: the five examples of the manual, byte for byte (V-SDO-1 to V-SDO-5).
#[test]
fn the_examples_of_the_manual() {
    let mut script = Script::booted();
    for request in [
        "67F#40 04 60 00 00 00 00 00",
        "67F#23 03 20 00 40 01 00 00",
        "67F#40 01 21 00 00 00 00 00",
        "67F#23 00 20 05 01 00 00 00",
        "67F#23 00 20 05 02 00 00 00",
    ] {
        script.send(request).run(20);
    }
    script.expect(expect![[r#"
        500   <-  67F#40 04 60 00 00 00 00 00
        500   ->  5FF#43 04 60 00 20 A1 07 00
        520   <-  67F#23 03 20 00 40 01 00 00
        520   ->  5FF#60 03 20 00 00 00 00 00
        530   MSP write 2003:0 = 320
        540   <-  67F#40 01 21 00 00 00 00 00
        540   ->  5FF#4F 01 21 00 7F 00 00 00
        560   <-  67F#23 00 20 05 01 00 00 00
        560   ->  5FF#60 00 20 05 00 00 00 00
        570   MSP write 2000:5 = 1
        580   <-  67F#23 00 20 05 02 00 00 00
        580   ->  5FF#80 00 20 05 30 00 09 06
    "#]]);
}

/// NM17x POS-08, A-54: without a scaling there is nothing to preset.
#[test]
fn a_preset_needs_a_scaling() {
    let mut script = Script::booted();
    script.send("67F#23 03 60 00 E8 03 00 00").send("67F#23 04 20 00 00 00 00 00");
    script.send("67F#23 03 60 00 E9 03 00 00").send("67F#40 03 60 00 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  67F#23 03 60 00 E8 03 00 00
        500   ->  5FF#60 03 60 00 00 00 00 00
        500   <-  67F#23 04 20 00 00 00 00 00
        500   ->  5FF#60 04 20 00 00 00 00 00
        500   <-  67F#23 03 60 00 E9 03 00 00
        500   ->  5FF#80 03 60 00 00 00 00 08
        500   <-  67F#40 03 60 00 00 00 00 00
        500   ->  5FF#43 03 60 00 E8 03 00 00
    "#]]);
}

/// NM17x LINK-04: a write reads back at once and reaches the application in the next gap.
#[test]
fn writes_read_back_at_once() {
    let mut script = Script::booted();
    for value in 1..=3 {
        script.send(&format!("67F#23 03 20 00 {value:02X} 00 00 00"));
        script.send("67F#40 03 20 00 00 00 00 00");
    }
    script.run(40);
    script.expect(expect![[r#"
        500   <-  67F#23 03 20 00 01 00 00 00
        500   ->  5FF#60 03 20 00 00 00 00 00
        500   <-  67F#40 03 20 00 00 00 00 00
        500   ->  5FF#43 03 20 00 01 00 00 00
        500   <-  67F#23 03 20 00 02 00 00 00
        500   ->  5FF#60 03 20 00 00 00 00 00
        500   <-  67F#40 03 20 00 00 00 00 00
        500   ->  5FF#43 03 20 00 02 00 00 00
        500   <-  67F#23 03 20 00 03 00 00 00
        500   ->  5FF#60 03 20 00 00 00 00 00
        500   <-  67F#40 03 20 00 00 00 00 00
        500   ->  5FF#43 03 20 00 03 00 00 00
        510   MSP write 2003:0 = 1
        520   MSP write 2003:0 = 2
        530   MSP write 2003:0 = 3
    "#]]);
}

/// NM17x LINK-05, EMCY-05, A-21: the 51st write in a row is refused with an emergency message.
#[test]
fn the_write_queue_overflows() {
    let mut script = Script::booted();
    for _ in 0..50 {
        script.send("67F#23 03 20 00 05 00 00 00");
    }
    script.transcript.clear();
    script.send("67F#23 03 20 00 06 00 00 00").run(10).send("67F#23 03 20 00 07 00 00 00");
    script.expect(expect![[r#"
        500   <-  67F#23 03 20 00 06 00 00 00
        500   ->  5FF#80 03 20 00 00 00 06 06
        500   ->  0FF#01 83 00 00 00 00 00 01
        510   MSP write 2003:0 = 5
        510   <-  67F#23 03 20 00 07 00 00 00
        510   ->  5FF#60 03 20 00 00 00 00 00
    "#]]);
}

/// NM17x LINK-06, EMCY-05: without process data there is no position, and no restart is needed.
#[test]
fn the_link_is_lost_and_found() {
    let mut script = Script::booted();
    script.send("000#01 7F").partner.connected = false;
    script.run(100).send("67F#40 04 60 00 00 00 00 00").send("67F#23 03 20 00 05 00 00 00");
    script.send("67F#40 03 20 00 00 00 00 00").partner.connected = true;
    script.run(400).send("67F#40 04 60 00 00 00 00 00");
    script.expect(expect![[r#"
        500   <-  000#01 7F
        500   ->  2FF#20 A1 07 00 00 00 00 00
        525   ->  0FF#10 83 00 00 00 00 00 01
        545   ->  0FF#10 83 01 00 00 00 00 04
        600   <-  67F#40 04 60 00 00 00 00 00
        600   ->  5FF#80 04 60 00 24 00 00 08
        600   <-  67F#23 03 20 00 05 00 00 00
        600   ->  5FF#80 03 20 00 00 00 06 06
        600   <-  67F#40 03 20 00 00 00 00 00
        600   ->  5FF#43 03 20 00 05 00 00 00
        940   ->  0FF#00 00 00 00 00 00 00 00
        1000  <-  67F#40 04 60 00 00 00 00 00
        1000  ->  5FF#43 04 60 00 20 A1 07 00
    "#]]);
}

/// NM17x LINK-06: a device whose application controller is dead still boots, after half a second.
#[test]
fn a_device_boots_without_its_application() {
    let mut script = Script::new();
    script.partner.connected = false;
    script.run(600).send("67F#40 00 10 00 00 00 00 00").send("67F#40 03 20 00 00 00 00 00");
    script.expect(expect![[r#"
        500   ->  77F#00
        500   ->  0FF#10 83 01 00 00 00 00 04
        600   <-  67F#40 00 10 00 00 00 00 00
        600   ->  5FF#43 00 10 00 96 01 02 00
        600   <-  67F#40 03 20 00 00 00 00 00
        600   ->  5FF#80 03 20 00 24 00 00 08
    "#]]);
}

/// NM17x NMT-02, NMT-04, NMT-07, ABORT-04: all five commands; every step down stops the
/// application.
#[test]
fn network_management() {
    let mut script = Script::booted();
    for command in ["01 7F", "80 00", "02 7F", "01 00", "02 7F", "80 7F", "82 7F", "81 7F"] {
        script.send(&format!("000#{command}")).run(10);
    }
    script.expect(expect![[r#"
        500   <-  000#01 7F
        500   ->  2FF#20 A1 07 00 00 00 00 00
        510   <-  000#80 00
        510   MSP urgent StateLowered
        520   <-  000#02 7F
        520   MSP urgent StateLowered
        530   <-  000#01 00
        540   <-  000#02 7F
        540   MSP urgent StateLowered
        550   <-  000#80 7F
        560   <-  000#82 7F
        560   ->  77F#00
        560   MSP urgent StateLowered
        560   do  FiltersChanged
        570   <-  000#81 7F
        570   MSP urgent StateLowered
        570   do  Restart
    "#]]);
}

/// NM17x STORE-02, LINK-05: what was confirmed to a master is with the application controller before
/// this one restarts.
#[test]
fn a_restart_waits_for_what_was_written() {
    let mut script = Script::booted();
    script.send("67F#23 03 20 00 05 00 00 00").send("67F#23 02 20 00 07 00 00 00");
    script.send("67F#23 04 20 00 09 00 00 00").send("000#81 7F");
    script.send("67F#23 02 20 00 00 00 00 00").run(100);
    script.expect(expect![[r#"
        500   <-  67F#23 03 20 00 05 00 00 00
        500   ->  5FF#60 03 20 00 00 00 00 00
        500   <-  67F#23 02 20 00 07 00 00 00
        500   ->  5FF#60 02 20 00 00 00 00 00
        500   <-  67F#23 04 20 00 09 00 00 00
        500   ->  5FF#60 04 20 00 00 00 00 00
        500   <-  000#81 7F
        500   MSP urgent StateLowered
        500   <-  67F#23 02 20 00 00 00 00 00
        510   MSP write 2003:0 = 5
        520   MSP write 2002:0 = 7
        530   MSP write 2004:0 = 9
        540   do  Restart
    "#]]);
}

/// NM17x LINK-03: what nobody acknowledges holds a restart up for a second.
#[test]
fn a_restart_waits_a_second_at_most() {
    let mut script = Script::booted();
    script.send("67F#23 03 20 00 05 00 00 00");
    script.partner.connected = false;
    script.send("000#81 7F").run(1_500);
    script.expect(expect![[r#"
        500   <-  67F#23 03 20 00 05 00 00 00
        500   ->  5FF#60 03 20 00 00 00 00 00
        500   <-  000#81 7F
        1500  do  Restart
    "#]]);
}

/// NM17x STORE-07, ADDR-02, OD-2101-1: node-ID and bit rate are saved at once and act after a restart.
#[test]
fn a_new_node_id_acts_after_a_restart() {
    let mut script = Script::booted();
    script.send("67F#2F 01 21 00 25 00 00 00").send("67F#2F 00 21 00 08 00 00 00");
    script.send("67F#40 01 21 00 00 00 00 00").send("67F#2F 01 21 00 80 00 00 00");
    script.send("000#81 7F");
    script.expect(expect![[r#"
        500   <-  67F#2F 01 21 00 25 00 00 00
        500   ->  5FF#60 01 21 00 00 00 00 00
        500   do  Store(Record { key: 210100, value: 25 })
        500   <-  67F#2F 00 21 00 08 00 00 00
        500   ->  5FF#60 00 21 00 00 00 00 00
        500   do  Store(Record { key: 210000, value: 8 })
        500   <-  67F#40 01 21 00 00 00 00 00
        500   ->  5FF#4F 01 21 00 25 00 00 00
        500   <-  67F#2F 01 21 00 80 00 00 00
        500   ->  5FF#80 01 21 00 30 00 09 06
        500   <-  000#81 7F
        500   MSP urgent StateLowered
        500   do  Restart
    "#]]);

    let mut restarted = Script::powered(&PRODUCT, &[(0x21_0100, 0x25), (0x21_0000, 8)]);
    assert_eq!(restarted.interface.bit_rate(), 1_000_000);
    restarted.run(400).send("625#40 01 21 00 00 00 00 00").send("625#40 01 18 01 00 00 00 00");
    restarted.expect(expect![[r#"
        340   ->  725#00
        400   <-  625#40 01 21 00 00 00 00 00
        400   ->  5A5#4F 01 21 00 25 00 00 00
        400   <-  625#40 01 18 01 00 00 00 00
        400   ->  5A5#43 01 18 01 A5 02 00 40
    "#]]);
}

/// NM17x PDO-05, PDO-09, PDO-18: TxPDO2 on a change of the position, not sooner than 80 ms after
/// the last, with the correction in force.
#[test]
fn the_position_is_sent_as_it_changes() {
    let mut script = Script::booted();
    script.send("000#01 7F").run(100);
    for position in [500_001, 500_002, 500_003] {
        script.partner.process.position_hundredths_mm = position;
        script.run(30);
    }
    script.run(100).send("67F#23 10 20 00 96 E7 FF FF").run(100);
    script.send("67F#23 00 20 06 00 00 00 00").run(100);
    script.expect(expect![[r#"
        500   <-  000#01 7F
        500   ->  2FF#20 A1 07 00 00 00 00 00
        610   ->  2FF#21 A1 07 00 00 00 00 00
        690   ->  2FF#23 A1 07 00 00 00 00 00
        790   <-  67F#23 10 20 00 96 E7 FF FF
        790   ->  5FF#60 10 20 00 00 00 00 00
        790   ->  2FF#23 A1 07 00 96 E7 00 00
        800   MSP write 2010:0 = 4294961046
        890   <-  67F#23 00 20 06 00 00 00 00
        890   ->  5FF#60 00 20 06 00 00 00 00
        890   ->  2FF#23 A1 07 00 00 00 00 00
        900   MSP write 2000:6 = 0
    "#]]);
}

/// NM17x EMCY-02, A-31, A-33: what the bus does to the error register, and when it is over.
#[test]
fn the_bus_gets_worse_and_recovers() {
    let mut script = Script::booted();
    script.bus(BusState::Warning).bus(BusState::Passive).bus(BusState::Off);
    script.send("67F#40 01 10 00 00 00 00 00").bus(BusState::Active);
    script.expect(expect![[r#"
        500   bus Warning
        500   ->  0FF#00 81 00 00 00 00 00 00
        500   bus Passive
        500   ->  0FF#20 81 11 00 00 00 00 00
        500   bus Off
        500   MSP urgent BusOff
        500   <-  67F#40 01 10 00 00 00 00 00
        500   ->  5FF#4F 01 10 00 11 00 00 00
        500   bus Active
        500   ->  0FF#40 81 11 00 00 00 00 00
        500   ->  0FF#00 00 00 00 00 00 00 00
    "#]]);
}

/// A-31, A-33: a restart of the communication ends no error that is still there.
#[test]
fn the_error_register_outlives_a_restart_of_the_communication() {
    let mut script = Script::booted();
    script.bus(BusState::Passive).send("000#82 7F").send("67F#40 01 10 00 00 00 00 00");
    script.bus(BusState::Active);
    script.expect(expect![[r#"
        500   bus Passive
        500   ->  0FF#20 81 11 00 00 00 00 00
        500   <-  000#82 7F
        500   ->  77F#00
        500   MSP urgent StateLowered
        500   do  FiltersChanged
        500   <-  67F#40 01 10 00 00 00 00 00
        500   ->  5FF#4F 01 10 00 11 00 00 00
        500   bus Active
        500   ->  0FF#00 00 00 00 00 00 00 00
    "#]]);
}

/// Numbers that belong to nobody, or are not permitted, do no harm.
#[test]
fn only_own_and_permitted_numbers_are_restored() {
    let stored = [(0x21_0100, 0), (0x21_0100, 128), (0x21_0000, 9), (0x20_0300, 7), (7, 7)];
    let mut script = Script::powered(&PRODUCT, &stored);
    assert_eq!(script.interface.bit_rate(), 125_000);
    script.run(400);
    script.expect(expect![[r#"
        340   ->  77F#00
    "#]]);
    let record = Event::Store(Record { key: 0x21_0100, value: 3 });
    script.send("67F#2F 01 21 00 03 00 00 00");
    assert!(script.transcript.contains(&format!("{record:X?}")), "{}", script.transcript);
    assert!(Slot::at(PRODUCT.dictionary, u16::MAX).is_none());
}
