//! The LCD chip's end of the I2C bus.
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rigless::chip::{Timeline, i2c};
use rigless::snapshot::Store;
use world::Surroundings;
use world::lcd_chip::Direction;

/// The chip of `surroundings` on the bus.
#[derive(Debug)]
pub(crate) struct LcdPort(pub(crate) Arc<Mutex<Surroundings>>);

impl LcdPort {
    fn world(&self) -> MutexGuard<'_, Surroundings> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store for LcdPort {}

impl i2c::Peer for LcdPort {
    fn start(&mut self, address: u8, read: bool, _: &mut Timeline<'_, '_>) -> bool {
        let direction = if read { Direction::Read } else { Direction::Write };
        self.world().lcd.start(address, direction)
    }

    fn write(&mut self, byte: u8, _: &mut Timeline<'_, '_>) -> bool {
        self.world().lcd.write(byte);
        true
    }

    fn read(&mut self, _last: bool, _: &mut Timeline<'_, '_>) -> u8 {
        u8::MAX
    }

    fn stop(&mut self, _: &mut Timeline<'_, '_>) {
        self.world().lcd.stop();
    }
}
