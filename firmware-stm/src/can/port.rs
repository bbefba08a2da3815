//! The CAN port as the core's task sees it.
//!
//! Reception: the task's handlers take frames straight out of the two FIFOs.
//! Transmission: the controller sends the mailboxes in the order of their identifiers, and equal
//! ones in the order of the mailboxes. When all three are taken and a more urgent frame comes, the
//! least urgent one is taken back and returned to the core, so no urgent frame waits behind three
//! others (no priority inversion). Taking back never waits: a frame that is on the wire already ends
//! as sent, up to 13 ms later at 10 kbit/s.
use bxcan::{Can, Interrupts};
use canopen::{Accepted, CanId, Frame};
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::peripherals::{CAN1, PD0, PD1};
use embassy_stm32::{Peri, rcc};

use super::registers::{self, Ended, ErrorState, Fifo, Outcome, Received};
use super::{acceptance, bit_timing};

/// Alternate function of the CAN pins (data sheet table 12).
const AF_CAN: u8 = 9;
const MAILBOXES: usize = 3;

/// The registers of CAN1. The values are made by [`Port`], which owns the peripheral.
struct Controller;

#[expect(unsafe_code, reason = "CAN1 of the STM32F429; `Port` holds its singleton")]
unsafe impl bxcan::Instance for Controller {
    const REGISTERS: *mut bxcan::RegisterBlock = embassy_stm32::pac::CAN1.as_ptr().cast();
}
#[expect(unsafe_code, reason = "the filter banks are reached through CAN1")]
unsafe impl bxcan::FilterOwner for Controller {
    const NUM_FILTER_BANKS: u8 = 28;
}

/// The peripheral and its pins.
pub(crate) struct Pins {
    pub(crate) can: Peri<'static, CAN1>,
    pub(crate) rx: Peri<'static, PD0>,
    pub(crate) tx: Peri<'static, PD1>,
}

/// A frame that cannot be taken now. An interrupt comes when a mailbox has become free.
pub(crate) struct Busy;

/// CAN1, its interrupts, filters and mailboxes.
pub(crate) struct Port {
    can: Can<Controller>,
    mailboxes: [Option<Pending>; MAILBOXES],
    bit_rate: Option<u32>,
    joined: bool,
    _pins: (Flex<'static>, Flex<'static>),
}

struct Pending {
    frame: Frame,
    aborted: bool,
}

impl Port {
    /// Takes CAN1 and its pins; silent until [`Port::configure`].
    pub(crate) fn new(pins: Pins) -> Self {
        let mut rx = Flex::new(pins.rx);
        rx.set_as_af_unchecked(AF_CAN, AfType::input(Pull::Up));
        let mut tx = Flex::new(pins.tx);
        tx.set_as_af_unchecked(AF_CAN, AfType::output(OutputType::PushPull, Speed::High));
        // The peripheral stays this port's: nothing else can be made of the singleton.
        let _: Peri<'static, CAN1> = pins.can;
        Self {
            can: reset_controller(),
            mailboxes: [const { None }; MAILBOXES],
            bit_rate: None,
            joined: false,
            _pins: (rx, tx),
        }
    }

    /// Runs the bus at `bit_rate` (bit/s, one of the nine of CiA 301; another one changes nothing)
    /// and receives the frames `accepted`. Joins the bus anew only if the bit rate changed;
    /// frames in the mailboxes are then forgotten.
    pub(crate) fn configure(&mut self, bit_rate: u32, accepted: impl Iterator<Item = Accepted>) {
        if self.bit_rate != Some(bit_rate) {
            let Some(timing) = bit_timing::register(bit_rate) else {
                defmt::error!("no such bit rate: {=u32} bit/s", bit_rate);
                return;
            };
            self.can =
                Can::builder(reset_controller_registers()).set_bit_timing(timing).leave_disabled();
            self.can.enable_interrupts(
                Interrupts::TRANSMIT_MAILBOX_EMPTY
                    | Interrupts::FIFO0_MESSAGE_PENDING
                    | Interrupts::FIFO1_MESSAGE_PENDING,
            );
            registers::report_error_states();
            self.mailboxes = [const { None }; MAILBOXES];
            self.bit_rate = Some(bit_rate);
            self.joined = false;
        }
        acceptance::accept(&mut self.can, accepted);
        self.join();
    }

