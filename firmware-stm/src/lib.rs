//! The shell of the CAN interface controller: pins, interrupts, tasks, flash, watchdog. What a
//! CANopen device does is in `interface`; here is how frames, bytes and time reach it.
//!
//! Two levels (`firmware_board::priority`): the core runs in the CAN handlers and on an interrupt
//! executor of their priority; link, flash and watchdog run in thread mode.
#![no_std]

mod can;
mod core_task;
mod fatal;
mod link;

use embassy_executor::Spawner;
use embassy_stm32::Peri;
use embassy_stm32::peripherals::IWDG;
use firmware_board::{
    LinkPins, LinkReceiver, LinkTransmitter, Parameters, serial_number, supervise,
};
use heapless::spsc::{Producer, Queue};
use interface::{Boot, Interface};
use profiles::Product;
use static_cell::{ConstStaticCell, StaticCell};

/// Bytes between the link's task and the core, which is asked to look after each chunk.
const LINK_QUEUE_LEN: usize = 256;

/// Runs the controller of `product`.
pub async fn run(spawner: Spawner, product: &'static Product) -> ! {
    static LINK_QUEUE: ConstStaticCell<Queue<u8, LINK_QUEUE_LEN>> =
        ConstStaticCell::new(Queue::new());
    static PARAMETERS: StaticCell<Parameters> = StaticCell::new();
    static INTERFACE: StaticCell<Interface> = StaticCell::new();

    let started = firmware_board::start("interface");
    let p = started.peripherals;
    let (to_core, from_application) = LINK_QUEUE.take().split();
    let (link_tx, link_rx) = firmware_board::open(LinkPins {
        uart: p.USART2,
        rx: p.PD6,
        tx: p.PD5,
        tx_dma: p.DMA1_CH6,
        rx_dma: p.DMA1_CH5,
    });
    spawner.spawn(defmt::unwrap!(receive(link_rx, to_core)));
    spawner.spawn(defmt::unwrap!(transmit(link_tx)));
    spawner.spawn(defmt::unwrap!(watch(p.IWDG)));
    let (parameters, records) = core_task::BEAT
        .during(async {
            let parameters = PARAMETERS.init(Parameters::open(p.FLASH).await);
            let records = parameters.load().await;
            (parameters, records)
        })
        .await;
    let boot = Boot { serial_number: serial_number(), nonce: started.number.get() };
    let stored = records.iter().map(|(key, number)| (*key, *number));
    let interface = INTERFACE.init_with(|| Interface::new(core_task::now(), product, boot, stored));
    let port = can::Port::new(can::Pins { can: p.CAN1, rx: p.PD0, tx: p.PD1 });
    core_task::start(core_task::Parts { interface, port, from_application });
    core_task::RECORDS.serve(parameters, core_task::confirm).await
}

#[embassy_executor::task]
async fn receive(port: LinkReceiver, to_core: Producer<'static, u8>) -> ! {
    link::receive(port, to_core).await
}

#[embassy_executor::task]
async fn transmit(port: LinkTransmitter) -> ! {
    firmware_board::transmit(&core_task::TO_APPLICATION, port).await
}

#[embassy_executor::task]
async fn watch(watchdog: Peri<'static, IWDG>) -> ! {
    supervise(watchdog, &[&core_task::BEAT, &link::BEAT], core_task::wake).await
}
