use emulated::bxcan::{BxCan, InterruptCounts};
use rigless::device::{Device, Level};
use rigless::mcu::{Operate, Single};
use rigless::soc::stm32f427::generated::CAN1;
use rigless::soc::{Bus as PartBus, Cpu, Endian, Width};
use rigless::time::VirtualNanos;
use world::can::{Bus, Delivery, Frame, Id, Nanos, Outside, Rate, Role};

pub(crate) const MCR: u64 = 0x000;
pub(crate) const MSR: u64 = 0x004;
pub(crate) const TSR: u64 = 0x008;
pub(crate) const RF0R: u64 = 0x00C;
pub(crate) const RF1R: u64 = 0x010;
pub(crate) const IER: u64 = 0x014;
pub(crate) const ESR: u64 = 0x018;
pub(crate) const BTR: u64 = 0x01C;
pub(crate) const TI0R: u64 = 0x180;
pub(crate) const RI0R: u64 = 0x1B0;
pub(crate) const MAILBOX_STRIDE: u64 = 0x10;
pub(crate) const FMR: u64 = 0x200;
pub(crate) const FM1R: u64 = 0x204;
pub(crate) const FS1R: u64 = 0x20C;
pub(crate) const FFA1R: u64 = 0x214;
pub(crate) const FA1R: u64 = 0x21C;
pub(crate) const F0R1: u64 = 0x240;

pub(crate) const INRQ: u32 = 1 << 0;
pub(crate) const SLEEP: u32 = 1 << 1;
pub(crate) const TXFP: u32 = 1 << 2;
pub(crate) const RFLM: u32 = 1 << 3;
pub(crate) const NART: u32 = 1 << 4;
pub(crate) const AWUM: u32 = 1 << 5;
pub(crate) const ABOM: u32 = 1 << 6;

/// Peripheral clock of the tests, and of the boards.
const PCLK1_HZ: u64 = 40_000_000;

/// The nine bit rates of CiA 301 at 40 MHz: bit/s, prescaler, TS1, TS2 (in quanta).
#[rustfmt::skip]
pub(crate) const RATES: [(u32, u32, u32, u32); 9] = [
    (1_000_000,   2, 16, 3),
    (  800_000,   2, 16, 8),
    (  500_000,   4, 16, 3),
    (  250_000,   8, 16, 3),
    (  125_000,  16, 16, 3),
    (  100_000,  20, 16, 3),
    (   50_000,  40, 16, 3),
    (   20_000, 100, 16, 3),
    (   10_000, 200, 16, 3),
];

pub(crate) fn btr(bits_per_second: u32) -> u32 {
    let (_, prescaler, first, second) =
        RATES.into_iter().find(|(rate, ..)| *rate == bits_per_second).unwrap();
    (prescaler - 1) | (first - 1) << 16 | (second - 1) << 20
}

pub(crate) fn std_frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(Id::Standard(id), data).unwrap()
}

pub(crate) fn ext_frame(id: u32, data: &[u8]) -> Frame {
    Frame::new(Id::Extended(id), data).unwrap()
}

/// Controllers on one bus, with virtual time.
pub(crate) struct Rig {
    pub(crate) bus: Bus,
    nodes: Vec<Single<BxCan>>,
    lines: Vec<[Level; 4]>,
    now: u64,
    boundary: u64,
    quantum: u64,
}

/// Short enough for 1 Mbit/s.
const QUANTUM_NS: u64 = 40_000;

impl Rig {
    /// `nodes` controllers as a reset leaves them, clocked by 40 MHz.
    pub(crate) fn new(nodes: usize) -> Self {
        let cpu = Cpu::new("CM4", true, 91, Endian::Little);
        let mut rig = Self {
            bus: Bus::new(1),
            nodes: Vec::new(),
            lines: vec![[Level::Low; 4]; nodes],
            now: 0,
            boundary: 0,
            quantum: QUANTUM_NS,
        };
        for node in 0..nodes {
            let builder = PartBus::builder(cpu, &[], [CAN1]);
            rig.nodes.push(Single::new(builder, "CAN1", BxCan::new()).unwrap());
            rig.clock(node);
        }
        rig
    }

