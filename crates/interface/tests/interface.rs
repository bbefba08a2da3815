//! The NM172 as masters see it, with a partner on the link that has the values of delivery.

use std::fmt::Write as _;

use canopen::{CanId, Frame};
use expect_test::{Expect, expect};
use interface::{Boot, BusState, Event, Interface, Record};
use object_dictionary::Slot;
use profiles::nm172::PRODUCT;
use shared_proto::limits::SNAPSHOT_VALUES_MAX;
use shared_proto::{Hello, PROTOCOL, ProcessData, Receiver, ToApplication, ToInterface, encode};
use units::{Duration, Instant};

const CYCLE: Duration = Duration::from_millis(10);

/// The application controller as the link shows it: greets, has its values at their defaults,
/// acknowledges.
struct Partner {
    receiver: Receiver<ToApplication>,
    hello: Hello,
    process: ProcessData,
    answers: Vec<ToInterface>,
    connected: bool,
}

impl Partner {
    fn hear(&mut self, frame: &[u8]) -> Option<String> {
        let message = frame.iter().filter_map(|&byte| self.receiver.push(byte)).last()?;
        match message {
            ToApplication::Hello(hello) => {
                self.hello.heard = hello.nonce;
                self.hello.in_service = hello.heard == self.hello.nonce;
                self.answers.push(ToInterface::Hello(self.hello));
                None
            }
            ToApplication::Idle(_) => None,
            ToApplication::Write(_, write) => {
                self.process.acknowledged = write.sequence;
                Some(format!("write {:04x}:{} = {}", write.index, write.sub, write.value))
            }
            ToApplication::RequestSnapshot { from, .. } => {
                let rows = PRODUCT.dictionary.rows().iter().skip(from.into());
                let values = rows.take(SNAPSHOT_VALUES_MAX).map(|row| row.initial(127)).collect();
                self.answers.push(ToInterface::Snapshot { from, values });
                None
            }
            ToApplication::Urgent(_, urgent) => {
                self.process.urgent_acknowledged = urgent.number;
                Some(format!("urgent {:?}", urgent.urgency))
            }
        }
    }
}

struct Script {
    now: Instant,
    interface: Interface,
    partner: Partner,
    transcript: String,
}

impl Script {
    /// Just powered.
    fn new() -> Self {
        let boot = Boot { serial_number: 0x4D52_F567, nonce: 1 };
        let hello = Hello {
            protocol: PROTOCOL,
            product: PRODUCT.code,
            firmware: PRODUCT.firmware,
            dictionary: PRODUCT.fingerprint,
            nonce: 2,
            heard: 0,
            in_service: false,
        };
        Self {
            now: Instant::ZERO,
            interface: Interface::new(Instant::ZERO, &PRODUCT, boot),
            partner: Partner {
                receiver: Receiver::default(),
                hello,
                process: ProcessData { position_hundredths_mm: 500_000, ..Default::default() },
                answers: Vec::new(),
                connected: true,
            },
            transcript: String::new(),
        }
    }

    /// Booted, half a second ago.
    fn booted() -> Self {
        let mut script = Self::new();
        script.run(500);
        script.transcript.clear();
        script
    }

    /// Lets time pass. The partner speaks every 10 ms.
    fn run(&mut self, ms: u64) -> &mut Self {
        let end = self.now + Duration::from_millis(ms);
        let mut cycle_at = self.now + CYCLE;
        loop {
            let due = self.interface.poll_timeout().unwrap_or(end).max(self.now);
            let next = due.min(cycle_at).min(end);
            self.now = next;
            if due == next {
                self.interface.handle_timeout(self.now);
                self.drain();
            }
            if cycle_at == next {
                cycle_at = cycle_at + CYCLE;
                self.partner_speaks();
            }
            if next == end {
                return self;
            }
        }
    }

    fn partner_speaks(&mut self) {
        if !self.partner.connected {
            return;
        }
        let regular = if self.partner.hello.in_service {
            ToInterface::Process(self.partner.process)
        } else {
            ToInterface::Hello(self.partner.hello)
        };
        self.partner.answers.push(regular);
        while let Some(message) = self.partner.answers.pop() {
            self.interface.handle_link(self.now, &encode(&message));
            self.drain();
        }
    }

