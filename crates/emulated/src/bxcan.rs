//! The CAN controller of the STM32F429, bxCAN (RM0090, chapter 32), on the bench's bus.
//!
//! CAN1 alone: the second controller shares the filter banks and is not used. Time-triggered mode
//! is not modelled, time stamps read 0, the debug freeze has no effect.
//!
//! The model lives on two clocks. Registers and interrupts are the emulated processor's, access by
//! access. The wire is the bus's: at every boundary between two quanta the engine fetches
//! [`BxCan::requests`], lets the bus resolve, and gives [`BxCan::deliver`] what came of it.

mod fifo;
mod filters;
mod mailbox;
mod registers;

use std::collections::VecDeque;

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::Layout;
use rigless::soc::stm32f427::generated::can1::Register;
use rigless::time::{EventId, VirtualNanos};
use world::can::{
    Activity, BitTime, Confinement, Delivery, ErrorCounters, MAILBOXES, Nanos, Outcome, PortState,
    Presence, RecessiveWait, SendOrder, What, Wire, WireError,
};

use self::fifo::{Fifo, WhenFull};
use self::filters::{FilterRegister, Filters};
use self::mailbox::{Mailbox, Part};
use self::registers::{btr, esr, ier, mcr, msr, rfr, tsr};

/// Receive FIFOs.
const FIFOS: usize = 2;
/// Interrupt lines, in the order of the part's table: transmit, FIFO 0, FIFO 1, status change.
const LINES: usize = 4;
/// The internal clock the part starts on, before anybody tells a rate.
const HSI_HZ: u64 = 16_000_000;
/// An error counter from here on sets the warning flag.
const WARNING: u16 = 96;
/// What the 8 bits of TEC show of a controller that went off the bus: the last value that fits.
const TEC_AT_BUS_OFF: u16 = 0xF8;
/// Bits TSR has for each mailbox.
const TSR_STRIDE: usize = 8;

/// How often the controller asserted its interrupt lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InterruptCounts {
    /// A mailbox became empty.
    pub transmit: u64,
    /// A frame in FIFO 0 or 1, or one of them full or overrun.
    pub receive: [u64; 2],
    /// Errors, wake-up, sleep.
    pub status: u64,
}

impl InterruptCounts {
    /// All lines together.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.transmit + self.receive.iter().sum::<u64>() + self.status
    }
}

/// Where the controller is between its three modes (RM0090, 32.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    /// SLAK is set.
    Sleep,
    /// INAK is set.
    Initialisation,
    /// On the way to normal mode: 11 recessive bits are due.
    Joining { from: Acknowledge, wait: RecessiveWait },
    /// Normal mode.
    Normal { since: Nanos },
}

/// The acknowledge bit that stays set while the controller waits for the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Acknowledge {
    Sleep,
    Initialisation,
}

/// The mode the software asks for by INRQ and SLEEP.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wanted {
    Sleep,
    Initialisation,
    Normal,
    /// Both bits: nothing changes.
    Undecided,
}

/// The controller CAN1.
#[derive(Debug)]
pub struct BxCan {
    pclk_hz: u64,
    control: u32,
    timing: u32,
    enabled: u32,
    mode: Mode,
    filters: Filters,
    mailboxes: [Mailbox; MAILBOXES],
    fifos: [Fifo; FIFOS],
    counters: ErrorCounters,
    recovery: Option<RecessiveWait>,
    last_error: u32,
    error_pending: bool,
    wake_up_pending: bool,
    sleep_pending: bool,
    line: Activity,
    sending: Option<usize>,
    internal: Option<(Nanos, usize)>,
    outcomes: VecDeque<Outcome>,
    levels: [Level; LINES],
    asserted: InterruptCounts,
    received_at: Option<Nanos>,
    reaction: Nanos,
    /// Since when frames wait that the software has not looked at, by FIFO.
    unseen_since: [Option<Nanos>; FIFOS],
    longest_wait: Nanos,
}

impl Default for BxCan {
    fn default() -> Self {
        Self::new()
    }
}

