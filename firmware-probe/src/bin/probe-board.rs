//! What the application controller's board wires to it: keys, inputs, motor lines, encoder, LCD.
//! Every 10 ms the levels of the inputs are logged when they changed and the encoder is read; the
//! motor follows the keys, left slow, right fast; the LCD shows 8 in its first place.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::gpio::{Input, Level, Output, Pull, Speed};
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH7, DMA2_CH0, DMA2_CH3, I2C1};
use embassy_stm32::spi::{self, MODE_2, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::{bind_interrupts, dma};
use embassy_time::{Duration, Ticker};
use firmware_probe::start;
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM7 => dma::InterruptHandler<DMA1_CH7>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
    DMA2_STREAM0 => dma::InterruptHandler<DMA2_CH0>;
    DMA2_STREAM3 => dma::InterruptHandler<DMA2_CH3>;
});

const LCD: u8 = 0x38;
static WORD: ConstStaticCell<[u8; 4]> = ConstStaticCell::new([0; 4]);
static PICTURE: ConstStaticCell<[u8; 7]> =
    ConstStaticCell::new([0xC8, 0xF8, 0xF0, 0xE0, 0x00, 0b1110_1111, 0]);

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let p = start();
    let mut config = i2c::Config::default();
    config.frequency = Hertz(400_000);
    let mut lcd = I2c::new(p.I2C1, p.PB8, p.PB9, p.DMA1_CH7, p.DMA1_CH0, Interrupts, config);
    let shown = lcd.write(LCD, PICTURE.take()).await.is_ok();
    let nobody = lcd.blocking_write(LCD + 1, &[0]).is_err();
    defmt::info!("lcd {=bool} nobody {=bool}", shown, nobody);

    let mut config = spi::Config::default();
    config.frequency = Hertz(625_000);
    config.mode = MODE_2;
    config.miso_pull = Pull::Up;
    let mut encoder =
        Spi::new_rxonly(p.SPI1, p.PA5, p.PA6, p.DMA2_CH3, p.DMA2_CH0, Interrupts, config);
    let word = WORD.take();

    let left = Input::new(p.PF13, Pull::Up);
    let right = Input::new(p.PF14, Pull::Up);
    let f = Input::new(p.PF15, Pull::Down);
    let g = Input::new(p.PE13, Pull::Down);
    let fault = Input::new(p.PD14, Pull::Down);
    let mut in1 = Output::new(p.PE9, Level::Low, Speed::Low);
    let mut in2 = Output::new(p.PE11, Level::Low, Speed::Low);
    let mut in3 = Output::new(p.PF12, Level::Low, Speed::Low);
    let mut in4 = Output::new(p.PD15, Level::Low, Speed::Low);

    let mut before = [false; 5];
    let mut tick = Ticker::every(Duration::from_millis(10));
    loop {
        tick.next().await;
        let read = encoder.read(word.as_mut_slice()).await.is_ok();
        let levels = [left.is_high(), right.is_high(), f.is_high(), g.is_high(), fault.is_high()];
        in1.set_level(Level::from(left.is_low()));
        in2.set_level(Level::from(right.is_low()));
        in3.set_level(Level::from(left.is_low() || right.is_low()));
        in4.set_level(Level::from(right.is_low()));
        defmt::info!("ssi {=bool} {=u32:#010x}", read, u32::from_be_bytes(*word));
        if levels != before {
            defmt::info!("pins {}", levels);
            before = levels;
        }
    }
}
