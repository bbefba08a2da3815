//! What the flash memory does with an erase, a store, a second store and a forbidden one.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_stm32::bind_interrupts;
use embassy_stm32::flash::{Flash, InterruptHandler};
use embassy_time::Instant;
use firmware_probe::start;

bind_interrupts!(struct Interrupts {
    FLASH => InterruptHandler;
});

/// Sector 12, the first of bank 2, as an offset from the start of the flash memory.
const SECTOR: u32 = 0x10_0000;
const SECTOR_LEN: u32 = 16 << 10;
const SECTOR_ADDRESS: *mut u32 = 0x0810_0000 as *mut u32;

#[expect(unsafe_code, reason = "the probe reads and writes flash cells as the core does")]
fn cell(index: usize) -> u32 {
    // SAFETY: within the sector, aligned, and nothing holds a reference to it.
    unsafe { SECTOR_ADDRESS.add(index).read_volatile() }
}

#[expect(unsafe_code, reason = "the probe reads and writes flash cells as the core does")]
fn store(index: usize, value: u32) {
    // SAFETY: within the sector, aligned, and nothing holds a reference to it.
    unsafe { SECTOR_ADDRESS.add(index).write_volatile(value) }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    let peripherals = start();
    let mut flash = Flash::new(peripherals.FLASH, Interrupts);
    let found = cell(0);
    defmt::info!("found {=u32:#x}", found);
    let runs = if found == u32::MAX { 1 } else { found + 1 };

    let began = Instant::now();
    let erased = flash.erase(SECTOR, SECTOR + SECTOR_LEN).await.is_ok();
    let took = began.elapsed().as_millis();
    defmt::info!("erase {=bool} {=u64} ms, cell {=u32:#x}", erased, took, cell(1));

    let written = flash.write(SECTOR, &runs.to_le_bytes()).await.is_ok();
    defmt::info!("write {=bool} cell {=u32:#x}", written, cell(0));

    let first = flash.write(SECTOR + 4, &0xFFFF_0F0F_u32.to_le_bytes()).await.is_ok();
    let second = flash.write(SECTOR + 4, &0x0FF0_FFFF_u32.to_le_bytes()).await.is_ok();
    defmt::info!("and {=bool} {=bool} cell {=u32:#x}", first, second, cell(1));

    store(2, 0);
    let status = embassy_stm32::pac::FLASH.sr().read();
    defmt::info!("locked: pgserr {=bool} cell {=u32:#x}", status.pgserr(), cell(2));
    defmt::info!("done");
}
