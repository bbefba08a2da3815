//! The interface controller's end of the internal link (manual 3.7.1; NM17x LINK-01 to LINK-07).
//!
//! The application controller is the clock. Each message from it opens a gap in which exactly one
//! goes back: a greeting while out of service, else an unacknowledged urgent order, the write that
//! waits for its acknowledgement, the next one of the queue, a request for values, or a keep-alive.
//! Only an urgent order does not wait for a gap.

use heapless::{Deque, Vec};
use object_dictionary::ObjectId;
use shared_proto::limits::{CYCLE_MS, SNAPSHOT_VALUES_MAX};
use shared_proto::{
    Encoded, Hello, NodeState, PROTOCOL, ProcessData, Receiver, Supervision, ToApplication,
    ToInterface, Urgency, Urgent, Write, encode,
};
use units::{Duration, Instant};

/// Writes that can wait for the application controller (NM17x LINK-05).
pub const WRITES_MAX: usize = 50;
/// A write is repeated when this many process data arrived without its acknowledgement.
const CYCLES_BEFORE_REPEAT: u8 = 2;
/// Attempts after the first one.
const REPEATS_MAX: u8 = 3;
/// Missing process data: noted at the second, out of service at the fourth.
const MISSING_NOTED: u8 = 2;
const MISSING_LOST: u8 = 4;
/// Values are asked for again when they have not come in this many cycles.
const SNAPSHOT_CYCLES_MAX: u8 = 3;
const CYCLE: Duration = Duration::from_millis(CYCLE_MS);
/// Jitter of the cycle that does not yet make process data late.
const CYCLE_TOLERANCE: Duration = Duration::from_millis(CYCLE_MS / 2);
/// Most a single byte or timeout makes happen: process data with a write given up, two stages of
/// missing process data, or a fault of the greeting.
const EVENTS_MAX: usize = 2;
/// An urgent order and the answer of the gap.
const OUTBOX_MAX: usize = 2;

/// What the link tells the core.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Process data arrived in service.
    Process(ProcessData),
    /// Values of consecutive rows, the first one's position ahead.
    Values(u16, Vec<u32, SNAPSHOT_VALUES_MAX>),
    /// All values of the application controller have been taken over since the last greeting.
    SnapshotComplete,
    /// The user touched the device while it showed the offer of this number.
    Touched(u8),
    /// The link is bad or good again.
    Fault(Fault),
}

/// States of the link that a master learns of (NM17x EMCY-05).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// 0x8310/01: process data missed twice in a row.
    ProcessDataMissing,
    /// 0x8310/04: process data missed four times in a row, the link is out of service.
    Lost,
    /// 0x8310/02: a write was dropped: not acknowledged after all its repetitions, or an action
    /// that the partner's restart overtook.
    WriteNotAcknowledged,
    /// 0x8310/03: a value that its object does not permit.
    CorruptValue,
    /// 0x8310/05: the other image has another protocol, product or dictionary.
    Mismatch,
}

/// Why a write can not be queued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueueError {
    /// [`WRITES_MAX`] writes are waiting.
    Full,
    /// The link is out of service.
    Down,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Greeting,
    /// Values still wanted from this position on, asked for so many cycles ago.
    Loading {
        from: u16,
        asked: Option<u8>,
    },
    InService,
}

/// What a write does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It sets a value: executed late or twice it does no harm.
    Value,
    /// It makes something happen at that moment: it is dropped rather than executed by a partner
    /// that has restarted since.
    Action,
    /// It moves the axis: like an action, and a stop drops it as well.
    Start,
}

#[derive(Clone, Copy, Debug)]
struct Queued {
    write: Write,
    kind: Kind,
}

/// A write on its way.
#[derive(Clone, Copy, Debug)]
struct InFlight {
    write: Write,
    kind: Kind,
    cycles: u8,
    repeats: u8,
}

/// One end of the line. Sans-IO: bytes in, bytes out, time as an argument.
#[derive(Debug)]
pub struct Link {
    own: Hello,
    /// Rows of the application controller: the first one's position, and the dictionary's length.
    rows: core::ops::Range<u16>,
    receiver: Receiver<ToInterface>,
    state: State,
    mismatched: bool,
    supervision: Supervision,
    writes: Deque<Queued, WRITES_MAX>,
    in_flight: Option<InFlight>,
    sequence: u8,
    urgent: Option<Urgent>,
    urgent_number: u8,
    missing: u8,
    missing_at: Instant,
    outbox: Deque<Encoded, OUTBOX_MAX>,
    events: Deque<Event, EVENTS_MAX>,
}

impl Link {
    /// A link that waits for the first greeting. `rows` are the positions of the dictionary that
    /// the application controller holds.
    #[must_use]
    pub fn new(now: Instant, own: Hello, rows: core::ops::Range<u16>, node_id: u8) -> Self {
        Self {
            own: Hello { protocol: PROTOCOL, heard: 0, in_service: false, ..own },
            rows,
            receiver: Receiver::default(),
            state: State::Greeting,
            mismatched: false,
            supervision: Supervision { state: NodeState::Initialising, node_id },
            writes: Deque::new(),
            in_flight: None,
            sequence: 0,
            urgent: None,
            urgent_number: 0,
            missing: 0,
            missing_at: now + CYCLE + CYCLE_TOLERANCE,
            outbox: Deque::new(),
            events: Deque::new(),
        }
    }