    /// Clocks a controller by 40 MHz.
    fn clock(&mut self, node: usize) {
        self.nodes[node].drive(VirtualNanos(self.now), |can, registers, context| {
            can.on_clock(PCLK1_HZ, registers, context);
        });
    }

    /// Has boundaries every `quantum_ns` from now on.
    pub(crate) fn with_quantum(mut self, quantum_ns: u64) -> Self {
        self.quantum = quantum_ns;
        self
    }

    /// `nodes` controllers in normal mode at 1 Mbit/s that receive everything into FIFO 0.
    pub(crate) fn running(nodes: usize) -> Self {
        let mut rig = Self::new(nodes);
        for node in 0..nodes {
            rig.set_up(node, 1_000_000, 0);
        }
        rig.run_us(100);
        rig
    }

    /// Sets a controller up: bit rate, everything into FIFO 0, then asks for normal mode with the
    /// given bits of MCR.
    pub(crate) fn set_up(&mut self, node: usize, bits_per_second: u32, control: u32) {
        self.write(node, MCR, INRQ);
        self.write(node, BTR, btr(bits_per_second));
        self.accept_everything(node);
        self.write(node, MCR, control);
    }

    pub(crate) fn accept_everything(&mut self, node: usize) {
        self.filters(
            node,
            &[FilterBank { bank: 0, fifo: 0, wide: true, list: false, values: [0, 0] }],
        );
    }

    pub(crate) fn filters(&mut self, node: usize, banks: &[FilterBank]) {
        let bits = |f: fn(&FilterBank) -> bool| {
            banks.iter().filter(|b| f(b)).fold(0, |bits, b| bits | 1 << b.bank)
        };
        self.write(node, FMR, 28 << 8 | 1);
        self.write(node, FA1R, 0);
        self.write(node, FM1R, bits(|b| b.list));
        self.write(node, FS1R, bits(|b| b.wide));
        self.write(node, FFA1R, bits(|b| b.fifo == 1));
        for bank in banks {
            let at = F0R1 + 8 * u64::from(bank.bank);
            self.write(node, at, bank.values[0]);
            self.write(node, at + 4, bank.values[1]);
        }
        self.write(node, FA1R, bits(|_| true));
        self.write(node, FMR, 28 << 8);
    }

    pub(crate) fn write(&mut self, node: usize, register: u64, value: u32) {
        let at = VirtualNanos(self.now);
        let address = CAN1.base + register;
        self.nodes[node].write(at, address, Width::W32, u64::from(value)).unwrap();
        self.take_lines();
    }

    pub(crate) fn read(&mut self, node: usize, register: u64) -> u32 {
        let at = VirtualNanos(self.now);
        let value = self.nodes[node].read(at, CAN1.base + register, Width::W32).unwrap();
        u32::try_from(value).unwrap()
    }

    /// Writes a frame to a mailbox and requests its transmission.
    pub(crate) fn send(&mut self, node: usize, mailbox: u64, frame: Frame) {
        let at = TI0R + MAILBOX_STRIDE * mailbox;
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        self.write(node, at + 4, u32::from(frame.dlc()));
        self.write(node, at + 8, u32::from_le_bytes(data[..4].try_into().unwrap()));
        self.write(node, at + 12, u32::from_le_bytes(data[4..].try_into().unwrap()));
        let id = match frame.id() {
            Id::Standard(id) => u32::from(id) << 21,
            Id::Extended(id) => id << 3 | 1 << 2,
        };
        self.write(node, at, id | u32::from(frame.is_remote()) << 1 | 1);
    }