impl BxCan {
    /// The controller as a reset leaves it: asleep.
    #[must_use]
    pub fn new() -> Self {
        Self {
            pclk_hz: HSI_HZ,
            control: mcr::AFTER_RESET,
            timing: btr::AFTER_RESET,
            enabled: 0,
            mode: Mode::Sleep,
            filters: Filters::new(),
            mailboxes: [Mailbox::default(); MAILBOXES],
            fifos: [Fifo::default(), Fifo::default()],
            counters: ErrorCounters::NONE,
            recovery: None,
            last_error: 0,
            error_pending: false,
            wake_up_pending: false,
            sleep_pending: false,
            line: Activity { start: Nanos::ZERO, quiet_from: Nanos::ZERO, free_at: Nanos::ZERO },
            sending: None,
            internal: None,
            outcomes: VecDeque::new(),
            levels: [Level::Low; LINES],
            asserted: InterruptCounts::default(),
            received_at: None,
            reaction: Nanos::ZERO,
            unseen_since: [None; FIFOS],
            longest_wait: Nanos::ZERO,
        }
    }

    /// What the controller wants from the bus, as of the boundary the engine has reached.
    #[must_use]
    pub fn requests(&self) -> PortState {
        let off = self.counters.confinement() == Confinement::BusOff;
        let (presence, since) = match self.mode {
            Mode::Normal { since } if !off => (self.presence(), since),
            Mode::Normal { .. } | Mode::Sleep | Mode::Initialisation | Mode::Joining { .. } => {
                (Presence::Off, Nanos::ZERO)
            }
        };
        PortState {
            presence,
            bit: self.bit(),
            since,
            counters: self.counters,
            order: self.order(),
            requests: self.mailboxes.map(|mailbox| mailbox.request()),
            waits: self.wants_to_leave()
                || self.mailboxes.iter().any(|mailbox| mailbox.is_withdrawn()),
        }
    }

    /// Takes what the bus made of it, at that boundary. The context is the controller's own for that
    /// instant, as rigless's `Bus::drive` hands it out.
    pub fn deliver(&mut self, delivery: &Delivery, context: &mut DeviceContext<'_>) {
        self.sending = delivery.sending.or(self.sending);
        if let Some(activity) = delivery.activity {
            self.line = activity;
            if let Mode::Joining { wait, .. } = &mut self.mode {
                wait.interrupted(&activity);
            }
            if let Some(wait) = &mut self.recovery {
                wait.interrupted(&activity);
            }
            if self.mode == Mode::Sleep {
                self.wake_up_pending = true;
                if self.control & mcr::AWUM != 0 {
                    self.control &= !mcr::SLEEP;
                }
            }
        }
        self.outcomes.extend(&delivery.outcomes);
        let under_way = [self.sending, self.internal.map(|(_, n)| n)];
        for (n, mailbox) in self.mailboxes.iter_mut().enumerate() {
            if mailbox.is_withdrawn() && !under_way.contains(&Some(n)) {
                mailbox.complete(0);
            }
        }
        let now = now(context);
        self.leave_if_asked(now);
        self.catch_up(context);
    }

    /// How often the interrupt lines were asserted since power-on. A reset keeps the count.
    #[must_use]
    pub const fn interrupts(&self) -> InterruptCounts {
        self.asserted
    }

    /// Whether the software takes part in the bus.
    #[must_use]
    pub const fn is_on_the_bus(&self) -> bool {
        self.is_normal()
    }

    /// From the interrupt of the last received frame to the first request for a transmission behind
    /// it.
    #[must_use]
    pub const fn reaction(&self) -> Nanos {
        self.reaction
    }

    /// The longest that a received frame waited for the software to look at its FIFO.
    #[must_use]
    pub const fn longest_wait(&self) -> Nanos {
        self.longest_wait
    }

    /// The bit time set in BTR.
    #[must_use]
    pub fn bit(&self) -> BitTime {
        let prescaler = (self.timing & btr::BRP_MASK) + 1;
        let first = (self.timing >> btr::TS1 & btr::TS1_MASK) + 1;
        let second = (self.timing >> btr::TS2 & btr::TS2_MASK) + 1;
        BitTime::from_cycles(prescaler * (1 + first + second), self.pclk_hz)
    }

    const fn presence(&self) -> Presence {
        match (self.timing & btr::LBKM != 0, self.timing & btr::SILM != 0) {
            (false, false) => Presence::Normal,
            (false, true) => Presence::Silent,
            (true, false) => Presence::LoopBack,
            (true, true) => Presence::Off,
        }
    }

