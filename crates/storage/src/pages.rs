//! Pages that know whether their last erase was finished.
//!
//! An erase that loses its supply leaves any mixture of old and erased cells, and such a page can
//! look erased, full or half full. So the first [`STAMP_LEN`] bytes of every page hold a stamp that
//! is cleared before an erase and written after it: a page without its stamp is erased once more
//! before anything is read from it. The stamp names the layout of the records, too: another layout
//! counts as not erased.

use core::ops::Range;
use embedded_storage_async::nor_flash::{ErrorType, NorFlash, ReadNorFlash};

/// Bytes at the start of each page that belong to the stamp.
const STAMP_LEN: usize = 8;

/// Layout 1. Half its bits are set, so that neither clearing nor erasing some of them gets near it.
const STAMP: u64 = 0xA53C_96E1_5AC3_691E;

/// Bits of a stamp that may be wrong: decay of a cell must not cost a page of records. While an
/// erase is due the stamp is at least [`STAMP`]'s zeros or ones away.
const STAMP_BITS_WRONG_MAX: u32 = 4;

const _: () = assert!(STAMP.count_ones() == 32);

/// Most pages a store spans.
pub(crate) const PAGES_MAX: usize = 4;

/// A flash of pages shorter by their stamps, addressed from zero.
pub(crate) struct Pages<F> {
    flash: F,
    base: u32,
    count: u32,
    /// One bit per page that was stamped when opened and whose erase did not end since.
    erase_due: u8,
}

const _: () = assert!(PAGES_MAX <= u8::BITS as usize);

/// What [`Pages::open`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Found {
    /// Memory as it comes from the factory.
    Blank,
    /// Every page has its stamp.
    Stamped,
    /// At least one page had to be erased.
    EraseUnfinished,
}

impl<F: NorFlash> Pages<F> {
    const PAGE_LEN: u32 = {
        assert!(F::ERASE_SIZE <= 1 << 20, "page addresses are 32 bit");
        assert!(STAMP_LEN.is_multiple_of(F::WRITE_SIZE) && STAMP_LEN.is_multiple_of(F::READ_SIZE));
        #[expect(clippy::cast_possible_truncation, reason = "asserted above")]
        let len = (F::ERASE_SIZE - STAMP_LEN) as u32;
        len
    };

    #[expect(clippy::cast_possible_truncation, reason = "asserted with PAGE_LEN")]
    const SECTOR_LEN: u32 = Self::PAGE_LEN + STAMP_LEN as u32;

    /// The whole sectors of `range`; `None` unless there are 2..=[`PAGES_MAX`] of them.
    pub(crate) fn new(flash: F, range: &Range<u32>) -> Option<Self> {
        let len = range.end.checked_sub(range.start)?;
        let whole =
            range.start.is_multiple_of(Self::SECTOR_LEN) && len.is_multiple_of(Self::SECTOR_LEN);
        let count = len / Self::SECTOR_LEN;
        let fits = (2..=PAGES_MAX).contains(&usize::try_from(count).ok()?);
        (whole && fits).then_some(Self { flash, base: range.start, count, erase_due: 0 })
    }

    /// The addresses of all pages.
    pub(crate) fn range(&self) -> Range<u32> {
        0..self.count * Self::PAGE_LEN
    }

    /// Brings every page into a defined state: finishes the erases that were interrupted.
    pub(crate) async fn open(&mut self) -> Result<Found, F::Error> {
        let mut found = Found::Stamped;
        if self.is_blank().await? {
            for page in 0..self.count {
                self.write_stamp(page, STAMP).await?;
            }
            return Ok(Found::Blank);
        }
        for page in 0..self.count {
            if !self.is_stamped(page).await? {
                found = Found::EraseUnfinished;
                self.erase_page(page).await?;
            }
        }
        Ok(found)
    }

    async fn is_blank(&mut self) -> Result<bool, F::Error> {
        let mut chunk = [0; 64];
        let mut at = self.base;
        while at < self.base + self.count * Self::SECTOR_LEN {
            self.flash.read(at, &mut chunk).await?;
            if chunk.iter().any(|&byte| byte != 0xFF) {
                return Ok(false);
            }
            at += 64;
        }
        Ok(true)
    }

    async fn is_stamped(&mut self, page: u32) -> Result<bool, F::Error> {
        let mut stamp = [0; STAMP_LEN];
        self.flash.read(self.sector(page), &mut stamp).await?;
        Ok((u64::from_le_bytes(stamp) ^ STAMP).count_ones() <= STAMP_BITS_WRONG_MAX)
    }

    async fn write_stamp(&mut self, page: u32, stamp: u64) -> Result<(), F::Error> {
        self.flash.write(self.sector(page), &stamp.to_le_bytes()).await
    }

    async fn erase_page(&mut self, page: u32) -> Result<(), F::Error> {
        self.erase_due |= 1 << page;
        self.write_stamp(page, 0).await?;
        let sector = self.sector(page);
        self.flash.erase(sector, sector + Self::SECTOR_LEN).await?;
        self.write_stamp(page, STAMP).await?;
        self.erase_due &= !(1 << page);
        Ok(())
    }

    /// An erase may have failed, or the future that did it was dropped: nothing may be read from or
    /// written to such a page before it is erased.
    async fn finish_erase(&mut self, page: u32) -> Result<(), F::Error> {
        if self.erase_due & (1 << page) == 0 {
            return Ok(());
        }
        self.erase_page(page).await
    }

    fn sector(&self, page: u32) -> u32 {
        self.base + page * Self::SECTOR_LEN
    }

    fn page_of(address: u32) -> u32 {
        address / Self::PAGE_LEN
    }

    fn physical(&self, address: u32) -> u32 {
        let within = address % Self::PAGE_LEN;
        self.sector(Self::page_of(address)) + (Self::SECTOR_LEN - Self::PAGE_LEN) + within
    }
}

impl<F: NorFlash> ErrorType for Pages<F> {
    type Error = F::Error;
}

impl<F: NorFlash> ReadNorFlash for Pages<F> {
    const READ_SIZE: usize = F::READ_SIZE;

    /// Never across a page border: `sequential-storage` keeps its items within a page.
    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.finish_erase(Self::page_of(offset)).await?;
        let at = self.physical(offset);
        self.flash.read(at, bytes).await
    }

    fn capacity(&self) -> usize {
        usize::try_from(self.range().end).unwrap_or(usize::MAX)
    }
}

impl<F: NorFlash> NorFlash for Pages<F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = F::ERASE_SIZE - STAMP_LEN;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        for page in Self::page_of(from)..Self::page_of(to) {
            self.erase_page(page).await?;
        }
        Ok(())
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.finish_erase(Self::page_of(offset)).await?;
        let at = self.physical(offset);
        self.flash.write(at, bytes).await
    }
}
