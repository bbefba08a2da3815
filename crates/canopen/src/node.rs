mod configuration;
mod errors;
mod reception;

use core::ops::Deref;

use heapless::Deque;
use object_dictionary::{Dictionary, Slot, Values};
use units::Instant;

use crate::acceptance::{Accepted, Screen};
use crate::application::{Application, WriteError};
use crate::bus::BusState;
use crate::cob_id::{self, NodeId, Service};
use crate::deadline::Deadline;
use crate::emcy;
use crate::frame::{CanId, Frame};
use crate::guarding::Guarded;
use crate::heartbeat::{self, CONSUMERS_MAX};
use crate::lss;
use crate::nmt::State;
use crate::outbox::Outbox;
use crate::parameter::number;
use crate::pdo::{PDO_MAX, Rpdos, Tpdos};
use crate::sdo;
use crate::settings::{BusOff, Emergency, ProductSettings, Settings};
use crate::sync::Sync;
use crate::time::TimeOfDay;
use errors::ErrorClass;

/// Events that may wait for [`Node::poll_event`].
const EVENTS_MAX: usize = 16;
/// The most that one call brings about: all producers and the master lost, what follows from that,
/// and all receive PDOs overdue.
const EVENTS_PER_CALL: usize = CONSUMERS_MAX + 1 + 1 + PDO_MAX;
const _: () = assert!(EVENTS_MAX >= EVENTS_PER_CALL);

/// When a node that waits for nothing wakes.
const NEVER: Instant = Instant::from_micros(u64::MAX);

const IDENTITY: u16 = 0x1018;
const NMT_STARTUP: u16 = 0x1F80;

/// The bit of 0x1F80 that lets a node become Operational without a master.
const SELF_STARTING: u32 = 1 << 3;

/// A CANopen device that owns no bus, no clock and no task.
///
/// Contract: after every call that takes `now`, drain [`Self::poll_event`], hand frames from
/// [`Self::peek_transmit`] to the controller as long as it takes any, and call
/// [`Self::handle_timeout`] no later than [`Self::poll_timeout`] says. A late call acts late; one that
/// is more than half an hour late may take what is overdue for what lies ahead.
///
/// `LEN` is the length of the product's dictionary, `S` says where its settings are.
#[derive(Debug)]
#[repr(C)]
pub struct Node<const LEN: usize, S = &'static Settings> {
    // In this order the processor reaches what every call needs with its shortest instructions.
    state: State,
    node_id: NodeId,
    /// Whether there are events, or other filters.
    has_news: bool,
    filters_changed: bool,
    /// The error register as far as the device sets it.
    device_errors: u8,
    bus: BusState,
    /// The identifier of TIME, if it is consumed; else none.
    time: CanId,
    /// What a master wrote last to an object of the communication, until it is followed: its answer
    /// goes first.
    configured: Option<Slot>,
    /// The time of the call that is served.
    now: Instant,
    /// Nothing is due before; [`NEVER`] while the node waits for nothing.
    wake_at: Instant,
    screen: Screen,
    settings: S,
    sync: Sync,
    heartbeat: heartbeat::Producer,
    guarded: Guarded,
    lss: Option<lss::Slave<LayerSettings<S>>>,
    sdo: sdo::Server,
    outbox: Outbox,
    rpdos: Rpdos,
    tpdos: Tpdos,
    emergencies: emcy::Producer,
    monitored: heartbeat::Consumers,
    events: Deque<Event, EVENTS_MAX>,
    values: Values<LEN>,
}

/// The settings of layer setting services, of a product that has them.
#[derive(Clone, Copy, Debug)]
struct LayerSettings<S>(S);

impl<S: ProductSettings> Deref for LayerSettings<S> {
    type Target = lss::Settings;

