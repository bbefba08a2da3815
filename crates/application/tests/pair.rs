//! Both controllers on one bad line: what a master wrote, what it reads back and what is stored are
//! the same again as soon as the line is good, and nothing else is ever stored.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::num::NonZeroU32;

use application::{Application, Boot, Inputs, MotorOutputs, STEP};
use canopen::{CanId, Frame};
use interface::Interface;
use object_dictionary::{Owner, Row, Storage};
use profiles::nm172;
use proptest::prelude::*;
use shared_proto::limits::BIT_RATE;
use units::{Duration, Instant};

/// How finely time passes here.
const TICK: Duration = Duration::from_micros(100);
const TICKS_PER_MS: u64 = 10;
/// A byte with its start and stop bit.
const BYTE_TIME: Duration = Duration::from_micros(10 * 1_000_000 / BIT_RATE as u64 + 1);
/// The interface controller notices, repeats, greets and reads all values again within this time.
const SETTLING_MS: u64 = 1_500;
const NODE_ID: u16 = 127;

/// What happens to the pair.
#[derive(Clone, Copy, Debug)]
enum Event {
    Write(u16, u8, u32),
    Burst(u32),
    Cut { ms: u64 },
    Pause { ms: u64 },
    RestartApplication,
    RestartInterface,
}

/// How bad the line is, per million.
#[derive(Clone, Copy, Debug)]
struct Noise {
    bit_errors: u32,
    lost_bytes: u32,
}

/// One direction of the line.
#[derive(Default)]
struct Wire {
    bytes: VecDeque<(Instant, u8)>,
    free_at: Instant,
}

struct Pair {
    application: Application,
    interface: Interface,
    application_on: Instant,
    interface_on: Instant,
    to_application: Wire,
    to_interface: Wire,
    now: Instant,
    noise: Noise,
    cut: bool,
    random: u64,
    starts: u32,
    storage: BTreeMap<u32, u32>,
    /// Whatever may be stored: defaults and written values.
    permitted: BTreeSet<(u32, u32)>,
    answers: Vec<Frame>,
}

impl Pair {
    fn new(noise: Noise, seed: u64) -> Self {
        Self {
            application: application(1, &BTreeMap::new()),
            interface: interface(2),
            application_on: Instant::ZERO,
            interface_on: Instant::ZERO,
            to_application: Wire::default(),
            to_interface: Wire::default(),
            now: Instant::ZERO,
            noise,
            cut: false,
            random: seed | 1,
            starts: 2,
            storage: BTreeMap::new(),
            permitted: parameters().map(|row| (row.id().key(), row.initial(0))).collect(),
            answers: Vec::new(),
        }
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Write(index, sub, value) => self.write(index, sub, value),
            Event::Burst(value) => (0..10).for_each(|n| self.write(0x2002, 0, value + n)),
            Event::Cut { ms } => {
                self.cut = true;
                self.run(ms);
                self.cut = false;
            }
            Event::Pause { ms } => self.run(ms),
            Event::RestartApplication => {
                self.starts += 1;
                self.application = application(self.starts, &self.storage);
                self.application_on = self.now;
            }
            Event::RestartInterface => {
                self.starts += 1;
                self.interface = interface(self.starts);
                self.interface_on = self.now;
            }
        }
        self.drain();
    }

    fn run(&mut self, ms: u64) {
        (0..ms * TICKS_PER_MS).for_each(|_| self.tick());
    }

    fn tick(&mut self) {
        self.now = self.now + TICK;
        let application_now = Instant::ZERO + self.now.since(self.application_on);
        let interface_now = Instant::ZERO + self.now.since(self.interface_on);
        let bytes = self.to_application.arrived(self.now);
        self.application.handle_link(application_now, &bytes);
        let bytes = self.to_interface.arrived(self.now);
        self.interface.handle_link(interface_now, &bytes);
        if application_now.as_micros().is_multiple_of(STEP.as_micros()) {
            let ssi = [0b1110_0000, 0, 0, 0];
            self.application.step(application_now, &Inputs { ssi, ..Inputs::default() });
        }
        if self.interface.poll_timeout().is_some_and(|at| at <= interface_now) {
            self.interface.handle_timeout(interface_now);
        }
        self.drain();
        assert_eq!(self.application.motor(), MotorOutputs::OFF);
    }

    fn drain(&mut self) {
        while let Some(frame) = self.application.poll_link() {
            let bytes = self.disturbed(&frame);
            self.to_interface.send(self.now, &bytes);
        }
        while let Some(frame) = self.interface.poll_link() {
            let bytes = self.disturbed(&frame);
            self.to_application.send(self.now, &bytes);
        }
        while let Some((key, value)) = self.application.poll_store() {
            let is_parameter = parameters().any(|row| row.id().key() == key);
            assert!(!is_parameter || self.permitted.contains(&(key, value)), "{key:#x}: {value}");
            self.storage.insert(key, value);
        }
        self.answers.extend(core::iter::from_fn(|| self.interface.take_transmit()));
        while self.interface.poll_event().is_some() {}
    }

    /// What is left of a frame. A lost byte takes the time of a byte.
    fn disturbed(&mut self, frame: &[u8]) -> Vec<Option<u8>> {
        let mut bytes = Vec::new();
        for byte in frame {
            let flipped = (0..8).filter(|_| self.chance(self.noise.bit_errors));
            let flipped = flipped.fold(0, |mask, bit| mask | 1 << bit);
            let lost = self.cut || self.chance(self.noise.lost_bytes);
            bytes.push((!lost).then_some(byte ^ flipped));
        }
        bytes
    }

    /// xorshift64.
    fn chance(&mut self, per_million: u32) -> bool {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random % 1_000_000 < per_million.into()
    }

    fn write(&mut self, index: u16, sub: u8, value: u32) {
        self.permitted.insert((u32::from(index) << 8 | u32::from(sub), value));
        self.transfer(0x23, index, sub, value);
    }

    fn read(&mut self, row: Row) -> Option<u32> {
        let [command, _, _, _, data @ ..] = self.transfer(0x40, row.id().index, row.id().sub, 0)?;
        (command != 0x80).then_some(u32::from_le_bytes(data))
    }

    fn transfer(&mut self, command: u8, index: u16, sub: u8, value: u32) -> Option<[u8; 8]> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let request = [command, low, high, sub, a, b, c, d];
        let request = Frame::new(CanId::from_low_bits((0x600 + NODE_ID).into()), &request)?;
        self.answers.clear();
        let interface_now = Instant::ZERO + self.now.since(self.interface_on);
        self.interface.handle_frame(interface_now, &request);
        self.drain();
        let answer = self.answers.iter().find(|frame| frame.id().get() == 0x580 + NODE_ID)?;
        answer.data().try_into().ok()
    }
}

