//! The interface controller's end of the link, against a scripted partner.

use std::fmt::Write as _;

use expect_test::{Expect, expect};
use interface::link::{Event, Kind, Link, QueueError, WRITES_MAX};
use object_dictionary::ObjectId;
use shared_proto::{
    Hello, NodeState, PROTOCOL, ProcessData, Receiver, ToApplication, ToInterface, Urgency, encode,
};
use units::{Duration, Instant};

const WINDOW: ObjectId = ObjectId { index: 0x2003, sub: 0 };
const PRESET: ObjectId = ObjectId { index: 0x6003, sub: 0 };

const OWN: Hello = Hello {
    protocol: PROTOCOL,
    product: 0x71,
    firmware: 105,
    dictionary: 7,
    nonce: 0xAA,
    heard: 0,
    in_service: false,
};

fn hello(nonce: u32, heard: u32, in_service: bool) -> ToInterface {
    ToInterface::Hello(Hello { nonce, heard, in_service, ..OWN })
}

fn process(acknowledged: u8) -> ToInterface {
    ToInterface::Process(ProcessData { acknowledged, ..ProcessData::default() })
}

fn values(from: u16, count: u32) -> ToInterface {
    ToInterface::Snapshot { from, values: (0..count).collect() }
}

/// The partner's line and the master's wishes, with a transcript of what the link makes of them.
struct Script {
    now: Instant,
    link: Link,
    transcript: String,
}

impl Script {
    fn new() -> Self {
        let link = Link::new(Instant::ZERO, OWN, 40..55, 127);
        Self { now: Instant::ZERO, link, transcript: String::new() }
    }

    /// In service, with all values loaded.
    fn in_service() -> Self {
        let mut script = Self::new();
        script.hears(hello(0xBB, 0xAA, false)).hears(values(40, 10)).hears(values(50, 5));
        script.link.set_node_state(NodeState::Operational);
        script.transcript.clear();
        script
    }

    fn after(&mut self, ms: u64) -> &mut Self {
        let end = self.now + Duration::from_millis(ms);
        while self.link.poll_timeout() <= end {
            self.now = self.link.poll_timeout();
            self.link.handle_timeout(self.now);
            self.note("");
        }
        self.now = end;
        self
    }

    fn hears(&mut self, message: ToInterface) -> &mut Self {
        for byte in encode(&message) {
            self.link.handle_byte(self.now, byte);
        }
        let heard = match message {
            ToInterface::Hello(hello) => brief(&hello),
            ToInterface::Process(process) => format!("process, ack {}", process.acknowledged),
            ToInterface::Snapshot { from, values } => format!("{} values at {from}", values.len()),
            ToInterface::Touched { offer } => format!("touched during offer {offer}"),
        };
        self.note(&heard);
        self
    }

    fn cycle(&mut self, acknowledged: u8) -> &mut Self {
        self.after(10).hears(process(acknowledged))
    }

    fn note(&mut self, heard: &str) {
        let ms = self.now.as_micros() / 1_000;
        let mut said = Vec::new();
        while let Some(event) = self.link.poll_event() {
            said.push(match event {
                Event::Process(_) => continue,
                Event::Values(from, values) => format!("takes {} at {from}", values.len()),
                Event::SnapshotComplete => "complete".into(),
                Event::Touched(offer) => format!("offer {offer} touched"),
                Event::Fault(fault) => format!("{fault:?}"),
            });
        }
        let mut receiver = Receiver::default();
        while let Some(frame) = self.link.poll_transmit() {
            said.extend(frame.iter().filter_map(|&byte| receiver.push(byte)).map(answer));
        }
        if !heard.is_empty() || !said.is_empty() {
            let said = if said.is_empty() { "nothing".into() } else { said.join(", ") };
            writeln!(self.transcript, "{ms:<4} ms  {heard:24} -> {said}")
                .expect("a string takes everything");
        }
    }

    #[track_caller]
    fn expect(&self, expected: Expect) {
        expected.assert_eq(&self.transcript);
    }
}

fn brief(hello: &Hello) -> String {
    let service = if hello.in_service { " up" } else { "" };
    format!("hello {:x} heard {:x}{service}", hello.nonce, hello.heard)
}