    const fn order(&self) -> SendOrder {
        if self.control & mcr::TXFP == 0 { SendOrder::Identifier } else { SendOrder::Request }
    }

    const fn is_normal(&self) -> bool {
        matches!(self.mode, Mode::Normal { .. })
    }

    const fn wanted(&self) -> Wanted {
        match (self.control & mcr::INRQ != 0, self.control & mcr::SLEEP != 0) {
            (true, false) => Wanted::Initialisation,
            (false, true) => Wanted::Sleep,
            (false, false) => Wanted::Normal,
            (true, true) => Wanted::Undecided,
        }
    }

    /// Moves to the mode the software asks for, as far as that needs no look at the bus.
    fn change_mode(&mut self, now: Nanos) {
        let from = match (self.mode, self.wanted()) {
            (_, Wanted::Undecided)
            | (Mode::Normal { .. } | Mode::Joining { .. }, Wanted::Normal)
            | (Mode::Sleep, Wanted::Sleep)
            | (Mode::Initialisation, Wanted::Initialisation) => return,
            // On the bus: the frame under way comes first, and only a boundary knows of it.
            (Mode::Normal { .. }, Wanted::Sleep | Wanted::Initialisation) => {
                if self.counters.confinement() == Confinement::BusOff {
                    self.leave();
                }
                return;
            }
            (
                Mode::Sleep | Mode::Initialisation | Mode::Joining { .. },
                Wanted::Sleep | Wanted::Initialisation,
            ) => return self.leave(),
            (Mode::Sleep, Wanted::Normal) => Acknowledge::Sleep,
            (Mode::Initialisation, Wanted::Normal) => Acknowledge::Initialisation,
        };
        let run_from = now.max(self.line.quiet_from);
        let wait = RecessiveWait::new(RecessiveWait::TO_JOIN, run_from, self.bit());
        self.mode = Mode::Joining { from, wait };
    }

    /// Leaves the bus if the software wants that and no frame is under way: certain at a boundary,
    /// and at the very instant the bus becomes free.
    fn leave_if_asked(&mut self, now: Nanos) {
        let over = now >= self.line.free_at && self.sending.is_none() && self.internal.is_none();
        if self.wants_to_leave() && over {
            self.leave();
        }
    }

    /// Whether the software wants another mode than the normal one it is in.
    const fn wants_to_leave(&self) -> bool {
        self.is_normal() && matches!(self.wanted(), Wanted::Sleep | Wanted::Initialisation)
    }

    fn leave(&mut self) {
        match self.wanted() {
            Wanted::Sleep => {
                self.mode = Mode::Sleep;
                self.sleep_pending = self.enabled & ier::SLKIE != 0;
            }
            Wanted::Initialisation => {
                self.mode = Mode::Initialisation;
                self.sleep_pending = false;
            }
            Wanted::Normal | Wanted::Undecided => {}
        }
        self.recovery = None;
    }

    /// Starts waiting for the end of bus-off.
    fn start_recovery(&mut self, from: Nanos) {
        let run_from = from.max(self.line.quiet_from);
        let sequences = RecessiveWait::AFTER_BUS_OFF;
        self.recovery = Some(RecessiveWait::new(sequences, run_from, self.bit()));
    }

