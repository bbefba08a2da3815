//! A node among frames, time and a product. The rules are those that hold whatever happens.

mod partners;
mod pdos;
mod steps;

use std::collections::BTreeSet;

use canopen::{
    Application, BlockTransfer, BusState, Event, Frame, Mapped, Node, NodeId, ReadError, Settings,
    State, TRANSMIT_MAX, TimeOfDay, WriteError, Written, lss,
};
use object_dictionary::{DataType, Dictionary, ObjectId, PdoMapping, Row, Slot};
use units::{Duration, Instant};

use crate::bytes::Bytes;
use crate::{cia_301, device};
use partners::Partners;
use pdos::PdoTimes;
use steps::Step;

const NMT: u16 = 0x000;
const SDO_RESPONSE: u16 = 0x580;
const SDO_REQUEST: u16 = 0x600;
const ERROR_CONTROL: u16 = 0x700;
const LSS_RESPONSE: u16 = 0x7E4;
const LSS_REQUEST: u16 = 0x7E5;

const ERROR_REGISTER: ObjectId = ObjectId { index: 0x1001, sub: 0 };
const TIME: ObjectId = ObjectId { index: 0x1012, sub: 0 };
const GUARD_TIME: ObjectId = ObjectId { index: 0x100C, sub: 0 };
const LIFE_TIME_FACTOR: ObjectId = ObjectId { index: 0x100D, sub: 0 };
const MONITORED: u16 = 0x1016;
const HEARTBEAT_TIME: ObjectId = ObjectId { index: 0x1017, sub: 0 };

static LSS: lss::Settings = lss::Settings::CIA_305;
static ALL_SERVICES: Settings = Settings { lss: Some(&LSS), ..dev1::SETTINGS };

const NM17X: Subject = Subject {
    dictionary: &device::DICTIONARY,
    settings: &device::SETTINGS,
    node_id: device::NODE_ID,
};
const DEV1: Subject =
    Subject { dictionary: &dev1::DICTIONARY, settings: &ALL_SERVICES, node_id: dev1::NODE_ID };

const CIA_301: Subject = Subject {
    dictionary: &cia_301::DICTIONARY,
    settings: &Settings::CIA_301,
    node_id: cia_301::NODE_ID,
};

/// Calls for what is due that a conversation waits for at once. Time goes on with the next step.
const WAKES_MAX: usize = 50;

/// Transmit PDOs that a device may have.
const PDO_MAX: usize = 4;

/// Values that are kept for the next start.
const KEPT_MAX: usize = 8;

/// Lets a node meet what `input` says.
pub fn converse(input: &[u8]) {
    let mut bytes = Bytes::new(input);
    match bytes.u8() {
        Some(0..=99) => Watch::<{ device::LEN }>::new(NM17X).run(&mut bytes),
        Some(100..=199) => Watch::<{ dev1::LEN }>::new(DEV1).run(&mut bytes),
        Some(200..) => Watch::<{ cia_301::LEN }>::new(CIA_301).run(&mut bytes),
        None => {}
    }
}

/// The product a node is of.
#[derive(Clone, Copy)]
struct Subject {
    dictionary: &'static Dictionary,
    settings: &'static Settings,
    node_id: NodeId,
}

/// Whether mailboxes take frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bus {
    Free,
    Busy,
}

/// What the storage does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storage {
    Idle,
    Busy,
}

/// How the product answers.
#[derive(Clone, Copy, Debug)]
enum Mood {
    Willing,
    Deaf,
    Refusing(WriteError),
    Unreadable(ReadError),
}

impl Application for Mood {
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Served;

    fn read(&mut self, _slot: Slot, _row: &Row) -> Result<(), ReadError> {
        match self {
            Self::Unreadable(error) => Err(*error),
            Self::Willing | Self::Deaf | Self::Refusing(_) => Ok(()),
        }
    }

    fn write(&mut self, _slot: Slot, _row: &Row, _raw: u32) -> Result<Written, WriteError> {
        match self {
            Self::Refusing(error) => Err(*error),
            Self::Deaf => Ok(Written::Ignored),
            Self::Willing | Self::Unreadable(_) => Ok(Written::Taken),
        }
    }

