use canopen::{CanId, Event, Frame, Node, Settings, State};
use object_dictionary::{Access, DataType, ObjectId, PdoMapping, Slot};
use proptest::collection::vec;
use proptest::prelude::*;
use units::{Duration, Instant};

use crate::device::{DICTIONARY, Device, LEN, NODE_ID, SETTINGS};

const NMT: u16 = 0x000;
const SYNC: u16 = 0x080;
const SDO_RESPONSE: u16 = 0x5FF;
const SDO_REQUEST: u16 = 0x67F;
const ERROR_CONTROL: u16 = 0x77F;

#[derive(Clone, Debug)]
enum Step {
    Receive(Frame),
    Set { position: u16, raw: u32 },
    Emergency { code: u16 },
    Errors { register: u8 },
    Advance { us: u64 },
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(CanId::new(id).unwrap(), data).unwrap()
}

fn any_frame() -> impl Strategy<Value = Frame> {
    let heartbeat = 0x700..=0x704_u16;
    let id = prop_oneof![Just(NMT), Just(SYNC), Just(SDO_REQUEST), heartbeat, 0..=0x7FF_u16];
    let data = prop_oneof![
        8 => vec(any::<u8>(), 0..=8).prop_map(Some),
        1 => Just(None),
    ];
    (id, data, 0..=8_u8).prop_map(|(id, data, len)| match data {
        Some(data) => frame(id, &data),
        None => Frame::new_remote(CanId::new(id).unwrap(), len).unwrap(),
    })
}

fn receive_pdo() -> impl Strategy<Value = Frame> {
    let data = vec(prop_oneof![Just(0), Just(0xFF), any::<u8>()], 0..=8);
    (prop::sample::select(vec![0x201, 0x37F, 0x301]), data).prop_map(|(id, data)| frame(id, &data))
}

fn nmt_command() -> impl Strategy<Value = Frame> {
    let command = prop_oneof![
        6 => Just(0x01_u8), 2 => Just(0x02), 4 => Just(0x80), 1 => Just(0x81), 1 => Just(0x82),
        1 => any::<u8>(),
    ];
    let node = prop_oneof![Just(0), Just(NODE_ID.get()), any::<u8>()];
    (command, node).prop_map(|(command, node)| frame(NMT, &[command, node]))
}

/// Requests for objects that mostly exist, with values that are mostly small.
fn sdo_request() -> impl Strategy<Value = Frame> {
    let command = prop_oneof![
        Just(0x40_u8),
        Just(0x22),
        Just(0x23),
        Just(0x2B),
        Just(0x2F),
        Just(0x21),
        Just(0x20),
        Just(0x60),
        Just(0x70),
        0..=0x1F_u8,
        any::<u8>(),
    ];
    let known = (0..DICTIONARY.rows().len()).prop_map(|row| DICTIONARY.rows()[row].id);
    let object = prop_oneof![
        8 => known,
        1 => any::<(u16, u8)>().prop_map(|(index, sub)| ObjectId { index, sub }),
    ];
    let monitored = (0..=4_u32, 0..=100_u32).prop_map(|(node, ms)| node << 16 | ms);
    let value =
        prop_oneof![0..=300_u32, monitored, any::<u32>(), Just(0x4000_01FF), Just(0xFFFF_FFFF)];
    let len = prop_oneof![9 => Just(8_usize), 1 => 0..8_usize];
    (command, object, value, len).prop_map(|(command, object, value, len)| {
        let [low, high] = object.index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        frame(SDO_REQUEST, &[command, low, high, object.sub, a, b, c, d][..len])
    })
}

fn step() -> impl Strategy<Value = Step> {
    let live = [(0x6004, 0), (0x204E, 1), (0x204E, 2), (0x2501, 4)];
    let mapped: Vec<u16> = (0_u16..)
        .zip(DICTIONARY.rows())
        .filter(|(_, row)| live.contains(&(row.id.index, row.id.sub)))
        .map(|(position, _)| position)
        .collect();
    prop_oneof![
        2 => any_frame().prop_map(Step::Receive),
        2 => nmt_command().prop_map(Step::Receive),
        8 => sdo_request().prop_map(Step::Receive),
        2 => Just(Step::Receive(frame(SYNC, &[]))),
        2 => receive_pdo().prop_map(Step::Receive),
        4 => (prop::sample::select(mapped), any::<u32>())
            .prop_map(|(position, raw)| Step::Set { position, raw }),
        1 => any::<u16>().prop_map(|code| Step::Emergency { code }),
        1 => prop_oneof![Just(0), any::<u8>()].prop_map(|register| Step::Errors { register }),
        4 => (0..200_000_u64).prop_map(|us| Step::Advance { us }),
    ]
}

/// Drives a node and checks everything that leaves it.
struct Watch {
    node: Node<LEN>,
    device: Device,
    settings: &'static Settings,
    now: Instant,
    state: State,
    booted: bool,
}

