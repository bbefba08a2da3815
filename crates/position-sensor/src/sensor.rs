use canopen::lss::{self, StoreError};
use canopen::{
    Accepted, Application, BusState, CanId, Frame, Node, NodeId, State, WriteError, Written,
};
use heapless::Deque;
use object_dictionary::{ObjectId, Row, Slot, Storage};
use profiles::OBJECTS_MAX;
use profiles::encoder::{BIT_RATE, NODE_ID, SERIAL_NUMBER};
use units::Instant;

use crate::bit_timing::{BitTiming, Step};
use crate::encoder;
use crate::family::{Present, View};
use crate::model::Model;

/// Events that may wait for [`Sensor::poll_event`]: one input makes at most one for the memory, new
/// filters and a restart.
const EVENTS_MAX: usize = 3;

/// A number to be kept without supply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Index and sub-index as [`ObjectId::key`] gives them.
    pub key: u32,
    /// The value.
    pub value: u32,
}

/// Objects that are saved or restored together (CiA 301, sections 7.5.2.13 and 7.5.2.14).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Group {
    first: u16,
    last: u16,
    spared: Option<ObjectId>,
}

impl Group {
    /// Whether the object with this key (see [`ObjectId::key`]) belongs to it.
    #[must_use]
    pub fn contains(&self, key: u32) -> bool {
        (u32::from(self.first)..=u32::from(self.last)).contains(&(key >> 8))
            && self.spared.is_none_or(|spared| spared.key() != key)
    }

    /// Bit rate and node-ID of the encoders.
    const LAYER_SETTINGS: Self = Self { first: 0x2100, last: 0x2101, spared: None };

    /// What a restart of the communication takes back.
    const COMMUNICATION: Self = Self { first: 0, last: 0x1FFF, spared: None };

    /// The objects behind sub-index `sub` of 0x1010 and 0x1011.
    const fn behind(sub: u8) -> Self {
        let (first, last) = match sub {
            1 => (0, u16::MAX),
            2 => (0x1000, 0x1FFF),
            3 => (0x6000, 0x9FFF),
            _ => (0x2000, 0x5FFF),
        };
        Self { first, last, spared: None }
    }
}

/// What the shell has to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Keep this without supply.
    Keep(Record),
    /// Keep what [`Sensor::parameters`] shows of the group in the place of everything that is kept
    /// of it, all or nothing, and report with [`Sensor::handle_stored`].
    Save(Group),
    /// Forget everything that is kept of the group, and report with [`Sensor::handle_stored`].
    Forget(Group),
    /// Set the acceptance filters to what [`Sensor::accepts`] says.
    FiltersChanged,
    /// Build a new sensor from what is kept.
    Restart,
    /// Call [`Sensor::restart_communication`] with what is kept.
    RestartCommunication,
}

/// Whom to tell what became of it.
#[derive(Clone, Copy, Debug)]
enum Storing {
    /// The client of the SDO server saves.
    Parameters,
    /// The client of the SDO server restores these.
    Defaults(Group),
    /// The master of the layer setting services stores.
    LayerSettings,
}

/// The sensor, without pins, clock and tasks.
///
/// Contract: after every call that takes `now` drain [`Self::peek_transmit`] and
/// [`Self::poll_event`], then call [`Self::handle_timeout`] no later than [`Self::poll_timeout`].
/// Read the shaft as [`Self::reads_cyclically`] and [`Self::reads_for`] say.
#[derive(Debug)]
pub struct Sensor {
    model: &'static Model,
    serial_number: u32,
    node: Node<OBJECTS_MAX>,
    bit_rate: u32,
    /// Where the shaft stands, once it has been read.
    steps: Option<i64>,
    /// What the memory is at.
    storing: Option<Storing>,
    /// A change of the bit rate on the way.
    bit_timing: Option<BitTiming>,
    events: Deque<Event, EVENTS_MAX>,
}