    #[inline]
    fn deref(&self) -> &lss::Settings {
        self.0.settings().lss.unwrap_or(&lss::Settings::CIA_305)
    }
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
    /// A master asks for parameters to be stored (0x1010). It waits for the answer that
    /// [`Node::handle_stored`] gives; no other command of this kind comes before that.
    Store {
        /// Sub-index: 1 all, 2 those of the communication, 3 those of the application, from 4 on
        /// the maker's own (CiA 301, section 7.5.2.13).
        sub: u8,
    },
    /// A master asks for parameters as they were at delivery (0x1011), in force after the next reset.
    /// It waits for the answer that [`Node::handle_stored`] gives; no other command of this kind comes
    /// before that.
    Restore {
        /// Sub-index, as in [`Self::Store`] (CiA 301, section 7.5.2.14).
        sub: u8,
    },
    /// A monitored node is missing. What 0x1029 says has happened.
    HeartbeatLost {
        /// The node.
        producer: NodeId,
    },
    /// A node that was missing is there again.
    HeartbeatRecovered {
        /// The node.
        producer: NodeId,
    },
    /// The master that guards this node is missing. What 0x1029 says has happened.
    GuardingLost,
    /// The master that was missing is there again.
    GuardingRecovered,
    /// The CAN controller's standing on the bus changed. What 0x1029 says has happened.
    BusStateChanged {
        /// Before.
        from: BusState,
        /// Now.
        to: BusState,
    },
    /// The network tells the time.
    Time(TimeOfDay),
    /// Layer setting services ask for something. After [`lss::Event::ActivateBitTiming`] the node
    /// is silent and deaf.
    Lss(lss::Event),
    /// A receive PDO stays away longer than its event timer allows.
    PdoOverdue {
        /// The PDO 0x1400 + `number`.
        number: u16,
    },
    /// [`Node::accepts`] changed.
    FiltersChanged,
    /// Frames were dropped because too many waited for a mailbox. Comes once, until none waits any
    /// more.
    TransmitOverflow {
        /// All since the node was built.
        lost: u32,
    },
}

impl<S: ProductSettings, const LEN: usize> Node<LEN, S> {
    /// A node with all values at their defaults. It sends nothing and listens to nothing until
    /// [`Self::boot`]; stored values are set before.
    #[must_use]
    pub fn new(dictionary: &'static Dictionary, node_id: NodeId, settings: S) -> Self {
        let mut node = Self {
            node_id,
            settings,
            now: Instant::ZERO,
            state: State::Initialising,
            heartbeat: heartbeat::Producer::off(),
            guarded: Guarded::off(),
            monitored: heartbeat::Consumers::off(),
            device_errors: 0,
            bus: BusState::Active,
            sync: Sync::off(),
            time: CanId::NONE,
            emergencies: emcy::Producer::new(node_id),
            sdo: sdo::Server::default(),
            configured: None,
            lss: None,
            rpdos: Rpdos::default(),
            tpdos: Tpdos::default(),
            outbox: Outbox::default(),
            screen: Screen::CLOSED,
            wake_at: NEVER,
            has_news: false,
            filters_changed: false,
            events: Deque::new(),
            values: Values::new(dictionary, node_id.get()),
        };
        node.configure();
        node
    }

    /// Initialisation is done: sends the boot-up message and enters Pre-operational, from there
    /// Operational if 0x1F80 says so. Nothing happens on a node that is up.
    pub fn boot(&mut self, now: Instant) {
        if self.state != State::Initialising {
            return;
        }
        self.now = now;
        self.start_lss(Some(self.node_id));
        self.send_error_control(State::Initialising.heartbeat_byte());
        self.heartbeat.start(now.into());
        self.enter(State::PreOperational);
        self.listen();
        if number(&self.values, NMT_STARTUP, 0) & SELF_STARTING != 0 {
            self.enter(State::Operational);
        }
        self.transmit_due();
        self.schedule();
    }

    /// In place of [`Self::boot`] for a device whose node-ID was taken away (CiA 305): it listens to
    /// layer setting services alone, until [`lss::Event::Configured`] says which node to build and to
    /// boot.
    pub fn wait_for_node_id(&mut self) {
        self.start_lss(None);
        self.screen.open(lss::REQUEST);
    }

    /// Takes a received frame in. A request is answered first: what a master wrote to an object of the
    /// communication is acted on, and how long a transfer may take is worked out, behind the answer.
    /// Then [`Self::handle_timeout`] is due at once.
    #[inline]
    pub fn handle_frame(
        &mut self,
        now: Instant,
        frame: &Frame,
        application: &mut impl Application,
    ) {
        if self.screen.passes(frame.id()) {
            self.now = now;
            if self.configured.is_some() {
                self.catch_up(frame, application);
            } else {
                self.dispatch(frame, application);
            }
        }
    }

    /// Does what is due. Harmless when nothing is.
    pub fn handle_timeout(&mut self, now: Instant, application: &mut impl Application) {
        self.now = now;
        if self.wake_at <= now {
            self.serve_due(application);
        }
    }

