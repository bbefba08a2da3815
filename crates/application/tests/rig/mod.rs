//! An application controller on a table: a sensor to turn, a line to speak on, a storage that
//! outlives a restart.
#![allow(dead_code, reason = "each test binary uses its part of the rig")]

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use application::{Application, Boot, Inputs, STEP};
use object_dictionary::{Number, Object, ObjectId};
use profiles::nm17x::between_controllers::MESSAGE_PARTS;
use profiles::{Product, nm172};
use shared_proto::{
    Encoded, Hello, NodeState, PROTOCOL, ProcessData, Receiver, Supervision, ToApplication,
    ToInterface, Urgency, Urgent, Write, encode,
};
use units::{Duration, Instant};

/// Places of the encoder in a turn.
pub(crate) const TURN: u32 = 4_096;
/// The word of the encoder in the middle of its range.
pub(crate) const MIDDLE: u32 = 4_096 * TURN;
/// Steps in a cycle of the link.
pub(crate) const CYCLE: u32 = 5;
/// The nonce of the first start of the application controller and of the other one.
pub(crate) const OWN_NONCE: u32 = 0xA0;
pub(crate) const PARTNER_NONCE: u32 = 0xB0;

pub(crate) struct Rig {
    product: &'static Product,
    pub(crate) application: Application,
    pub(crate) now: Instant,
    pub(crate) inputs: Inputs,
    pub(crate) storage: BTreeMap<u32, u32>,
    /// Values stored so far.
    pub(crate) stores: Vec<(u32, u32)>,
    /// Everything said on the line, in order.
    pub(crate) heard: Vec<ToInterface>,
    pub(crate) partner: Hello,
    /// Whether the other controller answers in every cycle.
    attended: bool,
    receiver: Receiver<ToInterface>,
    sequence: u8,
    starts: u32,
}

impl Rig {
    /// An NM172, delivered today, the encoder in the middle of its range.
    pub(crate) fn new() -> Self {
        Self::of(&nm172::PRODUCT)
    }

    /// Any product, delivered today.
    pub(crate) fn of(product: &'static Product) -> Self {
        let partner = Hello {
            protocol: PROTOCOL,
            product: product.code,
            firmware: product.firmware,
            dictionary: product.fingerprint,
            nonce: PARTNER_NONCE,
            heard: OWN_NONCE,
            in_service: true,
        };
        let mut rig = Self {
            product,
            application: started(product, OWN_NONCE, &BTreeMap::new()),
            now: Instant::ZERO,
            inputs: Inputs::default(),
            storage: BTreeMap::new(),
            stores: Vec::new(),
            heard: Vec::new(),
            partner,
            attended: false,
            receiver: Receiver::default(),
            sequence: 0,
            starts: 0,
        };
        rig.turn_to(MIDDLE);
        rig
    }

    /// Like [`Self::new`], and the two controllers have met.
    pub(crate) fn in_service() -> Self {
        let mut rig = Self::new();
        rig.step();
        rig.greet();
        assert!(rig.application.in_service());
        rig
    }

    /// Like [`Self::in_service`], and the other controller answers in every cycle.
    pub(crate) fn attended() -> Self {
        Self { attended: true, ..Self::in_service() }
    }

    /// Puts the shaft at a word of the encoder.
    pub(crate) fn turn_to(&mut self, word: u32) {
        self.inputs.ssi = (1 << 31 | (word ^ word >> 1) << 6).to_be_bytes();
    }

    /// One step of 2 ms.
    pub(crate) fn step(&mut self) {
        self.application.step(self.now, &self.inputs);
        self.drain();
        if self.attended {
            self.idle();
        }
        self.now = self.now + STEP;
    }

    pub(crate) fn steps(&mut self, count: u32) {
        (0..count).for_each(|_| self.step());
    }

    /// Steps on until the next step would be at `ms`.
    pub(crate) fn run_until_ms(&mut self, ms: u64) {
        while self.now.since(Instant::ZERO) < Duration::from_millis(ms) {
            self.step();
        }
    }

    pub(crate) fn greet(&mut self) {
        self.say(&ToApplication::Hello(self.partner));
    }

    pub(crate) fn say(&mut self, message: &ToApplication) {
        self.say_bytes(&encode(message));
    }

