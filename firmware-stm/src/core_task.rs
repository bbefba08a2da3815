//! The level that owns the core: everything that reaches it has one priority, above link, flash and
//! log, so nothing it does is interrupted by anything else it does.
//!
//! A frame is answered in the handler of its FIFO, before anything else. Link bytes and time come
//! through a task on an interrupt executor of the same priority.
use core::cell::UnsafeCell;
use core::future::poll_fn;
use core::task::{Poll, Waker};

use canopen::BusState;
use embassy_executor::InterruptExecutor;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_sync::waitqueue::AtomicWaker;
use firmware_board::{Beat, NumberSet, Outbox, Outcome, RecordQueue, priority};
use heapless::spsc::Consumer;
use interface::{Event, Interface, NotSaved, Record};
use units::{Duration, Instant};

use crate::can::{ErrorState, Fifo, Port, Received};

/// Bytes from the link handed over at once.
const LINK_CHUNK_LEN: usize = 64;
/// How soon to look again at a controller that is not on the bus yet, or whose error state has to
/// recover: getting worse interrupts, getting better does not.
const LOOK_AGAIN_AFTER: Duration = Duration::from_millis(5);

const _: () = assert!(embassy_time::TICK_HZ == 1_000_000);

static TASK: AtomicWaker = AtomicWaker::new();
static EXECUTOR: InterruptExecutor = InterruptExecutor::new();
static CORE: OnLevel<Core> = OnLevel::new();

/// The core's task is alive.
pub(crate) static BEAT: Beat = Beat::new();
/// Frames for the application controller.
pub(crate) static TO_APPLICATION: Outbox = Outbox::new();
/// What the core wants stored.
pub(crate) static RECORDS: RecordQueue = RecordQueue::new();

/// What became of what the core wanted stored: at most two requests wait for it at a time.
static CONFIRMED: Channel<CriticalSectionRawMutex, (u8, Outcome), 2> = Channel::new();

/// Tells the core what became of everything until a number.
pub(crate) fn confirm(number: u8, outcome: Outcome) {
    if CONFIRMED.try_send((number, outcome)).is_err() {
        defmt::error!("more confirmations than requests");
    }
    wake();
}

/// There is something besides frames, or it is time to show up.
pub(crate) fn wake() {
    TASK.wake();
}

/// The time as the core counts it.
#[inline]
pub(crate) fn now() -> Instant {
    Instant::from_micros(embassy_time::Instant::now().as_micros())
}

/// What belongs to the core's level.
struct OnLevel<T>(UnsafeCell<Option<T>>);

#[expect(unsafe_code, reason = "used on one level, where no handler interrupts another")]
unsafe impl<T: Send> Sync for OnLevel<T> {}

impl<T> OnLevel<T> {
    const fn new() -> Self {
        Self(UnsafeCell::new(None))
    }

    /// # Safety
    /// Only in handlers of the core's level, and one reference at a time.
    #[expect(unsafe_code, clippy::mut_from_ref, reason = "the caller is the only user")]
    unsafe fn get(&self) -> &mut Option<T> {
        unsafe { &mut *self.0.get() }
    }
}

/// What the core is put together from.
pub(crate) struct Parts {
    pub(crate) interface: &'static mut Interface,
    pub(crate) port: Port,
    pub(crate) from_application: Consumer<'static, u8>,
}

/// Starts the core's task on its executor.
pub(crate) fn start(parts: Parts) {
    interrupt::UART5.set_priority(priority::CORE);
    let spawner = EXECUTOR.start(interrupt::UART5);
    spawner.spawn(defmt::unwrap!(run(parts)));
}

/// UART5 is not used; its interrupt is the executor's.
#[interrupt]
fn UART5() {
    #[expect(unsafe_code, reason = "this is the executor's handler, enabled by its start")]
    unsafe {
        EXECUTOR.on_interrupt();
    }
}

#[interrupt]
fn CAN1_RX0() {
    with_core(|core| core.take_frame(Fifo::Control));
}

#[interrupt]
fn CAN1_RX1() {
    with_core(|core| core.take_frame(Fifo::Data));
}

#[interrupt]
fn CAN1_TX() {
    with_core(Core::take_outcomes);
}

#[interrupt]
fn CAN1_SCE() {
    with_core(Core::take_bus_state);
}

/// Called by the handlers above and the task below, all of the core's level.
#[inline]
fn with_core(work: impl FnOnce(&mut Core)) {
    #[expect(unsafe_code, reason = "its callers are of the core's level and do not nest")]
    if let Some(core) = unsafe { CORE.get() } {
        work(core);
        core.take_time();
    }
}

#[embassy_executor::task]
async fn run(parts: Parts) -> ! {
    let waker = poll_fn(|context| Poll::Ready(context.waker().clone())).await;
    TASK.register(&waker);
    let core = Core { parts, errors: ErrorState::Active, waker, armed: None };
    #[expect(unsafe_code, reason = "the executor has the core's level")]
    let core = unsafe { CORE.get() }.insert(core);
    core.configure_bus();
    for handler in
        [interrupt::CAN1_RX0, interrupt::CAN1_RX1, interrupt::CAN1_TX, interrupt::CAN1_SCE]
    {
        handler.set_priority(priority::CORE);
        #[expect(unsafe_code, reason = "what the handlers use is in place")]
        unsafe {
            handler.enable();
        }
    }
    poll_fn(|_| {
        BEAT.show();
        with_core(Core::run);
        Poll::<core::convert::Infallible>::Pending
    })
    .await;
    loop {
        core::future::pending::<()>().await;
    }
}

