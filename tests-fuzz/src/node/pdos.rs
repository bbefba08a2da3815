//! What transmit PDOs carry, and when they go out.

use canopen::{Frame, State, Trigger};
use object_dictionary::ObjectId;
use units::{Duration, Instant};

use super::{Cycle, PDO_MAX, Watch, valid};

/// The transmission type of a PDO that is sent on request, with what was true at the last SYNC.
const SAMPLED_AT_SYNC: u32 = 252;

/// When a transmit PDO went out.
#[derive(Clone, Copy)]
pub(super) struct PdoTimes {
    /// `None` when it may have gone out at another time, or had another inhibit time.
    pub(super) sent: Option<Instant>,
    pub(super) events: Cycle,
}

impl PdoTimes {
    pub(super) const UNKNOWN: Self =
        Self { sent: None, events: Cycle { period: None, since: Instant::ZERO } };
}

impl<const LEN: usize> Watch<LEN> {
    /// A process data object has the values of what it maps.
    pub(super) fn check_pdo(&self, frame: &Frame) {
        assert_eq!(self.state, State::Operational, "{frame:02X?}");
        let value = |index, sub| self.value(ObjectId { index, sub });
        let fits = |number| {
            let data = self.mapped(0x1A00 + number);
            let is_older = value(0x1800 + number, 2) == Some(SAMPLED_AT_SYNC);
            data == frame.data() || is_older && data.len() == frame.data().len()
        };
        assert!(self.pdos_with(frame.id().get()).any(fits), "{frame:02X?}");
    }

    /// The transmit PDOs with this identifier.
    fn pdos_with(&self, id: u16) -> impl Iterator<Item = u16> {
        (0..PDO_MAX as u16).filter(move |&number| self.pdo_id(number) == Some(id))
    }

    fn pdo_id(&self, number: u16) -> Option<u16> {
        self.value(ObjectId { index: 0x1800 + number, sub: 1 }).and_then(valid)
    }

    /// What starts a PDO of types 254 and 255.
    fn trigger(&self, number: u16) -> Option<Trigger> {
        match self.value(ObjectId { index: 0x1800 + number, sub: 2 })? {
            254 => Some(self.subject.settings.pdo.type_254),
            255 => Some(self.subject.settings.pdo.type_255),
            _ => None,
        }
    }

    fn inhibit_time(&self, number: u16) -> Duration {
        let steps = self.value(ObjectId { index: 0x1800 + number, sub: 3 }).unwrap_or(0);
        let unit = self.subject.settings.pdo.inhibit_unit;
        Duration::from_micros(unit.as_micros() * u64::from(steps))
    }

    /// Two events are no nearer to each other than the inhibit time.
    pub(super) fn check_inhibit_time(&mut self, frame: &Frame) {
        let numbers: Vec<_> = self.pdos_with(frame.id().get()).collect();
        for &number in &numbers {
            let (inhibit_time, is_event) =
                (self.inhibit_time(number), self.trigger(number).is_some());
            let times = &mut self.pdos[usize::from(number)];
            times.events.since = self.now;
            let before = times.sent.replace(self.now);
            let is_alone = numbers.len() == 1 && is_event && !self.is_remote;
            if let Some(before) = before.filter(|_| is_alone) {
                assert!(self.now.since(before) >= inhibit_time, "too early: {frame:02X?}");
            }
        }
    }

    /// How long a PDO takes at most that goes out on its event timer: an inhibit time may hold it
    /// back.
    pub(super) fn event_period(&self, number: u16) -> Option<Duration> {
        let id = self.pdo_id(number)?;
        let event_ms = self.value(ObjectId { index: 0x1800 + number, sub: 5 })?;
        let is_sent = event_ms > 0
            && self.state == State::Operational
            && !self.mapped(0x1A00 + number).is_empty();
        let is_known = !self.is_emergency(id) && !self.is_sync(id);
        let follows_timer = match self.trigger(number)? {
            Trigger::Timer | Trigger::ChangeOrTimer => true,
            Trigger::Change => false,
        };
        let inhibit_time = self.inhibit_time(number);
        let period = Duration::from_micros(u64::from(event_ms) * 1_000 + inhibit_time.as_micros());
        (is_sent && is_known && follows_timer).then_some(period)
    }

    /// The data of the PDO with this mapping: the values up to the first entry that is not of whole
    /// bytes, without those that do not fit.
    fn mapped(&self, index: u16) -> Vec<u8> {
        let value = |sub| self.value(ObjectId { index, sub });
        let count = value(0).filter(|&count| count <= 8).unwrap_or(0);
        let mut data = Vec::new();
        let mut end = 0;
        for entry in (1..=count as u8).map_while(value) {
            let [bits, sub, low, high] = entry.to_le_bytes();
            if bits == 0 || bits % 8 != 0 {
                break;
            }
            let object = ObjectId { index: u16::from_le_bytes([low, high]), sub };
            let mut bytes = self.value(object).unwrap_or(0).to_le_bytes().to_vec();
            bytes.resize(usize::from(bits / 8), 0);
            end += bytes.len();
            if end <= 8 {
                data.extend(bytes);
            }
        }
        data
    }
}
