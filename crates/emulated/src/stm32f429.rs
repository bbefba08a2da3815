//! The microcontroller: the described bus with a model behind each of its instances.
use std::sync::{Arc, Mutex};

use rigless::device::{Device, ErasedDevice, Level, RegisterFile, ResetCause};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::st::dma::Dma;
use rigless::soc::stm32f427::generated::rcc::{self as rcc_registers, bdcr};
use rigless::soc::stm32f427::generated::{dbg as dbg_registers, dma2};
use rigless::soc::stm32f427::peripherals::dbg::Dbg;
use rigless::soc::stm32f427::peripherals::gpio::{Gpio, Pin};
use rigless::soc::stm32f427::peripherals::i2c::I2c;
use rigless::soc::stm32f427::peripherals::iwdg::Iwdg;
use rigless::soc::stm32f427::peripherals::pwr::Pwr;
use rigless::soc::stm32f427::peripherals::rcc::{HSI_HZ, Rcc};
use rigless::soc::stm32f427::peripherals::usart::{Kind, Usart};
use rigless::soc::{Bus, Error};
use rigless::time::VirtualNanos;
use world::Surroundings;
use world::can::Delivery;

use crate::bxcan::BxCan;
use crate::flash_array::FlashArray;
use crate::lcd_port::LcdPort;
use crate::memory_map::{self, PORTS};
use crate::serial_line::SerialLine;
use crate::ssi_port::SsiPort;
use crate::tim5::Tim5;

/// The clock the ST-LINK of the board feeds into OSC_IN.
const HSE_HZ: u64 = 8_000_000;

/// The supply of the board.
const SUPPLY_MV: u32 = 3_300;

const DMA_CONTROLLERS: [&str; 2] = ["DMA1", "DMA2"];

/// A pin of the part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PinOf {
    port: usize,
    pin: Pin,
}

impl PinOf {
    /// Pin `number` (0 to 15) of port `port` ('A' to 'I').
    pub(crate) const fn new(port: char, number: u8) -> Self {
        let port = port as usize - 'A' as usize;
        assert!(port < PORTS.len());
        match Pin::new(number) {
            Some(pin) => Self { port, pin },
            None => panic!("a port has sixteen pins"),
        }
    }
}

/// One STM32F429ZI.
#[derive(Debug)]
pub(crate) struct Stm32f429 {
    bus: Bus,
    /// Which model answers for each slot of the bus.
    wiring: Vec<Model>,
    slots: Slots,
    rcc: Rcc,
    pwr: Pwr,
    gpio: [Gpio; PORTS.len()],
    usart2: Usart,
    spi1: SsiPort,
    i2c1: I2c,
    tim5: Tim5,
    dma: [Dma<dma2::Register>; DMA_CONTROLLERS.len()],
    iwdg: Iwdg,
    dbg: Dbg,
    can1: BxCan,
    /// The flash memory.
    pub(crate) flash: FlashArray,
}

/// The slots that are reached from outside the bus.
#[derive(Clone, Copy, Debug)]
struct Slots {
    rcc: usize,
    pwr: usize,
    gpio: [usize; PORTS.len()],
    usart2: usize,
    flash: usize,
    dbg: usize,
    can1: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Model {
    Rcc,
    Pwr,
    Gpio(usize),
    Usart2,
    Spi1,
    I2c1,
    Tim5,
    Dma(usize),
    Iwdg,
    Dbg,
    Can1,
    Flash,
    None,
}

impl Model {
    fn of(instance: &str) -> Self {
        if let Some(n) = PORTS.iter().position(|port| *port == instance) {
            return Self::Gpio(n);
        }
        if let Some(n) = DMA_CONTROLLERS.iter().position(|dma| *dma == instance) {
            return Self::Dma(n);
        }
        match instance {
            "RCC" => Self::Rcc,
            "PWR" => Self::Pwr,
            "USART2" => Self::Usart2,
            "SPI1" => Self::Spi1,
            "I2C1" => Self::I2c1,
            "TIM5" => Self::Tim5,
            "IWDG" => Self::Iwdg,
            "DBG" => Self::Dbg,
            "CAN1" => Self::Can1,
            "FLASH" => Self::Flash,
            _ => Self::None,
        }
    }
}

impl Stm32f429 {
    /// The part out of its power-on reset, with `flash` as its memory and nothing on its pins but
    /// the other end of USART2.
    ///
    /// # Errors
    /// When the description of the part contradicts itself.
    pub(crate) fn new(flash: FlashArray) -> Result<Self, Error> {
        let bus = memory_map::bus()?;
        let mut gpio_slots = [0; PORTS.len()];
        for (slot, port) in gpio_slots.iter_mut().zip(PORTS) {
            *slot = bus.slot(port)?;
        }
        let slots = Slots {
            rcc: bus.slot("RCC")?,
            pwr: bus.slot("PWR")?,
            gpio: gpio_slots,
            usart2: bus.slot("USART2")?,
            flash: bus.slot("FLASH")?,
            dbg: bus.slot("DBG")?,
            can1: bus.slot("CAN1")?,
        };
        let wiring = bus.slots().iter().map(|slot| Model::of(slot.peripheral().name)).collect();
        let mut part = Self {
            bus,
            wiring,
            slots,
            rcc: rcc(),
            pwr: Pwr::new(),
            gpio: std::array::from_fn(|_| Gpio::default()),
            usart2: usart(),
            spi1: SsiPort::new(),
            i2c1: I2c::with_clock(HSI_HZ),
            tim5: Tim5::new(),
            dma: dma(),
            iwdg: Iwdg::new(),
            dbg: Dbg,
            can1: BxCan::new(),
            flash,
        };
        part.usart2.attach(SerialLine::default());
        part.supply();
        part.check()?;
        Ok(part)
    }

