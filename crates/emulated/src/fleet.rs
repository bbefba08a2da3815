//! Any number of devices on one CAN bus, each with one or two controllers, all on one virtual clock.
//!
//! Every controller runs on a thread of its own, and none ever runs ahead of what may reach it:
//! the fleet gives out orders up to a *boundary*, waits for all, carries what was sent over the
//! lines between them, and gives out the next. A boundary lies at most one quantum after the
//! earliest instant anything can be sent; while every controller sleeps that instant may lie far
//! ahead, and only those who have something to do before the boundary are ordered at all. Nothing
//! a controller sends reaches another within a quantum, so neither the length of the quanta nor
//! the scheduling of the threads shows in the run.
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use units::Instant;
use world::can::{Bus, Delivery, Nanos, PortState, Presence, greatest_quantum};
use world::{Dice, Engine, EngineError, FlashImage, LogLine, Mcu, McuStats, Surroundings};

use crate::controller::{Command, Controller, CoreClock, Identity, Order, Report, Setup, Supply};
use crate::firmware::Firmware;
use crate::serial_line::{Byte, LINE_DELAY_NS, carry};

const MCUS: usize = Mcu::BOTH.len();
const NANOS_PER_MICRO: u64 = 1_000;

/// The images every device of a fleet runs.
#[derive(Clone, Debug)]
pub struct Images {
    stm: Arc<Firmware>,
    msp: Option<Arc<Firmware>>,
    clock: CoreClock,
}

impl Images {
    /// A CAN interface controller and an application controller. Both images set the cores to
    /// 160 MHz.
    #[must_use]
    pub const fn pair(stm: Arc<Firmware>, msp: Arc<Firmware>) -> Self {
        Self { stm, msp: Some(msp), clock: CoreClock::Mhz160 }
    }

    /// One controller, on the CAN bus and nothing else. The image leaves the core at the 16 MHz it
    /// starts with.
    #[must_use]
    pub const fn single(stm: Arc<Firmware>) -> Self {
        Self { stm, msp: None, clock: CoreClock::Mhz16 }
    }

    /// Of each controller, STM before MSP.
    fn by_mcu(&self) -> impl Iterator<Item = (Mcu, &Arc<Firmware>)> {
        [(Mcu::Stm, Some(&self.stm)), (Mcu::Msp, self.msp.as_ref())]
            .into_iter()
            .filter_map(|(mcu, image)| Some((mcu, image?)))
    }
}

/// How a fleet starts.
#[derive(Clone, Debug)]
pub struct Options {
    /// Devices on the bus.
    pub nodes: usize,
    /// Where everything random comes from: line faults, bus faults, half-done flash operations,
    /// memory after power-on.
    pub seed: u64,
    /// The flash of an earlier run, by node: STM, MSP. Bank 2 is taken from it, bank 1 is flashed
    /// with the image. Missing nodes start erased.
    pub flash: Vec<[Option<FlashImage>; MCUS]>,
}

/// Devices on a CAN bus, emulated.
#[derive(Debug)]
pub struct Fleet {
    now_ns: u64,
    /// Controllers of each device.
    controllers: usize,
    /// By node, STM before MSP.
    units: Vec<Unit>,
    nodes: Vec<Node>,
    bus: Arc<Mutex<Bus>>,
    failed: Option<EngineError>,
}

/// One device, apart from its controllers.
#[derive(Debug)]
struct Node {
    surroundings: Arc<Mutex<Surroundings>>,
    line_noise: Dice,
    log: Vec<LogLine>,
}

/// A controller, and what waits for it.
#[derive(Debug)]
struct Unit {
    controller: Controller,
    at_ns: u64,
    wakes_at_ns: u64,
    supply: Supply,
    sent: Vec<Byte>,
    bytes: Vec<Byte>,
    port: PortState,
    delivery: Option<Delivery>,
}