    fn receive(&mut self, _number: u16, _values: &Mapped<'_>) -> Written {
        match self {
            Self::Deaf => Written::Ignored,
            Self::Willing | Self::Refusing(_) | Self::Unreadable(_) => Written::Taken,
        }
    }

    fn write_text(&mut self, _slot: Slot, _row: &Row, _text: &[u8]) -> Result<(), WriteError> {
        match self {
            Self::Refusing(error) => Err(*error),
            Self::Willing | Self::Deaf | Self::Unreadable(_) => Ok(()),
        }
    }
}

/// Drives a node and checks everything that leaves it.
struct Watch<const LEN: usize> {
    subject: Subject,
    /// What masters write with receive PDOs.
    received: Vec<(Slot, Row)>,
    /// Identifiers that the node sends with, except SYNC.
    cob_ids: Vec<Slot>,
    node: Node<LEN>,
    mood: Mood,
    now: Instant,
    state: State,
    booted: bool,
    bus: Bus,
    /// Frames may be older than the present state and configuration.
    stale: bool,
    /// What is due now is left for later.
    hurries: bool,
    /// Frames that waited were dropped.
    lost_frames: bool,
    /// That was reported during the last call for what is due.
    overflow_is_new: bool,
    /// Identifiers that waiting frames may have.
    own: BTreeSet<u16>,
    /// SDO answers that are still owed at most.
    sdo_owed: usize,
    /// The first byte of the last SDO answer; `None` when that may be lost.
    sdo_answered: Option<u8>,
    /// Commands to store or restore so far.
    storage_commands: usize,
    /// Whether the storage has such a command to do.
    storage: Storage,
    /// Values of before, which are set at the start.
    kept: Vec<(Slot, u32)>,
    /// LSS answers that are still owed at most.
    lss_owed: usize,
    heartbeat: Cycle,
    sync: Cycle,
    pdos: [PdoTimes; PDO_MAX],
    /// A remote frame is served: inhibit times do not hold back what it asks for.
    is_remote: bool,
    partners: Partners,
    /// What the product said about its errors.
    errors: u8,
    bus_state: BusState,
    /// What a guarding request has to be answered with.
    guarding_answer: Option<u8>,
    /// The time that the network told since it was last looked at.
    told: Option<TimeOfDay>,
}

/// Something that comes again and again.
#[derive(Clone, Copy)]
struct Cycle {
    /// `None` when it is switched off.
    period: Option<Duration>,
    /// When it came last, or began.
    since: Instant,
}

impl Cycle {
    fn check(&mut self, now: Instant, period: Option<Duration>) {
        if period != self.period {
            *self = Self { period, since: now };
        }
        assert!(period.is_none_or(|period| now.since(self.since) <= period), "late: {now:?}");
    }
}

impl<const LEN: usize> Watch<LEN> {
    fn new(subject: Subject) -> Self {
        let slots = || subject.dictionary.slots();
        let sends = |id: ObjectId| {
            id.index == 0x1014 || (0x1800..0x1A00).contains(&id.index) && id.sub == 1
        };
        let mut watch = Self {
            subject,
            received: slots().filter(|(_, row)| row.pdo() == PdoMapping::Receive).collect(),
            cob_ids: slots().filter(|(_, row)| sends(row.id())).map(|(slot, _)| slot).collect(),
            node: Node::new(subject.dictionary, subject.node_id, subject.settings),
            mood: Mood::Willing,
            now: Instant::ZERO,
            state: State::Initialising,
            booted: false,
            bus: Bus::Free,
            stale: false,
            hurries: false,
            own: BTreeSet::new(),
            sdo_owed: 0,
            sdo_answered: Some(0),
            lost_frames: false,
            overflow_is_new: false,
            storage_commands: 0,
            storage: Storage::Idle,
            kept: Vec::new(),
            lss_owed: 0,
            heartbeat: Cycle { period: None, since: Instant::ZERO },
            sync: Cycle { period: None, since: Instant::ZERO },
            pdos: [PdoTimes::UNKNOWN; PDO_MAX],
            is_remote: false,
            partners: Partners::new(),
            errors: 0,
            bus_state: BusState::Active,
            guarding_answer: None,
            told: None,
        };
        watch.boot();
        watch
    }

