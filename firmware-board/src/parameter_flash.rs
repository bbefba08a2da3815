//! The sectors the stored parameters live in: bank 2, sectors 12..15, 4 x 16 KB (RM0090 table 6).
//!
//! Code runs from bank 1, so erasing and programming here stop neither the core nor a DMA transfer;
//! the caller's task waits for the flash interrupt.
use embassy_stm32::flash::{self, Async, Error, Flash};
use embassy_stm32::peripherals::FLASH;
use embassy_stm32::{Peri, bind_interrupts};
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

bind_interrupts!(struct Interrupts {
    FLASH => flash::InterruptHandler;
});

/// Distance of sector 12 from the start of flash.
const FIRST_SECTOR: u32 = 0x10_0000;
const SECTOR_LEN: usize = 16 * 1024;
const SECTORS: usize = 4;
/// Programmed at once: one 32-bit word, the widest the 3.3 V supply allows (RM0090 table 16).
const WORD_LEN: usize = 4;

/// The parameter sectors as NOR flash whose addresses start at zero.
pub(crate) struct ParameterFlash(Flash<'static, Async>);

impl ParameterFlash {
    /// Bytes in the parameter sectors.
    #[expect(clippy::cast_possible_truncation, reason = "64 KB")]
    pub(crate) const LEN: u32 = (SECTORS * SECTOR_LEN) as u32;

    /// Takes the flash controller.
    pub(crate) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self(Flash::new(flash, Interrupts))
    }

    /// The place in flash of the `len` bytes at `offset`.
    fn place(offset: u32, len: usize) -> Result<u32, Error> {
        let end = u32::try_from(len).ok().and_then(|len| offset.checked_add(len));
        if end.is_some_and(|end| end <= Self::LEN) {
            Ok(FIRST_SECTOR + offset)
        } else {
            Err(Error::Size)
        }
    }
}

impl ErrorType for ParameterFlash {
    type Error = Error;
}

impl ReadNorFlash for ParameterFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Error> {
        let place = Self::place(offset, bytes.len())?;
        self.0.blocking_read(place, bytes)
    }

    fn capacity(&self) -> usize {
        SECTORS * SECTOR_LEN
    }
}

impl NorFlash for ParameterFlash {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = SECTOR_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Error> {
        if from > to || to > Self::LEN {
            return Err(Error::Size);
        }
        self.0.erase(FIRST_SECTOR + from, FIRST_SECTOR + to).await
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Error> {
        let place = Self::place(offset, bytes.len())?;
        self.0.write(place, bytes).await
    }
}