impl Fleet {
    /// Starts the devices at time zero, with the supply on.
    ///
    /// # Errors
    /// When an image cannot run on the part at all.
    pub fn new(images: &Images, options: Options) -> Result<Self, EngineError> {
        let mut kept = options.flash;
        kept.resize(options.nodes, [None, None]);
        let mut units = Vec::new();
        let mut nodes = Vec::new();
        for (node, kept) in kept.into_iter().enumerate().take(options.nodes) {
            let surroundings = Arc::new(Mutex::new(Surroundings::default()));
            let purpose = u64::try_from(node).unwrap_or(u64::MAX);
            for ((mcu, firmware), kept) in images.by_mcu().zip(kept) {
                let (controller, report) = Controller::start(Setup {
                    identity: Identity { node, mcu },
                    firmware: Arc::clone(firmware),
                    clock: images.clock,
                    kept,
                    seed: options.seed,
                    surroundings: Arc::clone(&surroundings),
                })?;
                units.push(Unit::new(controller, report));
            }
            nodes.push(Node {
                surroundings,
                line_noise: Dice::new(options.seed, purpose ^ LINE_NOISE),
                log: Vec::new(),
            });
        }
        let bus = Arc::new(Mutex::new(Bus::new(options.seed)));
        let controllers = images.by_mcu().count();
        Ok(Self { now_ns: 0, controllers, units, nodes, bus, failed: None })
    }

    /// Runs up to `target_ns`.
    fn run(&mut self, target_ns: u64) -> Result<(), EngineError> {
        while self.now_ns < target_ns {
            let boundary_ns = self.next_boundary().min(target_ns);
            let ordered = |unit: &Unit| unit.wakes_at_ns <= boundary_ns || boundary_ns == target_ns;
            self.order(boundary_ns, ordered)?;
            self.now_ns = boundary_ns;
            self.carry_bytes();
            self.resolve_bus()?;
        }
        Ok(())
    }

    /// At most one quantum after the earliest instant anything can be sent.
    fn next_boundary(&self) -> u64 {
        let ports = self.ports();
        let bus = lock(&self.bus).next_activity(&ports).map_or(u64::MAX, |at| at.0);
        let earliest = self.units.iter().map(|unit| unit.wakes_at_ns).fold(bus, u64::min);
        let quantum = ports
            .iter()
            .filter(|port| port.presence != Presence::Off)
            .map(|port| greatest_quantum(port.bit))
            .fold(LINE_DELAY_NS, u64::min);
        earliest.max(self.now_ns).saturating_add(quantum)
    }

    /// Has the units that `chosen` names run up to `until_ns`, all at the same time.
    fn order(&mut self, until_ns: u64, chosen: impl Fn(&Unit) -> bool) -> Result<(), EngineError> {
        let chosen: Vec<bool> = self.units.iter().map(chosen).collect();
        for (unit, _) in self.units.iter_mut().zip(&chosen).filter(|(_, chosen)| **chosen) {
            unit.start(until_ns);
        }
        let mut fault = None;
        for (index, (unit, _)) in
            self.units.iter_mut().zip(&chosen).enumerate().filter(|(_, (_, chosen))| **chosen)
        {
            let (lines, complaint) = unit.wait()?;
            if let Some(node) = self.nodes.get_mut(index / self.controllers) {
                node.log.extend(lines);
            }
            fault = fault.or(complaint);
        }
        fault.map_or(Ok(()), Err)
    }

    /// Carries what the two controllers of each device, if it has two, sent each other.
    fn carry_bytes(&mut self) {
        for (pair, node) in self.units.chunks_mut(self.controllers).zip(&mut self.nodes) {
            let [stm, msp] = pair else { continue };
            if stm.sent.is_empty() && msp.sent.is_empty() {
                continue;
            }
            let faults = lock(&node.surroundings).link;
            msp.bring(carry(std::mem::take(&mut stm.sent), faults, &mut node.line_noise));
            stm.bring(carry(std::mem::take(&mut msp.sent), faults, &mut node.line_noise));
        }
    }

    /// Has the bus decide up to now, and sees to it that every controller it has news for stands
    /// at this boundary when it hears them.
    fn resolve_bus(&mut self) -> Result<(), EngineError> {
        let ports = self.ports();
        let now_ns = self.now_ns;
        let deliveries = lock(&self.bus).resolve(Nanos(now_ns), &ports);
        let news: Vec<bool> =
            deliveries.iter().map(|delivery| *delivery != Delivery::default()).collect();
        if !news.contains(&true) {
            return Ok(());
        }
        self.order(now_ns, |unit| unit.at_ns < now_ns)?;
        let stms = self.units.iter_mut().step_by(self.controllers);
        for (unit, delivery) in stms.zip(deliveries).filter(|(_, d)| *d != Delivery::default()) {
            unit.delivery = Some(delivery);
            unit.wakes_at_ns = now_ns;
        }
        Ok(())
    }

