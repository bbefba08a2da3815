use heapless::{Deque, Vec};
use object_dictionary::{Dictionary, ObjectId, Slot, Values};
use units::Instant;

use crate::application::Application;
use crate::cob_id::{self, NodeId, Service};
use crate::emcy;
use crate::frame::{CanId, Frame};
use crate::heartbeat;
use crate::nmt::{Command, State};
use crate::outbox::Outbox;
use crate::pdo::{TPDO_MAX, Tpdo};
use crate::sdo::{self, Objects};
use crate::settings::Settings;
use crate::sync;

/// Events that may wait for [`Node::poll_event`].
const EVENTS_MAX: usize = 4;
/// The most that one call brings about: boot-up and self-start.
const EVENTS_PER_CALL: usize = 2;
const _: () = assert!(EVENTS_MAX >= EVENTS_PER_CALL);

const SYNC_COB_ID: ObjectId = ObjectId { index: 0x1005, sub: 0 };
const ERROR_REGISTER: ObjectId = ObjectId { index: 0x1001, sub: 0 };
const HEARTBEAT_TIME: ObjectId = ObjectId { index: 0x1017, sub: 0 };
const NMT_STARTUP: ObjectId = ObjectId { index: 0x1F80, sub: 0 };

/// The bit of 0x1F80 that lets a node become Operational without a master.
const SELF_STARTING: u32 = 1 << 3;

/// A CANopen device that owns no bus, no clock and no task.
///
/// Contract: after every call that takes `now`, drain [`Self::poll_event`], hand frames from
/// [`Self::peek_transmit`] to the controller as long as it takes any, and call
/// [`Self::handle_timeout`] no later than [`Self::poll_timeout`] says.
///
/// `LEN` is the length of the product's dictionary.
#[derive(Debug)]
pub struct Node<const LEN: usize> {
    node_id: NodeId,
    settings: &'static Settings,
    state: State,
    values: Values<LEN>,
    heartbeat: heartbeat::Producer,
    sync: Option<sync::Consumer>,
    emergencies: emcy::Producer,
    sdo: sdo::Server,
    tpdos: Vec<Tpdo, TPDO_MAX>,
    outbox: Outbox,
    overflow: Overflow,
    filters_changed: bool,
    events: Deque<Event, EVENTS_MAX>,
}

/// What the core above a node has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The network management state changed.
    StateChanged {
        /// Before.
        from: State,
        /// Now.
        to: State,
    },
    /// A master asks for a restart of the device. The node is silent and deaf from here on.
    ResetNode,
    /// A master asks for a restart of the communication: build a new node from the stored values
    /// and boot it. This one is silent and deaf from here on.
    ResetCommunication,
    /// [`Node::accepts`] changed.
    FiltersChanged,
    /// Frames were dropped because too many waited for a mailbox. Comes once, until none waits any
    /// more.
    TransmitOverflow {
        /// All since the node was built.
        lost: u32,
    },
}

/// An overflow is reported once, until all frames are gone: the report may itself send a frame.
#[derive(Clone, Copy, Debug)]
enum Overflow {
    Reportable { lost_before: u32 },
    Reported,
}

/// A kind of frame that a node listens to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accepted {
    /// Its identifier.
    pub id: CanId,
    /// Whether it is the remote frame that counts.
    pub remote: bool,
}

