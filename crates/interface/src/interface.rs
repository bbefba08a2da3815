use canopen::lss::BitRate;
use canopen::{Accepted, BusState, Frame, Node, NodeId, State, WriteError};
use heapless::Deque;
use object_dictionary::{Access, Owner, Row, Slot};
use profiles::nm17x::{BIT_RATE, COMMANDS, NODE_ID, SERIAL_NUMBER, STATUS_REGISTER};
use profiles::{OBJECTS_MAX, Product};
use shared_proto::{Encoded, Hello, NodeState, PROTOCOL, ProcessData, Urgency};
use units::{Duration, Instant};

use crate::bit_timing::BitTiming;
use crate::emergency::{Condition, Conditions, Emergency};
use crate::link::{self, Link};
use crate::nm17x::Nm17x;
use crate::objects::{ApplicationWrite, Objects, Outcome};
use crate::record::Record;
use crate::saving::{Parameters, Saving};
use crate::slots::Slots;
use crate::stored::Set;

mod lss;
mod receive;

pub(crate) use receive::Received;

/// The boot-up message goes out without the application's values after this time.
const BOOT_UP_AFTER: Duration = Duration::from_millis(500);
/// A restart waits no longer for the application controller to acknowledge what masters wrote. A full
/// queue takes half of it.
const RESTART_WITHIN: Duration = Duration::from_millis(1_000);
/// The pre-defined error field outlives a restart of the communication (NM17x EMCY-04).
const ERROR_FIELD: u16 = 0x1003;
/// Events that may wait for [`Interface::poll_event`]: one input makes at most two records with their
/// confirmation, new filters and a restart.
const EVENTS_MAX: usize = 5;

/// What the shell knows when it starts.
#[derive(Clone, Copy, Debug)]
pub struct Boot {
    /// Object 0x1018:04, not 0.
    pub serial_number: u32,
    /// Differs from one start to the next, not 0.
    pub nonce: u32,
}

/// What the shell has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Save this, now.
    Store(Record),
    /// Replace the saved set by [`Interface::set_to_store`], as a whole.
    StoreSet,
    /// Forget all that is saved, in one step.
    Forget,
    /// When everything until here is saved, or is not, call [`Interface::handle_saved`] with this
    /// number.
    Confirm(u8),
    /// Set the acceptance filters to what [`Interface::accepts`] says.
    FiltersChanged,
    /// Restart the controller, behind everything that is to be saved. What masters wrote before is
    /// with the application controller, unless that took longer than a second.
    Restart,
}

/// The memory did not take what was to be saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotSaved;

/// The CAN interface controller, without pins, clock and tasks.
///
/// Contract: after every `handle_*` call drain [`Self::peek_transmit`], [`Self::poll_link`] and
/// [`Self::poll_event`], then call [`Self::handle_timeout`] no later than [`Self::poll_timeout`].
#[derive(Debug)]
pub struct Interface {
    product: &'static Product,
    node: Node<OBJECTS_MAX, Nm17x>,
    objects: Objects,
    /// Until when the boot-up message waits for the application's values.
    boot_up_by: Option<Instant>,
    /// Until when a restart waits for what is being written.
    restart_by: Option<Instant>,
    conditions: Conditions,
    /// In 0x2100's numbers.
    bit_rate: u8,
    bit_timing: Option<BitTiming>,
    stored: Set,
    saving: Saving,
    /// The last correction of RxPDO2, until another one is written.
    received_correction: Option<u16>,
    /// The number of the offer that the application controller shows.
    offer: Option<u8>,
    /// The number of the last offer.
    offers: u8,
    events: Deque<Event, EVENTS_MAX>,
}