    /// Whether process data arrive and writes are taken.
    #[must_use]
    pub fn in_service(&self) -> bool {
        self.state != State::Greeting
    }

    /// The node-ID the application controller is told from now on.
    pub fn set_node_id(&mut self, node_id: u8) {
        self.supervision.node_id = node_id;
    }

    /// What the application controller is told of the node from now on.
    pub fn set_node_state(&mut self, state: NodeState) {
        self.supervision.state = state;
    }

    /// A byte from the line. Drain [`Self::poll_event`] behind it.
    pub fn handle_byte(&mut self, now: Instant, byte: u8) {
        if let Some(message) = self.receiver.push(byte) {
            self.handle_message(now, message);
        }
    }

    /// Checks what is due.
    pub fn handle_timeout(&mut self, now: Instant) {
        while now >= self.missing_at {
            self.missing_at = self.missing_at + CYCLE;
            self.missing = self.missing.saturating_add(1);
            match self.missing {
                MISSING_NOTED => self.fault(Fault::ProcessDataMissing),
                MISSING_LOST => {
                    self.leave_service();
                    self.fault(Fault::Lost);
                }
                _ => {}
            }
        }
    }

    /// When [`Self::handle_timeout`] has something to do.
    #[must_use]
    pub fn poll_timeout(&self) -> Instant {
        self.missing_at
    }

