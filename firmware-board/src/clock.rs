//! The clock tree (RM0090 section 6.2).
//!
//! HSE is the 8 MHz output of the board's ST-LINK, so the oscillator is bypassed. 160 MHz and not
//! the possible 180 MHz: APB1 at 40 MHz is what divides to all nine CiA bit rates.
use embassy_stm32::Config;
use embassy_stm32::pac::FLASH;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllSource, Sysclk,
};
use embassy_stm32::time::Hertz;

use crate::priority;

const HSE_HZ: u32 = 8_000_000;
const PLL_M: u32 = 4;
const PLL_N: u32 = 160;
const PLL_P: u32 = 2;
const PLL_INPUT_HZ: u32 = HSE_HZ / PLL_M;
const VCO_HZ: u32 = PLL_INPUT_HZ * PLL_N;

/// Clock of the core and of AHB, in hertz.
pub const SYSCLK_HZ: u32 = VCO_HZ / PLL_P;
/// Clock of CAN1, USART2, I2C1 and the independent timers' bus, in hertz.
pub const APB1_HZ: u32 = SYSCLK_HZ / 4;
/// Clock of SPI1, in hertz.
pub const APB2_HZ: u32 = SYSCLK_HZ / 2;

const _: () = {
    assert!(HSE_HZ.is_multiple_of(PLL_M) && VCO_HZ.is_multiple_of(PLL_P));
    // Data sheet limits: PLL input 0.95..2.1 MHz, VCO 100..432 MHz, APB1 45 MHz, APB2 90 MHz;
    // above 168 MHz the regulator would need its over-drive.
    assert!(PLL_INPUT_HZ >= 950_000 && PLL_INPUT_HZ <= 2_100_000);
    assert!(VCO_HZ >= 100_000_000 && VCO_HZ <= 432_000_000);
    assert!(SYSCLK_HZ == 160_000_000);
    assert!(APB1_HZ == 40_000_000 && APB2_HZ == 80_000_000);
};

/// What the HAL sets up at start: the clock tree and the priority of the DMA streams.
pub(crate) fn config() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(HSE_HZ), mode: HseMode::Bypass });
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
    config.dma_interrupt_priority = priority::DATA;
    config
}

/// Turns the flash accelerator on (RM0090 section 3.5.2), which the HAL leaves off: at 160 MHz flash
/// has five wait states, and without prefetch and caches every jump would pay for them.
pub(crate) fn accelerate_flash() {
    FLASH.acr().modify(|w| {
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
}
