//! The display: pictures to a segment driver, whatever chip it is.
//!
//! A picture is sent when it changed. A chip that does not answer is set up again with every
//! attempt, so a display that was plugged off or lost its supply comes back by itself.
use embassy_stm32::i2c::{self, I2c};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH7, I2C1, PB8, PB9};
use embassy_stm32::time::Hertz;
use embassy_stm32::{Peri, bind_interrupts, dma};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, TimeoutError, Timer, with_timeout};
use lcd::pcf8576;
use static_cell::ConstStaticCell;

/// The segments of a picture, as the core composes them.
pub(crate) type Picture = [u8; pcf8576::RAM_LEN];

/// A chip that shows pictures.
pub(crate) trait SegmentLcd {
    /// Why the chip did not take it.
    type Error: defmt::Format;

    /// Sets the chip up.
    async fn initialise(&mut self) -> Result<(), Self::Error>;

    /// Shows `picture` from now on.
    async fn show(&mut self, picture: &Picture) -> Result<(), Self::Error>;
}

const BUS_HZ: u32 = 400_000;
/// Nine clocks per byte and one byte of address take 0.6 ms; a chip may stretch the clock.
const WRITE_WITHIN: Duration = Duration::from_millis(5);
/// Pause before the next attempt at a chip that does not answer.
const RETRY_AFTER: Duration = Duration::from_millis(100);

bind_interrupts!(struct Interrupts {
    I2C1_EV => i2c::EventInterruptHandler<I2C1>;
    I2C1_ER => i2c::ErrorInterruptHandler<I2C1>;
    DMA1_STREAM7 => dma::InterruptHandler<DMA1_CH7>;
    DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
});

static BYTES: ConstStaticCell<[u8; pcf8576::REFRESH_LEN]> =
    ConstStaticCell::new([0; pcf8576::REFRESH_LEN]);

/// The I²C, its pins and its DMA streams. The chip is only written; the driver wants both streams.
pub(crate) struct Pins {
    pub(crate) i2c: Peri<'static, I2C1>,
    pub(crate) clock: Peri<'static, PB8>,
    pub(crate) data: Peri<'static, PB9>,
    pub(crate) tx_dma: Peri<'static, DMA1_CH7>,
    pub(crate) rx_dma: Peri<'static, DMA1_CH0>,
}

/// A chip of the PCF8576 family on I2C1.
pub(crate) struct Pcf8576 {
    i2c: I2c<'static, Async, i2c::Master>,
    /// Reached by DMA, so it lies in a static.
    bytes: &'static mut [u8; pcf8576::REFRESH_LEN],
}

impl Pcf8576 {
    pub(crate) fn new(pins: Pins) -> Self {
        let mut config = i2c::Config::default();
        config.frequency = Hertz(BUS_HZ);
        let i2c =
            I2c::new(pins.i2c, pins.clock, pins.data, pins.tx_dma, pins.rx_dma, Interrupts, config);
        Self { i2c, bytes: BYTES.take() }
    }

    async fn write(&mut self, len: usize) -> Result<(), i2c::Error> {
        let bytes = self.bytes.get(..len).unwrap_or(self.bytes);
        match with_timeout(WRITE_WITHIN, self.i2c.write(pcf8576::ADDRESS, bytes)).await {
            Ok(written) => written,
            Err(TimeoutError) => Err(i2c::Error::Timeout),
        }
    }
}

impl SegmentLcd for Pcf8576 {
    type Error = i2c::Error;

    async fn initialise(&mut self) -> Result<(), i2c::Error> {
        for (place, byte) in self.bytes.iter_mut().zip(pcf8576::INITIALISE) {
            *place = byte;
        }
        self.write(pcf8576::INITIALISE.len()).await
    }

    async fn show(&mut self, picture: &Picture) -> Result<(), i2c::Error> {
        *self.bytes = pcf8576::refresh(picture);
        self.write(pcf8576::REFRESH_LEN).await
    }
}

static PICTURE: Signal<CriticalSectionRawMutex, Picture> = Signal::new();

/// Hands a changed picture to the display; an older one that was not shown yet is dropped.
pub(crate) fn show(picture: Picture) {
    PICTURE.signal(picture);
}

/// Shows what [`show`] was given.
pub(crate) async fn run(mut lcd: impl SegmentLcd) -> ! {
    let mut chip = Chip::Unknown;
    let mut picture = PICTURE.wait().await;
    loop {
        let shown = match chip {
            Chip::Ready => lcd.show(&picture).await,
            Chip::Unknown | Chip::Silent => match lcd.initialise().await {
                Ok(()) => lcd.show(&picture).await,
                Err(error) => Err(error),
            },
        };
        match shown {
            Ok(()) => {
                if chip == Chip::Silent {
                    defmt::info!("display answers again");
                }
                chip = Chip::Ready;
                picture = PICTURE.wait().await;
            }
            Err(error) => {
                if chip != Chip::Silent {
                    defmt::warn!("display does not answer: {}", error);
                }
                chip = Chip::Silent;
                Timer::after(RETRY_AFTER).await;
                picture = PICTURE.try_take().unwrap_or(picture);
            }
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Chip {
    /// Not set up since the start.
    Unknown,
    Ready,
    /// Did not answer, and this was logged.
    Silent,
}
