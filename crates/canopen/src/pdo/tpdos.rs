use heapless::Vec;
use object_dictionary::{Slot, Values};

use super::communication::Communication;
use super::slots::Slots;
use super::tpdo::Tpdo;
use super::{MAPPING, PDO_MAX, TRANSMIT};
use crate::deadline::{Deadline, Moment};
use crate::frame::CanId;
use crate::outbox::Outbox;
use crate::settings::PdoRules;

/// The transmit PDOs of a device, each at the place that its number says.
#[derive(Debug, Default)]
pub(crate) struct Tpdos {
    tpdos: Vec<Tpdo, PDO_MAX, u8>,
    /// All slots whose changes are events; others need no search.
    watched: Slots,
}

impl Tpdos {
    /// The node is Operational. Those in progress go on.
    pub(crate) fn start(&mut self, now: Moment) {
        self.tpdos.iter_mut().for_each(|tpdo| tpdo.start(now));
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.tpdos.iter_mut().for_each(Tpdo::stop);
    }

    /// Takes the PDO over that the object with `index` describes, if the product has it. One that
    /// is to begin anew stands still until [`Self::start`]. Whether it then listens to other remote
    /// frames.
    pub(crate) fn reread<const LEN: usize>(
        &mut self,
        now: Moment,
        index: u16,
        values: &Values<LEN>,
        rules: &PdoRules,
    ) -> bool {
        let number = index % MAPPING;
        let communication = Communication::read(values, TRANSMIT + number);
        let Some(communication) = communication else { return false };
        while self.tpdos.len() <= number.into() && self.tpdos.push(Tpdo::off()).is_ok() {}
        let Some(tpdo) = self.tpdos.get_mut(usize::from(number)) else { return false };
        let before = tpdo.remote_id();
        tpdo.reread(now, index, values, &communication, rules);
        let moved = before != tpdo.remote_id();
        self.watched = self.tpdos.iter().map(Tpdo::watched).fold(Slots::EMPTY, Slots::join);
        moved
    }

    /// The identifiers of the remote frames they answer.
    pub(crate) fn remote_ids(&self) -> impl Iterator<Item = CanId> {
        self.tpdos.iter().map(Tpdo::remote_id).filter(|&id| id != CanId::NONE)
    }

    /// Whether frames with this identifier are their own.
    pub(crate) fn send(&self, id: CanId) -> bool {
        self.tpdos.iter().any(|tpdo| tpdo.id() == id)
    }

    /// Whether frames with this identifier are their own and go out with a SYNC.
    pub(crate) fn send_with_sync(&self, id: CanId) -> bool {
        self.tpdos.iter().any(|tpdo| tpdo.id() == id && tpdo.follows_sync())
    }

    /// The value at `slot` changed. What that lets go out is due at once, or when the inhibit time
    /// ends.
    pub(crate) fn note_change(&mut self, slot: Slot) {
        self.tpdos.iter_mut().for_each(|tpdo| tpdo.note_change(slot));
    }

    /// Whether a change at this slot may be an event.
    #[inline]
    pub(crate) fn may_follow(&self, slot: Slot) -> bool {
        self.may_watch(Slots::of(slot))
    }

    /// Whether a change of one of these slots may be an event.
    pub(super) const fn may_watch(&self, slots: Slots) -> bool {
        self.watched.meets(slots)
    }

    /// The product has an event for the PDO 0x1800 + `number`.
    pub(crate) fn trigger(&mut self, number: u16) {
        if let Some(tpdo) = self.tpdos.get_mut(usize::from(number)) {
            tpdo.trigger();
        }
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
        now: Moment,
        id: CanId,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        for tpdo in self.tpdos.iter_mut().filter(|tpdo| tpdo.remote_id() == id) {
            tpdo.handle_remote(now, values, outbox);
        }
    }

    /// When the next one goes out, or its inhibit time ends.
    #[inline(never)]
    pub(crate) fn due_at(&self, now: Moment) -> Deadline {
        let due = self.tpdos.iter().map(|tpdo| tpdo.due_at(now));
        due.fold(Deadline::NEVER, |first, next| first.or_earlier(next, now))
    }

    /// Lets go out what is due.
    pub(crate) fn transmit_due<const LEN: usize>(
        &mut self,
        now: Moment,
        values: &Values<LEN>,
        outbox: &mut Outbox,
    ) {
        for tpdo in &mut self.tpdos {
            if tpdo.take_due(now) {
                tpdo.transmit(now, values, outbox);
            }
        }
    }
}
