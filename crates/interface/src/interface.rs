use canopen::{Accepted, Frame, Node, NodeId, State};
use heapless::Deque;
use object_dictionary::{Access, Owner, Slot};
use profiles::nm17x::{BIT_RATE, NODE_ID, SERIAL_NUMBER, STATUS_REGISTER};
use profiles::{OBJECTS_MAX, Product};
use shared_proto::{Encoded, Hello, NodeState, PROTOCOL, ProcessData, Urgency};
use units::{Duration, Instant};

use crate::emergency::{Condition, Conditions, Emergency};
use crate::link::{self, Link};
use crate::nm17x::SETTINGS;
use crate::objects::{Known, Objects, Outcome};
use crate::record::Record;
use crate::slots::Slots;

/// The boot-up message goes out without the application's values after this time.
const BOOT_UP_AFTER: Duration = Duration::from_millis(500);
/// The pre-defined error field outlives a restart of the communication (NM17x EMCY-04).
const ERROR_FIELD: u16 = 0x1003;
/// Events that may wait for [`Interface::poll_event`]: one input makes at most a record, new filters
/// and a restart.
const EVENTS_MAX: usize = 3;

/// What the shell knows when it starts.
#[derive(Clone, Copy, Debug)]
pub struct Boot {
    /// Object 0x1018:04, not 0.
    pub serial_number: u32,
    /// Differs from one start to the next, not 0.
    pub nonce: u32,
}

/// The CAN controller's standing on the bus (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusState {
    /// Error active, no warning.
    Active,
    /// An error counter has reached 96.
    Warning,
    /// Error passive.
    Passive,
    /// Bus-off.
    Off,
}

/// What the shell has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Save this, now.
    Store(Record),
    /// Set the acceptance filters to what [`Interface::accepts`] says.
    FiltersChanged,
    /// Restart the controller, behind everything that is to be saved.
    Restart,
}

/// The CAN interface controller, without pins, clock and tasks.
///
/// Contract: after every `handle_*` call drain [`Self::peek_transmit`], [`Self::poll_link`] and
/// [`Self::poll_event`], then call [`Self::handle_timeout`] no later than [`Self::poll_timeout`].
#[derive(Debug)]
pub struct Interface {
    product: &'static Product,
    slots: Slots,
    node: Node<OBJECTS_MAX>,
    link: Link,
    /// Until when the boot-up message waits for the application's values.
    boot_up_by: Option<Instant>,
    values_known: bool,
    bus: BusState,
    conditions: Conditions,
    events: Deque<Event, EVENTS_MAX>,
}

impl Interface {
    /// A controller with everything at delivery state. Stored numbers follow with
    /// [`Self::restore`], before anything else is handled.
    #[must_use]
    pub fn new(now: Instant, product: &'static Product, boot: Boot) -> Self {
        let hello = Hello {
            protocol: PROTOCOL,
            product: product.code,
            firmware: product.firmware,
            dictionary: product.fingerprint,
            nonce: boot.nonce,
            heard: 0,
            in_service: false,
        };
        let rows = product.dictionary.rows();
        let first = rows.iter().position(|row| row.owner == Owner::Application).unwrap_or(0);
        let rows = position(first)..position(rows.len());
        let mut interface = Self {
            product,
            slots: Slots::of(product.dictionary),
            node: Node::new(product.dictionary, DELIVERED_NODE_ID, &SETTINGS),
            link: Link::new(now, hello, rows, DELIVERED_NODE_ID.get()),
            boot_up_by: Some(now + BOOT_UP_AFTER),
            values_known: false,
            bus: BusState::Active,
            conditions: Conditions::default(),
            events: Deque::new(),
        };
        interface.restore(SERIAL_NUMBER.id().key(), boot.serial_number);
        interface
    }

    /// Takes over a number that was saved. Ignored when it is none of this controller's, or no
    /// longer permitted.
    pub fn restore(&mut self, key: u32, value: u32) {
        let rows = self.product.dictionary.slots();
        let found = rows.filter(|(_, row)| row.id.key() == key && row.permits(value)).last();
        let Some((slot, row)) = found.filter(|(_, row)| row.owner == Owner::Interface) else {
            return;
        };
        if row.id == NODE_ID.id()
            && let Some(node_id) = u8::try_from(value).ok().and_then(NodeId::new)
        {
            self.rebuild_node(node_id);
            self.link.set_node_id(node_id.get());
        }
        self.node.set_value(Instant::ZERO, slot, value);
    }

    /// The bit rate to use, in bit/s.
    #[must_use]
    pub fn bit_rate(&self) -> u32 {
        const KBIT_S: [u32; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1_000];
        let index = usize::from(self.node.values().get(&BIT_RATE));
        KBIT_S.get(index).map_or(125_000, |rate| rate * 1_000)
    }