impl Wire {
    fn send(&mut self, now: Instant, bytes: &[Option<u8>]) {
        self.free_at = self.free_at.max(now);
        for byte in bytes {
            self.free_at = self.free_at + BYTE_TIME;
            self.bytes.extend(byte.map(|byte| (self.free_at, byte)));
        }
    }

    fn arrived(&mut self, now: Instant) -> Vec<u8> {
        let count = self.bytes.iter().take_while(|(at, _)| *at <= now).count();
        self.bytes.drain(..count).map(|(_, byte)| byte).collect()
    }
}

fn application(nonce: u32, storage: &BTreeMap<u32, u32>) -> Application {
    let boot = Boot { nonce: NonZeroU32::new(nonce).expect("starts are counted from 1") };
    Application::new(&nm172::PRODUCT, boot, storage.iter().map(|(key, value)| (*key, *value)))
}

fn interface(nonce: u32) -> Interface {
    let boot = interface::Boot { serial_number: 1, nonce };
    Interface::new(Instant::ZERO, &nm172::PRODUCT, boot, [])
}

/// The rows that the application controller stores.
fn parameters() -> impl Iterator<Item = Row> {
    nm172::DICTIONARY
        .rows()
        .filter(|row| row.owner() == Owner::Application && row.storage() == Storage::AtOnce)
}

fn any_event() -> impl Strategy<Value = Event> {
    let object = prop_oneof![
        Just((0x2002, 0)),
        Just((0x2003, 0)),
        Just((0x2010, 0)),
        Just((0x2020, 1)),
        Just((0x6003, 0)),
    ];
    prop_oneof![
        8 => (object, 0_u32..9_999).prop_map(|((index, sub), value)| Event::Write(index, sub, value)),
        1 => prop_oneof![Just(0), Just(10_000_000)].prop_map(|scaling| Event::Write(0x2004, 0, scaling)),
        1 => prop_oneof![Just(1), Just(3), Just(4), Just(6)].prop_map(|n| Event::Write(0x2015, 0, n)),
        1 => (0_u32..9_000).prop_map(Event::Burst),
        1 => (0_u64..300).prop_map(|ms| Event::Cut { ms }),
        8 => (0_u64..40).prop_map(|ms| Event::Pause { ms }),
        1 => Just(Event::RestartApplication),
        1 => Just(Event::RestartInterface),
    ]
}

fn any_noise() -> impl Strategy<Value = Noise> {
    prop_oneof![
        Just(Noise { bit_errors: 0, lost_bytes: 0 }),
        Just(Noise { bit_errors: 1_000, lost_bytes: 0 }),
        Just(Noise { bit_errors: 0, lost_bytes: 5_000 }),
        Just(Noise { bit_errors: 300, lost_bytes: 1_000 }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// NM17x LINK-03, LINK-04, LINK-06, STORE-02: bit errors up to one in a thousand, lost bytes, a
    /// cut line and restarts of either side.
    #[test]
    fn both_sides_agree_in_the_end(
        events in proptest::collection::vec(any_event(), 0..120),
        noise in any_noise(),
        seed: u64,
    ) {
        let mut pair = Pair::new(noise, seed);
        for event in events {
            pair.happen(event);
        }
        pair.noise = Noise { bit_errors: 0, lost_bytes: 0 };
        pair.run(SETTLING_MS);
        prop_assert!(pair.application.in_service());
        for row in parameters() {
            let stored = pair.storage.get(&row.id().key()).copied().unwrap_or(row.initial(0));
            prop_assert_eq!(pair.read(row), Some(stored), "{:?}", row.id());
        }
    }
}
