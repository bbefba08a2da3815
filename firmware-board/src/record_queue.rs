//! Records on their way from the core to the flash.
//!
//! Erasing a sector takes up to half a second; in that time a master can write the same parameters
//! any number of times. Only the latest number of each has to reach the flash, so what waits is
//! bounded by the number of parameters.
use core::cell::RefCell;

use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Timer};
use heapless::LinearMap;
use shared_proto::limits::FRAME_US_MAX;

use crate::link_port::OUTBOX_LEN;
use crate::parameters::{Parameters, Records};

/// Time for the frames that still wait for the link: they say that this controller goes.
const LAST_FRAMES_TIME: Duration = Duration::from_micros(FRAME_US_MAX * (OUTBOX_LEN as u64 + 1));

/// What the core wants stored.
pub struct RecordQueue {
    state: Mutex<CriticalSectionRawMutex, RefCell<State>>,
    changed: Signal<CriticalSectionRawMutex, ()>,
}

struct State {
    records: Records,
    restart: bool,
}

enum Order {
    Store { key: u32, number: u32 },
    Restart,
}

impl RecordQueue {
    /// Nothing to store.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: Mutex::new(RefCell::new(State { records: LinearMap::new(), restart: false })),
            changed: Signal::new(),
        }
    }

    /// Has `number` stored under `key`; an earlier number of the same key that is still waiting
    /// never will be.
    pub fn put(&self, key: u32, number: u32) {
        let put = self.state.lock(|state| state.borrow_mut().records.insert(key, number));
        if put.is_err() {
            defmt::error!("more parameters than places: {=u32:#x} not stored", key);
        }
        self.changed.signal(());
    }

    /// Restarts the controller once everything is stored and the other one has been told.
    pub fn restart(&self) {
        self.state.lock(|state| state.borrow_mut().restart = true);
        self.changed.signal(());
    }

    fn take(&self) -> Option<Order> {
        self.state.lock(|state| {
            let state = &mut *state.borrow_mut();
            let key = state.records.keys().next().copied();
            match key.and_then(|key| state.records.remove(&key).map(|number| (key, number))) {
                Some((key, number)) => Some(Order::Store { key, number }),
                None => state.restart.then_some(Order::Restart),
            }
        })
    }

    /// Stores what is put in, and restarts when asked to.
    pub async fn serve(&self, parameters: &mut Parameters) -> ! {
        loop {
            while let Some(order) = self.take() {
                match order {
                    Order::Store { key, number } => parameters.keep(key, number).await,
                    Order::Restart => {
                        Timer::after(LAST_FRAMES_TIME).await;
                        cortex_m::peripheral::SCB::sys_reset();
                    }
                }
            }
            self.changed.wait().await;
        }
    }
}

impl Default for RecordQueue {
    fn default() -> Self {
        Self::new()
    }
}
