//! The task that owns the core: wait, hand over, drain.
//!
//! It runs on an interrupt executor above everything but the CAN handlers, so a frame is answered
//! without waiting for link, flash or log. All inputs raise one wake-up; a pass then looks at each
//! of them, frames first. A pass never waits.
use core::future::poll_fn;
use core::task::{Poll, Waker};

use embassy_executor::InterruptExecutor;
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;
use embassy_sync::waitqueue::AtomicWaker;
use firmware_board::{Beat, Outbox, RecordQueue, priority};
use heapless::spsc::Consumer;
use interface::{BusState, Event, Interface, Record};
use units::{Duration, Instant};

use crate::can::{Completed, ErrorState, Port, Turn};

/// Bytes from the link handed over at once.
const LINK_CHUNK_LEN: usize = 64;
/// How soon to look again at a controller that is not on the bus yet, or whose error state has to
/// recover: getting worse interrupts, getting better does not.
const LOOK_AGAIN_AFTER: Duration = Duration::from_millis(5);

const _: () = assert!(embassy_time::TICK_HZ == 1_000_000);

static CORE: AtomicWaker = AtomicWaker::new();
static EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// The core's task is alive.
pub(crate) static BEAT: Beat = Beat::new();
/// Frames for the application controller.
pub(crate) static TO_APPLICATION: Outbox = Outbox::new();
/// What the core wants stored.
pub(crate) static RECORDS: RecordQueue = RecordQueue::new();

/// Something happened that the core has to look at.
pub(crate) fn wake() {
    CORE.wake();
}

/// The time as the core counts it.
pub(crate) fn now() -> Instant {
    Instant::from_micros(embassy_time::Instant::now().as_micros())
}

/// What the core's task owns.
pub(crate) struct Core {
    pub(crate) interface: Interface,
    pub(crate) port: Port,
    pub(crate) from_application: Consumer<'static, u8>,
}

/// Starts the core's task on its executor.
pub(crate) fn start(core: Core) {
    interrupt::UART5.set_priority(priority::CORE);
    let spawner = EXECUTOR.start(interrupt::UART5);
    spawner.spawn(defmt::unwrap!(run(core)));
}

/// UART5 is not used; its interrupt is the executor's.
#[interrupt]
fn UART5() {
    #[expect(unsafe_code, reason = "this is the executor's handler, enabled by its start")]
    unsafe {
        EXECUTOR.on_interrupt();
    }
}

#[embassy_executor::task]
async fn run(core: Core) -> ! {
    let mut pass = Pass::new(core);
    // The task stays the same, so its waker does.
    poll_fn(|context| {
        CORE.register(context.waker());
        Poll::Ready(())
    })
    .await;
    poll_fn(|context| {
        BEAT.show();
        pass.run();
        pass.arm(context.waker());
        Poll::<core::convert::Infallible>::Pending
    })
    .await;
    loop {
        core::future::pending::<()>().await;
    }
}

struct Pass {
    core: Core,
    turn: Turn,
    errors: ErrorState,
    /// What the time base was last asked for.
    armed: Option<Instant>,
}

impl Pass {
    fn new(core: Core) -> Self {
        let mut pass = Self { core, turn: Turn::Control, errors: ErrorState::Active, armed: None };
        pass.configure_bus();
        pass
    }

    fn run(&mut self) {
        self.take_frames();
        self.take_outcomes();
        self.take_link_bytes();
        self.take_bus_state();
        let now = now();
        if self.core.interface.poll_timeout().is_some_and(|due| due <= now) {
            self.core.interface.handle_timeout(now);
            self.drain();
        }
    }

    fn take_frames(&mut self) {
        while let Some(frame) = self.core.port.receive(self.turn) {
            self.turn = self.turn.other();
            self.core.interface.handle_frame(now(), &frame);
            self.drain();
        }
    }

    fn take_outcomes(&mut self) {
        while let Some(completed) = self.core.port.poll_completed() {
            match completed {
                Completed::Sent => {}
                Completed::Returned(frame) => self.core.interface.give_back(frame),
            }
        }
        self.drain();
        self.core.port.listen_for_outcomes();
    }

    fn take_link_bytes(&mut self) {
        let mut chunk = heapless::Vec::<u8, LINK_CHUNK_LEN>::new();
        loop {
            while !chunk.is_full()
                && let Some(byte) = self.core.from_application.dequeue()
            {
                let _ = chunk.push(byte);
            }
            if chunk.is_empty() {
                break;
            }
            self.core.interface.handle_link(now(), &chunk);
            self.drain();
            chunk.clear();
        }
    }

    fn take_bus_state(&mut self) {
        self.core.port.join();
        let errors = self.core.port.error_state();
        if errors != self.errors {
            defmt::info!("CAN: {}", errors);
            self.errors = errors;
            self.core.interface.handle_bus(now(), bus_state(errors));
            self.drain();
        }
        let lost = self.core.port.take_lost();
        if lost > 0 {
            defmt::warn!("CAN: {=u32} frames lost", lost);
            self.core.interface.handle_overrun();
            self.drain();
        }
    }

    /// Hands on what the core brought about: frames first.
    fn drain(&mut self) {
        self.transmit();
        while !TO_APPLICATION.is_full()
            && let Some(frame) = self.core.interface.poll_link()
        {
            // There is room, and nobody else puts anything in.
            let _ = TO_APPLICATION.try_send(frame);
        }
        while let Some(event) = self.core.interface.poll_event() {
            self.act(event);
        }
    }

    fn transmit(&mut self) {
        while let Some(frame) = self.core.interface.peek_transmit() {
            if self.core.port.transmit(frame).is_err() {
                break;
            }
            self.core.interface.take_transmit();
        }
    }

    fn act(&mut self, event: Event) {
        match event {
            Event::Store(Record { key, value }) => RECORDS.put(key, value),
            Event::FiltersChanged => self.configure_bus(),
            Event::Restart => RECORDS.restart(),
        }
    }

    fn configure_bus(&mut self) {
        let Core { interface, port, .. } = &mut self.core;
        port.configure(interface.bit_rate(), interface.accepts());
    }

    /// Has the task woken when the core wants to be called, or a look at the controller is due.
    fn arm(&mut self, waker: &Waker) {
        let settled = self.core.port.joined() && self.errors == ErrorState::Active;
        let look_again = (!settled).then(|| now() + LOOK_AGAIN_AFTER);
        let due = [self.core.interface.poll_timeout(), look_again].into_iter().flatten().min();
        // An earlier request that has passed brought the wake-up of this pass.
        let pending = self.armed.filter(|armed| *armed > now());
        if let Some(due) = due
            && pending.is_none_or(|armed| due < armed)
        {
            embassy_time_driver::schedule_wake(due.as_micros(), waker);
            self.armed = Some(due);
        } else {
            self.armed = pending;
        }
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