    /// Whether the controller has seen the bus idle and takes part. To be asked again until it has;
    /// the bus may be held dominant for any time.
    pub(crate) fn join(&mut self) -> bool {
        if !self.joined && self.bit_rate.is_some() {
            self.joined = self.can.enable_non_blocking().is_ok();
        }
        self.joined
    }

    /// What [`Port::join`] said last.
    pub(crate) fn joined(&self) -> bool {
        self.joined
    }

    /// Takes the oldest frame out of `fifo`. The interrupt stays raised as long as there is more.
    #[inline]
    pub(crate) fn receive(&mut self, fifo: Fifo) -> Option<Received> {
        registers::receive(fifo)
    }

    /// Puts `frame` into a mailbox, or makes room for it if it is more urgent than what is there.
    #[inline]
    pub(crate) fn transmit(&mut self, frame: &Frame) -> Result<(), Busy> {
        if !self.joined {
            return Err(Busy);
        }
        let index = match &self.mailboxes {
            [None, None, None] => 0,
            mailboxes => place_behind(mailboxes, frame.id()).ok_or_else(|| {
                self.make_room(frame);
                Busy
            })?,
        };
        registers::request(index, frame);
        if let Some(place) = self.mailboxes.get_mut(index) {
            *place = Some(Pending { frame: *frame, aborted: false });
        }
        Ok(())
    }

    /// Takes the least urgent pending frame back if there is no room and `wanted` is more urgent.
    fn make_room(&mut self, wanted: &Frame) {
        if self.mailboxes.iter().any(Option::is_none) {
            return;
        }
        let pending = self.mailboxes.iter_mut().enumerate();
        let least = pending
            .filter_map(|(index, slot)| slot.as_mut().map(|pending| (index, pending)))
            .max_by_key(|(_, pending)| pending.frame.id());
        if let Some((index, pending)) = least
            && !pending.aborted
            && pending.frame.id() > wanted.id()
        {
            pending.aborted = true;
            registers::abort(index);
        }
    }

    /// Frees the mailboxes whose requests have ended. `give_back` gets the frames that were taken
    /// back for a more urgent one and have not been seen on the bus.
    pub(crate) fn take_outcomes(&mut self, mut give_back: impl FnMut(Frame)) {
        let ended = Ended::take();
        for (index, slot) in self.mailboxes.iter_mut().enumerate() {
            if let Some(outcome) = ended.outcome(index)
                && let Some(pending) = slot.take()
                && outcome == Outcome::Aborted
            {
                give_back(pending.frame);
            }
        }
    }

    /// The error state of the controller now; ends the interrupt raised by its last change.
    pub(crate) fn error_state(&self) -> ErrorState {
        registers::acknowledge_error_state();
        registers::error_state()
    }
}

/// An empty mailbox behind all that hold a frame with the same identifier.
fn place_behind(mailboxes: &[Option<Pending>; MAILBOXES], id: CanId) -> Option<usize> {
    let same = |slot: &Option<Pending>| slot.as_ref().is_some_and(|held| held.frame.id() == id);
    let first = mailboxes.iter().rposition(same).map_or(0, |last| last + 1);
    mailboxes.iter().skip(first).position(Option::is_none).map(|index| first + index)
}

fn reset_controller_registers() -> Controller {
    rcc::enable_and_reset::<CAN1>();
    Controller
}

/// CAN1 as after reset: asleep, off the bus.
fn reset_controller() -> Can<Controller> {
    Can::builder(reset_controller_registers()).leave_disabled()
}