    #[inline(never)]
    fn serve_due(&mut self, application: &mut impl Application) {
        self.follow_master();
        let now = self.now.into();
        self.sdo.handle_timeout(now, self.settings());
        self.answer();
        self.give_up_producers();
        self.give_up_master();
        if self.state == State::Initialising {
            return;
        }
        if self.heartbeat.take_due(now) {
            self.send_heartbeat();
        }
        self.end_sync_window();
        self.produce_sync(application);
        self.report_overdue();
        self.send_waiting_emergencies();
        self.transmit_due();
        self.schedule();
    }

    /// When to call [`Self::handle_timeout`]. Nothing is due before, and maybe nothing then. `None`
    /// as long as nothing happens.
    #[must_use]
    #[inline]
    pub fn poll_timeout(&self) -> Option<Instant> {
        (self.wake_at != NEVER).then_some(self.wake_at)
    }

    /// The next frame for a mailbox: the lowest CAN-ID, the oldest of equal ones.
    #[must_use]
    #[inline]
    pub fn peek_transmit(&self) -> Option<&Frame> {
        self.outbox.peek()
    }

    /// Takes the frame out that [`Self::peek_transmit`] shows.
    #[inline]
    pub fn take_transmit(&mut self) -> Option<Frame> {
        let frame = self.outbox.take()?;
        if self.sdo.is_sending_block() {
            self.send_segment();
        }
        Some(frame)
    }

    /// Takes a frame back that a more urgent one pushed out of its mailbox. It goes before those
    /// with the same identifier.
    pub fn give_back(&mut self, frame: Frame) {
        self.outbox.give_back(frame);
    }

    /// Sets the errors of the device; with those of the stack they are the error register, 0x1001.
    /// When none is left, an error reset message goes out. When bit 7 comes in Operational, what
    /// 0x1029:02 says happens.
    pub fn set_error_register(&mut self, now: Instant, errors: u8) {
        self.now = now;
        self.device_errors = errors;
        self.update_error_register();
        self.schedule();
    }

    /// The CAN controller's standing on the bus changed: what the settings say is sent, and the error
    /// register has bits 0 and 4 set as long as the controller is passive or off.
    pub fn handle_bus(&mut self, now: Instant, to: BusState) {
        let from = core::mem::replace(&mut self.bus, to);
        if from == to {
            return;
        }
        self.now = now;
        self.report(Event::BusStateChanged { from, to });
        if to.is_impaired() {
            self.update_error_register();
        }
        self.say(self.settings().bus.message(from, to));
        if to == BusState::Off && self.settings().bus.off == BusOff::CommunicationError {
            self.react(ErrorClass::Communication);
        }
        self.update_error_register();
        self.schedule();
    }

    /// Frames were lost because they came faster than they were taken from the CAN controller.
    pub fn handle_overrun(&mut self) {
        self.say(self.settings().bus.overrun);
    }

    /// Records an error in the pre-defined error field and sends an emergency message with the
    /// present error register. Nothing in a state that has no emergency messages: Initialising and
    /// Stopped (CiA 301, table 39). Messages inside the inhibit time wait.
    pub fn send_emergency(&mut self, error_code: u16, manufacturer: [u8; 5]) {
        self.raise(self.state, Emergency { code: error_code, manufacturer });
    }

    /// What happened, the oldest first.
    #[inline]
    pub fn poll_event(&mut self) -> Option<Event> {
        if self.has_events() { self.next_event() } else { None }
    }

    /// Whether [`Self::poll_event`] is worth a call.
    #[must_use]
    #[inline]
    pub fn has_events(&self) -> bool {
        self.has_news | self.outbox.has_overflowed()
    }

    /// The frames this node listens to, whatever its state; all others may be filtered out.
    pub fn accepts(&self) -> impl Iterator<Item = Accepted> {
        let data = |id| Accepted { id, remote: false };
        let remote = |id| Accepted { id, remote: true };
        let guarding = self.guarded.is_served().then(|| Service::ErrorControl.id(self.node_id));
        [
            cob_id::NMT,
            self.sync.id(),
            self.time,
            Service::SdoRequest.id(self.node_id),
            self.settings().lss.map_or(CanId::NONE, |_| lss::REQUEST),
        ]
        .into_iter()
        .filter(|&id| id != CanId::NONE)
        .chain(self.monitored.ids())
        .chain(self.rpdos.ids())
        .map(data)
        .chain(guarding.into_iter().chain(self.tpdos.remote_ids()).map(remote))
    }

