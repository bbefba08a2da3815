//! bxCAN of the STM32F4 (RM0090, chapter 32), one mailbox, one FIFO, no filter.

use perf_dev1::Bus;

use crate::register::{read, write};

/// 125 kbit/s at 16 MHz: a prescaler of 8, 13 and 2 quanta, one of them to jump.
const BIT_TIMING: u32 = 1 << 20 | 12 << 16 | 7;

const RCC_AHB1ENR: usize = 0x4002_3830;
const RCC_APB1ENR: usize = 0x4002_3840;
const GPIOD_MODER: usize = 0x4002_0C00;
const GPIOD_AFRL: usize = 0x4002_0C20;
const CAN1: usize = 0x4000_6400;
const MCR: usize = CAN1;
const MSR: usize = CAN1 + 0x004;
const TSR: usize = CAN1 + 0x008;
const RF0R: usize = CAN1 + 0x00C;
const BTR: usize = CAN1 + 0x01C;
const TI0R: usize = CAN1 + 0x180;
const TDT0R: usize = CAN1 + 0x184;
const TDL0R: usize = CAN1 + 0x188;
const TDH0R: usize = CAN1 + 0x18C;
const RI0R: usize = CAN1 + 0x1B0;
const RDT0R: usize = CAN1 + 0x1B4;
const RDL0R: usize = CAN1 + 0x1B8;
const RDH0R: usize = CAN1 + 0x1BC;
const FMR: usize = CAN1 + 0x200;
const FS1R: usize = CAN1 + 0x20C;
const FA1R: usize = CAN1 + 0x21C;
const F0R2: usize = CAN1 + 0x244;

/// CAN1.
pub(crate) struct Controller(());

impl Controller {
    /// Joins the bus.
    pub(crate) fn new() -> Self {
        write(RCC_AHB1ENR, read(RCC_AHB1ENR) | 1 << 3);
        write(RCC_APB1ENR, 1 << 25);
        // PD0 and PD1 are the controller's: its alternate function is number 9.
        write(GPIOD_MODER, 0b1010);
        write(GPIOD_AFRL, 0x99);
        write(MCR, 1 << 0);
        while read(MSR) & 1 == 0 {}
        write(BTR, BIT_TIMING);
        // One filter of 32 bits that lets everything through. After a reset the filters can be set
        // up, and half of them are this controller's.
        write(F0R2, 0);
        write(FS1R, 1);
        write(FA1R, 1);
        write(FMR, 14 << 8);
        // Retransmission, recovery from bus-off.
        write(MCR, 1 << 6);
        Self(())
    }

    /// The oldest frame with 11 bits that waits.
    pub(crate) fn receive<F>(
        &self,
        data_frame: impl FnOnce(u16, u8, [u8; 8]) -> F,
        remote_frame: impl FnOnce(u16, u8) -> F,
    ) -> Option<F> {
        if read(RF0R) & 0b11 == 0 {
            return None;
        }
        let id = read(RI0R);
        let [len, ..] = read(RDT0R).to_le_bytes();
        let ([a, b, c, d], [e, f, g, h]) = (read(RDL0R).to_le_bytes(), read(RDH0R).to_le_bytes());
        // Release the place in the FIFO.
        write(RF0R, 1 << 5);
        let (extended, remote) = (id & 1 << 2 != 0, id & 1 << 1 != 0);
        let [low, high, ..] = (id >> 21).to_le_bytes();
        let id = u16::from_le_bytes([low, high]);
        let len = (len & 0xF).min(8);
        match (extended, remote) {
            (true, _) => None,
            (false, true) => Some(remote_frame(id, len)),
            (false, false) => Some(data_frame(id, len, [a, b, c, d, e, f, g, h])),
        }
    }
}

impl Bus for Controller {
    fn is_free(&self) -> bool {
        read(TSR) & 1 << 26 != 0
    }

    fn send(&self, id: u32, len: u32, data: [u8; 8]) {
        let [a, b, c, d, e, f, g, h] = data;
        write(TDT0R, len);
        write(TDL0R, u32::from_le_bytes([a, b, c, d]));
        write(TDH0R, u32::from_le_bytes([e, f, g, h]));
        write(TI0R, id << 21 | 1);
    }
}
