use std::sync::Arc;

use emulated::{Firmware, Fleet, Images, Options};
use tests_host::images;
use units::{Duration, Instant};
use world::can::{Frame, Id, LogCursor, Logged, Outside, Rate, Role, Source};
use world::{Engine, EngineError};

/// Frames an outside node keeps waiting, so that the bus is never idle for want of one.
const WAITING: usize = 64;
/// How often the waiting frames are made up.
const REFILL_US: u64 = 2_000;

/// Bit rates the figures are taken at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BitRate {
    /// As delivered.
    Kbit125,
    /// The fastest.
    Kbit1000,
}

/// What a controller has done since the bench started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figures {
    pub(crate) instructions: u64,
    /// Of a device that has been on since time zero.
    pub(crate) awake_us: f64,
    pub(crate) stack_used: u32,
    pub(crate) can_interrupts: u64,
    pub(crate) can_reaction_ns: u64,
    pub(crate) can_wait_ns: u64,
    pub(crate) masked_ns: u64,
}

/// One NM172 and a master on a bus.
pub(crate) struct Rig {
    fleet: Fleet,
    master: Outside,
    log: LogCursor,
}

impl Rig {
    /// A device that is on the bus, at this bit rate.
    pub(crate) fn new(bit_rate: BitRate) -> Result<Self, EngineError> {
        let image = |name: &str| Firmware::read(&images().join(name)).map(Arc::new);
        let images = Images::pair(image("stm-nm172")?, image("msp-nm172")?);
        let fleet = Fleet::new(&images, Options { nodes: 1, seed: 1, flash: Vec::new() })?;
        let master = fleet.bus().attach(Rate::Automatic, Role::Normal);
        let mut rig = Self { fleet, master, log: LogCursor::default() };
        rig.run_ms(1_000)?;
        if bit_rate == BitRate::Kbit1000 {
            rig.write(&[0x2F, 0x00, 0x21, 0x00, 8, 0, 0, 0])?;
            rig.run_ms(300)?;
            rig.fleet.set_power(0, false);
            rig.run_ms(100)?;
            rig.fleet.set_power(0, true);
            rig.run_ms(6_000)?;
        }
        rig.frames();
        Ok(rig)
    }

    /// Where the device takes SDO requests.
    pub(crate) const fn sdo_request(&self) -> Id {
        Id::Standard(0x67F)
    }

    /// Virtual time, in nanoseconds.
    pub(crate) fn now_ns(&self) -> u64 {
        self.fleet.now().as_micros() * 1_000
    }

    pub(crate) fn run_us(&mut self, us: u64) -> Result<(), EngineError> {
        let until: Instant = self.fleet.now() + Duration::from_micros(us);
        self.fleet.run_until(until)
    }

    pub(crate) fn run_ms(&mut self, ms: u64) -> Result<(), EngineError> {
        self.run_us(ms * 1_000)
    }

    /// Queues a frame of the master.
    pub(crate) fn send(&mut self, frame: Frame) -> Result<(), EngineError> {
        self.fleet.bus().send(self.master, frame).map_err(|full| EngineError(full.to_string()))
    }

    /// An SDO download; time for its answer passes.
    pub(crate) fn write(&mut self, request: &[u8]) -> Result<(), EngineError> {
        let frame = Frame::new(self.sdo_request(), request)
            .map_err(|error| EngineError(error.to_string()))?;
        self.send(frame)?;
        self.run_ms(20)?;
        self.frames();
        Ok(())
    }

    /// The node becomes Operational.
    pub(crate) fn start(&mut self) -> Result<(), EngineError> {
        let start = Frame::new(Id::Standard(0), &[1, 0]);
        self.send(start.map_err(|error| EngineError(error.to_string()))?)?;
        self.run_ms(200)?;
        self.frames();
        Ok(())
    }

    /// Frames on the bus since the last call.
    pub(crate) fn frames(&mut self) -> Vec<Logged> {
        let bus = self.fleet.bus();
        let (logged, next) = bus.log_since(self.log);
        self.log = next;
        drop(bus);
        while self.fleet.bus().receive(self.master).is_some() {}
        logged
    }

    /// Sends these frames in turn, as many as the bus carries in `ms`. How many of them went over
    /// the bus, how many frames of the device with the identifier `answer` did, and the load in
    /// percent.
    pub(crate) fn saturate(
        &mut self,
        frames: &[Frame],
        answer: u32,
        ms: u64,
    ) -> Result<(usize, usize, u64), EngineError> {
        let mut turn = frames.iter().cycle();
        let (from, busy) = (self.now_ns(), self.fleet.bus().busy());
        let until = from + ms * 1_000_000;
        let (mut sent, mut answered) = (0, 0);
        let mut count = |logged: Vec<Logged>| {
            let answers = |logged: &&Logged| logged.frame.id().value() == answer;
            sent += logged.iter().filter(|l| !matches!(l.source, Source::Device(_))).count();
            answered += logged.iter().filter(answers).count();
        };
        while self.now_ns() < until {
            let waiting = self.fleet.bus().status(self.master).map_or(0, |status| status.waiting);
            for frame in turn.by_ref().take(WAITING.saturating_sub(waiting)) {
                self.send(*frame)?;
            }
            self.run_us(REFILL_US)?;
            count(self.frames());
        }
        let load = (self.fleet.bus().busy() - busy) * 100 / (self.now_ns() - from);
        self.run_ms(100)?;
        count(self.frames());
        Ok((sent, answered, load))
    }

    /// Turns the shaft by hand at once.
    pub(crate) fn turn(&mut self, steps: i64) {
        self.fleet.surroundings(0).spindle.turn(steps);
    }

    /// Turns the shaft by hand at a constant speed.
    pub(crate) fn turn_steadily(&mut self, steps_per_s: i64) {
        let now_ns = self.now_ns();
        self.fleet.surroundings(0).spindle.turn_steadily(now_ns, steps_per_s);
    }

    /// The actual value as the glass shows it.
    pub(crate) fn lower_line(&self) -> String {
        self.fleet.surroundings(0).lcd.lower()
    }

    /// STM, MSP.
    pub(crate) fn stats(&self) -> [Figures; 2] {
        #[expect(clippy::cast_precision_loss, reason = "a fraction of it has three places")]
        let now_us = self.fleet.now().as_micros() as f64;
        self.fleet.stats(0).map(|stats| Figures {
            instructions: stats.instructions,
            awake_us: stats.awake_fraction * now_us,
            stack_used: stats.stack_used,
            can_interrupts: stats.can_interrupts,
            can_reaction_ns: stats.can_reaction_ns,
            can_wait_ns: stats.can_wait_ns,
            masked_ns: stats.masked_ns,
        })
    }
}
