//! The application controller's end of the internal link (manual 3.7.1; NM17x LINK-01, LINK-02,
//! LINK-07, A-46, A-48).
//!
//! This end is the clock. In every cycle it sends process data, or a greeting while it is out of
//! service, and takes at most one message back. A write or an urgent order that comes a second time
//! carries the same number and is acknowledged again, not executed again. The numbers start anew
//! with a new nonce of the other side.
//!
//! Out of service a greeting is answered by the next cycle's only, so that two sides that do not
//! fit cannot keep the line busy with greetings.

use object_dictionary::ObjectId;
use shared_proto::limits::LOST_AFTER_MS;
use shared_proto::{
    Hello, PROTOCOL, ProcessData, Receiver, Supervision, ToApplication, ToInterface, Urgency,
};
use units::{Duration, Instant};

use crate::parameters::{Parameters, Run};

const LOST_AFTER: Duration = Duration::from_millis(LOST_AFTER_MS);
/// In every cycle of this number a few values are sent unasked, one row after the other. Whatever
/// was lost on the line, the copy of the other controller is true again after a round.
const REFRESH_CYCLES: u8 = 8;

/// What the other controller wants done. It is acknowledged with the next process data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Write a value to an object.
    Write(ObjectId, u32),
    /// Stop everything that moves.
    Stop(Urgency),
    /// The other controller has restarted: what it wanted shown is over (NM17x ADDR-10, DISP-19).
    StartAnew,
}

/// Whether the two controllers work together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Service {
    /// They have not met, or lost each other.
    Out,
    /// They do.
    In,
    /// The other image is not made for this one.
    Mismatched,
}

/// What the process data say of the axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Report {
    /// Object 0x6004.
    pub(crate) position_hundredths_mm: i32,
    /// Object 0x204E:01.
    pub(crate) status: u16,
    /// Object 0x204E:02.
    pub(crate) errors: u16,
}

/// This end of the line.
#[derive(Debug)]
pub(crate) struct Link {
    own: Hello,
    receiver: Receiver<ToApplication>,
    service: Service,
    partner_firmware: Option<u16>,
    supervision: Option<Supervision>,
    heard_at: Instant,
    cycle: u8,
    acknowledged: u8,
    urgent_acknowledged: u8,
    cycle_due: bool,
    values_due: bool,
    answer_due: bool,
    /// Values from this position of the dictionary on are wanted.
    wanted_from: Option<u16>,
    /// Where the round of values that nobody asked for goes on.
    refresh_from: u16,
}

impl Link {
    /// A link that has met nobody. `own` is what it says of itself; `heard` and `in_service` are
    /// filled in.
    pub(crate) fn new(own: Hello) -> Self {
        Self {
            own: Hello { protocol: PROTOCOL, heard: 0, in_service: false, ..own },
            receiver: Receiver::default(),
            service: Service::Out,
            partner_firmware: None,
            supervision: None,
            heard_at: Instant::ZERO,
            cycle: 0,
            acknowledged: 0,
            urgent_acknowledged: 0,
            cycle_due: false,
            values_due: false,
            answer_due: false,
            wanted_from: None,
            refresh_from: 0,
        }
    }

    /// Takes a byte of the line. The order in it is to be executed before the next byte.
    pub(crate) fn handle_byte(&mut self, now: Instant, byte: u8) -> Option<Order> {
        let message = self.receiver.push(byte)?;
        self.heard_at = now;
        match message {
            ToApplication::Hello(hello) => self.handle_hello(&hello),
            ToApplication::Idle(supervision) => {
                self.supervise(supervision)?;
                None
            }
            ToApplication::Write(supervision, write) => {
                self.supervise(supervision)?;
                let id = ObjectId { index: write.index, sub: write.sub };
                is_new(&mut self.acknowledged, write.sequence)
                    .then_some(Order::Write(id, write.value))
            }
            ToApplication::RequestSnapshot { supervision, from } => {
                self.supervise(supervision)?;
                self.wanted_from = Some(from);
                None
            }
            ToApplication::Urgent(supervision, urgent) => {
                self.supervise(supervision)?;
                is_new(&mut self.urgent_acknowledged, urgent.number)
                    .then_some(Order::Stop(urgent.urgency))
            }
        }
    }

    /// Notices that the other side is lost. Says whether it happened just now.
    pub(crate) fn handle_time(&mut self, now: Instant) -> bool {
        let lost = self.in_service() && now.since(self.heard_at) >= LOST_AFTER;
        if lost {
            self.service = Service::Out;
        }
        lost
    }

