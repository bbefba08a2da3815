//! The flash memory: its cells, and what erasing and programming does to them.
//!
//! The interface registers (keys, lock, option bytes, erase timing, wait states) are the model of
//! `rigless`; the array behind them is this one, after RM0090 sections 3.6 and 3.7:
//!
//! - programming clears bits and never sets one: a cell ends up as `old AND new`;
//! - a store with PG clear or CR locked is a sequence error (PGSERR), one whose width is not PSIZE
//!   a parallelism error (PGPERR), one across a 128-bit row an alignment error (PGAERR), one into
//!   a protected sector a write protection error (WRPERR); none of them changes a cell;
//! - a store while BSY stands waits for the operation under way;
//! - an operation that ends early, by loss of supply or reset, leaves a random part of it done.
//!
//! Times are typical values of the data sheet (DS9405 table 48).
use std::collections::VecDeque;
use std::num::NonZeroU32;
use std::ops::Range;

use rigless::device::{Device, DeviceContext, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::{Register, cr, optcr, sr};
use rigless::soc::stm32f427::peripherals::flash::{Flash, LOCK};
use rigless::soc::stm32f427::peripherals::rcc::HSI_HZ;
use rigless::time::{EventId, VirtualNanos};

use crate::memory_map::{FLASH_BASE, FLASH_LEN};
use world::Dice;

/// Programming one unit of any width: 16 µs.
const PROGRAM_NS: u64 = 16_000;

/// The supply of the boards.
const SUPPLY_MV: NonZeroU32 = NonZeroU32::new(3_300).expect("the supply is on");

/// Sectors of one bank.
const BANK_SECTORS: u64 = 12;
const BANK_LEN: usize = FLASH_LEN / 2;

/// A row that one program operation stays inside: 128 bits.
const ROW_BYTES: u64 = 16;

/// What erased cells hold, eight bytes at a time.
const ERASED: u64 = u64::MAX;
const WORD_BYTES: usize = 8;

/// Figures of one array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FlashCounts {
    /// Units programmed.
    pub(crate) programs: u64,
    /// Sectors erased.
    pub(crate) erases: u64,
}

/// The flash memory of one controller.
#[derive(Debug)]
pub(crate) struct FlashArray {
    interface: Flash,
    cells: Vec<u8>,
    operation: Option<Operation>,
    waiting: VecDeque<Store>,
    cut: Cut,
    dice: Dice,
    counts: FlashCounts,
}

/// What is being done to the cells.
#[derive(Debug)]
enum Operation {
    /// Timed by the interface.
    Erase {
        cells: Range<usize>,
        sectors: u64,
    },
    Program {
        store: Store,
        done: EventId,
    },
}

/// One store of the core into the array.
#[derive(Clone, Copy, Debug)]
struct Store {
    address: u64,
    width: Width,
    value: u64,
}

/// A loss of supply that was asked for in the middle of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cut {
    No,
    /// In this operation from now on; 1 is the next.
    In(u32),
    At(EventId),
}

impl FlashArray {
    /// An array holding `cells`, both banks.
    pub(crate) fn new(cells: Vec<u8>, dice: Dice) -> Self {
        assert_eq!(cells.len(), FLASH_LEN);
        Self {
            interface: interface(),
            cells,
            operation: None,
            waiting: VecDeque::new(),
            cut: Cut::No,
            dice,
            counts: FlashCounts::default(),
        }
    }

    /// Both banks as they are now.
    pub(crate) fn cells(&self) -> &[u8] {
        &self.cells
    }

    pub(crate) const fn counts(&self) -> FlashCounts {
        self.counts
    }

    /// Loses the supply in the middle of the `operation`-th operation from now.
    pub(crate) fn cut_at(&mut self, operation: u32) {
        self.cut = if operation == 0 { Cut::No } else { Cut::In(operation) };
    }