    /// A frame from a master: `id#data` in hexadecimal.
    fn send(&mut self, frame: &str) -> &mut Self {
        self.note("<-", frame);
        let (id, data) = frame.split_once('#').expect("id#data");
        let bytes: Vec<u8> = data
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16).expect("two hex digits"))
            .collect();
        let id = CanId::new(u16::from_str_radix(id, 16).expect("hexadecimal")).expect("11 bits");
        self.interface.handle_frame(self.now, &Frame::new(id, &bytes).expect("up to 8 bytes"));
        self.drain();
        self
    }

    fn bus(&mut self, state: BusState) -> &mut Self {
        self.note("bus", &format!("{state:?}"));
        self.interface.handle_bus(self.now, state);
        self.drain();
        self
    }

    fn drain(&mut self) {
        while let Some(frame) = self.interface.take_transmit() {
            let data: Vec<String> = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
            self.note("->", &format!("{:03X}#{}", frame.id().get(), data.join(" ")));
        }
        while let Some(frame) = self.interface.poll_link() {
            if self.partner.connected
                && let Some(order) = self.partner.hear(&frame)
            {
                self.note("MSP", &order);
            }
        }
        while let Some(event) = self.interface.poll_event() {
            self.note("do", &format!("{event:X?}"));
        }
    }

    fn note(&mut self, what: &str, detail: &str) {
        let ms = self.now.as_micros() / 1_000;
        writeln!(self.transcript, "{ms:<5} {what:3} {detail}").expect("a string takes everything");
    }

    #[track_caller]
    fn expect(&self, expected: Expect) {
        expected.assert_eq(&self.transcript);
    }
}

/// NM17x BOOT-03, NMT-03, V-BOOTUP: boot-up behind the application's values, then Pre-operational.
#[test]
fn a_device_boots() {
    let mut script = Script::new();
    script.run(200).send("67F#40 00 10 00 00 00 00 00").send("67F#40 18 10 04 00 00 00 00");
    script.expect(expect![[r#"
        140   ->  77F#00
        200   <-  67F#40 00 10 00 00 00 00 00
        200   ->  5FF#43 00 10 00 96 01 02 00
        200   <-  67F#40 18 10 04 00 00 00 00
        200   ->  5FF#43 18 10 04 67 F5 52 4D
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
        500   ->  0FF#01 83 00 00 00 00 00 01
        500   ->  5FF#80 03 20 00 00 00 06 06
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
    script.run(200).send("67F#40 04 60 00 00 00 00 00");
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
        740   ->  0FF#00 00 00 00 00 00 00 00
        800   <-  67F#40 04 60 00 00 00 00 00
        800   ->  5FF#43 04 60 00 20 A1 07 00
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

/// NM17x STORE-07, ADDR-02: node-ID and bit rate are saved at once and act after a restart.
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

    let mut restarted = Script::new();
    restarted.interface.restore(0x21_0100, 0x25);
    restarted.interface.restore(0x21_0000, 8);
    assert_eq!(restarted.interface.bit_rate(), 1_000_000);
    restarted.run(200).send("625#40 01 21 00 00 00 00 00").send("625#40 01 18 01 00 00 00 00");
    restarted.expect(expect![[r#"
        140   ->  725#00
        200   <-  625#40 01 21 00 00 00 00 00
        200   ->  5A5#4F 01 21 00 25 00 00 00
        200   <-  625#40 01 18 01 00 00 00 00
        200   ->  5A5#43 01 18 01 A5 02 00 40
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
    let mut script = Script::new();
    for (key, value) in [(0x21_0100, 0), (0x21_0100, 128), (0x21_0000, 9), (0x20_0300, 7), (7, 7)] {
        script.interface.restore(key, value);
    }
    assert_eq!(script.interface.bit_rate(), 125_000);
    script.run(200);
    script.expect(expect![[r#"
        140   ->  77F#00
    "#]]);
    let record = Event::Store(Record { key: 0x21_0100, value: 3 });
    script.send("67F#2F 01 21 00 03 00 00 00");
    assert!(script.transcript.contains(&format!("{record:X?}")), "{}", script.transcript);
    assert!(Slot::at(PRODUCT.dictionary, u16::MAX).is_none());
}
