use super::bits::Wire;
use super::bus::{FIRST_RATE, Logged, Source};
use super::counters::{Confinement, ErrorCounters};
use super::frame::Frame;
use super::port::{Activity, Outcome, Presence, What, WireError};
use super::time::{BitTime, Nanos};

/// Bits between two frames.
pub(super) const INTERMISSION_BITS: u32 = 3;
/// Bits of end of frame.
pub(super) const END_OF_FRAME_BITS: u32 = 7;
/// An error flag.
pub(super) const FLAG_BITS: u32 = 6;
/// Recessive bits behind an error flag.
pub(super) const DELIMITER_BITS: u32 = 8;
/// A node at another rate notices after this many bits at the earliest.
const MISMATCH_BITS: u32 = 6;

/// A node as it stands at a start of frame.
pub(super) struct Station {
    pub(super) source: Source,
    pub(super) presence: Presence,
    pub(super) bit: BitTime,
    pub(super) since: Nanos,
    pub(super) suspended_until: Nanos,
    pub(super) counters: ErrorCounters,
}

impl Station {
    fn is_active(&self) -> bool {
        self.presence == Presence::Normal && self.counters.confinement() == Confinement::ErrorActive
    }

    pub(super) fn sends(&self) -> bool {
        match self.presence {
            Presence::Normal | Presence::LoopBack => {
                self.counters.confinement() != Confinement::BusOff
            }
            Presence::Off | Presence::Silent => false,
        }
    }

    pub(super) fn hears(&self, start: Nanos) -> bool {
        match self.presence {
            Presence::Normal | Presence::Silent => {
                self.since <= start && self.counters.confinement() != Confinement::BusOff
            }
            Presence::Off | Presence::LoopBack => false,
        }
    }
}

/// A frame taking part in an arbitration.
pub(super) struct Bid {
    pub(super) station: usize,
    pub(super) mailbox: usize,
    pub(super) frame: Frame,
    pub(super) wire: Wire,
}

/// Something that destroys a frame, by the place of the bit.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cause {
    /// Two nodes send different frames under one identifier.
    Collision,
    /// A node at another rate raises its error flag.
    Mismatch,
    /// A bit is inverted.
    Disturbance,
    /// Nobody acknowledges.
    NoAcknowledge,
}

/// The parts nodes have in a frame, apart from its senders.
struct Cast {
    /// Receivers at the rate of the frame.
    matched: Vec<usize>,
    /// Receivers at another rate.
    foreign: Vec<usize>,
    acknowledges: bool,
    needs_no_acknowledge: bool,
}

/// Works out one start of frame.
pub(super) struct Attempt {
    start: Nanos,
    now: Nanos,
    pub(super) stations: Vec<Station>,
    /// Whoever sends (still): all with the same arbitration field.
    senders: Vec<Bid>,
    /// What comes of it, by station.
    pub(super) results: Vec<(usize, Outcome)>,
    pub(super) logged: Option<Logged>,
    /// 1 when the frame failed.
    pub(super) failed: u64,
}

impl Attempt {
    pub(super) fn new(start: Nanos, now: Nanos, stations: Vec<Station>, bids: Vec<Bid>) -> Self {
        Self { start, now, stations, senders: bids, results: Vec::new(), logged: None, failed: 0 }
    }

    /// The bit time of the frame: its sender's.
    fn bit(&self) -> BitTime {
        self.senders
            .first()
            .and_then(|bid| self.stations.get(bid.station))
            .map_or(BitTime::from_rate(FIRST_RATE), |station| station.bit)
    }

    /// The end of the bit at `place`, but not before the boundary.
    fn end_of(&self, place: u32) -> Nanos {
        self.start.after(self.bit().bits(place.saturating_add(1))).max(self.now.after(1))
    }

    /// The first place whose end lies behind the boundary.
    fn first_place(&self) -> u32 {
        self.bit().whole_bits(self.now.since(self.start))
    }

    fn result(&mut self, station: usize, at: Nanos, what: What) {
        let Some(before) = self.stations.get(station).map(|station| station.counters) else {
            return;
        };
        let counters = match what {
            What::Received(_) => before.received(),
            What::Transmitted(_) => before.transmitted(),
            What::LostArbitration(_) => before,
            What::TransmitFailed(_, error) => before.transmit_failed(error),
            What::ReceiveFailed(_) => before.receive_failed(),
        };
        self.results.push((station, Outcome { at, what, counters }));
    }