    /// The part restarts, with its registers at their reset values: an operation under way stays
    /// half done, the option bytes stay.
    pub(crate) fn restart(
        &mut self,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if let Some(operation) = self.operation.take() {
            self.leave_half_done(operation, context);
        }
        let (options, options1) = self.interface.committed_options();
        self.interface = interface();
        self.interface.keep_options(options, options1, registers);
        self.waiting.clear();
        if let Cut::At(_) = self.cut {
            self.cut = Cut::No;
        }
    }

    /// Sets and clears bits of SR and has the interface follow with its interrupt line.
    fn change_status(
        &mut self,
        set: u64,
        clear: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        registers.set(Register::Sr, registers.get(Register::Sr) & !clear | set);
        self.interface.write(Register::Sr, 0, registers, context);
    }

    fn refuse(
        &mut self,
        error: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let reported = cr::ERRIE.is_set(registers.get(Register::Cr));
        let operr = if reported { sr::OPERR.mask() } else { 0 };
        self.change_status(error | operr, 0, registers, context);
    }

    /// Takes up an erase the interface has just started.
    fn notice_erase(&mut self, registers: &RegisterFile, context: &mut DeviceContext<'_>) {
        let control = registers.get(Register::Cr);
        let erasing = sr::BSY.is_set(registers.get(Register::Sr)) && control >> 16 & 1 == 1;
        if self.operation.is_some() || !erasing {
            return;
        }
        let (cells, sectors) = match (cr::MER.is_set(control), cr::MER1.is_set(control)) {
            (true, true) => (0..FLASH_LEN, 2 * BANK_SECTORS),
            (true, false) => (0..BANK_LEN, BANK_SECTORS),
            (false, true) => (BANK_LEN..FLASH_LEN, BANK_SECTORS),
            (false, false) => (sector(cr::SNB.get(control)), 1),
        };
        let span = erase_ns(cells.len(), cr::PSIZE.get(control));
        self.operation = Some(Operation::Erase { cells, sectors });
        self.arm_cut(span, context);
    }

    fn start_store(
        &mut self,
        store: Store,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let control = registers.get(Register::Cr);
        let bytes = u64::from(store.width.bytes());
        let error = if !cr::PG.is_set(control) || LOCK.is_set(control) {
            Some(sr::PGSERR)
        } else if cr::PSIZE.get(control) != u64::from(store.width.bytes().trailing_zeros()) {
            Some(sr::PGPERR)
        } else if store.address % ROW_BYTES + bytes > ROW_BYTES {
            Some(sr::PGAERR)
        } else if protected(store.address, registers) {
            Some(sr::WRPERR)
        } else {
            None
        };
        if let Some(error) = error {
            self.refuse(error.mask(), registers, context);
            return;
        }
        self.change_status(sr::BSY.mask(), 0, registers, context);
        let done = context.schedule(VirtualNanos(context.now().0 + PROGRAM_NS));
        self.operation = Some(Operation::Program { store, done });
        self.arm_cut(PROGRAM_NS, context);
    }

    fn arm_cut(&mut self, span_ns: u64, context: &mut DeviceContext<'_>) {
        self.cut = match self.cut {
            Cut::In(1) => {
                let after = self.dice.below(span_ns);
                Cut::At(context.schedule(VirtualNanos(context.now().0 + after)))
            }
            Cut::In(more) => Cut::In(more - 1),
            Cut::No | Cut::At(_) => self.cut,
        };
    }

    /// An erase has run its time.
    fn finish_erase(&mut self, context: &mut DeviceContext<'_>) {
        if let Some(Operation::Erase { cells, sectors }) = self.operation.take() {
            self.counts.erases += sectors;
            for at in cells.step_by(WORD_BYTES) {
                self.set_word(at, ERASED, context);
            }
        }
    }

    fn finish_program(
        &mut self,
        store: Store,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.counts.programs += 1;
        self.clear_bits(store, store.value, context);
        let reported = cr::EOPIE.is_set(registers.get(Register::Cr));
        let eop = if reported { sr::EOP.mask() } else { 0 };
        self.change_status(eop, sr::BSY.mask(), registers, context);
        if let Some(next) = self.waiting.pop_front() {
            self.start_store(next, registers, context);
        }
    }

