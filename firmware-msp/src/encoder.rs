//! The absolute encoder: SSI over SPI1.
//!
//! The clock rests high; the encoder latches its position at the first falling edge and shifts at
//! the rising ones, so every bit is sampled at a falling edge (CPOL = 1, CPHA = 0). One read is 32
//! clocks for a sensor of 25 bits. What the bits mean, and whether they can be believed, is decided
//! by the core: the idle level ahead of the data and the monoflop time behind it are among them.
use embassy_stm32::gpio::Pull;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA2_CH0, DMA2_CH3, PA5, PA6, SPI1};
use embassy_stm32::spi::mode::Master;
use embassy_stm32::spi::{self, BitOrder, MODE_2, Spi};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, dma};
use firmware_board::APB2_HZ;
use static_cell::ConstStaticCell;

/// Bytes of one read: 32 falling edges.
pub(crate) const READ_LEN: usize = 4;

/// 80 MHz by 128. The encoder's limit is 1 MHz, a line of 100 m would allow 400 kHz; this one is
/// a few centimetres.
const CLOCK_HZ: u32 = APB2_HZ / 128;

bind_interrupts!(struct Interrupts {
    DMA2_STREAM0 => dma::InterruptHandler<DMA2_CH0>;
    DMA2_STREAM3 => dma::InterruptHandler<DMA2_CH3>;
});

static BYTES: ConstStaticCell<[u8; READ_LEN]> = ConstStaticCell::new([0; READ_LEN]);

/// The SPI, its pins and its DMA streams.
pub(crate) struct Pins {
    pub(crate) spi: Peri<'static, SPI1>,
    pub(crate) clock: Peri<'static, PA5>,
    pub(crate) data: Peri<'static, PA6>,
    pub(crate) tx_dma: Peri<'static, DMA2_CH3>,
    pub(crate) rx_dma: Peri<'static, DMA2_CH0>,
}

/// Reads the raw bits of the encoder.
pub(crate) struct Encoder {
    spi: Spi<'static, Async, Master>,
    /// Reached by DMA, so it lies in a static.
    bytes: &'static mut [u8; READ_LEN],
}

impl Encoder {
    pub(crate) fn new(pins: Pins) -> Self {
        let mut config = spi::Config::default();
        config.frequency = Hertz(CLOCK_HZ);
        config.mode = MODE_2;
        config.bit_order = BitOrder::MsbFirst;
        // A broken wire then reads as all ones, which the check of the monoflop time refuses.
        config.miso_pull = Pull::Up;
        let spi = Spi::new_rxonly(
            pins.spi,
            pins.clock,
            pins.data,
            pins.tx_dma,
            pins.rx_dma,
            Interrupts,
            config,
        );
        Self { spi, bytes: BYTES.take() }
    }

    /// One read, 51 µs long. `None` when the controller's own SPI failed, which no sensor causes.
    pub(crate) async fn read(&mut self) -> Option<[u8; READ_LEN]> {
        self.spi.read(self.bytes.as_mut_slice()).await.ok()?;
        Some(*self.bytes)
    }
}
