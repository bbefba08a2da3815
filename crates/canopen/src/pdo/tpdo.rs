use object_dictionary::{ObjectId, Slot, Values};
use units::{Duration, Instant};

use super::mapping::Mapping;
use super::transmission::Transmission;
use crate::cob_id::CobId;
use crate::frame::{CanId, Frame};
use crate::settings::Settings;

/// Transmit PDOs of a device.
pub(crate) const TPDO_MAX: usize = 4;

/// A transmit PDO (CiA 301, section 7.2.2; objects 0x1800 and 0x1A00 and following).
///
/// One that follows changes goes out once when the node becomes Operational, or when it is itself
/// switched on there, so that masters know the data from the start. Then every change goes out; one
/// inside the inhibit time goes out when that ends, with the data of that moment. The event timer
/// counts from the start; the inhibit time holds it back as well. SYNC-driven ones count from
/// becoming Operational and know no inhibit time.
#[derive(Debug)]
pub(crate) struct Tpdo {
    number: u16,
    parameters: Parameters,
    mapping: Mapping,
    inhibited_until: Instant,
    /// Only while the node is Operational and the PDO switched on.
    progress: Option<Progress>,
}

/// The communication parameter as the stack uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Parameters {
    id: Option<CanId>,
    transmission: Transmission,
    inhibit_time: Duration,
    event_time: Duration,
}

#[derive(Clone, Copy, Debug)]
struct Progress {
    changed_at: Option<Instant>,
    timer_at: Option<Instant>,
    syncs: u8,
}

impl Tpdo {
    /// The PDO 0x1800 + `number`. `None` when the product does not have it.
    pub(crate) fn new<const LEN: usize>(
        number: u16,
        values: &Values<LEN>,
        settings: &Settings,
    ) -> Option<Self> {
        let parameters = Parameters::read(number, values, settings)?;
        Some(Self {
            number,
            parameters,
            mapping: Mapping::read(values, MAPPING + number),
            inhibited_until: Instant::ZERO,
            progress: None,
        })
    }

    /// Whether `index` is its communication parameter.
    pub(crate) const fn is_described_by(&self, index: u16) -> bool {
        index == COMMUNICATION + self.number
    }

    /// Whether frames with this identifier are its own.
    pub(crate) fn sends(&self, id: CanId) -> bool {
        self.parameters.id == Some(id)
    }

    /// Takes the communication parameter over again. A PDO in progress goes on; one that now has
    /// another identifier or type begins anew.
    pub(crate) fn reread<const LEN: usize>(
        &mut self,
        now: Instant,
        running: bool,
        values: &Values<LEN>,
        settings: &Settings,
    ) {
        let Some(parameters) = Parameters::read(self.number, values, settings) else { return };
        let before = core::mem::replace(&mut self.parameters, parameters);
        self.inhibited_until = self.inhibited_until.min(now + parameters.inhibit_time);
        if !running {
            return;
        }
        let same = (before.id, before.transmission) == (parameters.id, parameters.transmission);
        match &mut self.progress {
            Some(progress) if same => progress.timer_at = parameters.timer_from(now),
            Some(_) | None => self.start(now),
        }
    }

    /// The node became Operational.
    pub(crate) fn start(&mut self, now: Instant) {
        let on = self.parameters.id.is_some() && !self.mapping.is_empty();
        self.progress = on.then(|| Progress {
            changed_at: self.parameters.transmission.follows_changes().then_some(now),
            timer_at: self.parameters.timer_from(now),
            syncs: 0,
        });
    }

    /// The node is no longer Operational.
    pub(crate) fn stop(&mut self) {
        self.progress = None;
    }

    /// The value at `slot` changed.
    pub(crate) fn note_change(&mut self, now: Instant, slot: Slot) {
        if let Some(progress) = &mut self.progress
            && self.parameters.transmission.follows_changes()
            && self.mapping.carries(slot)
        {
            progress.changed_at.get_or_insert(now);
        }
    }

    /// Counts a SYNC. Whether the PDO goes out with it.
    pub(crate) fn handle_sync(&mut self) -> bool {
        let Transmission::Synchronous { every } = self.parameters.transmission else {
            return false;
        };
        let Some(progress) = &mut self.progress else { return false };
        progress.syncs = progress.syncs.saturating_add(1);
        let goes = progress.syncs >= every;
        if goes {
            progress.syncs = 0;
        }
        goes
    }

    /// When it goes out, as things stand.
    pub(crate) fn due_at(&self) -> Option<Instant> {
        let progress = self.progress?;
        let event_at = match (progress.changed_at, progress.timer_at) {
            (Some(changed_at), Some(timer_at)) => changed_at.min(timer_at),
            (event_at, None) | (None, event_at) => event_at?,
        };
        Some(event_at.max(self.inhibited_until))
    }

    /// The frame with the present values, counted as sent.
    pub(crate) fn transmit<const LEN: usize>(
        &mut self,
        now: Instant,
        values: &Values<LEN>,
    ) -> Option<Frame> {
        let (id, progress) = (self.parameters.id?, self.progress.as_mut()?);
        progress.changed_at = None;
        progress.timer_at = progress.timer_at.map(|timer_at| {
            let next_at = timer_at + self.parameters.event_time;
            if timer_at <= now && next_at > now {
                next_at
            } else {
                now + self.parameters.event_time
            }
        });
        self.inhibited_until = now + self.parameters.inhibit_time;
        Some(self.mapping.frame(id, values))
    }
}

const COMMUNICATION: u16 = 0x1800;
const MAPPING: u16 = 0x1A00;

impl Parameters {
    /// `None` when the product has no such PDO.
    fn read<const LEN: usize>(
        number: u16,
        values: &Values<LEN>,
        settings: &Settings,
    ) -> Option<Self> {
        let index = COMMUNICATION + number;
        let value = |sub| {
            let slot = values.dictionary().find(ObjectId { index, sub }).ok()?;
            Some(values.raw(slot))
        };
        Some(Self {
            id: CobId::from_raw(value(1)?).valid(),
            transmission: Transmission::new(value(2)?, settings),
            inhibit_time: settings.inhibit_unit * u64::from(value(3).unwrap_or(0)),
            event_time: Duration::from_millis(u64::from(value(5).unwrap_or(0))),
        })
    }

    /// When the event timer elapses if it starts now.
    fn timer_from(&self, now: Instant) -> Option<Instant> {
        let on = self.transmission.follows_timer() && self.event_time > Duration::ZERO;
        on.then(|| now + self.event_time)
    }
}
