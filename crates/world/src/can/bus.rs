use std::collections::VecDeque;

use super::attempt::{Attempt, Bid, DELIMITER_BITS, INTERMISSION_BITS, Station};
use super::bits::Wire;
use super::counters::{Confinement, ErrorCounters};
use super::faults::{Chance, Faults};
use super::frame::Frame;
use super::outside::{Node, Outside, QueueFull, Rate, Role, Status, UnknownOutside};
use super::port::{
    Activity, Delivery, Outcome, PortState, Presence, Request, SendOrder, What, WireError,
};
use super::time::{BitTime, Nanos};

/// No controller notices anything of a frame earlier than this many bits after its start, unless
/// the frame fails. The shortest frames (remote frames without stuff bits) have 44 bits and are valid
/// one bit before their end; one bit is kept in reserve for rounding.
pub const EARLIEST_OUTCOME_BITS: u32 = 42;

/// Frames the log keeps; older ones are dropped.
pub const LOG_MAX: usize = 100_000;

/// Bits an error-passive node waits after the intermission behind a frame of its own.
const SUSPEND_BITS: u32 = 8;
/// The rate of [`Rate::Automatic`] while no device was ever on the bus: the devices' default.
pub(super) const FIRST_RATE: u32 = 125_000;

/// The longest quantum whose outcomes all lie behind its end, for nodes at this bit time: the time
/// from a start of frame to the first thing noticed of that frame, in nanoseconds.
#[must_use]
pub const fn greatest_quantum(bit: BitTime) -> u64 {
    bit.bits(EARLIEST_OUTCOME_BITS)
}

/// Who sent a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A device, by its port.
    Device(usize),
    /// An outside node.
    Outside(Outside),
}

/// A frame that went over the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Logged {
    /// Its start of frame.
    pub start: Nanos,
    /// The end of its end of frame.
    pub end: Nanos,
    /// The frame.
    pub frame: Frame,
    /// Who sent it.
    pub source: Source,
}

/// A place in the log. The default is the beginning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct LogCursor(u64);

/// One CAN bus.
///
/// Contract: at every boundary between two quanta call [`Bus::resolve`] with the state of every
/// device's controller and hand the deliveries back. In between, outside nodes may send and fetch.
/// Frames of outside nodes count as requested at the last boundary; what they receive and what the
/// log shows has ended at or before it.
#[derive(Debug)]
pub struct Bus {
    chance: Chance,
    faults: Faults,
    now: Nanos,
    free_at: Nanos,
    suspended: Vec<Nanos>,
    outsides: Vec<Node>,
    attached: u64,
    automatic: BitTime,
    flight: Option<Flight>,
    log: VecDeque<Logged>,
    log_dropped: u64,
    error_frames: u64,
    busy: u64,
}

/// What is on the wire and not over yet.
#[derive(Debug)]
struct Flight {
    activity: Activity,
    over_at: Nanos,
    logged: Option<Logged>,
    failed: u64,
    outside: Vec<(Outside, BitTime, Outcome)>,
}