    /// The frames to let through; all others are none of this device's.
    pub fn accepts(&self) -> impl Iterator<Item = Accepted> {
        self.node.accepts()
    }

    /// A frame from the bus.
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        let known =
            Known { values: self.values_known, scaling: self.value(self.slots.scaling) != 0 };
        let mut objects = Objects::new(&mut self.link, &self.slots, known);
        self.node.handle_frame(now, frame, &mut objects);
        match objects.outcome() {
            Outcome::Nothing => {}
            Outcome::Store(record) => self.event(Event::Store(record)),
            Outcome::ApplicationWritten => self.follow_correction(now),
            Outcome::QueueFull => self.send(Emergency::WRITE_QUEUE_FULL),
        }
        self.settle_node(now);
    }

    /// Bytes from the link.
    pub fn handle_link(&mut self, now: Instant, bytes: &[u8]) {
        for &byte in bytes {
            self.link.handle_byte(now, byte);
            self.settle_link(now);
        }
        self.node.handle_timeout(now);
        self.settle_node(now);
    }

    /// The controller's standing on the bus changed.
    pub fn handle_bus(&mut self, now: Instant, bus: BusState) {
        let before = core::mem::replace(&mut self.bus, bus);
        if before == bus {
            return;
        }
        let impaired = matches!(bus, BusState::Passive | BusState::Off);
        if impaired {
            self.set_condition(now, Condition::Bus, true);
        }
        match bus {
            BusState::Off => self.link.stop(Urgency::BusOff),
            BusState::Active | BusState::Warning | BusState::Passive if before == BusState::Off => {
                self.send(Emergency::BUS_OFF_RECOVERED);
            }
            BusState::Warning if before == BusState::Active => self.send(Emergency::BUS_WARNING),
            BusState::Passive => self.send(Emergency::BUS_PASSIVE),
            BusState::Active | BusState::Warning => {}
        }
        if !impaired {
            self.set_condition(now, Condition::Bus, false);
        }
        self.settle_node(now);
    }

    /// Frames were lost because they came faster than they were taken.
    pub fn handle_overrun(&mut self) {
        self.send(Emergency::CAN_OVERRUN);
    }

    /// Does what is due.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.link.handle_timeout(now);
        self.settle_link(now);
        if self.boot_up_by.is_some_and(|by| by <= now) {
            self.boot_up(now);
            self.set_condition(now, Condition::Link, true);
            self.send(Emergency::LINK_LOST);
        }
        self.node.handle_timeout(now);
        self.settle_node(now);
    }

    /// When [`Self::handle_timeout`] has something to do.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let due = [Some(self.link.poll_timeout()), self.node.poll_timeout(), self.boot_up_by];
        due.into_iter().flatten().min()
    }

    /// The next frame for a mailbox: the lowest CAN-ID, the oldest of equal ones.
    #[must_use]
    pub fn peek_transmit(&self) -> Option<&Frame> {
        self.node.peek_transmit()
    }

    /// Takes the frame out that [`Self::peek_transmit`] shows.
    pub fn take_transmit(&mut self) -> Option<Frame> {
        self.node.take_transmit()
    }

    /// Takes a frame back that a more urgent one pushed out of its mailbox.
    pub fn give_back(&mut self, frame: Frame) {
        self.node.give_back(frame);
    }

    /// The next frame for the link.
    pub fn poll_link(&mut self) -> Option<Encoded> {
        self.link.poll_transmit()
    }

    /// What there is to do, the oldest first.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}

/// The node-ID of a device that nobody has given one.
const DELIVERED_NODE_ID: NodeId = match NodeId::new(127) {
    Some(node_id) => node_id,
    None => panic!("127 is a node-ID"),
};

impl Interface {
    fn settle_link(&mut self, now: Instant) {
        while let Some(event) = self.link.poll_event() {
            match event {
                link::Event::Process(process) => self.take_process_data(now, &process),
                link::Event::Values(from, values) => self.take_values(now, from, &values),
                link::Event::SnapshotComplete => {
                    self.values_known = true;
                    self.boot_up(now);
                    self.set_condition(now, Condition::Link, false);
                }
                link::Event::Fault(fault) => {
                    if matches!(fault, link::Fault::Lost | link::Fault::Mismatch) {
                        self.set_condition(now, Condition::Link, true);
                    }
                    self.send(fault.into());
                }
            }
        }
    }