    /// Wires the encoder and the LCD chip of `surroundings` to it.
    pub(crate) fn attach(&mut self, surroundings: &Arc<Mutex<Surroundings>>) {
        self.spi1.attach(Arc::clone(surroundings));
        self.i2c1.attach(LcdPort(Arc::clone(surroundings)));
    }

    /// This end of the line between the controllers.
    pub(crate) fn serial_line(&mut self) -> &mut SerialLine {
        self.usart2.chip_mut().expect("attached when the part was built")
    }

    /// Has the part look at the serial line at `at`, which lies ahead.
    pub(crate) fn look_at_serial_line(&mut self, now: VirtualNanos, at: VirtualNanos) {
        let (_, mut context) = self.bus.drive(now, self.slots.usart2);
        let _event = context.schedule(at);
    }

    /// The CAN controller.
    pub(crate) const fn can(&self) -> &BxCan {
        &self.can1
    }

    /// Hands the CAN controller what the bus made of its requests, at the boundary `at`.
    pub(crate) fn deliver(&mut self, at: VirtualNanos, delivery: &Delivery) {
        let (_, mut context) = self.bus.drive(at, self.slots.can1);
        self.can1.deliver(delivery, &mut context);
    }

    /// Takes the supply away or gives it back, at `at`.
    pub(crate) fn switch_supply(&mut self, at: VirtualNanos, on: bool) {
        let (_, mut context) = self.bus.drive(at, self.slots.flash);
        context.request_power(on);
    }

    /// What the board puts on `pin` from `at` on; `None` leaves it open.
    pub(crate) fn drive_pin(&mut self, at: VirtualNanos, pin: PinOf, level: Option<Level>) {
        if let (Some(&slot), Some(gpio)) =
            (self.slots.gpio.get(pin.port), self.gpio.get_mut(pin.port))
        {
            let (registers, mut context) = self.bus.drive(at, slot);
            gpio.drive(pin.pin, level, registers, &mut context);
        }
    }

    /// The level of `pin`.
    pub(crate) fn pin(&self, pin: PinOf) -> Level {
        match (self.slots.gpio.get(pin.port), self.gpio.get(pin.port)) {
            (Some(&slot), Some(gpio)) => match self.bus.slots().get(slot) {
                Some(slot) => gpio.level(pin.pin, slot.registers()),
                None => Level::Low,
            },
            _ => Level::Low,
        }
    }

    /// Whether all of `pins` are switched to alternate function `function`.
    pub(crate) fn carries(&self, pins: &[PinOf], function: u8) -> bool {
        pins.iter().all(|pin| {
            let slot = self.slots.gpio.get(pin.port).and_then(|&slot| self.bus.slots().get(slot));
            slot.and_then(|slot| Gpio::function(pin.pin, slot.registers())) == Some(function)
        })
    }

    fn supply(&mut self) {
        let registers = self.bus.slot_mut(self.slots.pwr).registers_mut();
        self.pwr.set_supply(SUPPLY_MV, registers);
    }