    fn boot(&mut self) {
        let Subject { dictionary, settings, node_id } = self.subject;
        self.node = Node::new(dictionary, node_id, settings);
        self.booted = false;
        self.storage = Storage::Idle;
        self.partners = Partners::new();
        self.pdos = [PdoTimes::UNKNOWN; PDO_MAX];
        (self.errors, self.bus_state) = (0, BusState::Active);
        self.own.clear();
        for &(slot, raw) in &self.kept {
            self.node.set_value(self.now, slot, raw);
        }
        self.node.boot(self.now);
        self.drain();
    }

    fn run(&mut self, bytes: &mut Bytes<'_>) {
        while let Some(step) = self.next(bytes) {
            self.take(step);
        }
    }

    fn take(&mut self, step: Step) {
        match step {
            Step::Receive(frame) => self.receive(&frame),
            Step::ReceiveAfter { us, frame } => {
                self.pass(Duration::from_micros(us));
                self.partners.doubt();
                self.receive(&frame);
            }
            Step::Keep { slot, raw } => {
                self.kept.truncate(KEPT_MAX);
                self.kept.insert(0, (slot, raw));
            }
            Step::Set { slot, raw } => {
                let row = self.subject.dictionary.row(slot).unwrap();
                if row.permits(raw) {
                    self.node.set_value(self.now, slot, raw);
                }
            }
            Step::Emergency { code } => self.node.send_emergency(code, [0; 5]),
            Step::Errors { register } => {
                self.errors = register;
                self.node.set_error_register(self.now, register);
            }
            Step::Supervise(state) => {
                self.node.handle_bus(self.now, state);
                assert_eq!(self.node.bus_state(), state);
            }
            Step::Overrun => self.node.handle_overrun(),
            Step::Trigger { number } => self.node.trigger_tpdo(self.now, number),
            Step::Advance { us } => self.advance(Duration::from_micros(us)),
            Step::Hurry => {
                self.hurries = true;
                return;
            }
            Step::Sleep { us } => self.sleep(Duration::from_micros(us)),
            Step::Touch => self.node.take_offered_node_id(),
            Step::Mood(mood) => self.mood = mood,
            Step::Bus(bus) => self.bus = bus,
            Step::Stored(outcome) => self.handle_stored(outcome),
            Step::GiveBack => self.give_back(),
        }
        self.drain();
        if std::mem::take(&mut self.hurries) {
            self.stale = true;
        } else {
            self.advance(Duration::ZERO);
        }
        if self.bus == Bus::Free {
            (self.sdo_owed, self.lss_owed) = (0, 0);
        }
        if self.state == State::Initialising {
            self.boot();
        }
    }

    fn receive(&mut self, frame: &Frame) {
        let sdo = SDO_REQUEST + u16::from(self.subject.node_id.get());
        let asked = frame.id().get() == sdo && !frame.is_remote() && self.serves();
        let command = frame.data().first().copied().unwrap_or(0);
        if asked {
            self.sdo_owed += Self::answers_at_most(command);
        }
        if frame.id().get() == LSS_REQUEST {
            self.lss_owed += 1;
        }
        if asked && self.may_move_partners(frame) {
            self.partners.doubt();
        }
        if asked && (command != 0x40 || self.may_be_a_segment()) {
            self.pdos = [PdoTimes::UNKNOWN; PDO_MAX];
        }
        let (before, commands) = (self.values(), self.storage_commands);
        let answers = if self.guards(frame) {
            self.receive_guarding(frame);
            Vec::new()
        } else {
            let (time, has_one_service) = (self.told_by(frame), self.is_for_one_service(frame));
            self.hear_producer(frame);
            self.is_remote = frame.is_remote();
            self.node.handle_frame(self.now, frame, &mut self.mood);
            let answers = self.drain();
            self.is_remote = false;
            match self.told.take() {
                None => assert!(time.is_none() || !has_one_service, "{frame:02X?}"),
                told => assert_eq!(told, time),
            }
            answers
        };
        match answers.as_slice() {
            [answer] if asked => self.check_answer(frame, answer, &before),
            [] if asked && self.bus == Bus::Free => {
                let initiates = matches!(command, 0x40 | 0x20 | 0x22 | 0x23 | 0x2B | 0x2F);
                let whole = frame.data().len() == 8 && initiates;
                let waits = self.may_be_a_segment() || self.storage_commands != commands;
                assert!(!whole || waits, "no answer to {frame:02X?}");
            }
            _ => {}
        }
    }