    /// The product has an event for the transmit PDO 0x1800 + `number`: it goes out as if its data
    /// had changed, with a SYNC if its type is 0. Nothing happens in other states than Operational,
    /// and to types that know no events.
    pub fn trigger_tpdo(&mut self, now: Instant, number: u16) {
        self.now = now;
        self.follow_master();
        self.tpdos.trigger(number);
        self.follow_values();
    }

    /// The user touched the device: takes the node-ID that [`lss::Event::Offered`] showed, once per
    /// offer.
    pub fn take_offered_node_id(&mut self) {
        if let Some(slave) = self.lss_slave() {
            let reaction = slave.take_offer();
            self.follow(reaction);
        }
    }

    /// What became of [`Event::Store`] or [`Event::Restore`]: the client gets its answer, if it still
    /// waits.
    pub fn handle_stored(&mut self, outcome: Result<(), WriteError>) {
        self.sdo.handle_stored(outcome, self.settings());
        self.answer();
        self.schedule();
    }

    /// What became of [`lss::Event::Store`] or [`lss::Event::StoreNodeId`].
    pub fn handle_lss_stored(&mut self, outcome: Result<(), lss::StoreError>) {
        if let Some(slave) = self.lss_slave() {
            let reaction = slave.handle_stored(outcome);
            self.follow(reaction);
        }
    }

    /// The node-ID to build the next node with after [`Event::ResetCommunication`] or
    /// [`lss::Event::ActivateBitTiming`]; `None` when a master took it away.
    #[must_use]
    pub fn pending_node_id(&self) -> Option<NodeId> {
        self.lss.as_ref().map_or(Some(self.node_id), lss::Slave::pending_node_id)
    }

    /// The network management state.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// The CAN controller's standing on the bus, as [`Self::handle_bus`] was told.
    #[must_use]
    pub const fn bus_state(&self) -> BusState {
        self.bus
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
        self.now = now;
        self.change_value(slot, raw);
    }
}

impl<S: ProductSettings, const LEN: usize> Node<LEN, S> {
    fn change_value(&mut self, slot: Slot, raw: u32) {
        if self.values.raw(slot) != raw {
            self.follow_master();
            self.values.set_raw(slot, raw);
            self.note_change(slot);
        }
    }

    #[inline(never)]
    fn next_event(&mut self) -> Option<Event> {
        if let Some(event) = self.events.pop_front() {
            return Some(event);
        }
        if core::mem::take(&mut self.filters_changed) {
            return Some(Event::FiltersChanged);
        }
        self.has_news = false;
        let lost = self.outbox.take_overflow()?;
        self.say(self.settings().bus.overflow);
        Some(Event::TransmitOverflow { lost })
    }

