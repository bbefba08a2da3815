//! The UART between the two controllers: USART2 at 460 800 bit/s, 8N1, both directions by DMA.
//!
//! Reception runs into a ring without interrupts per byte; a reader is woken when the line falls
//! idle after a frame or half the ring is full.
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH5, DMA1_CH6, PD5, PD6, USART2};
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::{Peri, bind_interrupts, dma};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use shared_proto::Encoded;
use shared_proto::limits::{BIT_RATE, FRAME_MAX};
use static_cell::ConstStaticCell;

/// Bytes the receive ring holds: 11 ms of a line that is never idle, so a reader may be away for
/// more than a link cycle.
pub const RECEIVE_RING_LEN: usize = 512;

const _: () = {
    // Half the ring is what may arrive unnoticed: 8N1 puts ten bits on the line per byte.
    let half_ring_us = (RECEIVE_RING_LEN as u64 / 2) * 10 * 1_000_000 / BIT_RATE as u64;
    assert!(half_ring_us > 5_000);
};

/// Sends by DMA.
pub type LinkTransmitter = UartTx<'static, Async>;
/// Receives by DMA into the ring; reading may be cancelled without losing a byte.
pub type LinkReceiver = RingBufferedUartRx<'static>;

bind_interrupts!(struct Interrupts {
    USART2 => usart::InterruptHandler<USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
});

static RECEIVE_RING: ConstStaticCell<[u8; RECEIVE_RING_LEN]> =
    ConstStaticCell::new([0; RECEIVE_RING_LEN]);

/// The UART, its pins and its DMA streams.
pub struct LinkPins {
    /// The UART.
    pub uart: Peri<'static, USART2>,
    /// Receives.
    pub rx: Peri<'static, PD6>,
    /// Transmits.
    pub tx: Peri<'static, PD5>,
    /// DMA1 stream 6 feeds the transmitter.
    pub tx_dma: Peri<'static, DMA1_CH6>,
    /// DMA1 stream 5 empties the receiver.
    pub rx_dma: Peri<'static, DMA1_CH5>,
}

/// Opens the link port.
///
/// # Panics
/// When called twice, or when the bit rate cannot be had from the peripheral clock.
#[must_use]
pub fn open(pins: LinkPins) -> (LinkTransmitter, LinkReceiver) {
    let mut config = usart::Config::default();
    config.baudrate = BIT_RATE;
    // A cut or unconnected line rests at the idle level instead of picking up noise.
    config.rx_pull = embassy_stm32::gpio::Pull::Up;
    let uart = Uart::new(pins.uart, pins.rx, pins.tx, pins.tx_dma, pins.rx_dma, Interrupts, config);
    let (tx, rx) = defmt::unwrap!(uart).split();
    (tx, rx.into_ring_buffered(RECEIVE_RING.take()))
}

/// Frames on their way to [`transmit`]: an urgent one and what the cycle in hand brings.
pub const OUTBOX_LEN: usize = 4;
/// Encoded frames waiting for the line.
pub type Outbox = Channel<CriticalSectionRawMutex, Encoded, OUTBOX_LEN>;

/// Reached by DMA, so it lies in a static: no DMA controller reaches the stack in CCM.
static TRANSMITTED: ConstStaticCell<[u8; FRAME_MAX]> = ConstStaticCell::new([0; FRAME_MAX]);

/// Sends what is put into `outbox`.
pub async fn transmit(outbox: &Outbox, mut port: LinkTransmitter) -> ! {
    let bytes = TRANSMITTED.take();
    loop {
        let frame = outbox.receive().await;
        let (bytes, _) = bytes.split_at_mut(frame.len().min(FRAME_MAX));
        for (place, byte) in bytes.iter_mut().zip(&frame) {
            *place = *byte;
        }
        if let Err(error) = port.write(bytes).await {
            defmt::warn!("link: {}", error);
        }
    }
}