    /// Whether it may write to an object of life guarding or of a consumer of heartbeats.
    fn may_move_partners(&self, request: &Frame) -> bool {
        let &[command, low, high, ..] = request.data() else { return true };
        let is_initiate = command & 0xE0 == 0x20 && !self.may_be_a_segment();
        let index = u16::from_le_bytes([low, high]);
        let objects = [GUARD_TIME.index, LIFE_TIME_FACTOR.index, MONITORED, HEARTBEAT_TIME.index];
        !is_initiate || objects.contains(&index)
    }

    /// Whether it is a guarding request to be answered. Heartbeats go before guarding (CiA 301,
    /// section 7.2.8.2.2).
    fn guards(&self, frame: &Frame) -> bool {
        let own = ERROR_CONTROL + u16::from(self.subject.node_id.get());
        let beats = self.value(HEARTBEAT_TIME).unwrap_or(0) > 0;
        let is_guarded = self.value(GUARD_TIME).is_some() && !beats;
        is_guarded && frame.is_remote() && frame.id().get() == own
    }

    fn receive_guarding(&mut self, frame: &Frame) {
        self.guarding_answer = Some(self.partners.request(state_byte(self.state)));
        self.node.handle_frame(self.now, frame, &mut self.mood);
        self.drain();
        let left = self.guarding_answer.take();
        assert!(left.is_none() || self.bus == Bus::Busy, "no answer to a guarding request");
        let value = |object| u64::from(self.value(object).unwrap_or(0));
        let life_time = Duration::from_millis(value(GUARD_TIME) * value(LIFE_TIME_FACTOR));
        self.partners.renew(self.now, life_time);
    }

    /// The message of a monitored producer counts in every state.
    fn hear_producer(&mut self, frame: &Frame) {
        let producer = self.monitored().find(|&(producer, _)| {
            frame.id().get() == ERROR_CONTROL + u16::from(producer) && !frame.is_remote()
        });
        if let (Some((producer, time)), 1) = (producer, frame.dlc()) {
            let is_certain = self.is_for_one_service(frame);
            self.partners.hear(self.now, producer, time, is_certain);
        }
    }

    /// The time that a frame tells a node that consumes it.
    fn told_by(&self, frame: &Frame) -> Option<TimeOfDay> {
        const CONSUMED: u32 = 1 << 31;
        let cob_id = self.value(TIME).filter(|cob_id| cob_id & CONSUMED != 0)?;
        let is_time = u32::from(frame.id().get()) == cob_id & 0x7FF && !frame.is_remote();
        let &[a, b, c, d, low, high] = frame.data() else { return None };
        (is_time && self.serves()).then_some(TimeOfDay {
            milliseconds: u32::from_le_bytes([a, b, c, d & 0x0F]),
            days: u16::from_le_bytes([low, high]),
        })
    }

    /// Whether one service alone listens to frames like this one.
    fn is_for_one_service(&self, frame: &Frame) -> bool {
        let is_same = |id, remote| id == frame.id() && remote == frame.is_remote();
        self.node.accepts().filter(|accepted| is_same(accepted.id, accepted.remote)).count() == 1
    }

    /// One; a block of segments to what asks for one.
    fn answers_at_most(command: u8) -> usize {
        if matches!(command & 0xE3, 0xA2 | 0xA3) { 128 } else { 1 }
    }

    /// Behind the answer to a block download any frame may be one.
    const fn may_be_a_segment(&self) -> bool {
        matches!(self.sdo_answered, None | Some(0xA2 | 0xA4))
    }

