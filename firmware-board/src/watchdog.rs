//! The independent watchdog (RM0090 chapter 21) and who has to be alive for it to be served.
use core::future::Future;
use core::sync::atomic::{AtomicBool, Ordering};

use embassy_futures::select::{Either, select};
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Duration, Ticker};

/// How often the watchdog is served, provided that everybody has shown up since the last time.
const PET_EVERY: Duration = Duration::from_millis(25);

/// How often a task shows up when nothing else makes it.
pub const SHOW_UP_EVERY: Duration = Duration::from_ticks(PET_EVERY.as_ticks() / 2);

/// Opening the memory may erase all four sectors, 0.5 s each.
const START_WITHIN: Duration = Duration::from_secs(5);

/// Microseconds until the reset at the nominal 32 kHz of the LSI.
const BITE_AFTER_US: u32 = 200_000;

const _: () = {
    // The LSI runs at 17..47 kHz: at its fastest there is still room for a second missed beat.
    assert!(BITE_AFTER_US as u64 * 32 / 47 > 3 * PET_EVERY.as_micros());
};

/// The sign of life of one task: set by the task in less than 25 ms, taken by the
/// watchdog.
pub struct Beat(AtomicBool);

impl Beat {
    /// A task that has not shown up yet.
    #[must_use]
    pub const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// The task is alive.
    pub fn show(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Shows up for a task that is still busy with `work` at the start, for 5 s at
    /// most.
    pub async fn during<T>(&self, work: impl Future<Output = T>) -> T {
        let keep_up = async {
            let mut round = Ticker::every(SHOW_UP_EVERY);
            for _ in 0..START_WITHIN.as_ticks() / SHOW_UP_EVERY.as_ticks() {
                self.show();
                round.next().await;
            }
            core::future::pending::<core::convert::Infallible>().await
        };
        match select(work, keep_up).await {
            Either::First(result) => result,
            Either::Second(never) => match never {},
        }
    }

    fn shown(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Default for Beat {
    fn default() -> Self {
        Self::new()
    }
}

/// Starts the watchdog and serves it whenever all `beats` were shown; `remind` is called once per
/// round, to wake tasks that would otherwise wait for an event.
///
/// A task that stays away is waited for, not counted: the watchdog itself is the limit.
pub async fn supervise(iwdg: Peri<'static, IWDG>, beats: &[&Beat], remind: impl Fn()) -> ! {
    let mut watchdog = IndependentWatchdog::new(iwdg, BITE_AFTER_US);
    watchdog.unleash();
    let mut round = Ticker::every(PET_EVERY);
    loop {
        if beats.iter().all(|beat| beat.shown()) {
            watchdog.pet();
            for beat in beats {
                beat.0.store(false, Ordering::Relaxed);
            }
        }
        remind();
        round.next().await;
    }
}