impl Interface {
    /// The controller at its start. `stored` are keys and numbers that earlier events gave, in any
    /// order; those that are none of this controller's or no longer permitted are left out.
    #[must_use]
    pub fn new(
        now: Instant,
        product: &'static Product,
        boot: Boot,
        stored: impl IntoIterator<Item = (u32, u32)>,
    ) -> Self {
        let hello = Hello {
            protocol: PROTOCOL,
            product: product.code,
            firmware: product.firmware,
            dictionary: product.fingerprint,
            nonce: boot.nonce,
            heard: 0,
            in_service: false,
        };
        let mut rows = product.dictionary.rows();
        let end = rows.len();
        let first = rows.position(|row| row.owner() == Owner::Application).unwrap_or(0);
        let rows = position(first)..position(end);
        let (mut set, mut node_id, mut bit_rate) = (Set::default(), DELIVERED_NODE_ID, None);
        for (key, value) in stored {
            if set.restore(Record { key, value }, product.dictionary) {
            } else if key == NODE_ID.id().key() {
                let stored = u8::try_from(value).ok().and_then(NodeId::new);
                node_id = stored.unwrap_or(node_id);
            } else if key == BIT_RATE.id().key() {
                bit_rate = u8::try_from(value).ok().filter(|rate| *rate <= BIT_RATE_MAX);
            }
        }
        let slots = Slots::of(product.dictionary);
        let mut interface = Self {
            product,
            node: Node::new(product.dictionary, node_id, Nm17x),
            objects: Objects::new(slots, Link::new(now, hello, rows, node_id.get())),
            boot_up_by: Some(now + BOOT_UP_AFTER),
            restart_by: None,
            conditions: Conditions::default(),
            bit_rate: 0,
            bit_timing: None,
            stored: set,
            saving: Saving::default(),
            received_correction: None,
            offer: None,
            offers: 0,
            events: Deque::new(),
        };
        interface.set_value(Instant::ZERO, slots.serial_number, boot.serial_number);
        interface.set_value(Instant::ZERO, slots.node_id, node_id.get().into());
        if let Some(bit_rate) = bit_rate {
            interface.set_value(Instant::ZERO, slots.bit_rate, bit_rate.into());
        }
        interface.bit_rate = interface.node.values().get(&BIT_RATE);
        interface.stored.apply(&mut interface.node);
        interface.note_scaling();
        interface
    }

    /// The bit rate to use, in bit/s.
    #[must_use]
    pub fn bit_rate(&self) -> u32 {
        let rate = BIT_RATE_MAX.checked_sub(self.bit_rate).and_then(BitRate::from_index);
        u32::from(rate.unwrap_or(BitRate::Kbit125).kbit_per_s()) * 1_000
    }

    /// The numbers of [`Event::StoreSet`], with their keys.
    pub fn set_to_store(&self) -> impl Iterator<Item = Record> {
        self.saving.set().records()
    }

    /// What became of everything that was to be saved until [`Event::Confirm`].
    pub fn handle_saved(&mut self, now: Instant, number: u8, outcome: Result<(), NotSaved>) {
        self.follow_up(now);
        if let Some(parameters) = self.saving.take_parameters(number) {
            self.follow_parameters(now, parameters, outcome);
        }
        if let Some(settings) = self.saving.take_layer_settings(number) {
            self.follow_layer_settings(now, settings, outcome);
        }
        self.settle_node(now);
    }

    /// The frames to let through; all others are none of this device's.
    pub fn accepts(&self) -> impl Iterator<Item = Accepted> {
        self.node.accepts()
    }

    /// A frame from the bus. It is answered; what else it brings about comes behind its answer: then
    /// [`Self::handle_timeout`] is due at once.
    #[inline]
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        if self.is_behind() {
            self.follow_up(now);
        }
        self.node.handle_frame(now, frame, &mut self.objects);
    }

    /// Bytes from the link.
    pub fn handle_link(&mut self, now: Instant, bytes: &[u8]) {
        self.follow_up(now);
        for &byte in bytes {
            self.objects.link.handle_byte(now, byte);
            self.settle_link(now);
        }
        self.run_node(now);
    }

    /// The controller's standing on the bus changed.
    pub fn handle_bus(&mut self, now: Instant, bus: BusState) {
        self.follow_up(now);
        self.node.handle_bus(now, bus);
        self.settle_node(now);
    }

    /// Frames were lost because they came faster than they were taken.
    pub fn handle_overrun(&mut self) {
        self.node.handle_overrun();
    }

    /// Does what is due.
    pub fn handle_timeout(&mut self, now: Instant) {
        self.follow_up(now);
        self.objects.link.handle_timeout(now);
        self.settle_link(now);
        if self.boot_up_by.is_some_and(|by| by <= now) {
            self.boot_up(now);
            self.set_condition(now, Condition::Link, true);
            self.send(Emergency::LINK_LOST);
        }
        self.switch_bit_rate(now);
        self.run_node(now);
    }

    /// When [`Self::handle_timeout`] has something to do.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        if self.is_behind() {
            return Some(Instant::ZERO);
        }
        let switch_at = self.bit_timing.map(|timing| timing.due_at());
        let link_at = self.objects.link.poll_timeout();
        let due = [self.node.poll_timeout(), self.boot_up_by, self.restart_by, switch_at];
        Some(due.into_iter().flatten().fold(link_at, Instant::min))
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
        self.objects.link.poll_transmit()
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