    fn check_answer(&self, request: &Frame, answer: &[u8], before: &[u32]) {
        let [command, low, high, sub, value @ ..] = answer else { panic!("eight bytes") };
        if *command == 0x80 {
            assert_eq!(self.values(), before, "aborted, and changed: {request:02X?}");
        }
        let object = ObjectId { index: u16::from_le_bytes([*low, *high]), sub: *sub };
        let is_read = request.data()[0] == 0x40 && request.data()[1..4] == answer[1..4];
        if let (0x43 | 0x4B | 0x4F, true) = (*command, is_read) {
            let Ok(slot) = self.subject.dictionary.find(object) else {
                panic!("an object that is not there: {answer:02X?}")
            };
            let row = self.subject.dictionary.row(slot).unwrap();
            if !is_text(row.data_type()) {
                let len = row.data_type().len();
                let raw = self.node.values().raw(slot).to_le_bytes();
                assert_eq!((&value[..len], 4 - len), (&raw[..len], usize::from(command >> 2 & 3)));
            }
        }
    }

    /// The answer to a command to store or restore may come now, if nothing else came before.
    fn handle_stored(&mut self, outcome: Result<(), WriteError>) {
        if self.storage == Storage::Busy {
            self.storage = Storage::Idle;
            self.sdo_owed += 1;
        }
        self.node.handle_stored(outcome);
    }

    /// One command at a time.
    fn begin_storage(&mut self) {
        assert_eq!(self.storage, Storage::Idle);
        self.storage = Storage::Busy;
        self.storage_commands += 1;
    }

    fn give_back(&mut self) {
        if self.bus == Bus::Busy
            && let Some(frame) = self.node.peek_transmit().copied()
            && frame.id().get() != SDO_RESPONSE + u16::from(self.subject.node_id.get())
        {
            assert_eq!(self.node.take_transmit(), Some(frame));
            self.node.give_back(frame);
            assert_eq!(self.node.peek_transmit(), Some(&frame));
        }
    }

    fn advance(&mut self, span: Duration) {
        let until = self.now + span;
        for _ in 0..WAKES_MAX {
            match self.node.poll_timeout() {
                Some(due_at) if due_at <= until => self.now = self.now.max(due_at),
                Some(_) | None => {
                    self.now = until;
                    return;
                }
            }
            self.wake();
        }
    }

    fn sleep(&mut self, span: Duration) {
        self.pass(span);
        self.wake();
    }

    /// Nothing is served for this long, so that heartbeat and SYNC may be late.
    fn pass(&mut self, span: Duration) {
        self.now = self.now + span;
        (self.heartbeat.period, self.sync.period) = (None, None);
        self.pdos = [PdoTimes::UNKNOWN; PDO_MAX];
    }