    fn settle_node(&mut self, now: Instant) {
        while let Some(event) = self.node.poll_event() {
            match event {
                canopen::Event::StateChanged { from, to } => self.follow_state(from, to),
                canopen::Event::ResetNode => {
                    self.link.stop(Urgency::StateLowered);
                    self.event(Event::Restart);
                }
                canopen::Event::ResetCommunication => {
                    self.link.stop(Urgency::StateLowered);
                    self.rebuild_node(self.node.node_id());
                    self.event(Event::FiltersChanged);
                    self.boot_up_by = Some(now);
                    self.boot_up(now);
                }
                canopen::Event::HeartbeatLost { .. } | canopen::Event::GuardingLost => {
                    self.link.stop(Urgency::HeartbeatLost)
                }
                canopen::Event::HeartbeatRecovered { .. }
                | canopen::Event::GuardingRecovered
                | canopen::Event::PdoOverdue { .. } => {}
                canopen::Event::FiltersChanged => self.event(Event::FiltersChanged),
                // The settings of the NM17x ask for no layer setting services.
                canopen::Event::Lss(_) => {}
                canopen::Event::TransmitOverflow { .. } => self.send(Emergency::CAN_OVERRUN),
            }
        }
    }

    /// Positioning is possible in Pre-operational and Operational; every step down from there stops
    /// it (NM17x ABORT-04).
    fn follow_state(&mut self, from: State, to: State) {
        let rank = |state| match state {
            State::Initialising => 0,
            State::Stopped => 1,
            State::PreOperational => 2,
            State::Operational => 3,
        };
        self.link.set_node_state(match to {
            State::Initialising => NodeState::Initialising,
            State::Stopped => NodeState::Stopped,
            State::PreOperational => NodeState::PreOperational,
            State::Operational => NodeState::Operational,
        });
        if rank(to) < rank(from) {
            self.link.stop(Urgency::StateLowered);
        }
    }

    fn boot_up(&mut self, now: Instant) {
        if self.boot_up_by.take().is_some() {
            self.node.boot(now);
            self.settle_node(now);
        }
    }

    /// A node with communication parameters as stored, and everything else as it is.
    fn rebuild_node(&mut self, node_id: NodeId) {
        let fresh = Node::new(self.product.dictionary, node_id, &SETTINGS);
        let before = core::mem::replace(&mut self.node, fresh);
        for (slot, row) in self.product.dictionary.slots() {
            let kept = row.id.index >= 0x2000 || row.id.index == ERROR_FIELD;
            if kept || row.id == SERIAL_NUMBER.id() || row.id == STATUS_REGISTER.id() {
                self.node.set_value(Instant::ZERO, slot, before.values().raw(slot));
            }
        }
        self.node.set_error_register(Instant::ZERO, self.conditions.error_register());
    }

    fn take_process_data(&mut self, now: Instant, process: &ProcessData) {
        let Slots { position, status, errors, status_register, .. } = self.slots;
        self.set_value(now, position, process.position_hundredths_mm.cast_unsigned());
        self.set_value(now, status, process.status.into());
        self.set_value(now, errors, process.errors.into());
        self.set_value(now, status_register, process.status.into());
        self.set_condition(now, Condition::Application, process.errors != 0);
    }

    fn take_values(&mut self, now: Instant, from: u16, values: &[u32]) {
        for (position, &value) in (from..).zip(values) {
            let Some(slot) = Slot::at(self.product.dictionary, position) else { break };
            match self.product.dictionary.row(slot) {
                Some(row) if row.owner != Owner::Application || self.slots.is_live(slot) => {}
                Some(row) if self.link.is_writing(row.id) => {}
                Some(row) if row.access != Access::ReadWrite || row.permits(value) => {
                    self.node.set_value(now, slot, value);
                }
                Some(_) => self.send(link::Fault::CorruptValue.into()),
                None => break,
            }
        }
        self.follow_correction(now);
    }

    /// 0x2501:04: the correction in force, as far as 16 bits hold it.
    fn follow_correction(&mut self, now: Instant) {
        let enabled = self.value(self.slots.correction_enabled) == 1;
        let correction = if enabled { self.value(self.slots.correction).cast_signed() } else { 0 };
        let sent =
            i16::try_from(correction).unwrap_or(if correction < 0 { i16::MIN } else { i16::MAX });
        self.set_value(now, self.slots.correction_sent, sent.cast_unsigned().into());
    }

    fn value(&self, slot: Option<Slot>) -> u32 {
        slot.map_or(0, |slot| self.node.values().raw(slot))
    }

    fn set_value(&mut self, now: Instant, slot: Option<Slot>, raw: u32) {
        if let Some(slot) = slot {
            self.node.set_value(now, slot, raw);
        }
    }

    fn set_condition(&mut self, now: Instant, condition: Condition, present: bool) {
        self.conditions.set(condition, present);
        self.node.set_error_register(now, self.conditions.error_register());
    }

    fn send(&mut self, emergency: Emergency) {
        self.node.send_emergency(emergency.code, emergency.manufacturer());
    }

    fn event(&mut self, event: Event) {
        let waiting = self.events.iter().any(|waiting| *waiting == event);
        if !waiting && self.events.is_full() {
            self.events.pop_front();
        }
        if !waiting {
            let _ = self.events.push_back(event);
        }
    }
}

fn position(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}
