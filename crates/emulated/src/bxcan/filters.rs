use world::can::{Frame, Id};

use super::registers::{fmr, ir};

/// Banks of the part, shared by both of its controllers.
pub(super) const BANKS: usize = 28;

/// The filter banks (RM0090, 32.7.4).
#[derive(Clone, Debug)]
pub(super) struct Filters {
    master: u32,
    list: u32,
    wide: u32,
    fifo: u32,
    active: u32,
    banks: [[u32; 2]; BANKS],
}

/// Where a frame goes: the FIFO and the number of the filter that let it pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Match {
    pub(super) fifo: usize,
    pub(super) index: u8,
}

/// One register of the filters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FilterRegister {
    /// FMR.
    Master,
    /// FM1R.
    Mode,
    /// FS1R.
    Scale,
    /// FFA1R.
    Assignment,
    /// FA1R.
    Activation,
    /// `FiR1`, `FiR2`: bank and half.
    Bank(usize, usize),
}

/// The filters a bank holds, the most important kind first: 32 before 16 bits, lists before masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    WideList,
    WideMask,
    NarrowList,
    NarrowMask,
}

/// Bits of the 32 and 16 bit registers that are compared.
const WIDE_BITS: u32 = !1;
const NARROW_BITS: u32 = 0xFFFF;
const BANK_BITS: u32 = 0x0FFF_FFFF;

impl Filters {
    pub(super) const fn new() -> Self {
        Self {
            master: fmr::AFTER_RESET,
            list: 0,
            wide: 0,
            fifo: 0,
            active: 0,
            banks: [[0; 2]; BANKS],
        }
    }

    pub(super) fn read(&self, register: FilterRegister) -> u32 {
        match register {
            FilterRegister::Master => self.master,
            FilterRegister::Mode => self.list,
            FilterRegister::Scale => self.wide,
            FilterRegister::Assignment => self.fifo,
            FilterRegister::Activation => self.active,
            FilterRegister::Bank(bank, half) => {
                self.banks.get(bank).and_then(|b| b.get(half)).copied().unwrap_or_default()
            }
        }
    }

    /// Mode, scale and assignment change only while the filters are set up; a bank also while it is
    /// inactive.
    pub(super) fn write(&mut self, register: FilterRegister, value: u32) {
        let setting_up = self.setting_up();
        match register {
            FilterRegister::Master => {
                let writable = fmr::FINIT | fmr::CAN2SB_MASK << fmr::CAN2SB;
                self.master = self.master & !writable | value & writable;
            }
            FilterRegister::Mode if setting_up => self.list = value & BANK_BITS,
            FilterRegister::Scale if setting_up => self.wide = value & BANK_BITS,
            FilterRegister::Assignment if setting_up => self.fifo = value & BANK_BITS,
            FilterRegister::Mode | FilterRegister::Scale | FilterRegister::Assignment => {}
            FilterRegister::Activation => self.active = value & BANK_BITS,
            FilterRegister::Bank(bank, half) => {
                let free = setting_up || self.active >> bank & 1 == 0;
                if let (true, Some(held)) =
                    (free, self.banks.get_mut(bank).and_then(|b| b.get_mut(half)))
                {
                    *held = value;
                }
            }
        }
    }

    /// Whether nothing is received because the filters are set up.
    pub(super) const fn setting_up(&self) -> bool {
        self.master & fmr::FINIT != 0
    }

    /// The filter a frame passes, if any.
    ///
    /// Filters are numbered per FIFO over all banks, active or not. Of several that match the one
    /// of the more important kind counts, then the one of the lower bank, then the lower number.
    pub(super) fn accept(&self, frame: &Frame) -> Option<Match> {
        if self.setting_up() {
            return None;
        }
        let (wide, narrow) = (wide_pattern(frame), narrow_pattern(frame));
        let own = usize::try_from(self.master >> fmr::CAN2SB & fmr::CAN2SB_MASK).unwrap_or(BANKS);
        let mut numbers = [0u8; 2];
        let mut best: Option<(Kind, Match)> = None;
        for (n, [first, second]) in self.banks.iter().copied().enumerate().take(own) {
            let set = |bits: u32| bits >> n & 1 == 1;
            let fifo = usize::from(set(self.fifo));
            let kind = match (set(self.wide), set(self.list)) {
                (true, true) => Kind::WideList,
                (true, false) => Kind::WideMask,
                (false, true) => Kind::NarrowList,
                (false, false) => Kind::NarrowMask,
            };
            let same = |a: u32, b: u32, bits: u32| (a ^ b) & bits == 0;
            let narrow_is = |id: u32| same(narrow, id, NARROW_BITS);
            let narrow_in = |pair: u32| same(narrow, pair, pair >> 16 & NARROW_BITS);
            let hits = match kind {
                Kind::WideList => [
                    Some(same(wide, first, WIDE_BITS)),
                    Some(same(wide, second, WIDE_BITS)),
                    None,
                    None,
                ],
                Kind::WideMask => [Some(same(wide, first, second & WIDE_BITS)), None, None, None],
                Kind::NarrowList => {
                    [first, first >> 16, second, second >> 16].map(|id| Some(narrow_is(id)))
                }
                Kind::NarrowMask => [Some(narrow_in(first)), Some(narrow_in(second)), None, None],
            };
            let Some(number) = numbers.get_mut(fifo) else { continue };
            for hit in hits.into_iter().flatten() {
                let found = hit && set(self.active);
                if found && best.is_none_or(|(other, _)| kind < other) {
                    best = Some((kind, Match { fifo, index: *number }));
                }
                *number = number.wrapping_add(1);
            }
        }
        best.map(|(_, hit)| hit)
    }
}

/// A frame as a 32 bit filter sees it: the identifier register of a mailbox.
pub(super) fn wide_pattern(frame: &Frame) -> u32 {
    let remote = if frame.is_remote() { ir::RTR } else { 0 };
    match frame.id() {
        Id::Standard(id) => u32::from(id) << ir::STID | remote,
        Id::Extended(id) => id << ir::EXID | ir::IDE | remote,
    }
}

/// A frame as a 16 bit filter sees it: STID, RTR, IDE and the three uppermost bits of EXID.
fn narrow_pattern(frame: &Frame) -> u32 {
    let remote = u32::from(frame.is_remote()) << 4;
    match frame.id() {
        Id::Standard(id) => u32::from(id) << 5 | remote,
        Id::Extended(id) => (id >> 18) << 5 | remote | 1 << 3 | id >> 15 & 0b111,
    }
}
