use object_dictionary::{Slot, Values};
use units::{Duration, Instant};

use super::mapping::Mapping;
use super::span::Span;
use super::transmission::Transmission;
use crate::cob_id::CobId;
use crate::deadline::Deadline;
use crate::frame::{CanId, Frame};
use crate::outbox::Outbox;
use crate::parameter::parameter;
use crate::settings::{PdoRules, RemoteRequests};

/// A transmit PDO (CiA 301, section 7.2.2; objects 0x1800 and 0x1A00 and following).
///
/// One that follows changes goes out once when the node becomes Operational, or when it is itself
/// switched on there, so that masters know the data from the start. Then every change goes out; one
/// inside the inhibit time goes out when that ends, with the data of that moment. The event timer
/// counts from the start; the inhibit time holds it back as well. SYNC-driven ones count from
/// becoming Operational, or from the SYNC with the start value, and know no inhibit time.
///
/// A remote frame is answered at once, whatever the inhibit time says.
#[derive(Debug)]
pub(super) struct Tpdo {
    number: u16,
    parameters: Parameters,
    mapping: Mapping,
    inhibited_until: Instant,
    /// Only while the node is Operational and the PDO switched on.
    progress: Option<Progress>,
}

/// The communication parameter as the stack uses it.
#[derive(Clone, Copy, Debug)]
struct Parameters {
    cob_id: CobId,
    transmission: Transmission,
    inhibit_time: Duration,
    event_time: Duration,
    sync_start: u8,
    remote_requests: RemoteRequests,
}

#[derive(Clone, Copy, Debug)]
struct Progress {
    /// An event that has not gone out yet.
    event: bool,
    timer_at: Deadline,
    /// SYNCs up to the next frame; 0 before the first that counts.
    syncs_left: u8,
    /// The frame with the values at the last SYNC, where remote frames ask for that.
    sampled: Option<Frame>,
}

impl Tpdo {
    /// The PDO 0x1800 + `number`. `None` when the product does not have it.
    pub(super) fn new<const LEN: usize>(
        number: u16,
        values: &Values<LEN>,
        rules: &PdoRules,
    ) -> Option<Self> {
        Some(Self {
            number,
            parameters: Parameters::read(number, values, rules)?,
            mapping: Mapping::read(values, MAPPING + number),
            inhibited_until: Instant::ZERO,
            progress: None,
        })
    }

    /// Its place among the transmit PDOs, from 0.
    pub(super) const fn number(&self) -> u16 {
        self.number
    }

    /// Whether `index` is its communication parameter or its mapping.
    pub(super) const fn is_described_by(&self, index: u16) -> bool {
        index == COMMUNICATION + self.number || index == MAPPING + self.number
    }

    /// Whether frames with this identifier are its own.
    pub(super) fn sends(&self, id: CanId) -> bool {
        self.parameters.cob_id.is_valid_with(id)
    }

    /// Whether it goes out with a SYNC.
    pub(super) const fn follows_sync(&self) -> bool {
        self.parameters.transmission.follows_sync()
    }

    /// The identifier of the remote frames it answers.
    pub(super) const fn remote_id(&self) -> Option<CanId> {
        self.parameters.remote_id()
    }

    /// Where the slots lie whose changes are events now.
    pub(super) fn watched(&self) -> Span {
        let watches = self.progress.is_some() && self.parameters.transmission.follows_changes();
        if watches { self.mapping.span() } else { Span::EMPTY }
    }