    fn registers(&mut self, slot: usize) -> &mut RegisterFile {
        self.bus.slot_mut(slot).registers_mut()
    }
}

fn rcc() -> Rcc {
    let mut rcc = Rcc::new();
    rcc.attach_crystals(HSE_HZ, 0);
    rcc
}

fn usart() -> Usart {
    Usart::with_clock(Kind::Usart, HSI_HZ)
}

fn dma() -> [Dma<dma2::Register>; DMA_CONTROLLERS.len()] {
    std::array::from_fn(|n| {
        let (requests, reach) = memory_map::dma(n);
        Dma::wired(requests, reach)
    })
}

/// What a system reset leaves alone, read before it: section 6.1.3's backup domain, the reset
/// flags, and the debug component's settings (38.16.3).
#[derive(Debug)]
struct Kept {
    reset_flags: u64,
    backup: u64,
    debug: [u64; 3],
}

const DEBUG: [dbg_registers::Register; 3] = [
    dbg_registers::Register::DbgmcuCr,
    dbg_registers::Register::DbgmcuApb1Fz,
    dbg_registers::Register::DbgmcuApb2Fz,
];

impl Kept {
    fn read(part: &mut Stm32f429) -> Self {
        let slots = part.slots;
        let rcc = part.registers(slots.rcc);
        let reset_flags = rcc.get(rcc_registers::Register::Csr);
        let backup = rcc.get(rcc_registers::Register::Bdcr);
        let debug = DEBUG.map(|register| part.registers(slots.dbg).get(register));
        Self { reset_flags, backup, debug }
    }

    fn write(self, cause: ResetCause, part: &mut Stm32f429) {
        let slots = part.slots;
        let registers = part.bus.slot_mut(slots.rcc).registers_mut();
        registers.restore(rcc_registers::Register::Bdcr, !bdcr::LSERDY.mask(), self.backup);
        part.rcc.restarted(cause, self.reset_flags, registers);
        for (register, value) in DEBUG.into_iter().zip(self.debug) {
            part.registers(slots.dbg).set(register, value);
        }
    }
}

impl Mcu for Stm32f429 {
    fn bus(&self) -> &Bus {
        &self.bus
    }

    fn bus_mut(&mut self) -> &mut Bus {
        &mut self.bus
    }

    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        let kept = Kept::read(self);
        self.bus.reset();
        self.rcc = rcc();
        self.pwr = Pwr::new();
        self.gpio = std::array::from_fn(|_| Gpio::default());
        let mut usart2 = usart();
        usart2.inherit(&mut self.usart2);
        self.usart2 = usart2;
        let mut spi1 = SsiPort::new();
        spi1.inherit(&mut self.spi1);
        self.spi1 = spi1;
        let mut i2c1 = I2c::with_clock(HSI_HZ);
        i2c1.inherit(&mut self.i2c1);
        self.i2c1 = i2c1;
        self.tim5 = Tim5::new();
        self.dma = dma();
        self.iwdg = Iwdg::new();
        Device::reset(&mut self.can1);
        self.supply();
        let (registers, mut context) = self.bus.drive(at, self.slots.flash);
        self.flash.restart(registers, &mut context);
        if cause != ResetCause::PowerOn {
            kept.write(cause, self);
        }
    }

    fn poll(&mut self, now: VirtualNanos) {
        let (registers, mut context) = self.bus.drive(now, self.slots.usart2);
        Device::poll(&mut self.usart2, registers, &mut context);
    }

    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        let model: Option<&mut dyn ErasedDevice> = match self.wiring.get(slot) {
            Some(Model::Rcc) => Some(&mut self.rcc),
            Some(Model::Pwr) => Some(&mut self.pwr),
            Some(&Model::Gpio(n)) => self.gpio.get_mut(n).map(|gpio| gpio as _),
            Some(Model::Usart2) => Some(&mut self.usart2),
            Some(Model::Spi1) => Some(&mut self.spi1),
            Some(Model::I2c1) => Some(&mut self.i2c1),
            Some(Model::Tim5) => Some(&mut self.tim5),
            Some(&Model::Dma(n)) => self.dma.get_mut(n).map(|dma| dma as _),
            Some(Model::Iwdg) => Some(&mut self.iwdg),
            Some(Model::Dbg) => Some(&mut self.dbg),
            Some(Model::Can1) => Some(&mut self.can1),
            Some(Model::Flash) => Some(&mut self.flash),
            Some(Model::None) | None => None,
        };
        (&mut self.bus, model)
    }
}