/// The highest number of 0x2100, 1000 kbit/s; the table of layer setting services counts the other
/// way.
const BIT_RATE_MAX: u8 = 8;

impl Interface {
    /// Whether frames brought about what has not been followed.
    #[inline]
    fn is_behind(&self) -> bool {
        !matches!(self.objects.outcome, Outcome::Nothing) || self.node.has_events()
    }

    /// What frames brought about is followed behind their answers, and before anything else.
    fn follow_up(&mut self, now: Instant) {
        match core::mem::take(&mut self.objects.outcome) {
            Outcome::Nothing => {}
            Outcome::Store(record) => self.event(Event::Store(record)),
            Outcome::Write(write) => self.hand_on(now, write),
            Outcome::Text => self.objects.show_message(),
            Outcome::QueueFull => self.send(Emergency::WRITE_QUEUE_FULL),
            Outcome::Received(received) => self.follow_pdo(now, received),
        }
        self.settle_node(now);
    }

    /// Lets the node do what is due.
    fn run_node(&mut self, now: Instant) {
        self.node.handle_timeout(now, &mut self.objects);
        self.follow_up(now);
    }

    /// What a master wrote goes to the application.
    fn hand_on(&mut self, now: Instant, write: ApplicationWrite) {
        self.objects.hand_on(write);
        self.note_scaling();
        let (slots, slot) = (&self.objects.slots, Some(write.slot));
        if [slots.correction, slots.correction_enabled].contains(&slot) {
            self.received_correction.take_if(|_| slot == slots.correction);
            self.follow_correction(now);
        }
    }

    fn note_scaling(&mut self) {
        self.objects.has_scaling = self.value(self.objects.slots.scaling) != 0;
    }

