//! Any number of devices on one CAN bus, on one virtual clock.
//!
//! Time jumps to the earliest instant at which a device has something to do or the bus may begin a
//! frame. First the devices act, then the bus decides: so everything requested up to the start of a
//! frame contends for it.

use std::sync::{Mutex, MutexGuard, PoisonError};

use units::Instant;
use world::can::{Bus, Delivery, Nanos, PortState};
use world::{Engine, EngineError, FlashImage, LogLine, Mcu, McuStats, Surroundings};

use crate::device::{Device, Kind, Make};

/// How a fleet starts.
#[derive(Clone, Debug)]
pub struct Options {
    /// Devices on the bus.
    pub nodes: usize,
    /// Where everything random comes from: faults of lines and bus.
    pub seed: u64,
    /// The memory of an earlier run, by node: STM, MSP. Missing nodes start with everything at
    /// delivery state.
    pub flash: Vec<[Option<FlashImage>; 2]>,
}

/// Devices on a CAN bus.
#[derive(Debug)]
pub struct Fleet {
    now_ns: u64,
    devices: Vec<Device>,
    /// When each device has something to do.
    wakes_at_ns: Vec<u64>,
    /// What each device wants from the bus.
    ports: Vec<PortState>,
    bus: Mutex<Bus>,
}

impl Fleet {
    /// Devices of one `kind`, with the supply on since time zero.
    ///
    /// # Errors
    /// When the memory of the earlier run is not this engine's.
    pub fn new(kind: Kind, options: Options) -> Result<Self, EngineError> {
        let mut kept = options.flash;
        kept.resize(options.nodes, [None, None]);
        let mut devices = Vec::new();
        for (serial_number, kept) in (1..).zip(&kept) {
            let make = Make { serial_number, seed: options.seed };
            let mut device = Device::new(kind, make, kept)?;
            device.power_on(0);
            devices.push(device);
        }
        let mut fleet = Self {
            now_ns: 0,
            wakes_at_ns: vec![0; devices.len()],
            ports: vec![PortState::OFF; devices.len()],
            devices,
            bus: Mutex::new(Bus::new(options.seed)),
        };
        fleet.run_due();
        Ok(fleet)
    }

    fn run(&mut self, target_ns: u64) {
        loop {
            let bus = self.bus_acts_at();
            let next = self.wakes_at_ns.iter().copied().fold(bus, u64::min);
            if next > target_ns {
                break;
            }
            self.now_ns = next.max(self.now_ns);
            self.run_due();
            if self.bus_acts_at() <= self.now_ns {
                self.resolve_bus();
            }
        }
        self.now_ns = target_ns.max(self.now_ns);
        self.resolve_bus();
    }

    fn bus(&mut self) -> &mut Bus {
        self.bus.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    fn bus_acts_at(&mut self) -> u64 {
        let bus = self.bus.get_mut().unwrap_or_else(PoisonError::into_inner);
        bus.next_activity(&self.ports).map_or(u64::MAX, |at| at.0)
    }

    fn run_due(&mut self) {
        for index in 0..self.devices.len() {
            if self.wakes_at_ns.get(index).is_some_and(|at| *at <= self.now_ns) {
                if let Some(device) = self.devices.get_mut(index) {
                    device.run(self.now_ns);
                }
                self.look_at(index);
            }
        }
    }

    /// Sees when a device wants to run next, and what it wants from the bus.
    fn look_at(&mut self, index: usize) {
        let Self { devices, wakes_at_ns, ports, .. } = self;
        if let Some(device) = devices.get(index)
            && let Some(wakes_at) = wakes_at_ns.get_mut(index)
            && let Some(port) = ports.get_mut(index)
        {
            *wakes_at = device.wakes_at(self.now_ns);
            *port = device.port();
        }
    }

    fn resolve_bus(&mut self) {
        let now = Nanos(self.now_ns);
        let ports = std::mem::take(&mut self.ports);
        let deliveries = self.bus().resolve(now, &ports);
        self.ports = ports;
        for (index, delivery) in deliveries.into_iter().enumerate() {
            if delivery != Delivery::default()
                && let Some(device) = self.devices.get_mut(index)
            {
                device.deliver(delivery);
                self.look_at(index);
            }
        }
    }

    fn device(&self, node: usize) -> &Device {
        self.devices.get(node).expect("a node of this fleet")
    }
}

fn lock<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Engine for Fleet {
    fn node_count(&self) -> usize {
        self.devices.len()
    }

    fn now(&self) -> Instant {
        Nanos(self.now_ns).instant()
    }

    fn run_until(&mut self, at: Instant) -> Result<(), EngineError> {
        self.run(Nanos::from_instant(at).0);
        Ok(())
    }

    fn surroundings(&self, node: usize) -> MutexGuard<'_, Surroundings> {
        lock(&self.device(node).surroundings)
    }

    fn bus(&self) -> MutexGuard<'_, Bus> {
        lock(&self.bus)
    }

    fn set_power(&mut self, node: usize, on: bool) {
        let now_ns = self.now_ns;
        if let Some(device) = self.devices.get_mut(node) {
            if on {
                device.power_on(now_ns);
            } else {
                device.power_off(now_ns);
            }
        }
        self.look_at(node);
    }

    fn cut_power_at_flash_operation(&mut self, node: usize, mcu: Mcu, operation: u32) {
        if let Some(device) = self.devices.get_mut(node) {
            device.cut_at(mcu, operation);
        }
    }

    fn stats(&self, node: usize) -> [McuStats; 2] {
        self.device(node).stats()
    }

    fn take_log(&mut self, _node: usize) -> Vec<LogLine> {
        Vec::new()
    }

    fn flash(&self, node: usize, mcu: Mcu) -> FlashImage {
        self.device(node).board(mcu).memory.image()
    }
}