impl Watch {
    fn new(settings: &'static Settings) -> Self {
        Self {
            node: Node::new(&DICTIONARY, NODE_ID, settings),
            device: Device::new(),
            settings,
            now: Instant::ZERO,
            state: State::Initialising,
            booted: false,
        }
    }

    fn run(&mut self, step: &Step) {
        match step {
            Step::Receive(frame) => self.receive(frame),
            Step::Set { position, raw } => {
                let slot = Slot::at(&DICTIONARY, *position).unwrap();
                self.node.set_value(self.now, slot, *raw);
                self.advance(Duration::ZERO);
            }
            Step::Emergency { code } => {
                self.node.send_emergency(*code, [0; 5]);
                self.drain();
                self.advance(Duration::ZERO);
            }
            Step::Errors { register } => {
                self.node.set_error_register(self.now, *register);
                self.drain();
                self.advance(Duration::ZERO);
            }
            Step::Advance { us } => self.advance(Duration::from_micros(*us)),
        }
    }

    fn receive(&mut self, frame: &Frame) {
        let serves = matches!(self.state, State::PreOperational | State::Operational);
        let asked = frame.id().get() == SDO_REQUEST && !frame.is_remote() && serves;
        let expected = asked.then(|| self.expected(frame.data())).flatten();
        self.node.handle_frame(self.now, frame, &mut self.device);
        let answers = self.drain();
        assert!(answers.len() <= usize::from(asked), "{answers:02X?} to {frame:02X?}");
        if let Some(expected) = expected {
            assert_eq!(answers.first(), Some(&expected), "{frame:02X?}");
        }
        if asked && frame.data().len() == 8 && frame.data()[0] != 0x80 {
            assert_eq!(answers.len(), 1, "every whole request has an answer: {frame:02X?}");
        }
        self.advance(Duration::ZERO);
    }

    fn advance(&mut self, span: Duration) {
        let until = self.now + span;
        while let Some(due_at) = self.node.poll_timeout().filter(|&due_at| due_at <= until) {
            self.now = self.now.max(due_at);
            self.node.handle_timeout(self.now);
            assert!(self.drain().len() <= 1, "one transfer, one time-out");
            let next_at = self.node.poll_timeout();
            assert!(next_at.is_none_or(|next_at| next_at > self.now), "the node is never done");
        }
        self.now = until;
    }

    /// Checks frames and events; returns the SDO answers.
    fn drain(&mut self) -> Vec<Vec<u8>> {
        let mut lost = false;
        while let Some(event) = self.node.poll_event() {
            match event {
                Event::StateChanged { from, to } => {
                    assert_eq!(from, self.state);
                    self.state = to;
                }
                Event::ResetNode | Event::ResetCommunication => self.state = State::Initialising,
                Event::HeartbeatLost { producer } => {
                    assert!(self.monitors(producer.get()), "{producer:?}");
                    lost = true;
                }
                Event::HeartbeatRecovered { producer } => {
                    assert!(self.monitors(producer.get()), "{producer:?}");
                }
                Event::GuardingLost => lost = true,
                Event::GuardingRecovered => {}
                Event::PdoOverdue { .. } => assert_eq!(self.state, State::Operational),
                Event::FiltersChanged => {}
                Event::Lss(event) => panic!("{event:?} without the service"),
                Event::TransmitOverflow { lost } => panic!("{lost} frames lost"),
            }
        }
        assert_eq!(self.state, self.node.state());
        for (slot, row) in DICTIONARY.slots().filter(|(_, row)| row.pdo == PdoMapping::Receive) {
            assert!(row.permits(self.node.values().raw(slot)), "{:?}", row.id);
        }
        let serves = matches!(self.state, State::PreOperational | State::Operational);
        let mut answers = Vec::new();
        while let Some(frame) = self.node.take_transmit() {
            match frame.id().get() {
                ERROR_CONTROL => self.check_error_control(&frame),
                SDO_RESPONSE => {
                    assert_eq!(frame.dlc(), 8);
                    self.check_not_heard(&frame);
                    answers.push(frame.data().to_vec());
                }
                id if self.is_emergency(id) => {
                    assert!(serves || lost, "{frame:02X?}");
                    assert_eq!(frame.dlc(), 8);
                }
                id => self.check_pdo(id, &frame),
            }
        }
        answers
    }

    fn check_error_control(&mut self, frame: &Frame) {
        let expected = match self.state {
            _ if !self.booted => 0x00,
            State::PreOperational => 0x7F,
            State::Operational => 0x05,
            State::Stopped => 0x04,
            State::Initialising => panic!("a heartbeat from a node that is off"),
        };
        self.booted = true;
        assert_eq!(frame.data(), [expected]);
    }

    fn is_emergency(&self, id: u16) -> bool {
        let cob_id = self.value(ObjectId { index: 0x1014, sub: 0 });
        cob_id & 1 << 31 == 0 && cob_id & 0x7FF == u32::from(id)
    }

