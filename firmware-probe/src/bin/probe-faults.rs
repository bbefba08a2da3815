//! What no controller may do. Which of it, the first byte of flash bank 2 says.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::pac;
use embassy_time::Timer;
use firmware_probe::start;

/// TIM6, which the boards do not use and the bench does not have.
const CHOICE: *const u8 = 0x0810_0000 as *const u8;
const NOT_THERE: *const u32 = 0x4000_1000 as *const u32;

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let _peripherals = start();
    Timer::after_millis(2).await;
    match chosen() {
        0 => not_there(),
        1 => dma_into_ccm(),
        2 => gated(),
        _ => {}
    }
    defmt::info!("done");
}

#[expect(unsafe_code, reason = "the choice lies outside the image")]
fn chosen() -> u8 {
    // SAFETY: flash memory, which nothing writes while this runs.
    unsafe { CHOICE.read_volatile() }
}

#[expect(unsafe_code, reason = "the probe does what must be noticed")]
fn not_there() {
    // SAFETY: a read of a peripheral register has no effect on memory.
    let value = unsafe { NOT_THERE.read_volatile() };
    defmt::info!("read {=u32}", value);
}

fn dma_into_ccm() {
    pac::DMA1.st(6).m0ar().write_value(0x1000_0100);
}

fn gated() {
    pac::RCC.apb2enr().modify(|enable| enable.set_spi1en(false));
    defmt::info!("read {=u32}", pac::SPI1.cr1().read().0);
}
