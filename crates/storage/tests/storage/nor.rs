//! A NOR flash whose supply can be cut in the middle of any operation.
//!
//! Programming only clears bits and erasing only sets them, as on the device. The operation a cut
//! falls into changes a random part of the bits it was about to change; what follows fails until
//! the next power-on. One operation is the programming of one word or the erase of one sector.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

pub(crate) const WORD_LEN: usize = 4;

/// A sector small enough that every few records the oldest one is recycled.
pub(crate) const SECTOR_LEN: usize = 256;
pub(crate) const SECTORS: usize = 4;
pub(crate) const LEN: usize = SECTOR_LEN * SECTORS;

pub(crate) type SmallNor = Nor<SECTOR_LEN>;

#[derive(Clone, Debug)]
pub(crate) struct Nor<const SECTOR: usize> {
    pub(crate) bytes: Vec<u8>,
    /// Erases of each sector since the start.
    pub(crate) erases: Vec<u32>,
    /// Operations since the last power-on.
    pub(crate) operations: u32,
    fault: Fault,
    random: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    None,
    /// The supply goes during this operation.
    PowerCut {
        at: u32,
    },
    /// Only this operation fails.
    Glitch {
        at: u32,
    },
    Unpowered,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Failed;

impl NorFlashError for Failed {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

impl<const SECTOR: usize> Nor<SECTOR> {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            bytes: vec![0xFF; SECTOR * SECTORS],
            erases: vec![0; SECTORS],
            operations: 0,
            fault: Fault::None,
            random: seed | 1,
        }
    }

    /// Powered on again, with all faults gone.
    pub(crate) fn powered(&self) -> Self {
        Self { operations: 0, fault: Fault::None, ..self.clone() }
    }

    /// Powered on again; the supply goes during operation `at`, counted from zero.
    pub(crate) fn cut_at(&self, at: u32, seed: u64) -> Self {
        let fault = Fault::PowerCut { at };
        Self { operations: 0, fault, random: seed | 1, ..self.clone() }
    }

    /// Powered on again; operation `at` is done in part and reported as failed, the rest works.
    pub(crate) fn glitch_at(&self, at: u32, seed: u64) -> Self {
        let fault = Fault::Glitch { at };
        Self { operations: 0, fault, random: seed | 1, ..self.clone() }
    }

    pub(crate) fn is_unpowered(&self) -> bool {
        self.fault == Fault::Unpowered
    }

    /// xorshift64: the tests need variety, not quality.
    fn random_byte(&mut self) -> u8 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 32) as u8
    }

    /// Brings the bytes at `at` to `goal`, or part of the way there.
    fn change(&mut self, at: usize, goal: &[u8]) -> Result<(), Failed> {
        if self.is_unpowered() {
            return Err(Failed);
        }
        let operation = self.operations;
        self.operations += 1;
        let torn = match self.fault {
            Fault::PowerCut { at } | Fault::Glitch { at } => at == operation,
            Fault::None | Fault::Unpowered => false,
        };
        // How far a torn operation got: between hardly at all and almost done.
        let progress = self.random_byte() % 3;
        for (offset, &goal) in goal.iter().enumerate() {
            let reached = match (torn, progress) {
                (false, _) => 0xFF,
                (true, 0) => self.random_byte() & self.random_byte() & self.random_byte(),
                (true, 1) => self.random_byte(),
                (true, _) => self.random_byte() | self.random_byte() | self.random_byte(),
            };
            let cell = &mut self.bytes[at + offset];
            *cell = (*cell & !reached) | (goal & reached);
        }
        if !torn {
            return Ok(());
        }
        self.fault = match self.fault {
            Fault::PowerCut { .. } | Fault::Unpowered => Fault::Unpowered,
            Fault::Glitch { .. } | Fault::None => Fault::None,
        };
        Err(Failed)
    }
}

impl<const SECTOR: usize> ErrorType for Nor<SECTOR> {
    type Error = Failed;
}

impl<const SECTOR: usize> ReadNorFlash for Nor<SECTOR> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Failed> {
        if self.is_unpowered() {
            return Err(Failed);
        }
        let at = offset as usize;
        bytes.copy_from_slice(&self.bytes[at..at + bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const SECTOR: usize> NorFlash for Nor<SECTOR> {
    const WRITE_SIZE: usize = WORD_LEN;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Failed> {
        let (from, to) = (from as usize, to as usize);
        assert!(from.is_multiple_of(SECTOR) && to.is_multiple_of(SECTOR), "unaligned erase");
        for at in (from..to).step_by(SECTOR) {
            self.erases[at / SECTOR] += 1;
            self.change(at, &[0xFF; SECTOR])?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failed> {
        let at = offset as usize;
        assert!(at.is_multiple_of(WORD_LEN) && bytes.len().is_multiple_of(WORD_LEN));
        for (index, word) in bytes.chunks(WORD_LEN).enumerate() {
            let at = at + index * WORD_LEN;
            let goal: Vec<u8> =
                word.iter().zip(&self.bytes[at..]).map(|(new, old)| new & old).collect();
            self.change(at, &goal)?;
        }
        Ok(())
    }
}