    /// What is due is done by one call. Only what is to be said about an overflow comes later: it is
    /// known when its event is taken.
    fn wake(&mut self) {
        self.sdo_owed += 1;
        self.overflow_is_new = false;
        self.node.handle_timeout(self.now, &mut self.mood);
        self.drain();
        if self.bus == Bus::Free {
            self.sdo_owed = 0;
        }
        let next_at = self.node.poll_timeout();
        let is_done = next_at.is_none_or(|next_at| next_at > self.now);
        assert!(is_done || self.overflow_is_new, "the node is never done");
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
                    self.partners.lose(self.now, producer.get());
                    lost = true;
                }
                Event::HeartbeatRecovered { producer } => {
                    assert!(self.monitors(producer.get()), "{producer:?}");
                    self.partners.recover(producer.get());
                }
                Event::GuardingLost => {
                    self.partners.lose_master(self.now);
                    lost = true;
                }
                Event::GuardingRecovered => self.partners.recover_master(),
                Event::Time(time) => self.told = Some(time),
                Event::BusStateChanged { from, to } => {
                    assert_eq!(from, self.bus_state);
                    self.bus_state = to;
                }
                Event::PdoOverdue { .. } => assert_eq!(self.state, State::Operational),
                Event::FiltersChanged => {}
                Event::Store { .. } | Event::Restore { .. } => self.begin_storage(),
                Event::Lss(event) => self.handle_lss(event),
                Event::TransmitOverflow { .. } => {
                    assert_eq!(self.bus, Bus::Busy);
                    (self.lost_frames, self.overflow_is_new) = (true, true);
                }
            }
        }
        assert_eq!(self.state, self.node.state());
        if self.state == State::Initialising {
            let next = (self.node.peek_transmit(), self.node.poll_timeout());
            assert_eq!(next, (None, None), "the node is silent");
        } else {
            self.partners.check(self.now);
            self.check_error_register();
        }
        self.check_values();
        self.check_cycles();
        self.own.extend(self.own_ids());
        if self.bus == Bus::Busy || self.stale {
            self.pdos = [PdoTimes::UNKNOWN; PDO_MAX];
        }
        if self.bus == Bus::Busy {
            self.stale = true;
            return Vec::new();
        }
        let mut answers = Vec::new();
        let mut others = 0;
        while let Some(frame) = self.node.take_transmit() {
            if let Some(answer) = self.check_frame(&frame, lost) {
                answers.push(answer);
            } else {
                others += 1;
            }
        }
        assert!(others <= TRANSMIT_MAX + 1, "{others} frames waited");
        if std::mem::take(&mut self.lost_frames) {
            self.sdo_answered = None;
        }
        self.stale = false;
        if !self.hurries {
            self.own = self.own_ids();
        }
        answers
    }

    fn handle_lss(&mut self, event: lss::Event) {
        assert!(self.subject.settings.lss.is_some(), "{event:?} without the service");
        match event {
            lss::Event::Store { .. } | lss::Event::StoreNodeId { .. } => {
                self.lss_owed += 1;
                self.node.handle_lss_stored(Ok(()));
            }
            lss::Event::ActivateBitTiming { .. } => self.state = State::Initialising,
            lss::Event::Offered { .. }
            | lss::Event::AddressingEnded
            | lss::Event::Configured { .. } => {}
        }
    }

    /// The data of an SDO answer.
    fn check_frame(&mut self, frame: &Frame, lost: bool) -> Option<Vec<u8>> {
        let (id, node_id) = (frame.id().get(), u16::from(self.subject.node_id.get()));
        assert!(self.own.contains(&id), "the identifier of another node: {frame:02X?}");
        assert!(!frame.is_remote(), "{frame:02X?}");
        if id == SDO_RESPONSE + node_id {
            assert_eq!(frame.dlc(), 8);
            assert!(self.serves() || self.stale, "{frame:02X?}");
            let left = self.sdo_owed.checked_sub(1);
            self.sdo_owed = left.unwrap_or_else(|| panic!("nobody asked for {frame:02X?}"));
            self.sdo_answered = Some(frame.data()[0]);
            return Some(frame.data().to_vec());
        }
        if id == LSS_RESPONSE {
            assert_eq!(frame.dlc(), 8);
            let left = self.lss_owed.checked_sub(1);
            self.lss_owed = left.unwrap_or_else(|| panic!("nobody asked for {frame:02X?}"));
        } else if id == ERROR_CONTROL + node_id {
            self.check_error_control(frame);
            self.heartbeat.since = self.now;
        } else if self.is_sync(id) {
            assert!(frame.dlc() <= 1, "{frame:02X?}");
            self.sync.since = self.now;
        } else if !self.stale && self.is_emergency(id) && frame.dlc() == 8 {
            assert!(self.serves() || lost, "{frame:02X?}");
        } else if !self.stale {
            self.check_pdo(frame);
            self.check_inhibit_time(frame);
        }
        None
    }

    fn check_error_control(&mut self, frame: &Frame) {
        let &[byte] = frame.data() else { panic!("{frame:02X?}") };
        if !std::mem::replace(&mut self.booted, true) {
            assert_eq!(byte, 0);
        } else {
            let expected = self.guarding_answer.take().unwrap_or_else(|| state_byte(self.state));
            assert!(byte == expected || self.stale, "{byte:#04X}, not {expected:#04X}");
        }
    }

    /// It has the errors of the product, and bits of its own as long as the communication has one.
    fn check_error_register(&self) {
        const COMMUNICATION: u8 = 1 << 4 | 1;
        let is_impaired = matches!(self.bus_state, BusState::Passive | BusState::Off);
        let Some(is_lonely) = self.partners.is_one_lost() else { return };
        let own = if is_impaired || is_lonely { COMMUNICATION } else { 0 };
        assert_eq!(self.value(ERROR_REGISTER), Some(u32::from(self.errors | own)));
    }

    /// No heartbeat, no SYNC and no PDO with an event timer is late.
    fn check_cycles(&mut self) {
        let value = |index| self.value(ObjectId { index, sub: 0 }).unwrap_or(0);
        let produces_sync = value(0x1005) & 1 << 30 != 0 && self.state != State::Stopped;
        let (sync_us, heartbeat_ms) = (value(0x1006), value(0x1017));
        let runs = self.bus == Bus::Free && !self.stale && self.state != State::Initialising;
        let heartbeat = Duration::from_millis(u64::from(heartbeat_ms));
        let sync = Duration::from_micros(u64::from(sync_us));
        self.heartbeat.check(self.now, (runs && heartbeat_ms > 0).then_some(heartbeat));
        self.sync.check(self.now, (runs && produces_sync && sync_us > 0).then_some(sync));
        for number in 0..PDO_MAX as u16 {
            let period = self.event_period(number).filter(|_| runs);
            self.pdos[usize::from(number)].events.check(self.now, period);
        }
    }

    /// What a master cannot write is not there.
    fn check_values(&self) {
        for (slot, row) in &self.received {
            assert!(row.permits(self.node.values().raw(*slot)), "{:?}", row.id());
        }
    }

    fn own_ids(&self) -> BTreeSet<u16> {
        let node_id = u16::from(self.subject.node_id.get());
        let mut ids = BTreeSet::from([SDO_RESPONSE + node_id, ERROR_CONTROL + node_id]);
        if self.subject.settings.lss.is_some() {
            ids.insert(LSS_RESPONSE);
        }
        let cob_ids = self.cob_ids.iter().map(|&slot| self.node.values().raw(slot));
        ids.extend(cob_ids.filter_map(valid));
        let sync = self.value(ObjectId { index: 0x1005, sub: 0 });
        ids.extend(sync.filter(|sync| sync & 1 << 30 != 0).map(|sync| (sync & 0x7FF) as u16));
        ids
    }

    fn is_emergency(&self, id: u16) -> bool {
        self.value(ObjectId { index: 0x1014, sub: 0 }).and_then(valid) == Some(id)
    }

    fn is_sync(&self, id: u16) -> bool {
        let cob_id = self.value(ObjectId { index: 0x1005, sub: 0 }).unwrap_or(0);
        cob_id & 1 << 30 != 0 && cob_id & 0x7FF == u32::from(id)
    }

    fn monitors(&self, producer: u8) -> bool {
        self.monitored().any(|(monitored, _)| monitored == producer)
    }

    /// The producers whose heartbeats are monitored, and how long each may take.
    fn monitored(&self) -> impl Iterator<Item = (u8, Duration)> {
        let entries = (1..=127).map_while(|sub| self.value(ObjectId { index: MONITORED, sub }));
        entries.filter_map(|entry| {
            let [low, high, producer, _] = entry.to_le_bytes();
            let time_ms = u16::from_le_bytes([low, high]);
            let is_used = time_ms > 0 && (1..=127).contains(&producer);
            is_used.then(|| (producer, Duration::from_millis(time_ms.into())))
        })
    }

    const fn serves(&self) -> bool {
        matches!(self.state, State::PreOperational | State::Operational)
    }

    /// What masters write. The error register follows what happens.
    fn values(&self) -> Vec<u32> {
        let slots = self.subject.dictionary.slots();
        let written = slots.filter(|(_, row)| row.id() != ERROR_REGISTER);
        written.map(|(slot, _)| self.node.values().raw(slot)).collect()
    }

    /// `None` when the product does not have the object.
    fn value(&self, object: ObjectId) -> Option<u32> {
        self.subject.dictionary.find(object).ok().map(|slot| self.node.values().raw(slot))
    }
}

/// How a heartbeat tells a state (CiA 301, section 7.2.8.3.2.2).
fn state_byte(state: State) -> u8 {
    match state {
        State::PreOperational => 0x7F,
        State::Operational => 0x05,
        State::Stopped => 0x04,
        State::Initialising => panic!("a sign of life from a node that is off"),
    }
}

/// The identifier of a COB-ID that is in use.
fn valid(cob_id: u32) -> Option<u16> {
    (cob_id & 1 << 31 == 0).then_some((cob_id & 0x7FF) as u16)
}

fn is_text(data_type: DataType) -> bool {
    matches!(data_type, DataType::VisibleString(_))
}
