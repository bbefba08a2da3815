//! What every image does first.
use core::num::NonZeroU32;

use embassy_stm32::Peripherals;

use crate::clock::{accelerate_flash, config};
use crate::last_words::report_last_words;
use crate::priority;
use crate::reset_cause::ResetCause;
use crate::start_number::count_start;

/// The controller after [`start`].
pub struct Started {
    /// All peripherals.
    pub peripherals: Peripherals,
    /// Tells this start from the one before.
    pub number: NonZeroU32,
}

/// Sets up clocks and priorities and logs why the controller started and what stopped it before.
#[must_use]
pub fn start(image: &str) -> Started {
    let number = count_start();
    let peripherals = embassy_stm32::init(config());
    accelerate_flash();
    priority::assign();
    defmt::info!("{=str}: start {=u32}, {}", image, number.get(), ResetCause::take());
    report_last_words();
    Started { peripherals, number }
}