    fn monitors(&self, producer: u8) -> bool {
        let entries = [1, 2].map(|sub| self.value(ObjectId { index: 0x1016, sub }));
        entries.iter().any(|entry| entry >> 16 & 0xFF == u32::from(producer) && entry & 0xFFFF != 0)
    }

    fn check_not_heard(&self, frame: &Frame) {
        assert_eq!(self.node.accepts().find(|accepted| accepted.id == frame.id()), None);
    }

    fn check_pdo(&self, id: u16, frame: &Frame) {
        assert_eq!(self.state, State::Operational, "{frame:02X?}");
        assert_eq!(frame.dlc(), 8);
        let own = [0x1800, 0x1801].iter().any(|&index| {
            let cob_id = self.value(ObjectId { index, sub: 1 });
            cob_id & 1 << 31 == 0 && cob_id & 0x7FF == u32::from(id)
        });
        assert!(own, "the identifier of another node: {frame:02X?}");
    }

    fn value(&self, object: ObjectId) -> u32 {
        self.node.values().raw(DICTIONARY.find(object).unwrap())
    }

    fn is_empty_error(&self, object: ObjectId) -> bool {
        let count = self.value(ObjectId { index: 0x1003, sub: 0 });
        object.index == 0x1003 && u32::from(object.sub) > count
    }

    /// What a plain reading of the requirements answers to a request about a number. `None` for
    /// everything else, which only has to be answered once.
    fn expected(&self, data: &[u8]) -> Option<Vec<u8>> {
        let &[command, low, high, sub, a, b, c, d] = data else { return None };
        let object = ObjectId { index: u16::from_le_bytes([low, high]), sub };
        let answer = |command: u8, value: u32| {
            let mut answer = vec![command, low, high, sub];
            answer.extend(value.to_le_bytes());
            Some(answer)
        };
        let abort = |code: u32| answer(0x80, code);
        let told = match command {
            0x40 | 0x22 => None,
            0x23 => Some(4),
            0x2B => Some(2),
            0x2F => Some(1),
            0x41..=0x5F | 0x81..=0xFF => return abort(0x0504_0001),
            _ => return None,
        };
        let rows = DICTIONARY.rows();
        if !rows.iter().any(|row| row.id.index == object.index) {
            return abort(0x0602_0000);
        }
        let Some(row) = rows.iter().find(|row| row.id == object) else { return abort(0x0609_0011) };
        if matches!(row.data_type, DataType::VisibleString(_)) {
            return None;
        }
        let (len, codes) = (row.data_type.len(), &self.settings.abort_codes);
        if command == 0x40 {
            return match row.access {
                Access::WriteOnly => abort(0x0601_0001),
                Access::ReadOnly | Access::ReadWrite
                    if row.id.index == 0x2110 || self.is_empty_error(object) =>
                {
                    abort(0x0800_0024)
                }
                Access::ReadOnly | Access::ReadWrite => {
                    let mask = u32::MAX >> (32 - 8 * len);
                    let command = if len == 4 {
                        0x43
                    } else if len == 2 {
                        0x4B
                    } else {
                        0x4F
                    };
                    answer(command, self.value(object) & mask)
                }
            };
        }
        if row.access == Access::ReadOnly {
            return abort(0x0601_0002);
        }
        if told.is_some_and(|told| told != len) {
            return abort(codes.number_length.get());
        }
        let mut bytes = [a, b, c, d];
        let excess = bytes[len..].iter().any(|&byte| byte != 0);
        match codes.excess_bytes {
            Some(code) if told.is_none() && excess => return abort(code.get()),
            Some(_) | None => bytes[len..].fill(0),
        }
        let number = row.data_type.number(u32::from_le_bytes(bytes));
        let limits = row.limits();
        let within = |&(first, last): &(i64, i64)| (first..=last).contains(&number);
        if within(&(limits.min, limits.max)) || limits.also.iter().any(within) {
            None
        } else if limits.also.is_empty() {
            let above = number > limits.max;
            abort(if above { codes.above_maximum } else { codes.below_minimum }.get())
        } else {
            abort(codes.value_range.get())
        }
    }
}

proptest! {
    /// NM17x SDO-01, SDO-06, SDO-07, SDO-09, NMT-04, PDO-01, HB-01: whatever arrives, the node
    /// lives, answers a request once and rightly, uses its own identifiers only, sends what its
    /// state permits, and comes to rest.
    #[test]
    fn no_sequence_of_frames_breaks_the_rules(
        settings in prop::sample::select(vec![&SETTINGS, &Settings::CIA_301]),
        steps in vec(step(), 0..120),
    ) {
        let mut watch = Watch::new(settings);
        for step in &steps {
            if watch.state == State::Initialising {
                watch.node = Node::new(&DICTIONARY, NODE_ID, settings);
                watch.booted = false;
                watch.node.boot(watch.now);
                watch.drain();
            }
            watch.run(step);
        }
    }
}
