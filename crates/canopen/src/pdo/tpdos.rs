use heapless::Vec;
use object_dictionary::{Slot, Values};
use units::Instant;

use super::span::Span;
use super::tpdo::Tpdo;
use crate::deadline::Deadline;
use crate::frame::CanId;
use crate::outbox::Outbox;
use crate::settings::PdoRules;

/// Transmit PDOs of a device.
const TPDO_MAX: usize = 4;

/// The transmit PDOs of a device.
#[derive(Debug)]
pub(crate) struct Tpdos {
    tpdos: Vec<Tpdo, TPDO_MAX, u8>,
    /// Where all slots lie whose changes are events; others need no search.
    watched: Span,
    due_at: Deadline,
}

impl Tpdos {
    /// Those that the dictionary describes.
    pub(crate) fn new<const LEN: usize>(values: &Values<LEN>, rules: &PdoRules) -> Self {
        let mut tpdos = Vec::new();
        for tpdo in (0..).take(TPDO_MAX).filter_map(|number| Tpdo::new(number, values, rules)) {
            let _ = tpdos.push(tpdo);
        }
        Self { tpdos, watched: Span::EMPTY, due_at: Deadline::NEVER }
    }

    /// The node is Operational. Those in progress go on.
    pub(crate) fn start(&mut self, now: Instant) {
        self.tpdos.iter_mut().for_each(|tpdo| tpdo.start(now));
        self.watch();
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        self.watch();
    }

    /// Takes the PDO over again that the object with `index` describes. One that is to begin anew
    /// stands still until [`Self::start`]. Whether it then listens to other remote frames.
    pub(crate) fn reread<const LEN: usize>(
        &mut self,
        now: Instant,
        index: u16,
        values: &Values<LEN>,
        rules: &PdoRules,
    ) -> bool {
        let mut moved = false;
        for tpdo in self.tpdos.iter_mut().filter(|tpdo| tpdo.is_described_by(index)) {
            let before = tpdo.remote_id();
            tpdo.reread(now, values, rules);
            moved |= before != tpdo.remote_id();
        }
        self.watch();
        moved
    }

    /// The identifiers of the remote frames they answer.
    pub(crate) fn remote_ids(&self) -> impl Iterator<Item = CanId> {
        self.tpdos.iter().filter_map(Tpdo::remote_id)
    }

    /// Whether frames with this identifier are their own.
    pub(crate) fn send(&self, id: CanId) -> bool {
        self.tpdos.iter().any(|tpdo| tpdo.sends(id))
    }

    /// Whether frames with this identifier are their own and go out with a SYNC.
    pub(crate) fn send_with_sync(&self, id: CanId) -> bool {
        self.tpdos.iter().any(|tpdo| tpdo.sends(id) && tpdo.follows_sync())
    }

    /// The value at `slot` changed. What that lets go out is due at once, or when the inhibit time
    /// ends.
    pub(crate) fn note_change(&mut self, slot: Slot) {
        if self.may_watch(Span::of(slot)) {
            self.tpdos.iter_mut().for_each(|tpdo| tpdo.note_change(slot));
            self.schedule();
        }
    }

    /// Whether a change at this slot may be an event.
    #[inline]
    pub(crate) fn may_follow(&self, slot: Slot) -> bool {
        self.may_watch(Span::of(slot))
    }

    /// Whether a change of one of these slots may be an event.
    pub(super) fn may_watch(&self, span: Span) -> bool {
        self.watched.meets(span)
    }

    /// The product has an event for the PDO 0x1800 + `number`.
    pub(crate) fn trigger(&mut self, number: u16) {
        self.tpdos.iter_mut().filter(|tpdo| tpdo.number() == number).for_each(Tpdo::trigger);
        self.schedule();
    }

    /// Takes a SYNC, with its counter if it has one.
    pub(crate) fn handle_sync<const LEN: usize>(
        &mut self,
        counter: Option<u8>,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        for tpdo in &mut self.tpdos {
            tpdo.handle_sync(counter, values, outbox);
        }
    }

    /// Takes a remote frame.
    pub(crate) fn handle_remote<const LEN: usize>(
        &mut self,
        now: Instant,
        id: CanId,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        for tpdo in self.tpdos.iter_mut().filter(|tpdo| tpdo.remote_id() == Some(id)) {
            if let Some(frame) = tpdo.handle_remote(now, values) {
                outbox.supersede(frame);
            }
        }
        self.schedule();
    }

    /// When the next one goes out.
    pub(crate) const fn due_at(&self) -> Deadline {
        self.due_at
    }

    /// Lets go out what is due.
    #[inline]
    pub(crate) fn transmit_due<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        if self.due_at.is_due(now) {
            self.transmit_all_due(now, values, outbox);
        }
    }

    #[inline(never)]
    fn transmit_all_due<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        for tpdo in self.tpdos.iter_mut().filter(|tpdo| tpdo.due_at().is_due(now)) {
            if let Some(frame) = tpdo.transmit(now, values) {
                outbox.supersede(frame);
            }
        }
        self.schedule();
    }

    fn watch(&mut self) {
        self.watched = self.tpdos.iter().map(Tpdo::watched).fold(Span::EMPTY, Span::join);
        self.schedule();
    }

    fn schedule(&mut self) {
        let due = self.tpdos.iter().map(Tpdo::due_at).min();
        self.due_at = due.unwrap_or(Deadline::NEVER);
    }
}
