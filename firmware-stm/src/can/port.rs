//! The CAN port as the core's task sees it.
//!
//! Reception: the handlers of both FIFOs move frames into a queue each and wake the task.
//! Transmission: `bxcan` puts a frame into a mailbox; the controller sends the mailboxes in the
//! order of their identifiers. When all three are taken and a more urgent frame comes, the least
//! urgent one is taken back and returned to the core, so no urgent frame waits behind three others
//! (no priority inversion). Taking back never waits: a frame that is on the wire already ends as
//! sent, up to 13 ms later at 10 kbit/s.
use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicU32, Ordering};

use bxcan::{Can, Data, Interrupts, StandardId};
use canopen::{Accepted, DATA_MAX, Frame};
use embassy_stm32::gpio::{AfType, Flex, OutputType, Pull, Speed};
use embassy_stm32::interrupt::InterruptExt;
use embassy_stm32::peripherals::{CAN1, PD0, PD1};
use embassy_stm32::{Peri, interrupt, rcc};
use firmware_board::priority;
use heapless::spsc::{Consumer, Producer, Queue};
use static_cell::StaticCell;

use super::registers::{self, ErrorState, Fifo, Outcome, Received};
use super::{acceptance, bit_timing};
use crate::core_task;

/// Alternate function of the CAN pins (data sheet table 12).
const AF_CAN: u8 = 9;
const MAILBOXES: usize = 3;
/// Places of each queue, one of which stays empty: with the three of its FIFO 1.5 ms of shortest
/// frames at 1 Mbit/s. A power of two spares the handler a division.
const QUEUE_LEN: usize = 32;
type FrameQueue = Queue<Frame, QUEUE_LEN>;

const _: () = assert!(QUEUE_LEN.is_power_of_two());

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

/// What belongs to one interrupt handler.
struct HandlerOwned<T>(UnsafeCell<Option<T>>);

#[expect(
    unsafe_code,
    reason = "set before the interrupt is enabled, then used by its handler only"
)]
unsafe impl<T: Send> Sync for HandlerOwned<T> {}

impl<T> HandlerOwned<T> {
    const fn new() -> Self {
        Self(UnsafeCell::new(None))
    }

    /// # Safety
    /// Only while the interrupt is disabled, or in its handler.
    #[expect(unsafe_code, clippy::mut_from_ref, reason = "the caller is the only user")]
    unsafe fn get(&self) -> &mut Option<T> {
        unsafe { &mut *self.0.get() }
    }
}

static CONTROL: HandlerOwned<Producer<'static, Frame>> = HandlerOwned::new();
static DATA: HandlerOwned<Producer<'static, Frame>> = HandlerOwned::new();

/// Received frames that found FIFO or queue full.
static LOST: AtomicU32 = AtomicU32::new(0);

/// The peripheral and its pins.
pub(crate) struct Pins {
    pub(crate) can: Peri<'static, CAN1>,
    pub(crate) rx: Peri<'static, PD0>,
    pub(crate) tx: Peri<'static, PD1>,
}

/// How a frame left its mailbox.
pub(crate) enum Completed {
    /// Another node acknowledged it.
    Sent,
    /// It was taken back for a more urgent one and has not been seen on the bus.
    Returned(Frame),
}

/// A frame that cannot be taken now. [`Port::poll_completed`] announces the next chance.
pub(crate) struct Busy;

/// CAN1, its interrupts, filters and mailboxes.
pub(crate) struct Port {
    can: Can<Controller>,
    control: Consumer<'static, Frame>,
    data: Consumer<'static, Frame>,
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
        static CONTROL_QUEUE: StaticCell<FrameQueue> = StaticCell::new();
        static DATA_QUEUE: StaticCell<FrameQueue> = StaticCell::new();
        let (control_in, control) = CONTROL_QUEUE.init(Queue::new()).split();
        let (data_in, data) = DATA_QUEUE.init(Queue::new()).split();

        #[expect(unsafe_code, reason = "the interrupts are not enabled yet")]
        unsafe {
            *CONTROL.get() = Some(control_in);
            *DATA.get() = Some(data_in);
        }
        let mut rx = Flex::new(pins.rx);
        rx.set_as_af_unchecked(AF_CAN, AfType::input(Pull::Up));
        let mut tx = Flex::new(pins.tx);
        tx.set_as_af_unchecked(AF_CAN, AfType::output(OutputType::PushPull, Speed::High));
        // The peripheral stays this port's: nothing else can be made of the singleton.
        let _: Peri<'static, CAN1> = pins.can;
        let port = Self {
            can: reset_controller(),
            control,
            data,
            mailboxes: [const { None }; MAILBOXES],
            bit_rate: None,
            joined: false,
            _pins: (rx, tx),
        };
        for handler in
            [interrupt::CAN1_RX0, interrupt::CAN1_RX1, interrupt::CAN1_TX, interrupt::CAN1_SCE]
        {
            handler.set_priority(priority::CAN);
            #[expect(unsafe_code, reason = "what the handlers use is in place")]
            unsafe {
                handler.enable();
            }
        }
        port
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