impl Sensor {
    /// A sensor that boots with the numbers that were `kept`. Those that are not permitted (any
    /// more) are at delivery state.
    #[must_use]
    pub fn new(
        now: Instant,
        model: &'static Model,
        serial_number: u32,
        kept: impl Iterator<Item = Record> + Clone,
    ) -> Self {
        let node = node(model, serial_number, None, kept);
        let mut sensor = Self {
            model,
            serial_number,
            bit_rate: model.family.bit_rate(node.values()),
            node,
            steps: None,
            storing: None,
            bit_timing: None,
            events: Deque::new(),
        };
        sensor.derive(now);
        sensor.node.boot(now);
        sensor
    }

    /// Follows [`Event::RestartCommunication`]: the communication parameters are as `kept`, and so
    /// are node-ID and bit rate unless layer setting services have set others; everything else is as
    /// it is.
    pub fn restart_communication(
        &mut self,
        now: Instant,
        kept: impl Iterator<Item = Record> + Clone,
    ) {
        let pending = self.node.pending_node_id().filter(|id| *id != self.node.node_id());
        let fresh = node(self.model, self.serial_number, pending, kept);
        self.bit_rate = match self.bit_timing {
            Some(timing) => timing.bit_rate,
            None => self.model.family.bit_rate(fresh.values()),
        };
        let before = core::mem::replace(&mut self.node, fresh);
        for (slot, row) in self.model.dictionary.slots() {
            if !Group::COMMUNICATION.contains(row.id().key()) {
                self.node.set_value(now, slot, before.values().raw(slot));
            }
        }
        self.derive(now);
        if self.bit_timing.is_none() {
            self.node.boot(now);
        }
        self.event(Event::FiltersChanged);
        self.settle(now);
    }

    /// The bit rate to use, in bit/s.
    #[must_use]
    pub const fn bit_rate(&self) -> u32 {
        self.bit_rate
    }

    /// Whether the CAN controller is to come back from bus-off by itself (ISO 11898-1: after 128
    /// times 11 recessive bits). Else it stays away until the next start (encoder EN-ERR-03).
    #[must_use]
    pub fn recovers_from_bus_off(&self) -> bool {
        self.model.family.recovers_from_bus_off(self.node.values())
    }

    /// Whether the shaft is to be read before this frame is handled, and told with
    /// [`Self::handle_steps`] (encoder EN-PDO-11).
    #[must_use]
    pub fn reads_for(&self, frame: &Frame) -> bool {
        self.model.family.reads_for(self.node.values(), frame)
    }

    /// Whether the shaft is to be read again and again: always so until it has been read.
    #[must_use]
    pub fn reads_cyclically(&self) -> bool {
        self.steps.is_none() || self.model.family.reads_cyclically(self.node.values())
    }

    /// The frames to let through; all others are none of this device's.
    pub fn accepts(&self) -> impl Iterator<Item = Accepted> {
        self.node.accepts()
    }

    /// The numbers of a group that differ from the state at delivery.
    pub fn parameters(&self, group: Group) -> impl Iterator<Item = Record> {
        let node_id = self.node.node_id().get();
        let stored = self.model.dictionary.slots().filter(move |(_, row)| {
            row.storage() != Storage::Volatile && group.contains(row.id().key())
        });
        stored.filter_map(move |(slot, row)| {
            let value = self.node.values().raw(slot);
            (value != row.initial(node_id)).then_some(Record { key: row.id().key(), value })
        })
    }

    /// A frame from the bus. Layer setting services are for devices in Stopped (encoder B-34).
    pub fn handle_frame(&mut self, now: Instant, frame: &Frame) {
        if LSS_REQUEST == Some(frame.id()) && self.node.state() != State::Stopped {
            return;
        }
        let present = self.model.family.present(self.node.values());
        let mut objects = Objects { present, written: None };
        self.node.handle_frame(now, frame, &mut objects);
        if let Some(written) = objects.written {
            let mut view = View { now, node: &mut self.node };
            let steps = self.steps.unwrap_or(0);
            let keeps = self.model.family.follow(&mut view, written, &present, steps);
            self.derive(now);
            self.keep(keeps);
        }
        self.settle(now);
    }