struct Core {
    parts: Parts,
    errors: ErrorState,
    waker: Waker,
    /// What the time base was last asked for.
    armed: Option<Instant>,
}

impl Core {
    #[inline]
    fn take_frame(&mut self, fifo: Fifo) {
        match self.parts.port.receive(fifo) {
            Some(Received::Frame(frame)) => self.parts.interface.handle_frame(now(), &frame),
            Some(Received::Overrun) => {
                defmt::warn!("CAN: frame lost");
                self.parts.interface.handle_overrun();
            }
            None => return,
        }
        self.transmit();
        self.hand_on();
        // The controller counts a received frame in favour of itself, without an interrupt.
        if self.errors != ErrorState::Active {
            self.take_bus_state();
        }
    }

    fn take_outcomes(&mut self) {
        let Parts { interface, port, .. } = &mut self.parts;
        port.take_outcomes(|returned| interface.give_back(returned));
        self.transmit();
    }

    fn take_bus_state(&mut self) {
        if !self.parts.port.joined() && self.parts.port.join() {
            self.transmit();
        }
        let errors = self.parts.port.error_state();
        if errors != self.errors {
            defmt::info!("CAN: {}", errors);
            self.errors = errors;
            self.parts.interface.handle_bus(now(), bus_state(errors));
            self.transmit();
            self.hand_on();
        }
    }

    fn run(&mut self) {
        self.take_link_bytes();
        self.take_confirmations();
        self.take_bus_state();
    }

    fn take_link_bytes(&mut self) {
        let mut chunk = heapless::Vec::<u8, LINK_CHUNK_LEN>::new();
        loop {
            while !chunk.is_full()
                && let Some(byte) = self.parts.from_application.dequeue()
            {
                let _ = chunk.push(byte);
            }
            if chunk.is_empty() {
                break;
            }
            self.parts.interface.handle_link(now(), &chunk);
            self.transmit();
            self.hand_on();
            chunk.clear();
        }
    }

    fn take_confirmations(&mut self) {
        while let Ok((number, outcome)) = CONFIRMED.try_receive() {
            let outcome = match outcome {
                Outcome::Stored => Ok(()),
                Outcome::Failed => Err(NotSaved),
            };
            self.parts.interface.handle_saved(now(), number, outcome);
            self.transmit();
            self.hand_on();
        }
    }

    /// Does what is due, and has the task woken when the core wants to be called again, or a look at
    /// the controller is due.
    fn take_time(&mut self) {
        let now = now();
        let mut due = self.parts.interface.poll_timeout();
        if due.is_some_and(|due| due <= now) {
            self.parts.interface.handle_timeout(now);
            self.transmit();
            self.hand_on();
            due = self.parts.interface.poll_timeout();
        }
        let settled = self.parts.port.joined() && self.errors == ErrorState::Active;
        let look_again = (!settled).then(|| now + LOOK_AGAIN_AFTER);
        let due = [due, look_again].into_iter().flatten().min();
        // An earlier request that has passed has woken the task.
        self.armed = self.armed.filter(|armed| *armed > now);
        if let Some(due) = due
            && self.armed.is_none_or(|armed| due < armed)
        {
            embassy_time_driver::schedule_wake(due.as_micros(), &self.waker);
            self.armed = Some(due);
        }
    }

    /// Hands the frames of the core to the controller as far as it takes them.
    #[inline]
    fn transmit(&mut self) {
        let Parts { interface, port, .. } = &mut self.parts;
        while let Some(frame) = interface.peek_transmit() {
            if port.transmit(frame).is_err() {
                break;
            }
            interface.take_transmit();
        }
    }

    /// Hands on what else the core brought about.
    fn hand_on(&mut self) {
        while !TO_APPLICATION.is_full()
            && let Some(frame) = self.parts.interface.poll_link()
        {
            // There is room, and nobody else puts anything in.
            let _ = TO_APPLICATION.try_send(frame);
        }
        while let Some(event) = self.parts.interface.poll_event() {
            self.act(event);
        }
    }

    fn act(&mut self, event: Event) {
        match event {
            Event::Store(Record { key, value }) => RECORDS.put(key, value),
            Event::StoreSet => {
                let mut set = NumberSet::new();
                for Record { key, value } in self.parts.interface.set_to_store() {
                    let _ = set.push((key, value));
                }
                RECORDS.put_set(set);
            }
            Event::Forget => RECORDS.forget(),
            Event::Confirm(number) => RECORDS.confirm(number),
            Event::FiltersChanged => self.configure_bus(),
            Event::Restart => RECORDS.restart(),
        }
    }

    fn configure_bus(&mut self) {
        let Parts { interface, port, .. } = &mut self.parts;
        port.configure(interface.bit_rate(), interface.accepts());
    }
}

fn bus_state(errors: ErrorState) -> BusState {
    match errors {
        ErrorState::Active => BusState::Active,
        ErrorState::Warning => BusState::Warning,
        ErrorState::Passive => BusState::Passive,
        ErrorState::BusOff => BusState::Off,
    }
}
