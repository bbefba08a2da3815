//! The CAN controller of the STM with the driver in front of it.
//!
//! Three mailboxes, of which the frame with the lowest identifier goes first; a more urgent frame
//! takes the place of the least urgent one that is not on the wire. The counters are the bus's to
//! change; bus-off ends by itself after 128 times 11 recessive bits.

use std::collections::VecDeque;

use canopen::{Accepted, BusState, CanId, Frame};
use world::can::{
    BitTime, Confinement, Delivery, ErrorCounters, Id, MAILBOXES, Nanos, Outcome, PortState,
    Presence, RecessiveWait, Request, SendOrder, What,
};

/// An error counter from here on is a warning (RM0090, section 32.7.6).
const WARNING: u16 = 96;

/// What happened to a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Notice {
    /// One was received.
    Received(Frame),
    /// One left its mailbox without having been sent.
    Returned(Frame),
    /// Something else: there may be room in a mailbox, or another error state.
    Other,
}

/// A frame that cannot be taken now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Busy;

/// The controller.
#[derive(Debug)]
pub(crate) struct CanPort {
    bit_rate: Option<u32>,
    accepted: Vec<Accepted>,
    mode: Mode,
    counters: ErrorCounters,
    /// Whether bus-off ends.
    recovers: bool,
    mailboxes: [Option<Mailbox>; MAILBOXES],
    sending: Option<usize>,
    outcomes: VecDeque<Outcome>,
    /// The newest request.
    requested_at: Nanos,
    frames_taken: u64,
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    Joining(RecessiveWait),
    Normal { since: Nanos },
    BusOff(RecessiveWait),
}

#[derive(Clone, Copy, Debug)]
struct Mailbox {
    frame: Frame,
    request: Request,
    /// It is on the wire, and its place is wanted.
    aborted: bool,
}

impl CanPort {
    /// A controller that takes no part until [`CanPort::configure`].
    pub(crate) fn new() -> Self {
        Self {
            bit_rate: None,
            accepted: Vec::new(),
            mode: Mode::Joining(RecessiveWait::new(
                RecessiveWait::TO_JOIN,
                Nanos(u64::MAX),
                BitTime::from_rate(0),
            )),
            counters: ErrorCounters::NONE,
            recovers: true,
            mailboxes: [None; MAILBOXES],
            sending: None,
            outcomes: VecDeque::new(),
            requested_at: Nanos::ZERO,
            frames_taken: 0,
        }
    }

    /// Runs at `bit_rate` and receives the frames `accepted`. Joins the bus anew only if the bit
    /// rate changed; frames in the mailboxes are then forgotten.
    pub(crate) fn configure(
        &mut self,
        now: Nanos,
        bit_rate: u32,
        accepted: impl Iterator<Item = Accepted>,
    ) {
        self.accepted = accepted.collect();
        if self.bit_rate != Some(bit_rate) {
            let bit = BitTime::from_rate(bit_rate);
            *self = Self {
                bit_rate: Some(bit_rate),
                accepted: std::mem::take(&mut self.accepted),
                mode: Mode::Joining(RecessiveWait::new(RecessiveWait::TO_JOIN, now, bit)),
                recovers: self.recovers,
                frames_taken: self.frames_taken,
                ..Self::new()
            };
        }
    }

    /// Whether it comes back from bus-off by itself, from now on.
    pub(crate) fn set_recovery(&mut self, recovers: bool) {
        self.recovers = recovers;
    }

    fn bit(&self) -> BitTime {
        BitTime::from_rate(self.bit_rate.unwrap_or_default())
    }

    /// What it wants from the bus.
    pub(crate) fn state(&self) -> PortState {
        let (presence, since) = match self.mode {
            Mode::Joining(_) | Mode::BusOff(_) => (Presence::Off, Nanos::ZERO),
            Mode::Normal { since } => (Presence::Normal, since),
        };
        PortState {
            presence,
            bit: self.bit(),
            since,
            counters: self.counters,
            order: SendOrder::Identifier,
            requests: self.mailboxes.map(|mailbox| mailbox.map(|mailbox| mailbox.request)),
            waits: false,
        }
    }

    /// Takes in what the bus decided.
    pub(crate) fn deliver(&mut self, delivery: Delivery) {
        if let Some(activity) = &delivery.activity {
            match &mut self.mode {
                Mode::Joining(wait) | Mode::BusOff(wait) => wait.interrupted(activity),
                Mode::Normal { .. } => {}
            }
        }
        self.sending = delivery.sending.or(self.sending);
        self.outcomes.extend(delivery.outcomes);
    }

    /// When there is something to notice.
    pub(crate) fn next_event(&self) -> Option<Nanos> {
        self.outcomes.front().map(|outcome| outcome.at).into_iter().chain(self.joins_at()).min()
    }

    /// When it takes part again.
    fn joins_at(&self) -> Option<Nanos> {
        match self.mode {
            Mode::BusOff(_) if !self.recovers => None,
            Mode::Joining(wait) | Mode::BusOff(wait) => Some(wait.over_at()),
            Mode::Normal { .. } => None,
        }
    }