    /// Leaves the frames with the lowest arbitration field as the senders.
    pub(super) fn arbitrate(&mut self) {
        self.senders.sort_by_key(|bid| (bid.frame.arbitration(), bid.station));
        let Some(lead) = self.senders.first() else { return };
        let (key, bit) = (lead.frame.arbitration(), self.bit());
        let stations = &self.stations;
        let stays = |bid: &Bid| {
            let same_rate = stations.get(bid.station).is_some_and(|s| s.bit.matches(bit));
            bid.frame.arbitration() == key && same_rate
        };
        let (stay, lost): (Vec<Bid>, Vec<Bid>) =
            std::mem::take(&mut self.senders).into_iter().partition(stays);
        self.senders = stay;
        for bid in lost {
            let place = self.senders.first().and_then(|lead| lead.wire.first_difference(&bid.wire));
            let at = self.end_of(place.unwrap_or_default());
            self.result(bid.station, at, What::LostArbitration(bid.mailbox));
        }
    }

    /// The places a disturbance may hit.
    pub(super) fn disturbable(&self) -> (u32, u32) {
        let Some(lead) = self.senders.first() else { return (0, 0) };
        let first = self.first_place().max(lead.wire.after_arbitration());
        (first.min(lead.wire.len().saturating_sub(2)), lead.wire.ack_slot().saturating_sub(2))
    }

    /// Sends the frame, with a disturbance at the given place.
    pub(super) fn run(&mut self, disturbed_at: Option<u32>, no_ack: bool) -> Activity {
        let collision = self.collide();
        let Some(lead) = self.senders.first() else {
            let quiet_from = self.now.after(1);
            return Activity { start: self.start, quiet_from, free_at: quiet_from };
        };
        let (wire, frame) = (lead.wire.clone(), lead.frame);
        let cast = self.cast();
        let last = wire.len().saturating_sub(2);
        let flag_at = self.first_place().max(MISMATCH_BITS).min(last);
        self.foreign_nodes_fail(&cast.foreign, flag_at);
        let flagged = self.any_active(&cast.foreign);
        let acknowledged = cast.needs_no_acknowledge || (cast.acknowledges && !no_ack);
        let failure = [
            collision.map(|place| (place, Cause::Collision)),
            flagged.then_some((flag_at, Cause::Mismatch)),
            disturbed_at.map(|place| (place, Cause::Disturbance)),
            (!acknowledged).then(|| (wire.ack_slot(), Cause::NoAcknowledge)),
        ]
        .into_iter()
        .flatten()
        .min_by_key(|(place, _)| *place);
        match failure {
            None => self.pass(&wire, frame, &cast.matched),
            Some((place, cause)) => self.fail(place, cause, &wire, frame, &cast),
        }
    }

    /// Who has which part in the frame.
    fn cast(&self) -> Cast {
        let bit = self.bit();
        let sends = |n: usize| self.senders.iter().any(|bid| bid.station == n);
        let station = |n: &usize| self.stations.get(*n);
        let (matched, foreign): (Vec<usize>, Vec<usize>) = (0..self.stations.len())
            .filter(|n| station(n).is_some_and(|s| s.hears(self.start)) && !sends(*n))
            .partition(|n| station(n).is_some_and(|s| s.bit.matches(bit)));
        let presence = |n: &usize| station(n).map_or(Presence::Off, |s| s.presence);
        Cast {
            acknowledges: matched.iter().any(|n| presence(n) == Presence::Normal),
            needs_no_acknowledge: (0..self.stations.len())
                .any(|n| sends(n) && presence(&n) == Presence::LoopBack),
            matched,
            foreign,
        }
    }

    /// Nodes at another rate make nothing of the frame. Those that may, say so.
    fn foreign_nodes_fail(&mut self, foreign: &[usize], place: u32) {
        let at = self.end_of(place);
        for &n in foreign {
            let Some(station) = self.stations.get(n) else { continue };
            let counters = if station.is_active() {
                station.counters.receive_failed_first()
            } else {
                station.counters.receive_failed()
            };
            let what = What::ReceiveFailed(WireError::Stuff);
            self.results.push((n, Outcome { at, what, counters }));
        }
    }

    /// The frame is good.
    fn pass(&mut self, wire: &Wire, frame: Frame, receivers: &[usize]) -> Activity {
        self.deliver(receivers, self.end_of(wire.len() - 2), frame);
        let end = self.end_of(wire.len() - 1);
        for (station, mailbox) in self.sending() {
            self.result(station, end, What::Transmitted(mailbox));
        }
        self.logged = self.entry(end, frame);
        self.good_end(end)
    }