    /// Does everything whose instant has come, and sees to being called again.
    fn catch_up(&mut self, context: &mut DeviceContext<'_>) {
        let now = now(context);
        while let Some(outcome) = self.outcomes.pop_front_if(|outcome| outcome.at <= now) {
            self.handle(outcome);
        }
        if let Some((_, n)) = self.internal.take_if(|(end, _)| *end <= now) {
            self.counters = self.counters.transmitted();
            self.went_out(n, now);
        }
        if let Mode::Joining { wait, .. } = self.mode
            && wait.over_at() <= now
        {
            self.mode = Mode::Normal { since: wait.over_at() };
            self.sleep_pending = false;
            if self.counters.confinement() == Confinement::BusOff {
                self.start_recovery(wait.over_at());
            }
        }
        if let Some(wait) = self.recovery.take_if(|wait| wait.over_at() <= now) {
            self.counters = ErrorCounters::NONE;
            self.mode = Mode::Normal { since: wait.over_at() };
        }
        self.change_mode(now);
        if now == self.line.free_at {
            self.leave_if_asked(now);
        }
        self.start_internal(now);
        let leaving = self.wants_to_leave() && self.line.free_at > now;
        let joining = match self.mode {
            Mode::Joining { wait, .. } => Some(wait.over_at()),
            Mode::Sleep | Mode::Initialisation | Mode::Normal { .. } => None,
        };
        let next = [
            self.outcomes.front().map(|outcome| outcome.at),
            self.internal.map(|(end, _)| end),
            joining,
            self.recovery.map(|wait| wait.over_at()),
            leaving.then_some(self.line.free_at),
        ];
        if let Some(at) = next.into_iter().flatten().min() {
            context.schedule(VirtualNanos(at.0));
        }
        self.drive_lines(context);
    }

    fn handle(&mut self, outcome: Outcome) {
        let before = self.flags();
        self.counters = outcome.counters;
        match outcome.what {
            What::Received(frame) => {
                self.last_error = 0;
                self.store(frame, outcome.at);
            }
            What::Transmitted(n) => self.went_out(n, outcome.at),
            What::LostArbitration(n) => self.attempt_failed(n, tsr::ALST),
            What::TransmitFailed(n, error) => {
                self.sending = None;
                self.attempt_failed(n, tsr::TERR);
                self.last_error = error_code(error);
            }
            What::ReceiveFailed(error) => self.last_error = error_code(error),
        }
        let failed = match outcome.what {
            What::TransmitFailed(..) | What::ReceiveFailed(_) => true,
            What::Received(_) | What::Transmitted(_) | What::LostArbitration(_) => false,
        };
        let appeared = self.flags() & !before;
        self.error_pending |= [
            (ier::EWGIE, appeared & esr::EWGF != 0),
            (ier::EPVIE, appeared & esr::EPVF != 0),
            (ier::BOFIE, appeared & esr::BOFF != 0),
            (ier::LECIE, failed),
        ]
        .into_iter()
        .any(|(enable, happened)| happened && self.enabled & enable != 0);
        if appeared & esr::BOFF != 0 && self.control & mcr::ABOM != 0 {
            self.start_recovery(outcome.at);
        }
    }

    fn went_out(&mut self, n: usize, at: Nanos) {
        self.sending = None;
        self.last_error = 0;
        let Some(mailbox) = self.mailboxes.get_mut(n) else { return };
        let frame = mailbox.frame();
        mailbox.complete(tsr::TXOK);
        if self.timing & btr::LBKM != 0 {
            self.store(frame, at);
        }
    }

    fn attempt_failed(&mut self, n: usize, result: u32) {
        let once = self.control & mcr::NART != 0;
        let Some(mailbox) = self.mailboxes.get_mut(n) else { return };
        if mailbox.is_empty() {
            return;
        }
        if once || mailbox.is_withdrawn() {
            mailbox.complete(result);
        } else {
            mailbox.failed(result);
        }
    }

    fn store(&mut self, frame: world::can::Frame, at: Nanos) {
        let when_full =
            if self.control & mcr::RFLM == 0 { WhenFull::Overwrite } else { WhenFull::Lock };
        if let Some(hit) = self.filters.accept(&frame)
            && let Some(fifo) = self.fifos.get_mut(hit.fifo)
            && let Some(unseen_since) = self.unseen_since.get_mut(hit.fifo)
        {
            fifo.push(frame, hit.index, when_full);
            unseen_since.get_or_insert(at);
            self.received_at = Some(at);
        }
    }

    /// Mailboxes waiting to be sent, the one whose turn it is first.
    fn waiting(&self) -> Vec<usize> {
        let mut waiting: Vec<(u64, usize)> = self
            .mailboxes
            .iter()
            .enumerate()
            .filter_map(|(n, mailbox)| {
                let request = mailbox.request()?;
                Some(match self.order() {
                    SendOrder::Identifier => (u64::from(request.frame.arbitration()), n),
                    SendOrder::Request => (request.at.0, n),
                })
            })
            .collect();
        waiting.sort_unstable();
        waiting.into_iter().map(|(_, n)| n).collect()
    }