    pub(crate) fn say_bytes(&mut self, bytes: &[u8]) {
        self.application.handle_link(self.now, bytes);
        self.drain();
    }

    pub(crate) fn idle(&mut self) {
        self.say(&ToApplication::Idle(SUPERVISION));
    }

    /// A write with the next number, in the gap behind the next process data.
    pub(crate) fn write<T: Number>(&mut self, object: &Object<T>, value: T) {
        self.write_to(object.id(), value.to_raw());
    }

    /// A text for the display.
    pub(crate) fn show(&mut self, text: &[u8; 12]) {
        for (id, part) in MESSAGE_PARTS.into_iter().zip(text.as_chunks().0) {
            self.write_to(id, u32::from_le_bytes(*part));
        }
    }

    pub(crate) fn write_to(&mut self, id: ObjectId, value: u32) {
        self.sequence = if self.sequence == u8::MAX { 1 } else { self.sequence + 1 };
        let write = Write { sequence: self.sequence, index: id.index, sub: id.sub, value };
        self.say(&ToApplication::Write(SUPERVISION, write));
        self.steps(CYCLE);
        assert_eq!(self.process().acknowledged, self.sequence);
    }

    /// The last process data.
    pub(crate) fn process(&self) -> ProcessData {
        let last = |message: &ToInterface| match message {
            ToInterface::Process(process) => Some(*process),
            ToInterface::Hello(_) | ToInterface::Snapshot { .. } | ToInterface::Touched { .. } => {
                None
            }
        };
        self.heard.iter().rev().find_map(last).expect("no process data yet")
    }

    /// What has been said since the last time this was asked, one message a line.
    pub(crate) fn said(&mut self) -> String {
        self.heard.drain(..).map(|message| describe(&message) + "\n").collect()
    }

    /// Takes the supply away and gives it back.
    pub(crate) fn restart(&mut self) {
        self.starts += 1;
        self.application = started(self.product, OWN_NONCE + self.starts, &self.storage);
        self.now = Instant::ZERO;
        self.partner.heard = OWN_NONCE + self.starts;
        self.sequence = 0;
        self.step();
        self.greet();
    }

    fn drain(&mut self) {
        while let Some(frame) = self.application.poll_link() {
            self.listen(&frame);
        }
        while let Some((key, value)) = self.application.poll_store() {
            self.storage.insert(key, value);
            self.stores.push((key, value));
        }
    }

    fn listen(&mut self, frame: &Encoded) {
        let messages = frame.iter().filter_map(|byte| self.receiver.push(*byte));
        self.heard.extend(messages);
        assert_eq!(self.receiver.damaged(), 0);
    }
}

pub(crate) const SUPERVISION: Supervision =
    Supervision { state: NodeState::PreOperational, node_id: 127 };

pub(crate) fn write<T: Number>(sequence: u8, object: &Object<T>, value: T) -> Write {
    let id = object.id();
    Write { sequence, index: id.index, sub: id.sub, value: value.to_raw() }
}

pub(crate) fn stop(number: u8) -> ToApplication {
    ToApplication::Urgent(SUPERVISION, Urgent { number, urgency: Urgency::MotorStop })
}

fn started(product: &'static Product, nonce: u32, storage: &BTreeMap<u32, u32>) -> Application {
    let boot = Boot { nonce: NonZeroU32::new(nonce).expect("a nonce is not 0") };
    Application::new(product, boot, storage.iter().map(|(key, value)| (*key, *value)))
}

fn describe(message: &ToInterface) -> String {
    match message {
        ToInterface::Hello(hello) => {
            let service = if hello.in_service { "in" } else { "out of" };
            format!("hello from {:x}, heard {:x}, {service} service", hello.nonce, hello.heard)
        }
        ToInterface::Process(process) => format!(
            "process {}: at {}, write {}, stop {}",
            process.cycle,
            process.position_hundredths_mm,
            process.acknowledged,
            process.urgent_acknowledged
        ),
        ToInterface::Snapshot { from, values } => {
            format!("values from {from}: {}", values.len())
        }
        ToInterface::Touched { offer } => format!("touched during offer {offer}"),
    }
}
