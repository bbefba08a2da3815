//! Bits of the bxCAN registers (RM0090, 32.9), by register.

/// Master control.
pub(super) mod mcr {
    pub(crate) const INRQ: u32 = 1 << 0;
    pub(crate) const SLEEP: u32 = 1 << 1;
    pub(crate) const TXFP: u32 = 1 << 2;
    pub(crate) const RFLM: u32 = 1 << 3;
    pub(crate) const NART: u32 = 1 << 4;
    pub(crate) const AWUM: u32 = 1 << 5;
    pub(crate) const ABOM: u32 = 1 << 6;
    pub(crate) const RESET: u32 = 1 << 15;
    /// After a reset: asleep, frozen while the core is halted.
    pub(crate) const AFTER_RESET: u32 = SLEEP | 1 << 16;
}

/// Master status.
pub(super) mod msr {
    pub(crate) const INAK: u32 = 1 << 0;
    pub(crate) const SLAK: u32 = 1 << 1;
    pub(crate) const ERRI: u32 = 1 << 2;
    pub(crate) const WKUI: u32 = 1 << 3;
    pub(crate) const SLAKI: u32 = 1 << 4;
    pub(crate) const TXM: u32 = 1 << 8;
    pub(crate) const RXM: u32 = 1 << 9;
    /// The last sample and the pin: recessive.
    pub(crate) const RECESSIVE: u32 = 0b11 << 10;
}

/// Transmit status; one byte per mailbox and a byte about all.
pub(super) mod tsr {
    pub(crate) const RQCP: u32 = 1 << 0;
    pub(crate) const TXOK: u32 = 1 << 1;
    pub(crate) const ALST: u32 = 1 << 2;
    pub(crate) const TERR: u32 = 1 << 3;
    pub(crate) const ABRQ: u32 = 1 << 7;
    pub(crate) const CODE: u32 = 24;
    pub(crate) const TME: u32 = 26;
    pub(crate) const LOW: u32 = 29;
}

/// Receive FIFO.
pub(super) mod rfr {
    pub(crate) const FULL: u32 = 1 << 3;
    pub(crate) const FOVR: u32 = 1 << 4;
    pub(crate) const RFOM: u32 = 1 << 5;
}

/// Interrupt enable.
pub(super) mod ier {
    pub(crate) const TMEIE: u32 = 1 << 0;
    /// For FIFO 0; three places up for FIFO 1.
    pub(crate) const FMPIE: u32 = 1 << 1;
    pub(crate) const FFIE: u32 = 1 << 2;
    pub(crate) const FOVIE: u32 = 1 << 3;
    pub(crate) const FIFO_STRIDE: u32 = 3;
    pub(crate) const EWGIE: u32 = 1 << 8;
    pub(crate) const EPVIE: u32 = 1 << 9;
    pub(crate) const BOFIE: u32 = 1 << 10;
    pub(crate) const LECIE: u32 = 1 << 11;
    pub(crate) const ERRIE: u32 = 1 << 15;
    pub(crate) const WKUIE: u32 = 1 << 16;
    pub(crate) const SLKIE: u32 = 1 << 17;
}

/// Error status.
pub(super) mod esr {
    pub(crate) const EWGF: u32 = 1 << 0;
    pub(crate) const EPVF: u32 = 1 << 1;
    pub(crate) const BOFF: u32 = 1 << 2;
    pub(crate) const LEC: u32 = 4;
    pub(crate) const LEC_MASK: u32 = 0b111;
    pub(crate) const TEC: u32 = 16;
    pub(crate) const REC: u32 = 24;
}

/// Bit timing.
pub(super) mod btr {
    pub(crate) const BRP_MASK: u32 = 0x3FF;
    pub(crate) const TS1: u32 = 16;
    pub(crate) const TS1_MASK: u32 = 0xF;
    pub(crate) const TS2: u32 = 20;
    pub(crate) const TS2_MASK: u32 = 0x7;
    pub(crate) const LBKM: u32 = 1 << 30;
    pub(crate) const SILM: u32 = 1 << 31;
    /// Two segments of one quantum at a prescaler of 1, on the longest jump.
    pub(crate) const AFTER_RESET: u32 = 0x0123_0000;
}

/// Identifier of a mailbox: the same places in TIxR and RIxR.
pub(super) mod ir {
    pub(crate) const TXRQ: u32 = 1 << 0;
    pub(crate) const RTR: u32 = 1 << 1;
    pub(crate) const IDE: u32 = 1 << 2;
    pub(crate) const EXID: u32 = 3;
    pub(crate) const STID: u32 = 21;
}

/// Length of a mailbox: the same places in TDTxR and RDTxR.
pub(super) mod dtr {
    pub(crate) const DLC_MASK: u32 = 0xF;
    pub(crate) const FMI: u32 = 8;
}

/// Filter master.
pub(super) mod fmr {
    pub(crate) const FINIT: u32 = 1 << 0;
    pub(crate) const CAN2SB: u32 = 8;
    pub(crate) const CAN2SB_MASK: u32 = 0x3F;
    /// Filters being set up, half of the banks for each controller.
    pub(crate) const AFTER_RESET: u32 = 0x2A1C_0E01;
}