    /// The next received frame; control frames and data frames take turns.
    pub(crate) fn receive(&mut self, turn: Turn) -> Option<Frame> {
        match turn {
            Turn::Control => self.control.dequeue().or_else(|| self.data.dequeue()),
            Turn::Data => self.data.dequeue().or_else(|| self.control.dequeue()),
        }
    }

    /// Received frames lost since the last call.
    pub(crate) fn take_lost(&mut self) -> u32 {
        LOST.swap(0, Ordering::Relaxed)
    }

    /// Puts `frame` into a mailbox, or makes room for it if it is more urgent than what is there.
    pub(crate) fn transmit(&mut self, frame: &Frame) -> Result<(), Busy> {
        if !self.joined {
            return Err(Busy);
        }
        let wanted = driver_frame(frame);
        if !registers::has_free_mailbox() {
            self.make_room(&wanted);
            return Err(Busy);
        }
        let status = self.can.transmit(&wanted).map_err(|_| Busy)?;
        if let Some(mailbox) = self.mailboxes.get_mut(status.mailbox() as usize) {
            // Whatever was in there has been sent since the outcomes were read.
            *mailbox = Some(Pending { frame: *frame, aborted: false });
        }
        Ok(())
    }

    /// Takes the least urgent pending frame back if `wanted` is more urgent.
    fn make_room(&mut self, wanted: &bxcan::Frame) {
        let pending = self.mailboxes.iter_mut().enumerate();
        let least = pending
            .filter_map(|(index, slot)| slot.as_mut().map(|pending| (index, pending)))
            .min_by_key(|(_, pending)| driver_frame(&pending.frame).priority());
        if let Some((index, pending)) = least
            && !pending.aborted
            && driver_frame(&pending.frame).priority() < wanted.priority()
        {
            pending.aborted = true;
            registers::abort(index);
        }
    }

    /// What became of a frame given to [`Port::transmit`].
    pub(crate) fn poll_completed(&mut self) -> Option<Completed> {
        for (index, slot) in self.mailboxes.iter_mut().enumerate() {
            if let Some(outcome) = registers::take_outcome(index)
                && let Some(pending) = slot.take()
            {
                return Some(match outcome {
                    Outcome::Sent => Completed::Sent,
                    Outcome::Aborted => Completed::Returned(pending.frame),
                });
            }
        }
        None
    }

    /// Lets the next outcome interrupt again. To be called when [`Port::poll_completed`] is `None`.
    pub(crate) fn listen_for_outcomes(&self) {
        #[expect(unsafe_code, reason = "the handler only wakes the core")]
        unsafe {
            interrupt::CAN1_TX.enable();
        }
    }

    /// The error state of the controller now.
    pub(crate) fn error_state(&self) -> ErrorState {
        registers::error_state()
    }
}

/// Which queue is served first.
#[derive(Clone, Copy)]
pub(crate) enum Turn {
    Control,
    Data,
}

impl Turn {
    pub(crate) fn other(self) -> Self {
        match self {
            Self::Control => Self::Data,
            Self::Data => Self::Control,
        }
    }
}

fn reset_controller_registers() -> Controller {
    rcc::enable_and_reset::<CAN1>();
    Controller
}

/// CAN1 as after reset: asleep, off the bus.
fn reset_controller() -> Can<Controller> {
    Can::builder(reset_controller_registers()).leave_disabled()
}

fn driver_frame(frame: &Frame) -> bxcan::Frame {
    let id = StandardId::new(frame.id().get()).unwrap_or(StandardId::MAX);
    if frame.is_remote() {
        bxcan::Frame::new_remote(id, frame.dlc())
    } else if let Ok(all) = <[u8; DATA_MAX]>::try_from(frame.data()) {
        bxcan::Frame::new_data(id, all)
    } else {
        bxcan::Frame::new_data(id, Data::new(frame.data()).unwrap_or(Data::empty()))
    }
}

#[interrupt]
fn CAN1_RX0() {
    #[expect(unsafe_code, reason = "this is the handler")]
    if let Some(queue) = unsafe { CONTROL.get() } {
        take_frames(Fifo::Control, queue);
    }
}

#[interrupt]
fn CAN1_RX1() {
    #[expect(unsafe_code, reason = "this is the handler")]
    if let Some(queue) = unsafe { DATA.get() } {
        take_frames(Fifo::Data, queue);
    }
}

/// The outcomes stay in their flags until the core's task reads them.
#[interrupt]
fn CAN1_TX() {
    interrupt::CAN1_TX.disable();
    core_task::wake();
}

#[interrupt]
fn CAN1_SCE() {
    registers::acknowledge_error_state();
    core_task::wake();
}

#[inline]
fn take_frames(fifo: Fifo, queue: &mut Producer<'static, Frame>) {
    while let Some(received) = registers::receive(fifo) {
        let lost = match received {
            Received::Frame(frame) => queue.enqueue(frame).is_err(),
            Received::Overrun => true,
        };
        if lost {
            LOST.fetch_add(1, Ordering::Relaxed);
        }
    }
    core_task::wake();
}