    fn leave_half_done(&mut self, operation: Operation, context: &mut DeviceContext<'_>) {
        match operation {
            Operation::Erase { cells, .. } => {
                for at in cells.step_by(WORD_BYTES) {
                    let progress = self.dice.draw();
                    let word = match progress % 3 {
                        0 => ERASED,
                        1 => self.word(at) | self.dice.draw(),
                        _ => self.word(at),
                    };
                    self.set_word(at, word, context);
                }
            }
            Operation::Program { store, .. } => {
                let partly = store.value | self.dice.draw();
                self.clear_bits(store, partly, context);
            }
        }
    }

    /// Programs `store`'s cells with `value`.
    fn clear_bits(&mut self, store: Store, value: u64, context: &mut DeviceContext<'_>) {
        let at = usize::try_from(store.address - FLASH_BASE).expect("inside the array");
        let at_word = at - at % WORD_BYTES;
        let shift = 8 * (at % WORD_BYTES);
        let kept = !(store.width.mask() << shift);
        let word = self.word(at_word) & (kept | (value & store.width.mask()) << shift);
        self.set_word(at_word, word, context);
    }

    fn word(&self, at: usize) -> u64 {
        let bytes = self.cells.get(at..at + WORD_BYTES).expect("inside the array");
        u64::from_le_bytes(bytes.try_into().expect("eight bytes"))
    }

    /// Changes the cells here and where the core reads them.
    fn set_word(&mut self, at: usize, word: u64, context: &mut DeviceContext<'_>) {
        if word != self.word(at) {
            let cells = self.cells.get_mut(at..at + WORD_BYTES).expect("inside the array");
            cells.copy_from_slice(&word.to_le_bytes());
            let address = FLASH_BASE + u64::try_from(at).expect("an offset fits");
            context.program(address, Width::W64, word, 0);
        }
    }
}

fn interface() -> Flash {
    let mut interface = Flash::with_clock(HSI_HZ);
    interface.set_supply(SUPPLY_MV);
    interface
}

/// The cells of sector `number` as SNB counts (3.9.8): 0 to 11 in bank 1, 16 to 27 in bank 2.
fn sector(number: u64) -> Range<usize> {
    let (bank, within) = if number < 16 { (0, number) } else { (1, number - 16) };
    let (start, len) = match within {
        0..=3 => (within * (16 << 10), 16 << 10),
        4 => (64 << 10, 64 << 10),
        _ => ((within - 4) * (128 << 10), 128 << 10),
    };
    let start = bank * BANK_LEN + usize::try_from(start).expect("inside a bank");
    start..start + len
}

/// Whether the sector of `address` is write protected: its nWRP bit is 0 (3.7.4).
fn protected(address: u64, registers: &RegisterFile) -> bool {
    let at = usize::try_from(address - FLASH_BASE).expect("inside the array");
    let (options, first) = if at < BANK_LEN {
        (registers.get(Register::Optcr), 0)
    } else {
        (registers.get(Register::Optcr1), 16)
    };
    (0..BANK_SECTORS)
        .find(|n| sector(first + n).contains(&at))
        .is_some_and(|n| optcr::NWRP.get(options) >> n & 1 == 0)
}

/// How long erasing `len` cells takes at parallelism `psize`.
fn erase_ns(len: usize, psize: u64) -> u64 {
    let by_width = match len >> 10 {
        ..=16 => [400, 300, 250],
        17..=64 => [1_200, 700, 550],
        65..=128 => [2_000, 1_300, 1_000],
        _ => [16_000, 11_000, 8_000],
    };
    let width = usize::try_from(psize.min(2)).expect("at most 2");
    by_width.get(width).map_or(0, |ms| ms * 1_000_000)
}

impl Device for FlashArray {
    type Register = Register;

