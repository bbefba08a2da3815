//! Small images with known answers, which hold the bench to account before it judges a product:
//! each does one thing with a peripheral and logs what it saw.
#![no_std]

use defmt_rtt as _;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Config, Peripherals};
use panic_probe as _;

/// Starts the part on the board's clock: 8 MHz from the ST-LINK, SYSCLK 160 MHz, APB1 40 MHz, APB2
/// 80 MHz.
#[must_use]
pub fn start() -> Peripherals {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(8_000_000), mode: HseMode::Bypass });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV4,
        mul: PllMul::MUL160,
        divp: Some(PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    embassy_stm32::init(config)
}

/// The 96-bit unique device ID.
#[must_use]
pub fn unique_id() -> [u8; 12] {
    embassy_stm32::uid::uid()
}