    /// The CAN controller's standing on the bus changed.
    pub fn handle_bus(&mut self, now: Instant, bus: BusState) {
        self.node.handle_bus(now, bus);
        self.settle(now);
    }

    /// The shaft stands `steps` from where it stood when the device was made, right positive, in
    /// steps of [`Model::steps_per_turn`].
    pub fn handle_steps(&mut self, now: Instant, steps: i64) {
        if self.steps != Some(steps) {
            self.steps = Some(steps);
            self.derive(now);
            self.node.handle_timeout(now, &mut ());
            self.settle(now);
        }
    }

    /// What became of [`Event::Save`] or [`Event::Forget`].
    pub fn handle_stored(&mut self, now: Instant, outcome: Result<(), WriteError>) {
        match self.storing.take() {
            Some(Storing::Parameters) => self.node.handle_stored(outcome),
            Some(Storing::Defaults(group)) => {
                if outcome.is_ok() {
                    self.restore(now, group);
                }
                self.node.handle_stored(outcome);
            }
            Some(Storing::LayerSettings) => {
                self.node.handle_lss_stored(outcome.map_err(|_| StoreError::AccessFailed));
            }
            None => {}
        }
        self.settle(now);
    }

    /// Does what is due.
    pub fn handle_timeout(&mut self, now: Instant) {
        if let Some((step, left)) = self.bit_timing.and_then(|timing| timing.step(now)) {
            self.bit_timing = left;
            match step {
                Step::Switch => self.event(Event::RestartCommunication),
                Step::Boot => self.node.boot(now),
            }
        }
        self.node.handle_timeout(now, &mut ());
        self.settle(now);
    }

    /// When [`Self::handle_timeout`] has something to do.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let bit_timing = self.bit_timing.map(|timing| timing.due_at());
        [self.node.poll_timeout(), bit_timing].into_iter().flatten().min()
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

    /// What there is to do, the oldest first.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn derive(&mut self, now: Instant) {
        let steps = self.steps.unwrap_or(0);
        self.model.family.derive(&mut View { now, node: &mut self.node }, steps);
    }

    fn restore(&mut self, now: Instant, group: Group) {
        let node_id = self.node.node_id().get();
        for (slot, row) in self.model.dictionary.slots() {
            if row.storage() != Storage::Volatile && group.contains(row.id().key()) {
                self.node.set_value(now, slot, row.initial(node_id));
            }
        }
        self.derive(now);
    }

    fn keep(&mut self, object: ObjectId) {
        let dictionary = self.model.dictionary;
        let Ok(slot) = dictionary.find(object) else { return };
        if dictionary.row(slot).is_some_and(|row| row.storage() == Storage::AtOnce) {
            let value = self.node.values().raw(slot);
            self.event(Event::Keep(Record { key: object.key(), value }));
        }
    }

    fn settle(&mut self, now: Instant) {
        while let Some(event) = self.node.poll_event() {
            match event {
                canopen::Event::StateChanged { from: State::Stopped, .. } => self.leave_lss(now),
                canopen::Event::ResetNode => {
                    let restarts = self.model.family.restarts_on_reset_node(self.node.values());
                    self.event(if restarts { Event::Restart } else { Event::RestartCommunication });
                }
                canopen::Event::ResetCommunication => self.event(Event::RestartCommunication),
                canopen::Event::Store { sub } => {
                    self.storing = Some(Storing::Parameters);
                    self.event(Event::Save(Group::behind(sub)));
                }
                canopen::Event::Restore { sub } => {
                    let spared = self.model.family.spared_by_restore();
                    let group = Group { spared, ..Group::behind(sub) };
                    self.storing = Some(Storing::Defaults(group));
                    self.event(Event::Forget(group));
                }
                canopen::Event::Lss(event) => self.follow_lss(now, event),
                canopen::Event::FiltersChanged => self.event(Event::FiltersChanged),
                // Nothing here depends on the other states, on others or on what the bus loses.
                canopen::Event::StateChanged { .. }
                | canopen::Event::HeartbeatLost { .. }
                | canopen::Event::HeartbeatRecovered { .. }
                | canopen::Event::GuardingLost
                | canopen::Event::GuardingRecovered
                | canopen::Event::BusStateChanged { .. }
                | canopen::Event::Time(_)
                | canopen::Event::PdoOverdue { .. }
                | canopen::Event::TransmitOverflow { .. } => {}
            }
        }
    }

    fn follow_lss(&mut self, now: Instant, event: lss::Event) {
        match event {
            lss::Event::Store { node_id, bit_rate } => {
                let mut view = View { now, node: &mut self.node };
                if let Some(node_id) = node_id {
                    view.set(&NODE_ID, node_id.get());
                }
                if let Some(bit_rate) = bit_rate {
                    view.set(&BIT_RATE, encoder::number_of(bit_rate));
                }
                self.storing = Some(Storing::LayerSettings);
                self.event(Event::Save(Group::LAYER_SETTINGS));
            }
            lss::Event::ActivateBitTiming { bit_rate, delay } => {
                let bit_s = u32::from(bit_rate.kbit_per_s()) * 1_000;
                self.bit_timing = Some(BitTiming::new(now, bit_s, delay));
            }
            // The encoders always have a node-ID, and offer none.
            lss::Event::Configured { .. }
            | lss::Event::StoreNodeId { .. }
            | lss::Event::Offered { .. }
            | lss::Event::AddressingEnded => {}
        }
    }

    /// Whoever leaves Stopped leaves the configuration as well (encoder B-34).
    fn leave_lss(&mut self, now: Instant) {
        const SWITCH_TO_WAITING: [u8; 8] = [0x04, 0, 0, 0, 0, 0, 0, 0];
        if let Some(request) = LSS_REQUEST.and_then(|id| Frame::new(id, &SWITCH_TO_WAITING)) {
            self.node.handle_frame(now, &request, &mut ());
        }
    }

    fn event(&mut self, event: Event) {
        let _ = self.events.push_back(event);
    }
}

