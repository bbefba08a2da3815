//! The CAN interface controller of the NM172.
#![no_std]
#![no_main]

use profiles::nm172;

#[embassy_executor::main]
async fn main(spawner: embassy_executor::Spawner) {
    firmware_stm::run(spawner, &nm172::PRODUCT).await
}