    fn settle_link(&mut self, now: Instant) {
        while let Some(event) = self.objects.link.poll_event() {
            match event {
                link::Event::Process(process) => self.take_process_data(now, &process),
                link::Event::Values(from, values) => self.take_values(now, from, &values),
                link::Event::SnapshotComplete => {
                    self.objects.values_known = true;
                    self.boot_up(now);
                    self.set_condition(now, Condition::Link, false);
                }
                link::Event::Touched(offer) => self.take_offer(offer),
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
                    self.objects.link.stop(Urgency::StateLowered);
                    self.restart_by = Some(now + RESTART_WITHIN);
                }
                canopen::Event::ResetCommunication => {
                    self.objects.link.stop(Urgency::StateLowered);
                    self.rebuild_node(self.node.pending_node_id().unwrap_or(self.node.node_id()));
                    self.event(Event::FiltersChanged);
                    self.boot_up_by = Some(now);
                    self.boot_up(now);
                }
                canopen::Event::HeartbeatLost { .. } | canopen::Event::GuardingLost => {
                    self.objects.link.stop(Urgency::HeartbeatLost)
                }
                canopen::Event::HeartbeatRecovered { .. }
                | canopen::Event::GuardingRecovered
                | canopen::Event::PdoOverdue { .. } => {}
                canopen::Event::Store { .. } => {
                    let number = self.saving.ask_to_keep(Set::of(&self.node));
                    self.event(Event::StoreSet);
                    self.event(Event::Confirm(number));
                }
                canopen::Event::Restore { .. } => {
                    let number = self.saving.ask_to_forget();
                    self.event(Event::Forget);
                    self.event(Event::Confirm(number));
                }
                canopen::Event::FiltersChanged => self.event(Event::FiltersChanged),
                canopen::Event::Lss(event) => self.follow_lss(now, event),
                canopen::Event::BusStateChanged { to: BusState::Off, .. } => {
                    self.objects.link.stop(Urgency::BusOff);
                }
                canopen::Event::BusStateChanged { .. }
                | canopen::Event::Time(_)
                | canopen::Event::TransmitOverflow { .. } => {}
            }
        }
        if self.restart_by.take_if(|by| *by <= now || !self.objects.link.has_writes()).is_some() {
            self.event(Event::Restart);
        }
    }

    fn follow_parameters(
        &mut self,
        now: Instant,
        parameters: Parameters,
        outcome: Result<(), NotSaved>,
    ) {
        match (outcome, parameters) {
            (Ok(()), Parameters::Keep) => self.stored = self.saving.set().clone(),
            (Ok(()), Parameters::Forget) => {
                self.stored = Set::default();
                let Slots { node_id, bit_rate, .. } = self.objects.slots;
                let delivered = bit_rate.and_then(|slot| self.product.dictionary.row(slot));
                self.set_value(now, node_id, DELIVERED_NODE_ID.get().into());
                self.set_value(now, bit_rate, delivered.map_or(0, |row| row.initial(0)));
            }
            (Err(NotSaved), Parameters::Keep | Parameters::Forget) => {}
        }
        self.node.handle_stored(outcome.map_err(|NotSaved| WriteError::NotStored));
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
        self.objects.link.set_node_state(match to {
            State::Initialising => NodeState::Initialising,
            State::Stopped => NodeState::Stopped,
            State::PreOperational => NodeState::PreOperational,
            State::Operational => NodeState::Operational,
        });
        if rank(to) < rank(from) {
            self.objects.link.stop(Urgency::StateLowered);
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
        let fresh = Node::new(self.product.dictionary, node_id, Nm17x);
        let before = core::mem::replace(&mut self.node, fresh);
        self.stored.apply(&mut self.node);
        self.end_offer();
        self.objects.link.set_node_id(node_id.get());
        for (slot, row) in self.product.dictionary.slots() {
            let kept = row.id().index >= 0x2000 || row.id().index == ERROR_FIELD;
            if kept || row.id() == SERIAL_NUMBER.id() || row.id() == STATUS_REGISTER.id() {
                self.node.set_value(Instant::ZERO, slot, before.values().raw(slot));
            }
        }
        self.node.set_error_register(Instant::ZERO, self.conditions.error_register());
        self.node.handle_bus(Instant::ZERO, before.bus_state());
    }

    fn take_process_data(&mut self, now: Instant, process: &ProcessData) {
        let Slots { position, status, errors, status_register, .. } = self.objects.slots;
        self.set_value(now, position, process.position_hundredths_mm.cast_unsigned());
        self.set_value(now, status, process.status.into());
        self.set_value(now, errors, process.errors.into());
        self.set_value(now, status_register, process.status.into());
        self.set_condition(now, Condition::Application, process.errors != 0);
    }

    fn take_values(&mut self, now: Instant, from: u16, values: &[u32]) {
        let correction = self.value(self.objects.slots.correction);
        for (position, &value) in (from..).zip(values) {
            let Some(slot) = Slot::at(self.product.dictionary, position) else { break };
            match self.product.dictionary.row(slot) {
                Some(row)
                    if row.owner() != Owner::Application || self.objects.slots.is_live(slot) => {}
                Some(row) if self.objects.link.is_writing(row.id()) => {}
                Some(row) if is_plausible(row, value) => self.node.set_value(now, slot, value),
                Some(_) => self.send(link::Fault::CorruptValue.into()),
                None => break,
            }
        }
        if self.value(self.objects.slots.correction) != correction {
            self.received_correction = None;
        }
        self.note_scaling();
        self.follow_correction(now);
    }

    /// 0x2501:04: the correction that RxPDO2 brought, else the one of 0x2010 as far as 16 bits
    /// hold it; 0 while it is not in force.
    fn follow_correction(&mut self, now: Instant) {
        let correction = self.value(self.objects.slots.correction).cast_signed();
        let saturated = correction.clamp(i16::MIN.into(), i16::MAX.into());
        let sent =
            match (self.value(self.objects.slots.correction_enabled), self.received_correction) {
                (0, _) => 0,
                (_, Some(received)) => received.into(),
                (_, None) => saturated.cast_unsigned() & u32::from(u16::MAX),
            };
        self.set_value(now, self.objects.slots.correction_sent, sent);
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

/// Whether the application controller may say this of an object: of a parameter what masters may
/// write, and of its state anything.
fn is_plausible(row: Row, value: u32) -> bool {
    row.access() != Access::ReadWrite || COMMANDS.contains(&row.id()) || row.permits(value)
}

fn position(count: usize) -> u16 {
    u16::try_from(count).unwrap_or(u16::MAX)
}