impl<const LEN: usize> Node<LEN> {
    /// A node with all values at their defaults. It sends nothing and listens to nothing until
    /// [`Self::boot`]; stored values are set before.
    #[must_use]
    pub fn new(
        dictionary: &'static Dictionary,
        node_id: NodeId,
        settings: &'static Settings,
    ) -> Self {
        let values = Values::new(dictionary, node_id.get());
        let value = |object| dictionary.find(object).ok().map(|slot| values.raw(slot));
        let mut heartbeat = heartbeat::Producer::default();
        heartbeat.set_period_ms(value(HEARTBEAT_TIME).unwrap_or(0));
        let mut tpdos = Vec::new();
        for tpdo in (0..).take(TPDO_MAX).filter_map(|number| Tpdo::new(number, &values, settings)) {
            let _ = tpdos.push(tpdo);
        }
        Self {
            node_id,
            settings,
            state: State::Initialising,
            heartbeat,
            sync: value(SYNC_COB_ID).map(sync::Consumer::new),
            emergencies: emcy::Producer::new(node_id, &values),
            sdo: sdo::Server::default(),
            tpdos,
            outbox: Outbox::default(),
            overflow: Overflow::Reportable { lost_before: 0 },
            filters_changed: false,
            events: Deque::new(),
            values,
        }
    }

    /// Initialisation is done: sends the boot-up message and enters Pre-operational, from there
    /// Operational if 0x1F80 says so. Nothing happens on a node that is up.
    pub fn boot(&mut self, now: Instant) {
        if self.state != State::Initialising {
            return;
        }
        self.outbox.push_boot_up(self.boot_up());
        self.heartbeat.start(now);
        self.enter(now, State::PreOperational);
        if self.value(NMT_STARTUP) & SELF_STARTING != 0 {
            self.enter(now, State::Operational);
        }
        self.transmit_due(now);
    }

    /// Takes a received frame in.
    pub fn handle_frame(
        &mut self,
        now: Instant,
        frame: &Frame,
        application: &mut impl Application,
    ) {
        if self.state == State::Initialising || frame.is_remote() {
            return;
        }
        if frame.id() == cob_id::NMT {
            self.handle_nmt(now, frame);
        } else if frame.id() == Service::SdoRequest.id(self.node_id) {
            self.handle_sdo(now, frame, application);
        } else if self.sync.is_some_and(|sync| sync.recognises(frame)) {
            self.handle_sync(now);
        }
    }

    /// Does what is due. Harmless when nothing is.
    pub fn handle_timeout(&mut self, now: Instant) {
        if let Some(response) = self.sdo.handle_timeout(now) {
            self.outbox.push(Frame::full(Service::SdoResponse.id(self.node_id), response.encode()));
        }
        if self.heartbeat.take_due(now) {
            self.send_heartbeat();
        }
        self.send_waiting_emergencies(now);
        self.transmit_due(now);
    }

