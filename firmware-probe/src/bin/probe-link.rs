//! The line between the controllers: every 20 ms sixteen bytes go out; what comes in is logged
//! with the instant the last byte of each burst was there.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{DMA1_CH5, DMA1_CH6, USART2};
use embassy_stm32::usart::{self, Uart, UartTx};
use embassy_stm32::{bind_interrupts, dma};
use embassy_time::{Duration, Instant, Ticker};
use firmware_probe::{start, unique_id};
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    USART2 => usart::InterruptHandler<USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
});

static RING: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);
static OUT: ConstStaticCell<[u8; 16]> = ConstStaticCell::new([0; 16]);

#[embassy_executor::task]
async fn send(mut line: UartTx<'static, Async>, first: u8) {
    let out = OUT.take();
    let mut tick = Ticker::every(Duration::from_millis(20));
    loop {
        tick.next().await;
        for (n, byte) in (first..).zip(out.iter_mut()) {
            *byte = n;
        }
        defmt::info!("sends at {=u64}", Instant::now().as_micros());
        if line.write(out.as_slice()).await.is_err() {
            defmt::warn!("cannot send");
        }
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let p = start();
    let first = unique_id()[2] * 0x40;
    let mut config = usart::Config::default();
    config.baudrate = 460_800;
    let Ok(line) = Uart::new(p.USART2, p.PD6, p.PD5, p.DMA1_CH6, p.DMA1_CH5, Interrupts, config)
    else {
        defmt::panic!("no line");
    };
    let (tx, rx) = line.split();
    let mut rx = rx.into_ring_buffered(RING.take());
    match send(tx, first) {
        Ok(task) => spawner.spawn(task),
        Err(_) => defmt::panic!("no task"),
    }
    let mut bytes = [0; 64];
    loop {
        match rx.read(&mut bytes).await {
            Ok(len) => {
                let got = bytes.get(..len).unwrap_or_default();
                defmt::info!("got {=[u8]:02x} at {=u64}", got, Instant::now().as_micros());
            }
            Err(_) => defmt::warn!("lost bytes"),
        }
    }
}