/// A node with what was kept, or with another node-ID. It is not booted.
fn node(
    model: &'static Model,
    serial_number: u32,
    node_id: Option<NodeId>,
    kept: impl Iterator<Item = Record> + Clone,
) -> Node<OBJECTS_MAX> {
    let dictionary = model.dictionary;
    let key = model.family.node_id().id().key();
    let kept_id = kept.clone().filter(|record| record.key == key).last();
    let kept_id = kept_id.and_then(|record| NodeId::new(u8::try_from(record.value).ok()?));
    let node_id = node_id.or(kept_id).unwrap_or(DELIVERED_NODE_ID);
    let mut node = Node::new(dictionary, node_id, model.settings);
    for (slot, row) in dictionary.slots().filter(|(_, row)| row.storage() != Storage::Volatile) {
        let kept = kept.clone().filter(|record| record.key == row.id().key()).last();
        if let Some(record) = kept.filter(|record| row.permits(record.value)) {
            node.set_value(Instant::ZERO, slot, record.value);
        }
    }
    if let Ok(slot) = dictionary.find(SERIAL_NUMBER.id()) {
        node.set_value(Instant::ZERO, slot, serial_number);
    }
    node
}

/// Where masters of the layer setting services speak (CiA 305).
const LSS_REQUEST: Option<CanId> = CanId::new(0x7E5);

/// The node-ID of a device that nobody has given another (AP04 A-03, encoder EN-GEN-02).
const DELIVERED_NODE_ID: NodeId = match NodeId::new(1) {
    Some(node_id) => node_id,
    None => panic!("1 is a node-ID"),
};

/// The product behind the objects, for as long as one frame is handled.
struct Objects {
    present: Present,
    /// The object that was written, with whatever follows from it.
    written: Option<ObjectId>,
}

impl Application for Objects {
    fn write(&mut self, _slot: Slot, row: &Row, raw: u32) -> Result<Written, WriteError> {
        let written = self.present.check(row.id(), raw)?;
        self.written = (written == Written::Taken).then_some(row.id());
        Ok(written)
    }
}