    #[inline]
    fn settings(&self) -> &'static Settings {
        self.settings.settings()
    }

    fn answer(&mut self) {
        if let Some(answer) = self.sdo.take_answer() {
            let id = Service::SdoResponse.id(self.node_id);
            self.outbox.push(Frame::full(id, answer.to_bytes()));
        }
    }

    fn start_lss(&mut self, node_id: Option<NodeId>) {
        let (identity, settings) = (self.identity(), LayerSettings(self.settings));
        self.lss = self.settings().lss.map(|_| lss::Slave::new(settings, identity, node_id));
    }

    /// None for a node that is silent and deaf.
    fn lss_slave(&mut self) -> Option<&mut lss::Slave<LayerSettings<S>>> {
        let listens = self.screen.passes(lss::REQUEST);
        self.lss.as_mut().filter(|_| listens)
    }

    /// One segment of a block waits for a mailbox at a time: a block may have more of them than
    /// frames can wait.
    #[inline(never)]
    fn send_segment(&mut self) {
        if !self.outbox.holds(Service::SdoResponse.id(self.node_id)) {
            self.sdo.send_segment();
            self.answer();
        }
    }

    fn follow(&mut self, reaction: Option<lss::Reaction>) {
        match reaction {
            Some(lss::Reaction::Response(response)) => self.outbox.push(response),
            Some(lss::Reaction::Event(event @ lss::Event::ActivateBitTiming { .. })) => {
                self.leave(Event::Lss(event));
            }
            Some(lss::Reaction::Event(event)) => self.report(Event::Lss(event)),
            None => {}
        }
    }

    fn identity(&self) -> lss::Identity {
        let part = |sub| number(&self.values, IDENTITY, sub);
        lss::Identity {
            vendor_id: part(1),
            product_code: part(2),
            revision: part(3),
            serial: part(4),
        }
    }

    /// A PDO came or values changed: what is due now goes out, and what follows later is not missed.
    #[inline(never)]
    fn follow_values(&mut self) {
        self.transmit_due();
        self.wake_for_pdos();
    }

    fn produce_sync(&mut self, application: &mut impl Application) {
        if let Some(frame) = self.sync.take_due(self.now.into()) {
            self.outbox.supersede(frame);
            self.handle_sync(&frame, application);
        }
    }

    /// PDOs that did not go out in the window of their SYNC are late.
    fn end_sync_window(&mut self) {
        if self.sync.take_window_end(self.now.into()) {
            let tpdos = &self.tpdos;
            self.outbox.retain(&mut |frame| !tpdos.send_with_sync(frame.id()));
        }
    }

    fn report_overdue(&mut self) {
        while let Some(number) = self.rpdos.take_due(self.now.into()) {
            self.report(Event::PdoOverdue { number });
            self.say(self.settings().receive_errors.overdue);
        }
    }

    fn enter(&mut self, to: State) {
        let from = core::mem::replace(&mut self.state, to);
        if from == to {
            return;
        }
        if to == State::Operational {
            self.tpdos.start(self.now.into());
        } else {
            self.rpdos.stop();
            self.tpdos.stop();
            let error_control = Service::ErrorControl.id(self.node_id);
            let tpdos = &self.tpdos;
            self.outbox.retain(&mut |frame| match to {
                State::PreOperational | State::Operational => !tpdos.send(frame.id()),
                State::Stopped | State::Initialising => {
                    frame.id() == error_control || frame.id() == lss::RESPONSE
                }
            });
        }
        if to.serves_sdo() {
            self.sync.start(self.now.into());
        } else {
            self.sdo.stop();
            self.sync.stop();
        }
        self.report(Event::StateChanged { from, to });
    }

    /// Ends all activity for good.
    fn leave(&mut self, reason: Event) {
        self.state = State::Initialising;
        self.screen = Screen::CLOSED;
        self.wake_at = NEVER;
        self.configured = None;
        self.sdo.stop();
        self.rpdos.stop();
        self.tpdos.stop();
        self.outbox.clear();
        self.report(reason);
    }

    /// Heartbeats do not pile up before a bus that takes nothing: the newest stands for all, and
    /// none follows a boot-up message that still waits.
    fn send_heartbeat(&mut self) {
        if !self.outbox.holds_boot_up() {
            self.send_error_control(self.state.heartbeat_byte());
        }
    }

    #[inline(never)]
    fn send_error_control(&mut self, byte: u8) {
        self.outbox.supersede(Frame::single(Service::ErrorControl.id(self.node_id), byte));
    }

    fn transmit_due(&mut self) {
        self.tpdos.transmit_due(self.now.into(), &self.values, &mut self.outbox);
    }

    /// Something is due at `deadline`; nothing on a node that is not up.
    #[inline(never)]
    fn wake_by(&mut self, deadline: Deadline) {
        if deadline != Deadline::NEVER && self.state != State::Initialising {
            self.wake_at = self.wake_at.min(deadline.instant(self.now));
        }
    }

    #[inline(never)]
    fn wake_for_pdos(&mut self) {
        let now = self.now.into();
        self.wake_by(self.tpdos.due_at(now).or_earlier(self.rpdos.due_at(now), now));
    }

    /// Looks for what is due next. What a master wrote stays due at once.
    fn schedule(&mut self) {
        let now = self.now.into();
        let deadline = self
            .sdo
            .due_at()
            .or_earlier(self.heartbeat.due_at(), now)
            .or_earlier(self.monitored.due_at(now), now)
            .or_earlier(self.guarded.due_at(), now)
            .or_earlier(self.emergency_due_at(), now)
            .or_earlier(self.sync.due_at(now), now)
            .or_earlier(self.rpdos.due_at(now), now)
            .or_earlier(self.tpdos.due_at(now), now);
        self.wake_at = if self.configured.is_some() { self.now } else { NEVER };
        self.wake_by(deadline);
    }

    #[inline(never)]
    fn report(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
        self.has_news = true;
    }
}