    /// What the CAN controllers want from the bus, by node. Only the STM's is wired to it.
    fn ports(&self) -> Vec<PortState> {
        self.units.iter().step_by(self.controllers).map(|unit| unit.port.clone()).collect()
    }

    /// None for a controller that the devices do not have.
    fn controller(&self, node: usize, mcu: Mcu) -> Option<&Controller> {
        let of_node = self.units.chunks(self.controllers).nth(node).expect("a node of this fleet");
        of_node.get(mcu as usize).map(|unit| &unit.controller)
    }

    fn node(&self, node: usize) -> &Node {
        self.nodes.get(node).expect("a node of this fleet")
    }
}

/// Tells the lines' noise from other uses of the seed.
const LINE_NOISE: u64 = 1 << 63;

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Unit {
    fn new(controller: Controller, report: Report) -> Self {
        Self {
            controller,
            at_ns: report.at_ns,
            wakes_at_ns: report.wakes_at_ns,
            supply: report.supply,
            sent: report.sent,
            bytes: Vec::new(),
            port: report.can,
            delivery: None,
        }
    }

    fn start(&mut self, until_ns: u64) {
        self.controller.tell(Command::Run(Order {
            until_ns,
            bytes: std::mem::take(&mut self.bytes),
            can: self.delivery.take(),
        }));
    }

    fn wait(&mut self) -> Result<(Vec<LogLine>, Option<EngineError>), EngineError> {
        let report = self.controller.stopped()?;
        self.at_ns = report.at_ns;
        self.wakes_at_ns = report.wakes_at_ns;
        self.supply = report.supply;
        self.sent.extend(report.sent);
        self.port = match report.supply {
            Supply::On => report.can,
            Supply::Off => PortState::OFF,
        };
        Ok((report.lines, report.fault))
    }

    fn bring(&mut self, bytes: Vec<Byte>) {
        if let Some(first) = bytes.first() {
            self.wakes_at_ns = self.wakes_at_ns.min(first.at_ns);
        }
        self.bytes.extend(bytes);
    }
}

impl Engine for Fleet {
    fn node_count(&self) -> usize {
        self.nodes.len()
    }

    fn now(&self) -> Instant {
        Instant::from_micros(self.now_ns / NANOS_PER_MICRO)
    }

    fn run_until(&mut self, at: Instant) -> Result<(), EngineError> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        let outcome = self.run(at.as_micros().saturating_mul(NANOS_PER_MICRO));
        self.failed = outcome.clone().err();
        outcome
    }

    fn surroundings(&self, node: usize) -> MutexGuard<'_, Surroundings> {
        lock(&self.node(node).surroundings)
    }

    fn bus(&self) -> MutexGuard<'_, Bus> {
        lock(&self.bus)
    }

    fn set_power(&mut self, node: usize, on: bool) {
        let supply = if on { Supply::On } else { Supply::Off };
        let now_ns = self.now_ns;
        for unit in self.units.chunks_mut(self.controllers).nth(node).unwrap_or_default() {
            unit.controller.tell(Command::Supply(supply));
            unit.bytes.clear();
            unit.delivery = None;
            unit.start(now_ns);
            match unit.wait() {
                Ok((_, fault)) => self.failed = self.failed.take().or(fault),
                Err(error) => self.failed = Some(error),
            }
        }
    }

    fn cut_power_at_flash_operation(&mut self, node: usize, mcu: Mcu, operation: u32) {
        if let Some(controller) = self.controller(node, mcu) {
            controller.tell(Command::CutAtFlashOperation(operation));
        }
    }

    fn stats(&self, node: usize) -> [McuStats; MCUS] {
        Mcu::BOTH.map(|mcu| {
            self.controller(node, mcu).and_then(|it| it.stats().ok()).unwrap_or_default()
        })
    }

    fn take_log(&mut self, node: usize) -> Vec<LogLine> {
        self.nodes.get_mut(node).map(|node| std::mem::take(&mut node.log)).unwrap_or_default()
    }

    fn flash(&self, node: usize, mcu: Mcu) -> FlashImage {
        self.controller(node, mcu).and_then(|it| it.flash().ok()).unwrap_or_default()
    }
}