    /// Looped back and silent, a frame takes its time and touches no wire.
    fn start_internal(&mut self, now: Nanos) {
        let both = btr::LBKM | btr::SILM;
        if self.timing & both != both || !self.is_normal() || self.internal.is_some() {
            return;
        }
        let bit = self.bit();
        if let Some(n) = self.waiting().first().copied()
            && let Some(mailbox) = self.mailboxes.get(n)
        {
            let bits = Wire::of(&mailbox.frame()).len();
            self.internal = Some((now.after(bit.bits(bits)), n));
        }
    }

    fn abort(&mut self, n: usize, now: Nanos) {
        // A frame that may be on the wire since the last boundary is known only at the next.
        let sent_from_here = self.sending == Some(n) || self.internal.is_some_and(|(_, m)| m == n);
        let known = !self.is_normal()
            || self.counters.confinement() == Confinement::BusOff
            || self.presence() == Presence::Off
            || now < self.line.free_at;
        let Some(mailbox) = self.mailboxes.get_mut(n) else { return };
        mailbox.withdraw(now);
        if mailbox.is_withdrawn() && known && !sent_from_here {
            mailbox.complete(0);
        }
    }

    /// EWGF, EPVF and BOFF.
    fn flags(&self) -> u32 {
        let highest = self.counters.transmit().max(u16::from(self.counters.receive()));
        let mut flags = if highest >= WARNING { esr::EWGF } else { 0 };
        flags |= match self.counters.confinement() {
            Confinement::ErrorActive => 0,
            Confinement::ErrorPassive => esr::EPVF,
            Confinement::BusOff => esr::EPVF | esr::BOFF,
        };
        flags
    }

    fn status(&self, now: Nanos) -> u32 {
        let acknowledged = match self.mode {
            Mode::Sleep | Mode::Joining { from: Acknowledge::Sleep, .. } => msr::SLAK,
            Mode::Initialisation | Mode::Joining { from: Acknowledge::Initialisation, .. } => {
                msr::INAK
            }
            Mode::Normal { .. } => 0,
        };
        let transmits = self.sending.is_some() || self.internal.is_some();
        let busy = self.is_normal() && self.line.start <= now && now < self.line.free_at;
        [
            (self.error_pending, msr::ERRI),
            (self.wake_up_pending, msr::WKUI),
            (self.sleep_pending, msr::SLAKI),
            (transmits, msr::TXM),
            (busy && !transmits, msr::RXM),
        ]
        .into_iter()
        .filter_map(|(set, bit)| set.then_some(bit))
        .fold(msr::RECESSIVE | acknowledged, |status, bit| status | bit)
    }

    fn transmit_status(&self) -> u32 {
        let waiting = self.waiting();
        let free = (0..MAILBOXES).find(|n| !waiting.contains(n));
        let lowest = waiting.last().copied().unwrap_or_default();
        let number = |n: usize| u32::try_from(n).unwrap_or_default();
        let mut status = number(free.unwrap_or(lowest)) << tsr::CODE;
        if waiting.len() > 1 {
            status |= 1 << tsr::LOW << lowest;
        }
        for (n, mailbox) in self.mailboxes.iter().enumerate() {
            status |= mailbox.status() << (TSR_STRIDE * n);
            if mailbox.is_empty() {
                status |= 1 << tsr::TME << n;
            }
        }
        status
    }

    fn error_status(&self) -> u32 {
        let transmit = match self.counters.confinement() {
            Confinement::BusOff => TEC_AT_BUS_OFF,
            Confinement::ErrorActive | Confinement::ErrorPassive => self.counters.transmit(),
        };
        self.flags()
            | self.last_error << esr::LEC
            | u32::from(transmit) << esr::TEC
            | u32::from(self.counters.receive()) << esr::REC
    }