    /// Takes its objects over again. A PDO in progress goes on; one that now has another
    /// identifier, type or mapping begins anew.
    pub(super) fn reread<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
        rules: &PdoRules,
    ) {
        let Some(again) = Self::new(self.number, values, rules) else { return };
        let before = core::mem::replace(self, again);
        let kind = |tpdo: &Self| (tpdo.parameters.cob_id.valid(), tpdo.parameters.transmission);
        self.inhibited_until = before.inhibited_until.min(now + self.parameters.inhibit_time);
        if kind(&before) == kind(self) && before.mapping == self.mapping {
            let timer_at = self.parameters.timer_from(now);
            self.progress = before.progress.map(|progress| Progress { timer_at, ..progress });
        }
    }

    /// The node is Operational. A PDO in progress goes on.
    pub(super) fn start(&mut self, now: Instant) {
        let is_on = self.parameters.cob_id.valid().is_some() && self.mapping.byte_len() > 0;
        if is_on && self.progress.is_none() {
            self.progress = Some(Progress {
                event: self.parameters.transmission.follows_changes(),
                timer_at: self.parameters.timer_from(now),
                syncs_left: 0,
                sampled: None,
            });
        }
    }

    /// The node is no longer Operational.
    pub(super) fn stop(&mut self) {
        self.progress = None;
    }

    /// The value at `slot` changed.
    pub(super) fn note_change(&mut self, slot: Slot) {
        if let Some(progress) = &mut self.progress
            && self.parameters.transmission.follows_changes()
            && self.mapping.carries(slot)
        {
            progress.event = true;
        }
    }

    /// The product has an event of its own.
    pub(super) fn trigger(&mut self) {
        if let Some(progress) = &mut self.progress
            && self.parameters.transmission.has_events()
        {
            progress.event = true;
        }
    }

    /// Goes out with a SYNC, if it is its turn. `counter` is that of the SYNC, if there is one.
    #[inline]
    pub(super) fn handle_sync<const LEN: usize>(
        &mut self,
        counter: Option<u8>,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        let Some(progress) = &mut self.progress else { return };
        let goes = match self.parameters.transmission {
            Transmission::EverySync { nth } => {
                progress.count_sync(counter, self.parameters.sync_start, nth)
            }
            Transmission::SyncAfterEvent => core::mem::take(&mut progress.event),
            Transmission::RemoteFromSync => {
                self.sample(values);
                false
            }
            Transmission::Remote | Transmission::Event(_) | Transmission::Never => false,
        };
        if goes {
            outbox.supersede(self.frame(values));
        }
    }

    fn sample<const LEN: usize>(&mut self, values: &Values<LEN>) {
        let sampled = self.frame(values);
        if let Some(progress) = &mut self.progress {
            progress.sampled = Some(sampled);
        }
    }

    /// The frame that a remote frame with its identifier asks for.
    pub(super) fn handle_remote<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
    ) -> Option<Frame> {
        let progress = self.progress?;
        match self.parameters.transmission {
            Transmission::Event(_) => self.transmit(now, values),
            Transmission::SyncAfterEvent
            | Transmission::EverySync { .. }
            | Transmission::RemoteFromSync
            | Transmission::Remote
            | Transmission::Never => Some(progress.sampled.unwrap_or_else(|| self.frame(values))),
        }
    }

    /// When an event or the event timer lets it go out, as things stand.
    pub(super) fn due_at(&self) -> Deadline {
        match (self.progress, self.parameters.transmission) {
            (Some(Progress { event: true, .. }), Transmission::Event(_)) => {
                Deadline::at(self.inhibited_until)
            }
            (Some(Progress { timer_at, .. }), _) => {
                timer_at.max(Deadline::at(self.inhibited_until))
            }
            (None, _) => Deadline::NEVER,
        }
    }

    /// The frame with the present values, counted as sent for an event.
    pub(super) fn transmit<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
    ) -> Option<Frame> {
        let progress = self.progress.as_mut()?;
        progress.event = false;
        if let Some(timer_at) = progress.timer_at.instant() {
            let next_at = timer_at + self.parameters.event_time;
            let in_step = timer_at <= now && next_at > now;
            progress.timer_at =
                Deadline::at(if in_step { next_at } else { now + self.parameters.event_time });
        }
        self.inhibited_until = now + self.parameters.inhibit_time;
        Some(self.frame(values))
    }

    /// The frame with the present values.
    fn frame<const LEN: usize>(&self, values: &Values<LEN>) -> Frame {
        let data = self.mapping.gather(values).to_le_bytes();
        Frame::padded_from(self.parameters.cob_id.can_id(), data, self.mapping.byte_len())
    }
}

impl Progress {
    /// Counts a SYNC. Whether it is the n-th, which begins the next count.
    fn count_sync(&mut self, counter: Option<u8>, start: u8, nth: u8) -> bool {
        let left = match (self.syncs_left, counter) {
            (0, Some(counter)) if start > 0 && counter != start => return false,
            (0, _) => nth,
            (left, _) => left,
        };
        let goes = left == 1;
        self.syncs_left = if goes { nth } else { left.saturating_sub(1) };
        goes
    }
}

const COMMUNICATION: u16 = 0x1800;
const MAPPING: u16 = 0x1A00;

impl Parameters {
    /// `None` when the product has no such PDO.
    fn read<const LEN: usize>(number: u16, values: &Values<LEN>, rules: &PdoRules) -> Option<Self> {
        let index = COMMUNICATION + number;
        let value = |sub| parameter(values, index, sub);
        let [sync_start, ..] = value(6).unwrap_or(0).to_le_bytes();
        Some(Self {
            cob_id: CobId::from_raw(value(1)?),
            transmission: Transmission::new(value(2)?, rules),
            inhibit_time: rules.inhibit_unit * u64::from(value(3).unwrap_or(0)),
            event_time: Duration::from_millis(u64::from(value(5).unwrap_or(0))),
            sync_start,
            remote_requests: rules.remote_requests,
        })
    }

    /// When the event timer elapses if it starts now.
    fn timer_from(&self, now: Instant) -> Deadline {
        if self.transmission.follows_timer() {
            Deadline::after(now, self.event_time)
        } else {
            Deadline::NEVER
        }
    }

    const fn remote_id(&self) -> Option<CanId> {
        let answers = match self.remote_requests {
            RemoteRequests::AllTypes => true,
            RemoteRequests::RemoteTypes => self.transmission.is_remote_only(),
        };
        if answers && self.cob_id.allows_remote() { self.cob_id.valid() } else { None }
    }
}
