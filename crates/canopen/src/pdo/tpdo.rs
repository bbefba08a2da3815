use object_dictionary::{Slot, Values};

use super::MAPPING;
use super::communication::Communication;
use super::mapping::Mapping;
use super::slots::Slots;
use super::transmission::Transmission;
use crate::deadline::{Deadline, Moment, Span};
use crate::frame::{CanId, DATA_MAX, Frame};
use crate::outbox::Outbox;
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
    /// None while it is switched off or carries nothing.
    id: CanId,
    mapping: Mapping,
    transmission: Transmission,
    /// The counter of the SYNC that counts as the first; 0 when any does.
    sync_start: u32,
    /// The identifier of the remote frames it answers, or none.
    remote_id: CanId,
    /// The slots whose changes are events.
    watched: Slots,
    inhibit_time: Span,
    /// None at all where the event timer is no event.
    event_time: Span,
    /// Never while it may go out.
    inhibited_until: Deadline,
    /// Only while the node is Operational and the PDO switched on.
    progress: Option<Progress>,
}

#[derive(Clone, Copy, Debug)]
struct Progress {
    /// An event that has not gone out yet.
    event: bool,
    timer_at: Deadline,
    /// SYNCs up to the next frame; 0 before the first that counts.
    syncs_left: u8,
    /// The data at the last SYNC, where remote frames ask for that.
    sampled: Option<[u8; DATA_MAX]>,
}

impl Tpdo {
    /// One that is switched off.
    pub(super) fn off() -> Self {
        Self {
            id: CanId::NONE,
            mapping: Mapping::default(),
            transmission: Transmission::Never,
            sync_start: 0,
            remote_id: CanId::NONE,
            watched: Slots::EMPTY,
            inhibit_time: Span::ZERO,
            event_time: Span::ZERO,
            inhibited_until: Deadline::NEVER,
            progress: None,
        }
    }

    /// The identifier of its frames; none while it is switched off.
    pub(super) const fn id(&self) -> CanId {
        self.id
    }

    /// The identifier of the remote frames it answers; none where it does not.
    pub(super) const fn remote_id(&self) -> CanId {
        self.remote_id
    }

    /// Whether it goes out with a SYNC.
    pub(super) const fn follows_sync(&self) -> bool {
        self.transmission.follows_sync()
    }

    /// The slots whose changes are events.
    pub(super) const fn watched(&self) -> Slots {
        self.watched
    }

    /// Takes its objects over. A PDO in progress goes on; one that now has another identifier, type
    /// or mapping begins anew.
    pub(super) fn reread<const LEN: usize>(
        &mut self,
        now: Moment,
        index: u16,
        values: &Values<LEN>,
        communication: &Communication,
        rules: &PdoRules,
    ) {
        let before = (self.id, self.transmission);
        self.mapping.reread(values, index | MAPPING);
        self.id = self.mapping.id(communication.cob_id);
        self.transmission = Transmission::new(communication.transmission_type, rules);
        self.sync_start = communication.sync_start;
        self.watched =
            if self.transmission.follows_changes() { self.mapping.slots() } else { Slots::EMPTY };
        self.event_time = if self.transmission.follows_timer() {
            Span::from_millis(communication.event_time_ms)
        } else {
            Span::ZERO
        };
        self.inhibit_time = Span::from(rules.inhibit_unit).times(communication.inhibit_time);
        self.inhibited_until = self.inhibited_until.limited(now, self.inhibit_time);
        let answers = match rules.remote_requests {
            RemoteRequests::AllTypes => true,
            RemoteRequests::RemoteTypes => self.transmission.is_remote_only(),
        };
        let answers = answers && communication.cob_id.allows_remote();
        self.remote_id = if answers { self.id } else { CanId::NONE };
        if before != (self.id, self.transmission) || index & MAPPING != 0 {
            self.progress = None;
        }
        if let Some(progress) = &mut self.progress {
            progress.timer_at = Deadline::after(now, self.event_time);
        }
    }

    /// The node is Operational. A PDO in progress goes on.
    pub(super) fn start(&mut self, now: Moment) {
        if self.id != CanId::NONE && self.progress.is_none() {
            self.progress = Some(Progress {
                event: !self.watched.is_empty(),
                timer_at: Deadline::after(now, self.event_time),
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
        if self.watched.meets(Slots::of(slot)) && self.mapping.carries(slot) {
            self.trigger();
        }
    }

    /// There is an event.
    pub(super) fn trigger(&mut self) {
        if let Some(progress) = &mut self.progress {
            progress.event = self.transmission.has_events();
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
        let goes = match self.transmission {
            Transmission::EverySync { nth } => progress.count_sync(counter, self.sync_start, nth),
            Transmission::SyncAfterEvent => core::mem::take(&mut progress.event),
            Transmission::RemoteFromSync => {
                progress.sampled = Some(self.mapping.gather(values).to_le_bytes());
                false
            }
            Transmission::Remote | Transmission::Event(_) | Transmission::Never => false,
        };
        if goes {
            self.send(values, outbox);
        }
    }

    /// Takes a remote frame with its identifier.
    pub(super) fn handle_remote<const LEN: usize>(
        &mut self,
        now: Moment,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        match (self.transmission, &self.progress) {
            (_, None) => {}
            (Transmission::Event(_), Some(_)) => self.transmit(now, values, outbox),
            (_, Some(_)) => self.send(values, outbox),
        }
    }

    /// When the inhibit time ends, or an event or the event timer lets it go out, as things stand.
    pub(super) fn due_at(&self, now: Moment) -> Deadline {
        match (&self.progress, self.transmission) {
            _ if self.inhibited_until != Deadline::NEVER => self.inhibited_until,
            (Some(Progress { event: true, .. }), Transmission::Event(_)) => Deadline::at(now),
            (Some(progress), _) => progress.timer_at,
            (None, _) => Deadline::NEVER,
        }
    }

    /// Whether it goes out now. An inhibit time that is over ends.
    pub(super) fn take_due(&mut self, now: Moment) -> bool {
        self.inhibited_until.take_due(now);
        self.due_at(now).is_due(now)
    }

    /// Goes out for an event.
    pub(super) fn transmit<const LEN: usize>(
        &mut self,
        now: Moment,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        if let Some(progress) = &mut self.progress {
            progress.event = false;
            if progress.timer_at != Deadline::NEVER {
                let from = progress.timer_at.or_earlier(Deadline::at(now), now);
                progress.timer_at = from.next(now, self.event_time);
            }
        }
        self.inhibited_until = Deadline::after(now, self.inhibit_time);
        self.send(values, outbox);
    }

    /// Sends the present values, or those at the last SYNC where remote frames ask for that.
    fn send<const LEN: usize>(&self, values: &Values<LEN>, outbox: &mut Outbox) {
        let mapping = &self.mapping;
        let data = match self.progress {
            Some(Progress { sampled: Some(data), .. }) => data,
            Some(Progress { sampled: None, .. }) | None => mapping.gather(values).to_le_bytes(),
        };
        outbox.supersede(Frame::padded_from(self.id, data, mapping.byte_len()));
    }
}

impl Progress {
    /// Counts a SYNC. Whether it is the n-th, which begins the next count.
    fn count_sync(&mut self, counter: Option<u8>, start: u32, nth: u8) -> bool {
        let left = match (self.syncs_left, counter) {
            (0, Some(counter)) if start > 0 && u32::from(counter) != start => return false,
            (0, _) => nth,
            (left, _) => left,
        };
        let goes = left == 1;
        self.syncs_left = if goes { nth } else { left.saturating_sub(1) };
        goes
    }
}
