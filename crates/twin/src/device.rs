//! One device and what surrounds it.

use std::sync::{Mutex, PoisonError};

use position_sensor::Model;
use profiles::Product;
use world::can::{Delivery, PortState};
use world::{EngineError, FlashImage, Mcu, McuStats, Surroundings};

use crate::board::Board;
use crate::pair::Pair;
use crate::single::Single;

/// What devices are made of.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// Two controllers.
    Pair(&'static Product),
    /// One controller.
    Single(&'static Model),
}

/// What the products are called on the command line.
pub fn slugs() -> impl Iterator<Item = &'static str> {
    kinds().map(|(slug, _)| slug)
}

/// The kind of devices that is called `slug`.
#[must_use]
pub fn kind(slug: &str) -> Option<Kind> {
    kinds().find(|(name, _)| *name == slug).map(|(_, kind)| kind)
}

fn kinds() -> impl Iterator<Item = (&'static str, Kind)> {
    let pairs = [&profiles::nm170::PRODUCT, &profiles::nm172::PRODUCT, &profiles::nm174::PRODUCT];
    let pairs = pairs.into_iter().map(|product| (product.slug, Kind::Pair(product)));
    pairs.chain(position_sensor::MODELS.iter().map(|model| (model.slug, Kind::Single(model))))
}

/// What makes one device another than the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Make {
    pub(crate) serial_number: u32,
    /// Decides what a bad line does.
    pub(crate) seed: u64,
}

/// The device.
#[derive(Debug)]
pub(crate) struct Device {
    pub(crate) surroundings: Mutex<Surroundings>,
    controllers: Controllers,
}

#[derive(Debug)]
enum Controllers {
    Pair(Pair),
    Single(Single),
}

impl Device {
    /// A device without supply, with what was `kept` from an earlier run: STM, MSP.
    ///
    /// # Errors
    /// When that is not this engine's.
    pub(crate) fn new(
        kind: Kind,
        make: Make,
        kept: &[Option<FlashImage>; 2],
    ) -> Result<Self, EngineError> {
        let controllers = match kind {
            Kind::Pair(product) => Controllers::Pair(Pair::new(product, make, kept)?),
            Kind::Single(model) => Controllers::Single(Single::new(model, make, kept)?),
        };
        Ok(Self { surroundings: Mutex::default(), controllers })
    }

    fn parts(&mut self) -> (&mut Controllers, &mut Surroundings) {
        let world = self.surroundings.get_mut().unwrap_or_else(PoisonError::into_inner);
        (&mut self.controllers, world)
    }

    /// The supply comes.
    pub(crate) fn power_on(&mut self, now_ns: u64) {
        match self.parts() {
            (Controllers::Pair(pair), world) => pair.power_on(now_ns, world),
            (Controllers::Single(single), _) => single.power_on(now_ns),
        }
    }

    /// The supply goes.
    pub(crate) fn power_off(&mut self, now_ns: u64) {
        match self.parts() {
            (Controllers::Pair(pair), world) => pair.power_off(now_ns, world),
            (Controllers::Single(single), world) => single.power_off(now_ns, world),
        }
    }

    /// When the next thing happens, if nobody disturbs.
    pub(crate) fn wakes_at(&self, now_ns: u64) -> u64 {
        match &self.controllers {
            Controllers::Pair(pair) => pair.wakes_at(now_ns),
            Controllers::Single(single) => single.wakes_at(),
        }
    }

    /// Takes in what the bus decided.
    pub(crate) fn deliver(&mut self, delivery: Delivery) {
        match &mut self.controllers {
            Controllers::Pair(pair) => pair.deliver(delivery),
            Controllers::Single(single) => single.deliver(delivery),
        }
    }

    /// What its CAN controller wants from the bus.
    pub(crate) fn port(&self) -> PortState {
        match &self.controllers {
            Controllers::Pair(pair) => pair.port(),
            Controllers::Single(single) => single.port(),
        }
    }

    /// Does what is due.
    pub(crate) fn run(&mut self, now_ns: u64) {
        match self.parts() {
            (Controllers::Pair(pair), world) => pair.run(now_ns, world),
            (Controllers::Single(single), world) => single.run(now_ns, world),
        }
    }

    /// One controller without its core.
    pub(crate) fn board(&self, mcu: Mcu) -> &Board {
        match &self.controllers {
            Controllers::Pair(pair) => pair.board(mcu),
            Controllers::Single(single) => single.board(mcu),
        }
    }

    /// See [`world::Engine::cut_power_at_flash_operation`].
    pub(crate) fn cut_at(&mut self, mcu: Mcu, operation: u32) {
        match &mut self.controllers {
            Controllers::Pair(pair) => pair.cut_at(mcu, operation),
            Controllers::Single(single) => single.cut_at(mcu, operation),
        }
    }

    /// Figures of both controllers.
    pub(crate) fn stats(&self) -> [McuStats; 2] {
        match &self.controllers {
            Controllers::Pair(pair) => pair.stats(),
            Controllers::Single(single) => single.stats(),
        }
    }
}