impl Bus {
    /// A quiet bus nobody hangs on. `seed` decides where disturbances hit.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            chance: Chance::new(seed),
            faults: Faults::default(),
            now: Nanos::ZERO,
            free_at: Nanos::ZERO,
            suspended: Vec::new(),
            outsides: Vec::new(),
            attached: 0,
            automatic: BitTime::from_rate(FIRST_RATE),
            flight: None,
            log: VecDeque::new(),
            log_dropped: 0,
            error_frames: 0,
            busy: 0,
        }
    }

    /// The last boundary.
    #[must_use]
    pub const fn now(&self) -> Nanos {
        self.now
    }

    /// Attaches an outside node. It takes part at once, or from the end of the frame on the wire.
    pub fn attach(&mut self, rate: Rate, role: Role) -> Outside {
        let name = Outside(self.attached);
        self.attached += 1;
        self.outsides.push(Node::new(name, rate, role, self.now.max(self.free_at)));
        name
    }

    /// Takes an outside node off the bus. A frame of its own on the wire still goes through.
    /// Nothing happens when it is gone already.
    pub fn detach(&mut self, outside: Outside) {
        self.outsides.retain(|node| node.name != outside);
    }

    /// Queues a frame; it goes out when the bus is free and its turn has come.
    ///
    /// # Errors
    /// [`QueueFull`] when [`super::SEND_MAX`] frames are waiting, or the node is detached.
    pub fn send(&mut self, outside: Outside, frame: Frame) -> Result<(), QueueFull> {
        let now = self.now;
        self.outsides.iter_mut().find(|n| n.name == outside).ok_or(QueueFull)?.send(now, frame)
    }

    /// The oldest frame the node received and has not fetched, with the instant it was valid.
    /// A node does not receive its own frames.
    pub fn receive(&mut self, outside: Outside) -> Option<(Nanos, Frame)> {
        self.outsides.iter_mut().find(|n| n.name == outside)?.receive()
    }

    /// How a node is doing.
    ///
    /// # Errors
    /// When it is detached.
    pub fn status(&self, outside: Outside) -> Result<Status, UnknownOutside> {
        self.outsides.iter().find(|n| n.name == outside).map(Node::status).ok_or(UnknownOutside)
    }

    /// What is wrong with the cable.
    #[must_use]
    pub const fn faults(&self) -> Faults {
        self.faults
    }

    /// Changes what is wrong with the cable, from the next start of frame on.
    pub const fn set_faults(&mut self, faults: Faults) {
        self.faults = faults;
    }

    /// Where the log ends now: the next frame will be logged there.
    #[must_use]
    pub fn log_end(&self) -> LogCursor {
        LogCursor(self.log_dropped + self.log.len() as u64)
    }

    /// Good frames logged since `cursor`, oldest first, and where to go on.
    #[must_use]
    pub fn log_since(&self, cursor: LogCursor) -> (Vec<Logged>, LogCursor) {
        let skip = usize::try_from(cursor.0.saturating_sub(self.log_dropped)).unwrap_or(usize::MAX);
        (self.log.iter().skip(skip).copied().collect(), self.log_end())
    }

    /// Frames that failed, whatever the reason.
    #[must_use]
    pub const fn error_frames(&self) -> u64 {
        self.error_frames
    }

    /// How long the bus was not idle, in nanoseconds, error frames and the intermission included.
    /// The load over a span is what this grew by, divided by the span.
    #[must_use]
    pub const fn busy(&self) -> u64 {
        self.busy
    }

    /// The earliest instant something can happen on the wire, going by what is requested so far; an
    /// engine whose devices are all asleep may put its next boundary a quantum behind it.
    #[must_use]
    pub fn next_activity(&self, ports: &[PortState]) -> Option<Nanos> {
        if ports.iter().any(|port| port.waits) {
            return Some(self.now);
        }
        if self.faults.stuck_dominant {
            return Some(self.free_at.max(self.now));
        }
        self.next_start(ports)
    }

    /// Decides what goes over the wire up to the boundary `now`. `ports` are the devices'
    /// controllers, always in the same order; the answer has one delivery for each.
    pub fn resolve(&mut self, now: Nanos, ports: &[PortState]) -> Vec<Delivery> {
        self.settle(now);
        self.suspended.resize(ports.len(), Nanos::ZERO);
        if let Some(port) = ports.iter().find(|port| port.presence != Presence::Off) {
            self.automatic = port.bit;
        }
        let mut deliveries: Vec<Delivery> = ports
            .iter()
            .map(|port| Delivery { waited_for: port.waits, ..Delivery::default() })
            .collect();
        let activity = if self.faults.stuck_dominant {
            self.hold_dominant(now, ports, &mut deliveries)
        } else {
            self.next_start(ports)
                .filter(|start| *start <= now)
                .map(|start| self.attempt(start, now, ports, &mut deliveries))
        };
        if let Some(activity) = activity {
            for delivery in &mut deliveries {
                delivery.activity = Some(activity);
            }
            for node in &mut self.outsides {
                node.saw(&activity);
            }
        }
        for node in &mut self.outsides {
            node.recover(now);
        }
        self.now = now;
        deliveries
    }

    /// Lets the outside nodes and the log know what is over by `now`.
    fn settle(&mut self, now: Nanos) {
        let Some(flight) = self.flight.take_if(|flight| flight.over_at <= now) else { return };
        self.busy += flight.activity.free_at.since(flight.activity.start);
        self.error_frames += flight.failed;
        if let Some(logged) = flight.logged {
            if self.log.len() >= LOG_MAX {
                self.log.pop_front();
                self.log_dropped += 1;
            }
            self.log.push_back(logged);
        }
        for (name, bit, outcome) in flight.outside {
            if let Some(node) = self.outsides.iter_mut().find(|node| node.name == name) {
                node.handle(&outcome, bit, flight.activity.quiet_from);
            }
        }
    }

    fn station_of_port(&self, port: usize, state: &PortState) -> Station {
        Station {
            source: Source::Device(port),
            presence: state.presence,
            bit: state.bit,
            since: state.since,
            suspended_until: self.suspended.get(port).copied().unwrap_or_default(),
            counters: state.counters,
        }
    }

    fn station_of_outside(&self, node: &Node) -> Station {
        Station {
            source: Source::Outside(node.name),
            presence: match node.role {
                Role::Normal => Presence::Normal,
                Role::ListenOnly => Presence::Silent,
            },
            bit: match node.rate {
                Rate::Fixed(rate) => BitTime::from_rate(rate),
                Rate::Automatic => self.automatic,
            },
            since: node.back_at().unwrap_or(node.since),
            suspended_until: node.suspended_until,
            counters: if node.back_at().is_some() { ErrorCounters::NONE } else { node.counters },
        }
    }

    /// When a frame of this station could start, going by one request alone.
    fn could_start(&self, station: &Station, request: &Request) -> Option<Nanos> {
        let start = [station.since, station.suspended_until, request.at, self.free_at, self.now]
            .into_iter()
            .fold(Nanos::ZERO, Nanos::max);
        let stands = request.withdrawn_at.is_none_or(|at| start < at);
        (station.sends() && stands).then_some(start)
    }

    /// The next start of frame, by what is requested so far.
    fn next_start(&self, ports: &[PortState]) -> Option<Nanos> {
        let of_ports = ports.iter().enumerate().flat_map(|(port, state)| {
            let station = self.station_of_port(port, state);
            let requests = state.requests.iter().flatten();
            requests.filter_map(move |request| self.could_start(&station, request))
        });
        let of_outsides = self
            .outsides
            .iter()
            .filter_map(|node| self.could_start(&self.station_of_outside(node), &node.request()?));
        of_ports.chain(of_outsides).min()
    }

    /// Everything that contends at `start`, one frame per node.
    fn bids(&self, start: Nanos, stations: &[Station], ports: &[PortState]) -> Vec<Bid> {
        let ready = |station: &Station, request: &Request| {
            self.could_start(station, request).is_some_and(|at| at <= start)
        };
        let mut bids = Vec::new();
        for (index, station) in stations.iter().enumerate() {
            let chosen = match station.source {
                Source::Device(port) => ports.get(port).and_then(|state| {
                    let requests = state.requests.iter().enumerate();
                    let held = requests.filter_map(|(n, r)| r.as_ref().map(|r| (n, r)));
                    held.filter(|(_, request)| ready(station, request))
                        .min_by_key(|(mailbox, request)| match state.order {
                            SendOrder::Identifier => {
                                (u64::from(request.frame.arbitration()), *mailbox)
                            }
                            SendOrder::Request => (request.at.0, *mailbox),
                        })
                        .map(|(mailbox, request)| (mailbox, request.frame))
                }),
                Source::Outside(name) => self
                    .outsides
                    .iter()
                    .find(|node| node.name == name)
                    .and_then(Node::request)
                    .filter(|request| ready(station, request))
                    .map(|request| (0, request.frame)),
            };
            if let Some((mailbox, frame)) = chosen {
                bids.push(Bid { station: index, mailbox, frame, wire: Wire::of(&frame) });
            }
        }
        bids
    }

    /// One frame, or an attempt at one, from `start` on.
    fn attempt(
        &mut self,
        start: Nanos,
        now: Nanos,
        ports: &[PortState],
        deliveries: &mut [Delivery],
    ) -> Activity {
        let stations: Vec<Station> = ports
            .iter()
            .enumerate()
            .map(|(port, state)| self.station_of_port(port, state))
            .chain(self.outsides.iter().map(|node| self.station_of_outside(node)))
            .collect();
        let bids = self.bids(start, &stations, ports);
        let mut attempt = Attempt::new(start, now, stations, bids);
        attempt.arbitrate();
        let injected = self.chance.happens(self.faults.error_rate);
        let at = injected.then(|| {
            let (first, last) = attempt.disturbable();
            self.chance.between(first, last)
        });
        let activity = attempt.run(at, self.faults.no_ack);
        self.free_at = activity.free_at;
        let Attempt { stations, results, logged, failed, .. } = attempt;
        let mut flight = Flight { activity, over_at: start, logged, failed, outside: Vec::new() };
        for (index, outcome) in results {
            flight.over_at = flight.over_at.max(outcome.at);
            let Some(station) = stations.get(index) else { continue };
            let suspended_until = match outcome.what {
                What::Transmitted(_) | What::TransmitFailed(..)
                    if outcome.counters.confinement() == Confinement::ErrorPassive =>
                {
                    activity.free_at.after(station.bit.bits(SUSPEND_BITS))
                }
                What::Transmitted(_)
                | What::TransmitFailed(..)
                | What::Received(_)
                | What::LostArbitration(_)
                | What::ReceiveFailed(_) => station.suspended_until,
            };
            match station.source {
                Source::Device(port) => {
                    if let Some(delivery) = deliveries.get_mut(port) {
                        delivery.sending = match outcome.what {
                            What::Transmitted(mailbox) | What::TransmitFailed(mailbox, _) => {
                                Some(mailbox)
                            }
                            What::Received(_)
                            | What::LostArbitration(_)
                            | What::ReceiveFailed(_) => delivery.sending,
                        };
                        delivery.outcomes.push(outcome);
                    }
                    if let Some(suspended) = self.suspended.get_mut(port) {
                        *suspended = suspended_until;
                    }
                }
                Source::Outside(name) => {
                    flight.outside.push((name, station.bit, outcome));
                    if let Some(node) = self.outsides.iter_mut().find(|node| node.name == name) {
                        node.suspended_until = suspended_until;
                    }
                }
            }
        }
        for delivery in deliveries {
            delivery.outcomes.sort_by_key(|outcome| outcome.at);
        }
        flight.outside.sort_by_key(|(_, _, outcome)| outcome.at);
        self.flight = Some(flight);
        activity
    }

    /// The bus is held dominant: every node sees errors, none can send.
    fn hold_dominant(
        &mut self,
        now: Nanos,
        ports: &[PortState],
        deliveries: &mut [Delivery],
    ) -> Option<Activity> {
        if self.free_at > now {
            return None;
        }
        let start = self.free_at.max(self.now);
        let mut slowest = self.automatic;
        for (port, (state, delivery)) in ports.iter().zip(deliveries).enumerate() {
            let station = self.station_of_port(port, state);
            if station.hears(start) {
                slowest = slowest.max(state.bit);
                let counters = state.counters.receive_failed_first();
                if counters != state.counters {
                    let (at, what) = (now.after(1), What::ReceiveFailed(WireError::Stuff));
                    delivery.outcomes.push(Outcome { at, what, counters });
                }
            }
        }
        for index in 0..self.outsides.len() {
            let Some(node) = self.outsides.get(index) else { continue };
            let station = self.station_of_outside(node);
            if let Some(node) = self.outsides.get_mut(index).filter(|_| station.hears(start)) {
                let counters = node.counters.receive_failed_first();
                let (at, what) = (now, What::ReceiveFailed(WireError::Stuff));
                node.handle(&Outcome { at, what, counters }, station.bit, now);
            }
        }
        let quiet_from = now.after(1);
        let free_at = quiet_from.after(slowest.bits(DELIMITER_BITS + INTERMISSION_BITS));
        self.busy += free_at.since(start);
        self.free_at = free_at;
        Some(Activity { start, quiet_from, free_at })
    }
}