fn answer(message: ToApplication) -> String {
    match message {
        ToApplication::Hello(hello) => brief(&hello),
        ToApplication::Idle(supervision) => format!("idle {:?}", supervision.state),
        ToApplication::Write(_, write) => {
            format!("write #{} {:04x}:{} = {}", write.sequence, write.index, write.sub, write.value)
        }
        ToApplication::RequestSnapshot { from, .. } => format!("wants values from {from}"),
        ToApplication::Urgent(_, urgent) => {
            format!("urgent #{} {:?}", urgent.number, urgent.urgency)
        }
    }
}

/// NM17x LINK-01, LINK-02: greeting, values, service.
#[test]
fn both_sides_start() {
    let mut script = Script::new();
    script.hears(hello(0xBB, 0, false)).after(10).hears(hello(0xBB, 0xAA, false));
    script.cycle(0).hears(values(40, 10)).hears(values(50, 5)).cycle(0);
    script.expect(expect![[r#"
        0    ms  hello bb heard 0         -> hello aa heard bb
        10   ms  hello bb heard aa        -> hello aa heard bb up
        20   ms  process, ack 0           -> wants values from 40
        20   ms  10 values at 40          -> takes 10 at 40
        20   ms  5 values at 50           -> takes 5 at 50, complete
        30   ms  process, ack 0           -> idle Initialising
    "#]]);
}

/// NM17x LINK-06: a partner that restarted is greeted, and its values are read again.
#[test]
fn the_partner_restarts() {
    let mut script = Script::in_service();
    script.cycle(0).after(10).hears(hello(0xCC, 0, false));
    script.after(10).hears(hello(0xCC, 0xAA, false)).cycle(0).hears(values(40, 10));
    script.expect(expect![[r#"
        10   ms  process, ack 0           -> idle Operational
        20   ms  hello cc heard 0         -> hello aa heard cc
        30   ms  hello cc heard aa        -> hello aa heard cc up
        40   ms  process, ack 0           -> wants values from 40
        40   ms  10 values at 40          -> takes 10 at 40
    "#]]);
}

/// NM17x LINK-06: a restart between an order and its acknowledgement: a value is set again, a
/// preset is not made at another place.
#[test]
fn the_partner_restarts_with_writes_on_their_way() {
    let mut script = Script::in_service();
    for (id, kind) in [(PRESET, Kind::Action), (WINDOW, Kind::Value), (PRESET, Kind::Action)] {
        script.link.write(id, 7, kind).expect("in service");
    }
    script.cycle(0).after(10).hears(hello(0xCC, 0, false));
    script.after(10).hears(hello(0xCC, 0xAA, false)).cycle(0).cycle(2);
    script.expect(expect![[r#"
        10   ms  process, ack 0           -> write #1 6003:0 = 7
        20   ms  hello cc heard 0         -> WriteNotAcknowledged, hello aa heard cc
        30   ms  hello cc heard aa        -> hello aa heard cc up
        40   ms  process, ack 0           -> write #2 2003:0 = 7
        50   ms  process, ack 2           -> wants values from 40
    "#]]);
}

/// NM17x LINK-06: this side restarted while the partner was in service.
#[test]
fn this_side_restarts() {
    let mut script = Script::new();
    script.hears(process(0)).after(10).hears(hello(0xBB, 0xAA, false)).cycle(0);
    script.expect(expect![[r#"
        0    ms  process, ack 0           -> hello aa heard 0
        10   ms  hello bb heard aa        -> hello aa heard bb up
        20   ms  process, ack 0           -> wants values from 40
    "#]]);
}

/// NM17x LINK-06, A-30: noted at the second missing process data, lost at the fourth, back with a
/// greeting and without a restart.
#[test]
fn process_data_stay_away() {
    let mut script = Script::in_service();
    script.cycle(0).after(100).hears(process(0)).after(10).hears(hello(0xBB, 0xAA, true));
    script.cycle(0);
    script.expect(expect![[r#"
        10   ms  process, ack 0           -> idle Operational
        35   ms                           -> ProcessDataMissing
        55   ms                           -> Lost
        110  ms  process, ack 0           -> hello aa heard bb
        120  ms  hello bb heard aa up     -> nothing
        130  ms  process, ack 0           -> wants values from 40
    "#]]);
}

/// NM17x LINK-03, LINK-04: one write in a gap, the next one behind the acknowledgement.
#[test]
fn writes_go_one_by_one() {
    let mut script = Script::in_service();
    for value in [320, 321] {
        script.link.write(WINDOW, value, Kind::Value).expect("in service");
    }
    script.cycle(0).cycle(1).cycle(2);
    script.expect(expect![[r#"
        10   ms  process, ack 0           -> write #1 2003:0 = 320
        20   ms  process, ack 1           -> write #2 2003:0 = 321
        30   ms  process, ack 2           -> idle Operational
    "#]]);
}

/// NM17x LINK-06: repeated three times, then dropped with a fault; the next one follows.
#[test]
fn a_write_is_not_acknowledged() {
    let mut script = Script::in_service();
    script.link.write(WINDOW, 1, Kind::Value).expect("in service");
    script.link.write(WINDOW, 2, Kind::Value).expect("in service");
    for _ in 0..10 {
        script.cycle(0);
    }
    script.expect(expect![[r#"
        10   ms  process, ack 0           -> write #1 2003:0 = 1
        20   ms  process, ack 0           -> idle Operational
        30   ms  process, ack 0           -> write #1 2003:0 = 1
        40   ms  process, ack 0           -> idle Operational
        50   ms  process, ack 0           -> write #1 2003:0 = 1
        60   ms  process, ack 0           -> idle Operational
        70   ms  process, ack 0           -> write #1 2003:0 = 1
        80   ms  process, ack 0           -> idle Operational
        90   ms  process, ack 0           -> WriteNotAcknowledged, write #2 2003:0 = 2
        100  ms  process, ack 0           -> idle Operational
    "#]]);
}

/// NM17x LINK-07, A-46: an order to stop waits for nothing and is repeated until acknowledged.
#[test]
fn an_urgent_order_overtakes() {
    let mut script = Script::in_service();
    script.link.write(WINDOW, 1, Kind::Value).expect("in service");
    script.link.stop(Urgency::MotorStop);
    script.note("stop");
    script.cycle(0);
    let acknowledged =
        ProcessData { urgent_acknowledged: 1, acknowledged: 0, ..ProcessData::default() };
    script.after(10).hears(ToInterface::Process(acknowledged));
    script.expect(expect![[r#"
        0    ms  stop                     -> urgent #1 MotorStop
        10   ms  process, ack 0           -> urgent #1 MotorStop
        20   ms  process, ack 0           -> write #1 2003:0 = 1
    "#]]);
}

/// NM17x LINK-06: other tables, other protocol: never in service, said once.
#[test]
fn the_images_do_not_fit() {
    let mut script = Script::new();
    let other = Hello { dictionary: 8, nonce: 0xBB, heard: 0xAA, ..OWN };
    script.hears(ToInterface::Hello(other)).after(10).hears(ToInterface::Hello(other));
    script.cycle(0);
    script.expect(expect![[r#"
        0    ms  hello bb heard aa        -> Mismatch, hello aa heard 0
        10   ms  hello bb heard aa        -> hello aa heard 0
        20   ms  process, ack 0           -> hello aa heard 0
    "#]]);
    assert_eq!(script.link.write(WINDOW, 1, Kind::Value), Err(QueueError::Down));
}

/// NM17x LINK-05: the queue holds 50 writes; the next one is refused and later ones are not lost.
#[test]
fn the_queue_is_bounded() {
    let mut script = Script::in_service();
    for value in 0..WRITES_MAX {
        assert_eq!(
            script.link.write(WINDOW, value.try_into().expect("small"), Kind::Value),
            Ok(())
        );
    }
    assert_eq!(script.link.write(WINDOW, 50, Kind::Value), Err(QueueError::Full));
    for sequence in 0..50 {
        script.cycle(sequence);
    }
    let written = script.transcript.matches("write #").count();
    assert_eq!(written, WRITES_MAX, "{}", script.transcript);
    assert_eq!(script.link.write(WINDOW, 50, Kind::Value), Ok(()));
}

/// NM17x LINK-06: values that do not come are asked for again.
#[test]
fn lost_values_are_asked_for_again() {
    let mut script = Script::new();
    script.hears(hello(0xBB, 0xAA, false));
    script.cycle(0).hears(values(40, 10));
    for _ in 0..5 {
        script.cycle(0);
    }
    script.hears(values(50, 5));
    script.expect(expect![[r#"
        0    ms  hello bb heard aa        -> hello aa heard bb up
        10   ms  process, ack 0           -> wants values from 40
        10   ms  10 values at 40          -> takes 10 at 40
        20   ms  process, ack 0           -> idle Initialising
        30   ms  process, ack 0           -> idle Initialising
        40   ms  process, ack 0           -> idle Initialising
        50   ms  process, ack 0           -> wants values from 50
        60   ms  process, ack 0           -> idle Initialising
        60   ms  5 values at 50           -> takes 5 at 50, complete
    "#]]);
}
