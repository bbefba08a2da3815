use heapless::Vec;
use object_dictionary::Values;

use crate::cob_id::{NodeId, Service};
use crate::deadline::{Deadline, Moment, Span};
use crate::frame::CanId;
use crate::parameter::number;

/// Producers that a device can monitor. Further entries of 0x1016 are not acted on.
pub(crate) const CONSUMERS_MAX: usize = 8;

/// The object with one entry for each producer.
pub(crate) const CONSUMER_TIME: u16 = 0x1016;

/// The heartbeat consumers (CiA 301, section 7.2.8.2.2.1; object 0x1016).
///
/// Monitoring of a producer starts with its first message; its boot-up message is one. A producer
/// that was lost is not monitored until it is heard again. Writing an entry starts it anew.
#[derive(Debug)]
pub(crate) struct Consumers {
    /// Up to the last one that the device has.
    entries: Vec<Consumer, CONSUMERS_MAX, u8>,
}

#[derive(Clone, Copy, Debug)]
struct Consumer {
    /// Only while the producer is alive.
    expires_at: Deadline,
    time_ms: u16,
    /// `None` for an entry that is not used.
    producer: Option<NodeId>,
    is_lost: bool,
}

impl Consumers {
    /// Nothing is monitored.
    pub(crate) const fn off() -> Self {
        Self { entries: Vec::new() }
    }

    /// Takes an entry over. Whether another producer is listened to.
    pub(crate) fn reread<const LEN: usize>(&mut self, sub: u8, values: &Values<LEN>) -> bool {
        let unused = Consumer::new(None, 0);
        while self.entries.len() < usize::from(sub) && self.entries.push(unused).is_ok() {}
        let place = usize::from(sub).checked_sub(1);
        let Some(entry) = place.and_then(|place| self.entries.get_mut(place)) else { return false };
        let (producer, time_ms) = match monitored(number(values, CONSUMER_TIME, sub)) {
            Some((producer, time_ms)) => (Some(producer), time_ms),
            None => (None, 0),
        };
        core::mem::replace(entry, Consumer::new(producer, time_ms)).producer != producer
    }

    /// The identifiers of the producers.
    pub(crate) fn ids(&self) -> impl Iterator<Item = CanId> {
        let producers = self.entries.iter().filter_map(|entry| entry.producer);
        producers.map(|producer| Service::ErrorControl.id(producer))
    }

    /// Takes a message with an identifier of the error control. Comes back with a producer that had
    /// been lost.
    pub(crate) fn handle(&mut self, now: Moment, id: CanId) -> Option<NodeId> {
        let is_of = |producer| Service::ErrorControl.id(producer) == id;
        let consumer =
            self.entries.iter_mut().find(|consumer| consumer.producer.is_some_and(is_of))?;
        let time = Span::from_millis(consumer.time_ms.into());
        consumer.expires_at = Deadline::after(now, time);
        core::mem::take(&mut consumer.is_lost).then_some(consumer.producer).flatten()
    }

    /// When the next producer counts as lost.
    pub(crate) fn due_at(&self, now: Moment) -> Deadline {
        let expiries = self.entries.iter().map(|consumer| consumer.expires_at);
        expiries.fold(Deadline::NEVER, |first, next| first.or_earlier(next, now))
    }

    /// A producer that is lost from now on.
    pub(crate) fn take_due(&mut self, now: Moment) -> Option<NodeId> {
        let consumer = self
            .entries
            .iter_mut()
            .find_map(|consumer| consumer.expires_at.take_due(now).then_some(consumer))?;
        consumer.is_lost = true;
        consumer.producer
    }

    /// Whether the value `raw` of an entry would monitor a producer that another one monitors already.
    pub(crate) fn is_doubled(&self, sub: u8, raw: u32) -> bool {
        let Some((producer, _)) = monitored(raw) else { return false };
        let mut numbered = (1..).zip(&self.entries);
        numbered.any(|(number, entry)| number != sub && entry.producer == Some(producer))
    }

    /// Whether a producer is lost.
    pub(crate) fn is_any_lost(&self) -> bool {
        self.entries.iter().any(|consumer| consumer.is_lost)
    }
}

impl Consumer {
    const fn new(producer: Option<NodeId>, time_ms: u16) -> Self {
        Self { expires_at: Deadline::NEVER, time_ms, producer, is_lost: false }
    }
}

/// Node-ID and milliseconds of an entry. `None` for an entry that is not used.
fn monitored(raw: u32) -> Option<(NodeId, u16)> {
    let [low, high, node_id, _] = raw.to_le_bytes();
    let time_ms = u16::from_le_bytes([low, high]);
    let producer = NodeId::new(node_id)?;
    (time_ms > 0).then_some((producer, time_ms))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x HB-02.
    #[test]
    fn an_entry_without_node_id_or_time_is_not_used() {
        let used = |raw| monitored(raw).map(|(producer, time_ms)| (producer.get(), time_ms));
        for (raw, expected) in [
            (0x0001_0064, Some((1, 100))),
            (0x007F_FFFF, Some((127, 65_535))),
            (0xFF05_0001, Some((5, 1))),
            (0x0000_0064, None),
            (0x0080_0064, None),
            (0x0001_0000, None),
            (0, None),
        ] {
            assert_eq!(used(raw), expected, "{raw:#010x}");
        }
    }
}
