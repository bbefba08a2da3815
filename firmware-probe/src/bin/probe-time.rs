//! How long delays of 1 ms to 1 s really take.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_time::{Instant, Timer};
use firmware_probe::start;

const DELAYS_MS: [u64; 17] =
    [1, 5, 15, 30, 48, 49, 50, 50, 60, 64, 65, 66, 100, 131, 200, 500, 1_000];

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let _peripherals = start();
    defmt::info!("started after {=u64} us", Instant::now().as_micros());
    for ms in DELAYS_MS {
        let began = Instant::now();
        Timer::after_millis(ms).await;
        defmt::info!("{=u64} ms took {=u64} us", ms, began.elapsed().as_micros());
    }
    defmt::info!("done");
}