    /// The frame fails at `place`.
    fn fail(
        &mut self,
        place: u32,
        cause: Cause,
        wire: &Wire,
        frame: Frame,
        cast: &Cast,
    ) -> Activity {
        self.failed = 1;
        let at = self.end_of(place);
        let senders: Vec<usize> = self.sending().into_iter().map(|(station, _)| station).collect();
        let flag_is_seen = self.any_active(&senders);
        let error = match cause {
            Cause::Disturbance if !wire.bit(place) => WireError::BitDominant,
            Cause::Disturbance | Cause::Collision | Cause::Mismatch => WireError::BitRecessive,
            Cause::NoAcknowledge => WireError::Ack,
        };
        for (station, mailbox) in self.sending() {
            self.result(station, at, What::TransmitFailed(mailbox, error));
        }
        if cause == Cause::NoAcknowledge && !flag_is_seen {
            // The recessive flag of an error-passive sender looks like the end of a frame.
            self.deliver(&cast.matched, self.end_of(wire.len() - 2), frame);
            let end = self.end_of(wire.len() - 1);
            self.logged = self.entry(end, frame).filter(|_| !cast.matched.is_empty());
            return self.good_end(end);
        }
        let seen = if place < wire.ack_slot() { WireError::Stuff } else { WireError::Form };
        for &n in &cast.matched {
            self.result(n, at, What::ReceiveFailed(seen));
        }
        let bit = self.bit();
        let echoed = self.any_active(&cast.matched) || cause == Cause::Mismatch;
        let flags = bit.bits(if echoed { 2 * FLAG_BITS } else { FLAG_BITS });
        let foreign_flags = cast
            .foreign
            .iter()
            .filter_map(|&n| self.stations.get(n))
            .filter(|station| station.is_active())
            .map(|station| station.bit.bits(FLAG_BITS));
        let quiet_from = at.after(foreign_flags.fold(flags, u64::max));
        let free_at = quiet_from.after(bit.bits(DELIMITER_BITS + INTERMISSION_BITS));
        Activity { start: self.start, quiet_from, free_at }
    }

    fn any_active(&self, group: &[usize]) -> bool {
        group.iter().any(|&n| self.stations.get(n).is_some_and(Station::is_active))
    }

    /// Station and mailbox of everyone who sends.
    fn sending(&self) -> Vec<(usize, usize)> {
        self.senders.iter().map(|bid| (bid.station, bid.mailbox)).collect()
    }

    /// Two senders under one identifier: error-passive ones that see their recessive bit overwritten
    /// fall out unnoticed. The answer is the place at which an error-active one notices.
    fn collide(&mut self) -> Option<u32> {
        loop {
            let (lead, others) = self.senders.split_first()?;
            let place = others.iter().filter_map(|o| lead.wire.first_difference(&o.wire)).min()?;
            let overwritten = |bid: &Bid| bid.wire.bit(place);
            let is_active =
                |bid: &Bid| self.stations.get(bid.station).is_some_and(Station::is_active);
            if self.senders.iter().any(|bid| overwritten(bid) && is_active(bid)) {
                return Some(place.max(self.first_place()));
            }
            let (out, stay): (Vec<Bid>, Vec<Bid>) =
                std::mem::take(&mut self.senders).into_iter().partition(overwritten);
            self.senders = stay;
            let at = self.end_of(place);
            for bid in out {
                let failed = What::TransmitFailed(bid.mailbox, WireError::BitRecessive);
                self.result(bid.station, at, failed);
            }
        }
    }

    fn deliver(&mut self, receivers: &[usize], at: Nanos, frame: Frame) {
        for &n in receivers {
            // A sender that fell out of a collision is no receiver of the frame that went on.
            if !self
                .results
                .iter()
                .any(|(m, o)| *m == n && matches!(o.what, What::TransmitFailed(..)))
            {
                self.result(n, at, What::Received(frame));
            }
        }
    }

    fn entry(&self, end: Nanos, frame: Frame) -> Option<Logged> {
        let lead = self.senders.first()?;
        let source = self.stations.get(lead.station)?.source;
        Some(Logged { start: self.start, end, frame, source })
    }

    fn good_end(&self, end: Nanos) -> Activity {
        let bit = self.bit();
        let recessive = bit.bits(END_OF_FRAME_BITS + 1);
        Activity {
            start: self.start,
            quiet_from: Nanos(end.0.saturating_sub(recessive)),
            free_at: end.after(bit.bits(INTERMISSION_BITS)),
        }
    }
}