    /// Drives the interrupt lines as the flags and their enable bits say.
    fn drive_lines(&mut self, context: &mut DeviceContext<'_>) {
        let enabled = |bit: u32| self.enabled & bit != 0;
        let completed = self.mailboxes.iter().any(|mailbox| mailbox.status() & tsr::RQCP != 0);
        let fifo = |n: u32, fifo: &Fifo| {
            let up = n * ier::FIFO_STRIDE;
            let status = fifo.status();
            fifo.front().is_some() && enabled(ier::FMPIE << up)
                || status & rfr::FULL != 0 && enabled(ier::FFIE << up)
                || status & rfr::FOVR != 0 && enabled(ier::FOVIE << up)
        };
        let [first, second] = &self.fifos;
        let wanted = [
            completed && enabled(ier::TMEIE),
            fifo(0, first),
            fifo(1, second),
            self.error_pending && enabled(ier::ERRIE)
                || self.wake_up_pending && enabled(ier::WKUIE)
                || self.sleep_pending && enabled(ier::SLKIE),
        ];
        let [in_first, in_second] = &mut self.asserted.receive;
        let counts = [&mut self.asserted.transmit, in_first, in_second, &mut self.asserted.status];
        for (position, ((level, wanted), count)) in
            self.levels.iter_mut().zip(wanted).zip(counts).enumerate()
        {
            let wanted = if wanted { Level::High } else { Level::Low };
            if *level != wanted {
                *level = wanted;
                *count += u64::from(wanted == Level::High);
                context.interrupt(position, wanted);
            }
        }
    }

    fn write_control(&mut self, value: u32, now: Nanos) {
        if value & mcr::RESET != 0 {
            let (kept, levels) = (self.filters.clone(), self.levels);
            self.restart();
            (self.filters, self.levels) = (kept, levels);
            return;
        }
        self.control = value;
        let waiting = self.recovery.is_some() || !self.is_normal();
        if self.counters.confinement() == Confinement::BusOff
            && self.control & mcr::ABOM != 0
            && !waiting
        {
            self.start_recovery(now);
        }
    }

    /// Back to the reset state, but for the clock it runs on, the state of the wire and the counts.
    /// Whoever resets it lowers the lines.
    fn restart(&mut self) {
        let Self { pclk_hz, line, asserted, reaction, longest_wait, .. } = *self;
        *self = Self { pclk_hz, line, asserted, reaction, longest_wait, ..Self::new() };
    }

    fn value(&self, register: Register, now: Nanos) -> Option<u32> {
        Some(match place(register)? {
            Place::Control => self.control,
            Place::Status => self.status(now),
            Place::TransmitStatus => self.transmit_status(),
            Place::Fifo(n) => self.fifos.get(n)?.status(),
            Place::Enable => self.enabled,
            Place::ErrorStatus => self.error_status(),
            Place::Timing => self.timing,
            Place::Transmit(n, part) => self.mailboxes.get(n)?.read(part),
            Place::Receive(n, part) => self
                .fifos
                .get(n)?
                .front()
                .map_or(0, |(frame, filter)| mailbox::received(frame, *filter, part)),
            Place::Filter(filter) => self.filters.read(filter),
        })
    }
}

/// A register, sorted by what it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Control,
    Status,
    TransmitStatus,
    Fifo(usize),
    Enable,
    ErrorStatus,
    Timing,
    Transmit(usize, Part),
    Receive(usize, Part),
    Filter(FilterRegister),
}

const PARTS: [Part; 4] = [Part::Identifier, Part::Length, Part::Low, Part::High];

fn place(register: Register) -> Option<Place> {
    let row = register.index();
    let after = |first: Register| row.checked_sub(first.index());
    let fixed = [
        (Register::Mcr, Place::Control),
        (Register::Msr, Place::Status),
        (Register::Tsr, Place::TransmitStatus),
        (Register::Rf0r, Place::Fifo(0)),
        (Register::Rf1r, Place::Fifo(1)),
        (Register::Ier, Place::Enable),
        (Register::Esr, Place::ErrorStatus),
        (Register::Btr, Place::Timing),
        (Register::Fmr, Place::Filter(FilterRegister::Master)),
        (Register::Fm1r, Place::Filter(FilterRegister::Mode)),
        (Register::Fs1r, Place::Filter(FilterRegister::Scale)),
        (Register::Ffa1r, Place::Filter(FilterRegister::Assignment)),
        (Register::Fa1r, Place::Filter(FilterRegister::Activation)),
    ];
    if let Some((_, place)) = fixed.into_iter().find(|(fixed, _)| *fixed == register) {
        return Some(place);
    }
    if let Some(n) = after(Register::F0r1) {
        return Some(Place::Filter(FilterRegister::Bank(n / 2, n % 2)));
    }
    if let Some(n) = after(Register::Ri0r) {
        return Some(Place::Receive(n / PARTS.len(), *PARTS.get(n % PARTS.len())?));
    }
    let n = after(Register::Ti0r)?;
    Some(Place::Transmit(n / PARTS.len(), *PARTS.get(n % PARTS.len())?))
}