    /// When [`Self::handle_timeout`] has something to do. `None` as long as nothing happens.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Instant> {
        let tpdos = self.tpdos.iter().filter_map(Tpdo::due_at);
        let emergencies = self.emergencies.due_at().filter(|_| self.state.serves_sdo());
        let due = [self.sdo.poll_timeout(), self.heartbeat.due_at(), emergencies];
        due.into_iter().flatten().chain(tpdos).min()
    }

    /// The next frame for a mailbox: the lowest CAN-ID, the oldest of equal ones.
    #[must_use]
    pub fn peek_transmit(&self) -> Option<&Frame> {
        self.outbox.peek()
    }

    /// Takes the frame out that [`Self::peek_transmit`] shows.
    pub fn take_transmit(&mut self) -> Option<Frame> {
        let frame = self.outbox.take();
        if self.outbox.peek().is_none() && matches!(self.overflow, Overflow::Reported) {
            self.overflow = Overflow::Reportable { lost_before: self.outbox.lost() };
        }
        frame
    }

    /// Takes a frame back that a more urgent one pushed out of its mailbox. It goes before those
    /// with the same identifier.
    pub fn give_back(&mut self, frame: Frame) {
        if frame == self.boot_up() {
            self.outbox.push_boot_up(frame);
        } else {
            self.outbox.give_back(frame);
        }
    }

    /// Sets the error register, 0x1001, to what the device says. When no error is left, an error
    /// reset message goes out.
    pub fn set_error_register(&mut self, now: Instant, errors: u8) {
        let Ok(slot) = self.values.dictionary().find(ERROR_REGISTER) else { return };
        let before = self.values.raw(slot);
        self.set_value(now, slot, u32::from(errors));
        if before != 0 && errors == 0 {
            self.send_emergency(0x0000, [0; 5]);
        }
    }

    /// Records an error in the pre-defined error field and sends an emergency message with the
    /// present error register. Nothing in a state that has no emergency messages: Initialising and
    /// Stopped (CiA 301, table 39). Messages inside the inhibit time wait.
    pub fn send_emergency(&mut self, error_code: u16, manufacturer: [u8; 5]) {
        if !self.state.serves_sdo() {
            return;
        }
        let frame =
            self.emergencies.raise(error_code, manufacturer, &mut self.values, self.settings);
        if let Some(frame) = frame {
            self.outbox.push(frame);
        }
    }

    /// What happened, the oldest first.
    pub fn poll_event(&mut self) -> Option<Event> {
        if let Some(event) = self.events.pop_front() {
            return Some(event);
        }
        if core::mem::take(&mut self.filters_changed) {
            return Some(Event::FiltersChanged);
        }
        let lost = self.outbox.lost();
        match self.overflow {
            Overflow::Reportable { lost_before } if lost_before != lost => {
                self.overflow = Overflow::Reported;
                Some(Event::TransmitOverflow { lost })
            }
            Overflow::Reportable { .. } | Overflow::Reported => None,
        }
    }

    /// The frames this node listens to, whatever its state; all others may be filtered out.
    pub fn accepts(&self) -> impl Iterator<Item = Accepted> + use<LEN> {
        let data = |id| Accepted { id, remote: false };
        [
            Some(cob_id::NMT),
            self.sync.map(sync::Consumer::id),
            Some(Service::SdoRequest.id(self.node_id)),
        ]
        .into_iter()
        .flatten()
        .map(data)
    }

    /// The network management state.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// The node-ID it was built with.
    #[must_use]
    pub const fn node_id(&self) -> NodeId {
        self.node_id
    }

    /// The values of all objects.
    #[must_use]
    pub const fn values(&self) -> &Values<LEN> {
        &self.values
    }

    /// Sets a value from the device's side, without the checks that clients meet. PDOs that follow
    /// its changes become due at `now`; they go out with the next [`Self::handle_timeout`], so that
    /// values set together are sent together.
    pub fn set_value(&mut self, now: Instant, slot: Slot, raw: u32) {
        if self.values.raw(slot) != raw {
            self.values.set_raw(slot, raw);
            self.note_change(now, slot);
        }
    }
}

impl<const LEN: usize> Node<LEN> {
    fn handle_nmt(&mut self, now: Instant, frame: &Frame) {
        match Command::parse(frame.data(), self.node_id) {
            Some(Command::Enter(state)) => {
                self.enter(now, state);
                self.send_waiting_emergencies(now);
                self.transmit_due(now);
            }
            Some(Command::ResetNode) => self.leave(Event::ResetNode),
            Some(Command::ResetCommunication) => self.leave(Event::ResetCommunication),
            None => {}
        }
    }

    fn handle_sdo(&mut self, now: Instant, frame: &Frame, application: &mut impl Application) {
        if !self.state.serves_sdo() {
            return;
        }
        let Some(request) = sdo::Request::parse(frame.data()) else { return };
        let mut objects = Objects::new(&mut self.values, application, self.settings);
        let response = self.sdo.handle(now, request, &mut objects);
        let changed = objects.changed();
        if let Some(response) = response {
            self.outbox.push(Frame::full(Service::SdoResponse.id(self.node_id), response.encode()));
        }
        if let Some(slot) = changed {
            self.note_change(now, slot);
            self.handle_timeout(now);
        }
    }

    fn handle_sync(&mut self, now: Instant) {
        for tpdo in &mut self.tpdos {
            if tpdo.handle_sync()
                && let Some(frame) = tpdo.transmit(now, &self.values)
            {
                self.outbox.supersede(frame);
            }
        }
    }

