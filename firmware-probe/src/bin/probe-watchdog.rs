//! The independent watchdog: five pets 50 ms apart, then none; after the watchdog's reset one by
//! software, after that nothing more.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_time::{Instant, Timer};
use firmware_probe::start;

const TIMEOUT_US: u32 = 100_000;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let cause = embassy_stm32::pac::RCC.csr().read();
    embassy_stm32::pac::RCC.csr().modify(|csr| csr.set_rmvf(true));
    let p = start();
    defmt::info!(
        "power-on {=bool} watchdog {=bool} software {=bool}",
        cause.porrstf(),
        cause.wdgrstf(),
        cause.sftrstf()
    );
    if cause.wdgrstf() {
        Timer::after_millis(5).await;
        cortex_m::peripheral::SCB::sys_reset();
    }
    if cause.sftrstf() {
        return;
    }
    let mut watchdog = IndependentWatchdog::new(p.IWDG, TIMEOUT_US);
    watchdog.unleash();
    for _ in 0..5 {
        Timer::after_millis(50).await;
        watchdog.pet();
    }
    defmt::info!("last pet at {=u64} us", Instant::now().as_micros());
}