/// LEC.
const fn error_code(error: WireError) -> u32 {
    match error {
        WireError::Stuff => 1,
        WireError::Form => 2,
        WireError::Ack => 3,
        WireError::BitRecessive => 4,
        WireError::BitDominant => 5,
        WireError::Crc => 6,
    }
}

fn now(context: &DeviceContext<'_>) -> Nanos {
    Nanos(context.now().0)
}

impl Device for BxCan {
    type Register = Register;

    fn read(
        &mut self,
        register: Register,
        _registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> Option<u64> {
        let now = now(context);
        if let Some(Place::Fifo(n)) = place(register)
            && let Some(since) = self.unseen_since.get_mut(n).and_then(Option::take)
        {
            self.longest_wait = self.longest_wait.max(Nanos(now.0.saturating_sub(since.0)));
        }
        self.value(register, now).map(u64::from)
    }

    fn peek(
        &self,
        register: Register,
        _registers: &RegisterFile,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.value(register, Nanos(now.0)).map(u64::from)
    }

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let Some(place) = place(register) else { return };
        let now = now(context);
        let value = u32::try_from(value).unwrap_or(u32::MAX);
        // Bits that act when written: a narrow access does not touch the others.
        let touched = u32::try_from(context.access_mask().unwrap_or(u64::MAX) & 0xFFFF_FFFF)
            .unwrap_or(u32::MAX);
        let commands = value & touched;
        match place {
            Place::Control => self.write_control(value, now),
            Place::Status => {
                self.error_pending &= commands & msr::ERRI == 0;
                self.wake_up_pending &= commands & msr::WKUI == 0;
                self.sleep_pending &= commands & msr::SLAKI == 0;
            }
            Place::TransmitStatus => {
                for n in 0..MAILBOXES {
                    let byte = commands >> (TSR_STRIDE * n);
                    if let Some(mailbox) = self.mailboxes.get_mut(n) {
                        mailbox.clear(byte);
                    }
                    if byte & tsr::ABRQ != 0 {
                        self.abort(n, now);
                    }
                }
            }
            Place::Fifo(n) => {
                if let Some(fifo) = self.fifos.get_mut(n) {
                    fifo.command(commands);
                }
            }
            Place::Enable => self.enabled = value,
            Place::ErrorStatus => self.last_error = value >> esr::LEC & esr::LEC_MASK,
            Place::Timing => {
                if self.mode == Mode::Initialisation {
                    self.timing = value;
                }
            }
            Place::Transmit(n, part) => {
                if let Some(mailbox) = self.mailboxes.get_mut(n) {
                    let was_empty = mailbox.is_empty();
                    mailbox.write(part, value, now);
                    if was_empty
                        && !mailbox.is_empty()
                        && let Some(received_at) = self.received_at.take()
                    {
                        self.reaction = Nanos(now.0.saturating_sub(received_at.0));
                    }
                }
            }
            Place::Receive(..) => {}
            Place::Filter(filter) => self.filters.write(filter, value),
        }
        self.catch_up(context);
        // The register file merges narrow writes with what it holds: keep it at what counts.
        if let Some(held) = self.value(register, now) {
            registers.set(register, u64::from(held));
        }
    }

    fn on_event(
        &mut self,
        _event: EventId,
        _registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.catch_up(context);
    }

    fn on_clock(
        &mut self,
        hz: u64,
        _registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.pclk_hz = hz;
        self.catch_up(context);
    }

    /// With the whole part: it runs on the internal clock again, and its lines are low.
    fn reset(&mut self) {
        self.restart();
        self.pclk_hz = HSI_HZ;
    }

    /// By RCC alone: the clock goes on.
    fn reset_line(&mut self, _registers: &mut RegisterFile, _context: &mut DeviceContext<'_>) {
        self.restart();
    }
}