    /// Takes the frame out of a FIFO, with the number of the filter it passed.
    pub(crate) fn take(&mut self, node: usize, fifo: u64) -> Option<(Frame, u32)> {
        let status = RF0R + 4 * fifo;
        if self.read(node, status) & 0b11 == 0 {
            return None;
        }
        let at = RI0R + MAILBOX_STRIDE * fifo;
        let [id, length, low, high] = [0, 4, 8, 12].map(|offset| self.read(node, at + offset));
        self.write(node, status, 1 << 5);
        let dlc = usize::try_from(length & 0xF).unwrap();
        let data = [low.to_le_bytes(), high.to_le_bytes()].concat();
        let name = if id >> 2 & 1 == 1 {
            Id::Extended(id >> 3)
        } else {
            Id::Standard(u16::try_from(id >> 21).unwrap())
        };
        let frame = if id >> 1 & 1 == 1 {
            Frame::remote(name, u8::try_from(dlc).unwrap()).unwrap()
        } else {
            Frame::new(name, &data[..dlc]).unwrap()
        };
        Some((frame, length >> 8 & 0xFF))
    }

    /// Everything in a FIFO.
    pub(crate) fn take_all(&mut self, node: usize, fifo: u64) -> Vec<Frame> {
        std::iter::from_fn(|| self.take(node, fifo)).map(|(frame, _)| frame).collect()
    }

    pub(crate) fn attach(&mut self, bits_per_second: u32) -> Outside {
        self.bus.attach(Rate::Fixed(bits_per_second), Role::Normal)
    }

    pub(crate) fn now(&self) -> u64 {
        self.now
    }

    pub(crate) fn run_us(&mut self, us: u64) {
        self.run_until(self.now + us * 1000);
    }

    pub(crate) fn run_until(&mut self, at: u64) {
        while self.boundary + self.quantum <= at {
            self.boundary += self.quantum;
            self.advance(self.boundary);
            let states: Vec<_> = self.nodes.iter().map(|node| node.model.requests()).collect();
            let deliveries = self.bus.resolve(Nanos(self.boundary), &states);
            let news = |delivery: &&Delivery| **delivery != Delivery::default();
            for (node, delivery) in self.nodes.iter_mut().zip(&deliveries).filter(|(_, d)| news(d))
            {
                node.drive(VirtualNanos(self.boundary), |can, _, context| {
                    can.deliver(delivery, context);
                });
            }
            self.take_lines();
        }
        self.advance(at);
    }

    fn advance(&mut self, at: u64) {
        for node in &mut self.nodes {
            node.advance_to(VirtualNanos(at));
        }
        self.now = at;
        self.take_lines();
    }

    /// Runs until a register's bits are as wanted and answers when that was, to the nanosecond.
    #[track_caller]
    pub(crate) fn run_to(&mut self, node: usize, register: u64, mask: u32, wanted: u32) -> u64 {
        let limit = self.now + 1_000_000_000;
        while self.read(node, register) & mask != wanted {
            let boundary = self.boundary + self.quantum;
            let event = self.nodes.iter().filter_map(|n| n.next_event()).map(|at| at.0).min();
            let next = event.unwrap_or(boundary).min(boundary).max(self.now);
            assert!(next < limit, "register {register:#x} never showed {wanted:#x}");
            self.run_until(next);
        }
        self.now
    }

    /// The levels of the interrupt lines: transmit, FIFO 0, FIFO 1, status change.
    pub(crate) fn lines(&self, node: usize) -> [bool; 4] {
        self.lines[node].map(|level| level == Level::High)
    }

    pub(crate) fn interrupts(&self, node: usize) -> InterruptCounts {
        self.nodes[node].model.interrupts()
    }

    /// Resets the part; its clock comes up again.
    pub(crate) fn reset(&mut self, node: usize) {
        self.nodes[node].reset_every_model();
        self.lines[node] = [Level::Low; 4];
        self.clock(node);
    }

    fn take_lines(&mut self) {
        for (node, lines) in self.nodes.iter_mut().zip(&mut self.lines) {
            for change in node.drain_interrupts() {
                lines[usize::from(change.interrupt - CAN1.interrupts[0])] = change.level;
            }
        }
    }
}

/// One filter bank of CAN1.
#[derive(Clone, Copy)]
pub(crate) struct FilterBank {
    pub(crate) bank: u32,
    pub(crate) fifo: u32,
    pub(crate) wide: bool,
    pub(crate) list: bool,
    pub(crate) values: [u32; 2],
}