    fn write(
        &mut self,
        register: Register,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        self.interface.write(register, value, registers, context);
        self.notice_erase(registers, context);
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.cut == Cut::At(event) {
            self.cut = Cut::No;
            context.request_power(false);
            return;
        }
        if let Some(Operation::Program { store, done }) = self.operation {
            if done == event {
                self.operation = None;
                self.finish_program(store, registers, context);
            }
            return;
        }
        self.interface.on_event(event, registers, context);
        let erasing = matches!(self.operation, Some(Operation::Erase { .. }));
        if erasing && !sr::BSY.is_set(registers.get(Register::Sr)) {
            self.finish_erase(context);
            if let Some(next) = self.waiting.pop_front() {
                self.start_store(next, registers, context);
            }
        }
        self.notice_erase(registers, context);
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.interface.on_clock(hz, registers, context);
    }

    fn write_region(
        &mut self,
        address: u64,
        width: Width,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> bool {
        let store = Store { address, width, value };
        if self.operation.is_some() {
            self.waiting.push_back(store);
        } else {
            self.start_store(store, registers, context);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory_map::BANK_2;
    use crate::stm32f429::Stm32f429;
    use rigless::emulator::{Error, Memory};
    use rigless::mcu::Operate as _;

    const KEYR: u64 = 0x4002_3C04;
    const OPTKEYR: u64 = 0x4002_3C08;
    const SR: u64 = 0x4002_3C0C;
    const CR: u64 = 0x4002_3C10;
    const OPTCR1: u64 = 0x4002_3C18;
    const PG: u64 = 1;
    const PSIZE_32: u64 = 2 << 8;
    const ERASE_SECTOR_12: u64 = 1 << 1 | 16 << 3 | 1 << 16;

    /// The cells are looked at in the array itself.
    struct NoMemory;

    impl Memory for NoMemory {
        fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
            Err(Error::Memory { address, width })
        }

        fn write(&mut self, address: u64, width: Width, _: u64) -> Result<(), Error> {
            Err(Error::Memory { address, width })
        }

        fn program(&mut self, _: u64, _: Width, _: u64) -> Result<(), Error> {
            Ok(())
        }
    }

    /// A part whose registers are written one by one, each 1 ms after the one before.
    struct Rig {
        part: Stm32f429,
        now: u64,
    }

    impl Rig {
        fn unlocked() -> Self {
            let flash = FlashArray::new(vec![0xFF; FLASH_LEN], Dice::new(7, 0));
            let mut rig = Self { part: Stm32f429::new(flash).unwrap(), now: 0 };
            rig.write(KEYR, 0x4567_0123, Width::W32);
            rig.write(KEYR, 0xCDEF_89AB, Width::W32);
            rig
        }

        fn pass(&mut self, ns: u64) {
            self.now += ns;
            self.part.advance_to(VirtualNanos(self.now));
            self.part.settle(&mut NoMemory).unwrap();
        }

        fn write(&mut self, address: u64, value: u64, width: Width) {
            self.part.write(VirtualNanos(self.now), address, width, value).unwrap();
            self.part.settle(&mut NoMemory).unwrap();
            self.pass(1_000_000);
        }

        fn status(&mut self) -> u64 {
            self.part.read(VirtualNanos(self.now), SR, Width::W32).unwrap()
        }

        fn word(&self, address: u64) -> u64 {
            self.part.flash.word(usize::try_from(address - FLASH_BASE).unwrap())
        }
    }

    #[test]
    fn a_store_clears_bits_and_sets_none() {
        let mut rig = Rig::unlocked();
        rig.write(CR, PG | PSIZE_32, Width::W32);
        rig.write(BANK_2 + 4, 0xF0F0_FFFF, Width::W32);
        rig.write(BANK_2 + 4, 0xFFFF_00FF, Width::W32);
        assert_eq!(rig.word(BANK_2), 0xF0F0_00FF_FFFF_FFFF);
        assert_eq!(rig.status(), 0);
        assert_eq!(rig.part.flash.counts(), FlashCounts { programs: 2, erases: 0 });
    }

    #[test]
    fn a_store_of_another_width_than_psize_is_a_parallelism_error() {
        let mut rig = Rig::unlocked();
        rig.write(CR, PG | PSIZE_32, Width::W32);
        rig.write(BANK_2, 0, Width::W8);
        assert_eq!((rig.status(), rig.word(BANK_2)), (sr::PGPERR.mask(), ERASED));
    }

    #[test]
    fn a_store_without_pg_is_a_sequence_error_that_a_written_one_clears() {
        let mut rig = Rig::unlocked();
        rig.write(BANK_2, 0, Width::W8);
        assert_eq!((rig.status(), rig.word(BANK_2)), (sr::PGSERR.mask(), ERASED));
        rig.write(SR, sr::PGSERR.mask(), Width::W32);
        assert_eq!(rig.status(), 0);
    }

    #[test]
    fn a_store_across_a_row_is_an_alignment_error() {
        let mut rig = Rig::unlocked();
        rig.write(CR, PG | PSIZE_32, Width::W32);
        rig.write(BANK_2 + 14, 0, Width::W32);
        assert_eq!((rig.status(), rig.word(BANK_2 + 8)), (sr::PGAERR.mask(), ERASED));
    }

    #[test]
    fn a_protected_sector_is_neither_programmed_nor_erased() {
        let mut rig = Rig::unlocked();
        rig.write(OPTKEYR, 0x0819_2A3B, Width::W32);
        rig.write(OPTKEYR, 0x4C5D_6E7F, Width::W32);
        rig.write(OPTCR1, 0x0FFE_0000, Width::W32);
        rig.write(CR, PG, Width::W32);
        rig.write(BANK_2, 0, Width::W8);
        assert_eq!((rig.status(), rig.word(BANK_2)), (sr::WRPERR.mask(), ERASED));
        rig.write(BANK_2 + (16 << 10), 0, Width::W8);
        assert_eq!(rig.word(BANK_2 + (16 << 10)), ERASED << 8);
        rig.write(SR, sr::WRPERR.mask(), Width::W32);
        rig.write(CR, ERASE_SECTOR_12, Width::W32);
        assert_eq!(rig.status(), sr::WRPERR.mask());
    }

    #[test]
    fn an_erase_takes_its_sector_and_its_time() {
        let mut rig = Rig::unlocked();
        rig.write(CR, PG, Width::W32);
        for at in [0, (16 << 10) - 1, 16 << 10] {
            rig.write(BANK_2 + at, 0, Width::W8);
        }
        rig.write(CR, ERASE_SECTOR_12, Width::W32);
        rig.pass(398_000_000);
        assert_eq!((rig.status(), rig.word(BANK_2)), (sr::BSY.mask(), ERASED << 8));
        rig.pass(2_000_000);
        assert_eq!((rig.status(), rig.word(BANK_2)), (0, ERASED));
        assert_eq!(rig.word(BANK_2 + (16 << 10) - 8), ERASED);
        assert_eq!(rig.word(BANK_2 + (16 << 10)), ERASED << 8, "the next sector");
    }

    #[test]
    fn a_store_during_an_erase_waits_for_it() {
        let mut rig = Rig::unlocked();
        rig.write(CR, ERASE_SECTOR_12, Width::W32);
        rig.write(BANK_2 + (32 << 10), 0, Width::W8);
        assert_eq!(rig.word(BANK_2 + (32 << 10)), ERASED);
        rig.pass(400_000_000);
        assert_eq!(rig.status(), sr::PGSERR.mask(), "PG was not set");
    }

    #[test]
    fn an_operation_cut_short_is_half_done() {
        use rigless::device::ResetCause;
        use rigless::mcu::Mcu as _;
        let mut rig = Rig::unlocked();
        rig.write(CR, PG, Width::W32);
        for at in 0..512 {
            rig.write(BANK_2 + at, 0, Width::W8);
        }
        rig.write(CR, ERASE_SECTOR_12, Width::W32);
        rig.part.reset(VirtualNanos(rig.now), ResetCause::Pin);
        rig.part.settle(&mut NoMemory).unwrap();
        let words: Vec<u64> = (0..64).map(|n| rig.word(BANK_2 + 8 * n)).collect();
        assert!(words.contains(&0) && words.contains(&ERASED), "{words:x?}");
        assert!(words.iter().any(|word| ![0, ERASED].contains(word)), "{words:x?}");
    }
}
