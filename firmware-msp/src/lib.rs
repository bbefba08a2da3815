//! The shell of the application controller: pins, tasks, display, flash, watchdog. What a device
//! measures, shows and drives is in `application`; here is how inputs, bytes and time reach it.
//!
//! Everything runs in thread mode, and DMA moves all bytes: between two inputs the core sleeps.
#![no_std]

mod core_task;
mod display;
mod encoder;
mod fatal;
mod motor;
mod panel;

use application::{Application, Boot};
use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG;
use firmware_board::{LinkPins, LinkTransmitter, Parameters, supervise};
use profiles::Product;
use static_cell::StaticCell;

/// Runs the controller of `product`.
pub async fn run(spawner: Spawner, product: &'static Product) -> ! {
    static PARAMETERS: StaticCell<Parameters> = StaticCell::new();

    let started = firmware_board::start("application");
    let p = started.peripherals;
    // Before anything that takes time: the motor's lines are low, and stay so.
    let motor =
        motor::Motor::new(motor::Pins { in1: p.PE9, in2: p.PE11, in3: p.PF12, in4: p.PD15 });
    let panel = panel::Panel::new(panel::Pins {
        left: p.PF13,
        right: p.PF14,
        input_f: p.PF15,
        input_g: p.PE13,
        motor_fault: p.PD14,
    });
    let encoder = encoder::Encoder::new(encoder::Pins {
        spi: p.SPI1,
        clock: p.PA5,
        data: p.PA6,
        tx_dma: p.DMA2_CH3,
        rx_dma: p.DMA2_CH0,
    });
    let glass = display::Pcf8576::new(display::Pins {
        i2c: p.I2C1,
        clock: p.PB8,
        data: p.PB9,
        tx_dma: p.DMA1_CH7,
        rx_dma: p.DMA1_CH0,
    });
    let (link_tx, from_interface) = firmware_board::open(LinkPins {
        uart: p.USART2,
        rx: p.PD6,
        tx: p.PD5,
        tx_dma: p.DMA1_CH6,
        rx_dma: p.DMA1_CH5,
    });
    spawner.spawn(defmt::unwrap!(show(glass)));
    spawner.spawn(defmt::unwrap!(transmit(link_tx)));
    spawner.spawn(defmt::unwrap!(watch(p.IWDG)));
    let (parameters, records) = core_task::BEAT
        .during(async {
            let parameters = PARAMETERS.init(Parameters::open(p.FLASH).await);
            let records = parameters.load().await;
            (parameters, records)
        })
        .await;
    let stored = records.iter().map(|(key, number)| (*key, *number));
    let application = Application::new(product, Boot { nonce: started.number }, stored);
    spawner.spawn(defmt::unwrap!(keep(parameters)));
    core_task::Core { application, encoder, panel, motor, from_interface }.run().await
}

#[embassy_executor::task]
async fn show(glass: display::Pcf8576) -> ! {
    display::run(glass).await
}

#[embassy_executor::task]
async fn transmit(port: LinkTransmitter) -> ! {
    firmware_board::transmit(&core_task::TO_INTERFACE, port).await
}

#[embassy_executor::task]
async fn watch(watchdog: Peri<'static, IWDG>) -> ! {
    supervise(watchdog, &[&core_task::BEAT], || {}).await
}

#[embassy_executor::task]
async fn keep(parameters: &'static mut Parameters) -> ! {
    core_task::RECORDS.serve(parameters, |_, _| {}).await
}
