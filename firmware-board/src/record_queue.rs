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
use crate::parameters::{NumberSet, Outcome, Parameters, Records};

/// Time for the frames that still wait for the link: they say that this controller goes.
const LAST_FRAMES_TIME: Duration = Duration::from_micros(FRAME_US_MAX * (OUTBOX_LEN as u64 + 1));

/// What the core wants stored.
pub struct RecordQueue {
    state: Mutex<CriticalSectionRawMutex, RefCell<State>>,
    changed: Signal<CriticalSectionRawMutex, ()>,
}

struct State {
    /// Comes before all that waits with it: what waited before it is forgotten at once.
    forget: bool,
    records: Records,
    set: Option<NumberSet>,
    confirm: Option<u8>,
    restart: bool,
}

enum Order {
    Forget,
    Store { key: u32, number: u32 },
    StoreSet,
    Confirm(u8),
    Restart,
}

impl RecordQueue {
    /// Nothing to store.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            state: Mutex::new(RefCell::new(State {
                forget: false,
                records: LinearMap::new(),
                set: None,
                confirm: None,
                restart: false,
            })),
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

    /// Has the numbers that are stored as a set replaced by these.
    pub fn put_set(&self, set: NumberSet) {
        self.state.lock(|state| state.borrow_mut().set = Some(set));
        self.changed.signal(());
    }

    /// Has everything forgotten that is stored or waits.
    pub fn forget(&self) {
        self.state.lock(|state| {
            let state = &mut *state.borrow_mut();
            state.records.clear();
            state.set = None;
            state.forget = true;
        });
        self.changed.signal(());
    }

    /// Has `number` confirmed when nothing waits any more.
    pub fn confirm(&self, number: u8) {
        self.state.lock(|state| state.borrow_mut().confirm = Some(number));
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
            if core::mem::take(&mut state.forget) {
                return Some(Order::Forget);
            }
            let key = state.records.keys().next().copied();
            if let Some((key, number)) =
                key.and_then(|key| state.records.remove(&key).map(|number| (key, number)))
            {
                return Some(Order::Store { key, number });
            }
            let set = state.set.is_some().then_some(Order::StoreSet);
            set.or_else(|| state.confirm.take().map(Order::Confirm))
                .or_else(|| state.restart.then_some(Order::Restart))
        })
    }

    fn take_set(&self) -> Option<NumberSet> {
        self.state.lock(|state| state.borrow_mut().set.take())
    }

    /// Stores what is put in, and restarts when asked to. `confirm` is told the numbers that are to
    /// be confirmed, and whether anything failed since the last one.
    pub async fn serve(
        &self,
        parameters: &mut Parameters,
        mut confirm: impl FnMut(u8, Outcome),
    ) -> ! {
        let mut failed = false;
        loop {
            while let Some(order) = self.take() {
                let outcome = match order {
                    Order::Forget => parameters.forget().await,
                    Order::Store { key, number } => parameters.keep(key, number).await,
                    Order::StoreSet => match self.take_set() {
                        Some(set) => parameters.keep_set(&set).await,
                        None => Outcome::Stored,
                    },
                    Order::Confirm(number) => {
                        let failed = core::mem::take(&mut failed);
                        confirm(number, if failed { Outcome::Failed } else { Outcome::Stored });
                        Outcome::Stored
                    }
                    Order::Restart => {
                        Timer::after(LAST_FRAMES_TIME).await;
                        cortex_m::peripheral::SCB::sys_reset();
                    }
                };
                failed |= outcome == Outcome::Failed;
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