    /// Starts a cycle.
    pub(crate) fn start_cycle(&mut self) {
        self.cycle_due = true;
    }

    /// Lets values be sent; once in a cycle.
    pub(crate) fn offer_values(&mut self) {
        self.values_due = true;
    }

    /// The greeting to send now: an answer to one, or in the place of process data.
    pub(crate) fn poll_greeting(&mut self) -> Option<Hello> {
        let due = core::mem::take(&mut self.answer_due)
            || !self.in_service() && core::mem::take(&mut self.cycle_due);
        due.then(|| Hello { in_service: self.in_service(), ..self.own })
    }

    /// Whether it is time for [`Self::process`]; once in a cycle.
    pub(crate) fn take_process_due(&mut self) -> bool {
        core::mem::take(&mut self.cycle_due)
    }

    /// The process data of this cycle.
    pub(crate) fn process(&mut self, report: Report) -> ToInterface {
        self.cycle = self.cycle.wrapping_add(1);
        ToInterface::Process(ProcessData {
            cycle: self.cycle,
            acknowledged: self.acknowledged,
            urgent_acknowledged: self.urgent_acknowledged,
            position_hundredths_mm: report.position_hundredths_mm,
            status: report.status,
            errors: report.errors,
        })
    }

    /// Once in a cycle: that the offer of this number was touched, else values that were asked for,
    /// else values to tell, else now and then some of the round.
    pub(crate) fn poll_values(
        &mut self,
        touched: Option<u8>,
        parameters: &mut Parameters,
    ) -> Option<ToInterface> {
        if !core::mem::take(&mut self.values_due) || !self.in_service() {
            return None;
        }
        if let Some(offer) = touched {
            return Some(ToInterface::Touched { offer });
        }
        let (from, values) = self
            .wanted(parameters)
            .or_else(|| parameters.poll_tell())
            .or_else(|| self.refresh(parameters))?;
        Some(ToInterface::Snapshot { from, values })
    }

    /// Whether the two controllers work together.
    pub(crate) fn in_service(&self) -> bool {
        self.service == Service::In
    }

    /// Whether the other image is not made for this one.
    pub(crate) fn mismatched(&self) -> bool {
        self.service == Service::Mismatched
    }

    /// Firmware version of the other controller in hundredths, once it greeted.
    pub(crate) fn partner_firmware(&self) -> Option<u16> {
        self.partner_firmware
    }

    /// Node-ID in use, once the other controller said it.
    pub(crate) fn node_id(&self) -> Option<u8> {
        self.supervision.map(|supervision| supervision.node_id)
    }

    fn handle_hello(&mut self, hello: &Hello) -> Option<Order> {
        let restarted = self.own.heard != hello.nonce;
        if restarted {
            self.own.heard = hello.nonce;
            self.service = Service::Out;
            self.acknowledged = 0;
            self.urgent_acknowledged = 0;
            self.wanted_from = None;
        }
        self.partner_firmware = Some(hello.firmware);
        if !self.own.fits(hello) {
            self.service = Service::Mismatched;
        } else if hello.heard == self.own.nonce {
            self.service = Service::In;
        } else if self.mismatched() {
            self.service = Service::Out;
        }
        self.answer_due |= self.in_service() && !hello.in_service;
        restarted.then_some(Order::StartAnew)
    }

    /// Takes over what every message but a greeting says. `None` out of service, where they are not
    /// listened to.
    fn supervise(&mut self, supervision: Supervision) -> Option<()> {
        self.in_service().then(|| self.supervision = Some(supervision))
    }

    fn wanted(&mut self, parameters: &Parameters) -> Option<(u16, Run)> {
        let from = self.wanted_from.take()?;
        let values = parameters.run(from);
        let len = u16::try_from(values.len()).ok().filter(|len| *len > 0)?;
        self.wanted_from = from.checked_add(len);
        Some((from, values))
    }

    fn refresh(&mut self, parameters: &Parameters) -> Option<(u16, Run)> {
        if !self.cycle.is_multiple_of(REFRESH_CYCLES) {
            return None;
        }
        let rows = parameters.own_rows();
        let from = if rows.contains(&self.refresh_from) { self.refresh_from } else { rows.start };
        let values = parameters.run(from);
        let len = u16::try_from(values.len()).unwrap_or(u16::MAX);
        self.refresh_from = from.saturating_add(len);
        Some((from, values))
    }
}

/// Whether a number is not the one of the last time; remembers it. 0 is no number.
fn is_new(last: &mut u8, number: u8) -> bool {
    let is_new = number != 0 && number != *last;
    if is_new {
        *last = number;
    }
    is_new
}