    /// The next frame for the line.
    pub fn poll_transmit(&mut self) -> Option<Encoded> {
        self.outbox.pop_front()
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Queues a write for the application controller.
    ///
    /// # Errors
    /// When the queue is full or the link is out of service.
    pub fn write(&mut self, id: ObjectId, value: u32, kind: Kind) -> Result<(), QueueError> {
        self.check_room(1)?;
        let sequence = next_number(self.sequence);
        let write = Write { sequence, index: id.index, sub: id.sub, value };
        self.writes.push_back(Queued { write, kind }).map_err(|_| QueueError::Full)?;
        self.sequence = sequence;
        Ok(())
    }

    /// Whether so many writes would be taken.
    ///
    /// # Errors
    /// When the queue has less room or the link is out of service.
    pub fn check_room(&self, writes: usize) -> Result<(), QueueError> {
        if !self.in_service() {
            Err(QueueError::Down)
        } else if WRITES_MAX - self.writes.len() < writes {
            Err(QueueError::Full)
        } else {
            Ok(())
        }
    }

    /// Whether a write to this entry waits or is on its way: what the application controller says
    /// of its value meanwhile is out of date.
    #[must_use]
    pub fn is_writing(&self, id: ObjectId) -> bool {
        let in_flight = self.in_flight.iter().map(|in_flight| &in_flight.write);
        self.writes
            .iter()
            .map(|queued| &queued.write)
            .chain(in_flight)
            .any(|write| (write.index, write.sub) == (id.index, id.sub))
    }

    /// Whether any write waits or is on its way.
    #[must_use]
    pub fn has_writes(&self) -> bool {
        self.in_flight.is_some() || !self.writes.is_empty()
    }

    /// Orders a stop. It goes out at once and again in every gap until it is acknowledged. Starts
    /// that still wait are dropped.
    pub fn stop(&mut self, urgency: Urgency) {
        self.retain_writes(|kind| kind != Kind::Start);
        if self.in_flight.is_some_and(|in_flight| in_flight.kind == Kind::Start) {
            self.in_flight = None;
        }
        self.urgent_number = next_number(self.urgent_number);
        let urgent = Urgent { number: self.urgent_number, urgency };
        self.urgent = Some(urgent);
        self.send(&ToApplication::Urgent(self.supervision, urgent));
    }

    fn handle_message(&mut self, now: Instant, message: ToInterface) {
        match message {
            ToInterface::Hello(hello) => self.handle_hello(now, &hello),
            ToInterface::Process(process) if self.in_service() => {
                self.alive(now);
                self.acknowledge(&process);
                self.event(Event::Process(process));
                self.answer();
            }
            ToInterface::Snapshot { from, values } if self.in_service() => {
                self.handle_values(from, values);
            }
            ToInterface::Touched { offer } if self.in_service() => {
                self.event(Event::Touched(offer));
            }
            ToInterface::Process(_)
            | ToInterface::Snapshot { .. }
            | ToInterface::Touched { .. } => self.send_hello(),
        }
    }

    fn handle_hello(&mut self, now: Instant, hello: &Hello) {
        if !self.own.fits(hello) {
            if !self.mismatched {
                self.mismatched = true;
                self.fault(Fault::Mismatch);
            }
            self.leave_service();
            self.send_hello();
            return;
        }
        self.mismatched = false;
        if hello.nonce != self.own.heard {
            self.leave_service();
            self.own.heard = hello.nonce;
            self.drop_actions();
        }
        if hello.heard == self.own.nonce && !self.in_service() {
            self.alive(now);
            self.own.in_service = true;
            self.state = State::Loading { from: self.rows.start, asked: None };
            self.repeat_in_flight();
        }
        if !hello.in_service {
            self.send_hello();
        }
    }

    /// The partner has restarted: the moment the actions were meant for has passed.
    fn drop_actions(&mut self) {
        let waiting = self.writes.len();
        self.retain_writes(|kind| kind == Kind::Value);
        let mut dropped = self.writes.len() != waiting;
        if self.in_flight.is_some_and(|in_flight| in_flight.kind != Kind::Value) {
            self.in_flight = None;
            dropped = true;
        }
        if dropped {
            self.fault(Fault::WriteNotAcknowledged);
        }
    }

    fn retain_writes(&mut self, stays: impl Fn(Kind) -> bool) {
        for _ in 0..self.writes.len() {
            if let Some(queued) = self.writes.pop_front()
                && stays(queued.kind)
            {
                let _ = self.writes.push_back(queued);
            }
        }
    }

    /// The other side may have restarted since: what was on its way is new to it.
    fn repeat_in_flight(&mut self) {
        if let Some(in_flight) = &mut self.in_flight {
            (in_flight.cycles, in_flight.repeats) = (CYCLES_BEFORE_REPEAT, 0);
        }
    }

    fn leave_service(&mut self) {
        self.state = State::Greeting;
        self.own.in_service = false;
    }

    fn alive(&mut self, now: Instant) {
        self.missing = 0;
        self.missing_at = now + CYCLE + CYCLE_TOLERANCE;
    }

    fn acknowledge(&mut self, process: &ProcessData) {
        if self.urgent.is_some_and(|urgent| urgent.number == process.urgent_acknowledged) {
            self.urgent = None;
        }
        if let Some(in_flight) = &mut self.in_flight {
            if in_flight.write.sequence == process.acknowledged {
                self.in_flight = None;
            } else {
                in_flight.cycles += 1;
            }
        }
    }

    fn handle_values(&mut self, from: u16, values: Vec<u32, SNAPSHOT_VALUES_MAX>) {
        let count = u16::try_from(values.len()).unwrap_or(u16::MAX);
        self.event(Event::Values(from, values));
        if let State::Loading { from: wanted, .. } = self.state
            && wanted == from
        {
            let next = from.saturating_add(count);
            if next >= self.rows.end {
                self.state = State::InService;
                self.event(Event::SnapshotComplete);
            } else {
                self.state = State::Loading { from: next, asked: Some(0) };
            }
        }
    }

    /// The one message of the gap.
    fn answer(&mut self) {
        if let Some(urgent) = self.urgent {
            self.send(&ToApplication::Urgent(self.supervision, urgent));
        } else if let Some(write) = self.due_write() {
            self.send(&ToApplication::Write(self.supervision, write));
        } else if let Some(from) = self.due_request() {
            let supervision = self.supervision;
            self.send(&ToApplication::RequestSnapshot { supervision, from });
        } else {
            self.send(&ToApplication::Idle(self.supervision));
        }
    }

    fn due_write(&mut self) -> Option<Write> {
        if let Some(in_flight) = &mut self.in_flight {
            if in_flight.cycles < CYCLES_BEFORE_REPEAT {
                return None;
            }
            if in_flight.repeats < REPEATS_MAX {
                in_flight.repeats += 1;
                in_flight.cycles = 0;
                return Some(in_flight.write);
            }
            self.in_flight = None;
            self.fault(Fault::WriteNotAcknowledged);
        }
        let Queued { write, kind } = self.writes.pop_front()?;
        self.in_flight = Some(InFlight { write, kind, cycles: 0, repeats: 0 });
        Some(write)
    }

    /// Values are read behind the last write, so that they can not undo it.
    fn due_request(&mut self) -> Option<u16> {
        let State::Loading { from, asked } = &mut self.state else { return None };
        if self.in_flight.is_some() {
            return None;
        }
        match asked {
            Some(cycles) if *cycles < SNAPSHOT_CYCLES_MAX => {
                *cycles += 1;
                None
            }
            Some(_) | None => {
                *asked = Some(0);
                Some(*from)
            }
        }
    }

    fn send_hello(&mut self) {
        self.send(&ToApplication::Hello(self.own));
    }

    fn send(&mut self, message: &ToApplication) {
        if self.outbox.is_full() {
            self.outbox.pop_front();
        }
        let _ = self.outbox.push_back(encode(message));
    }

    fn fault(&mut self, fault: Fault) {
        self.event(Event::Fault(fault));
    }

    fn event(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }
}

/// 1 to 255, then 1 again; 0 means none.
fn next_number(number: u8) -> u8 {
    if number == u8::MAX { 1 } else { number + 1 }
}