    /// The next thing to notice up to `now`.
    pub(crate) fn poll(&mut self, now: Nanos) -> Option<Notice> {
        self.next_event().filter(|at| *at <= now)?;
        if let Some(since) = self.joins_at().filter(|at| *at <= now) {
            if matches!(self.mode, Mode::BusOff(_)) {
                self.counters = ErrorCounters::NONE;
            }
            self.mode = Mode::Normal { since };
            return Some(Notice::Other);
        }
        let outcome = self.outcomes.pop_front()?;
        self.counters = outcome.counters;
        if self.counters.confinement() == Confinement::BusOff {
            let sequences = RecessiveWait::AFTER_BUS_OFF;
            self.mode = Mode::BusOff(RecessiveWait::new(sequences, outcome.at, self.bit()));
        }
        Some(match outcome.what {
            What::Received(frame) => self.received(&frame),
            What::Transmitted(mailbox) => {
                self.sending = None;
                self.take(mailbox);
                Notice::Other
            }
            What::LostArbitration(mailbox) => self.failed(mailbox),
            What::TransmitFailed(mailbox, _) => {
                self.sending = None;
                self.failed(mailbox)
            }
            What::ReceiveFailed(_) => Notice::Other,
        })
    }

    fn take(&mut self, mailbox: usize) -> Option<Mailbox> {
        self.mailboxes.get_mut(mailbox)?.take()
    }

    /// A frame that was not sent tries again, unless its place is wanted.
    fn failed(&mut self, mailbox: usize) -> Notice {
        let slot = self.mailboxes.get_mut(mailbox);
        let aborted = slot.and_then(|slot| slot.take_if(|mailbox| mailbox.aborted));
        aborted.map_or(Notice::Other, |mailbox| Notice::Returned(mailbox.frame))
    }

    fn received(&mut self, frame: &world::can::Frame) -> Notice {
        let Id::Standard(id) = frame.id() else { return Notice::Other };
        let id = CanId::from_low_bits(id.into());
        let remote = frame.is_remote();
        if !self.accepted.iter().any(|wanted| wanted.id == id && wanted.remote == remote) {
            return Notice::Other;
        }
        let frame =
            if remote { Frame::new_remote(id, frame.dlc()) } else { Frame::new(id, frame.data()) };
        self.frames_taken += 1;
        frame.map_or(Notice::Other, Notice::Received)
    }

    /// Puts `frame` into a mailbox; the frame it takes the place of is given back.
    ///
    /// # Errors
    /// [`Busy`]: a later [`Notice`] is the next chance.
    pub(crate) fn transmit(&mut self, now: Nanos, frame: &Frame) -> Result<Option<Frame>, Busy> {
        if matches!(self.mode, Mode::Joining(_)) {
            return Err(Busy);
        }
        let wire = wire_frame(frame).ok_or(Busy)?;
        let index = match self.mailboxes.iter().position(Option::is_none) {
            Some(free) => free,
            None => self.make_room(&wire).ok_or(Busy)?,
        };
        // One after the other: on an idle bus the first has begun before the second is there.
        self.requested_at = now.max(self.requested_at.after(1));
        let request = Request { at: self.requested_at, withdrawn_at: None, frame: wire };
        let mailbox = Mailbox { frame: *frame, request, aborted: false };
        let before = self.mailboxes.get_mut(index).and_then(|slot| slot.replace(mailbox));
        Ok(before.map(|mailbox| mailbox.frame))
    }

    /// The mailbox of the least urgent frame, if `wanted` is more urgent and it can be had at once.
    fn make_room(&mut self, wanted: &world::can::Frame) -> Option<usize> {
        let held = self.mailboxes.iter_mut().enumerate();
        let (index, least) = held
            .filter_map(|(index, slot)| slot.as_mut().map(|mailbox| (index, mailbox)))
            .max_by_key(|(_, mailbox)| mailbox.request.frame.arbitration())
            .filter(|(_, least)| least.request.frame.arbitration() > wanted.arbitration())?;
        least.aborted = self.sending == Some(index);
        (!least.aborted).then_some(index)
    }

    /// Its standing on the bus.
    pub(crate) fn bus_state(&self) -> BusState {
        let worst = self.counters.transmit().max(self.counters.receive().into());
        match self.counters.confinement() {
            Confinement::BusOff => BusState::Off,
            Confinement::ErrorPassive => BusState::Passive,
            Confinement::ErrorActive if worst >= WARNING => BusState::Warning,
            Confinement::ErrorActive => BusState::Active,
        }
    }

    /// Frames that passed the filters since power-on.
    pub(crate) fn frames_taken(&self) -> u64 {
        self.frames_taken
    }
}

fn wire_frame(frame: &Frame) -> Option<world::can::Frame> {
    let id = Id::Standard(frame.id().get());
    if frame.is_remote() {
        world::can::Frame::remote(id, frame.dlc()).ok()
    } else {
        world::can::Frame::new(id, frame.data()).ok()
    }
}