    fn enter(&mut self, now: Instant, to: State) {
        let from = core::mem::replace(&mut self.state, to);
        if from == to {
            return;
        }
        match to {
            State::Operational => self.tpdos.iter_mut().for_each(|tpdo| tpdo.start(now)),
            State::PreOperational => self.stop_pdos(),
            State::Stopped | State::Initialising => {
                self.stop_pdos();
                self.sdo.stop();
                let error_control = Service::ErrorControl.id(self.node_id);
                self.outbox.retain(|frame| frame.id() == error_control);
            }
        }
        self.report(Event::StateChanged { from, to });
    }

    fn stop_pdos(&mut self) {
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        let tpdos = &self.tpdos;
        self.outbox.retain(|frame| !tpdos.iter().any(|tpdo| tpdo.sends(frame.id())));
    }

    /// Ends all activity for good.
    fn leave(&mut self, reason: Event) {
        self.state = State::Initialising;
        self.heartbeat.stop();
        self.sdo.stop();
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        self.outbox.clear();
        self.report(reason);
    }

    /// Heartbeats do not pile up before a bus that takes nothing: the newest stands for all, and
    /// none follows a boot-up message that still waits.
    fn send_heartbeat(&mut self) {
        if !self.outbox.holds_boot_up() {
            let id = Service::ErrorControl.id(self.node_id);
            self.outbox.supersede(Frame::single(id, self.state.heartbeat_byte()));
        }
    }

    const fn boot_up(&self) -> Frame {
        let id = Service::ErrorControl.id(self.node_id);
        Frame::single(id, State::Initialising.heartbeat_byte())
    }

    /// Messages that were held back go out in the states that have emergency messages.
    fn send_waiting_emergencies(&mut self, now: Instant) {
        while self.state.serves_sdo()
            && let Some(frame) = self.emergencies.take_due(now)
        {
            self.outbox.push(frame);
        }
    }

    fn transmit_due(&mut self, now: Instant) {
        for tpdo in &mut self.tpdos {
            if tpdo.due_at().is_some_and(|due_at| due_at <= now)
                && let Some(frame) = tpdo.transmit(now, &self.values)
            {
                self.outbox.supersede(frame);
            }
        }
    }

    /// Acts on a changed value: on the stack's own objects at once, on mapped ones by marking their
    /// PDOs.
    fn note_change(&mut self, now: Instant, slot: Slot) {
        for tpdo in &mut self.tpdos {
            tpdo.note_change(now, slot);
        }
        let Some(row) = self.values.dictionary().row(slot) else { return };
        let raw = self.values.raw(slot);
        match row.id.index {
            0x1005 => self.listen_to_sync(sync::Consumer::new(raw)),
            0x1017 => {
                self.heartbeat.set_period_ms(raw);
                match self.state {
                    State::Initialising => {}
                    State::PreOperational | State::Operational | State::Stopped => {
                        self.heartbeat.restart(now);
                    }
                }
            }
            0x1014 | 0x1015 => self.emergencies.reread(now, &self.values),
            index @ 0x1800..=0x19FF => self.reread_tpdo(now, index),
            _ => {}
        }
    }

    fn listen_to_sync(&mut self, sync: sync::Consumer) {
        self.filters_changed |= self.sync != Some(sync);
        self.sync = Some(sync);
    }

    fn reread_tpdo(&mut self, now: Instant, index: u16) {
        let running = self.state == State::Operational;
        for tpdo in self.tpdos.iter_mut().filter(|tpdo| tpdo.is_described_by(index)) {
            tpdo.reread(now, running, &self.values, self.settings);
        }
    }

    fn report(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }

    fn value(&self, object: ObjectId) -> u32 {
        self.values.dictionary().find(object).map_or(0, |slot| self.values.raw(slot))
    }
}
