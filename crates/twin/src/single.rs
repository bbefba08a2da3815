//! A device with one controller: its core, and what a shell does for it.

use canopen::BusState;
use position_sensor::{Event, Model, Record, Sensor};
use units::Instant;
use world::can::{Delivery, Nanos, PortState};
use world::spindle::STEPS_PER_TURN;
use world::{EngineError, FlashImage, Mcu, McuStats, Surroundings};

use crate::board::{Board, Cause};
use crate::can_port::{CanPort, Notice};
use crate::device::Make;
use crate::memory::{Kept, Memory};

/// How often the sensor is read.
const READ_EVERY_NS: u64 = 2_000_000;

/// The controller with its supply and its memory.
#[derive(Debug)]
pub(crate) struct Single {
    model: &'static Model,
    make: Make,
    core: Option<Core>,
    board: Board,
    /// What other devices have besides.
    nothing: Board,
    frames_taken_before: u64,
}

/// The controller while it has supply.
#[derive(Debug)]
struct Core {
    sensor: Box<Sensor>,
    port: CanPort,
    read_at_ns: u64,
    bus: BusState,
}

impl Single {
    /// Without supply, with what was `kept` from an earlier run.
    ///
    /// # Errors
    /// When that is not this engine's.
    pub(crate) fn new(
        model: &'static Model,
        make: Make,
        [kept, nothing]: &[Option<FlashImage>; 2],
    ) -> Result<Self, EngineError> {
        let board = Board::new(kept.as_ref())?;
        let nothing = Board::new(nothing.as_ref())?;
        Ok(Self { model, make, core: None, board, nothing, frames_taken_before: 0 })
    }

    /// See [`crate::device::Device::power_on`].
    pub(crate) fn power_on(&mut self, now_ns: u64) {
        if self.core.is_none() {
            self.start(now_ns, Cause::PowerOn);
        }
    }

    /// See [`crate::device::Device::power_off`].
    pub(crate) fn power_off(&mut self, now_ns: u64, world: &mut Surroundings) {
        self.stop();
        world.lose_power(now_ns);
    }

    fn start(&mut self, now_ns: u64, cause: Cause) {
        self.stop();
        self.board.start(now_ns, cause);
        let now = self.board.time(now_ns);
        let kept = kept(&self.board.memory);
        let sensor = Box::new(Sensor::new(now, self.model, self.make.serial_number, kept));
        let mut core =
            Core { sensor, port: CanPort::new(), read_at_ns: now_ns, bus: BusState::Active };
        core.configure_bus(now_ns);
        self.core = Some(core);
    }

    fn stop(&mut self) {
        self.frames_taken_before += self.core.take().map_or(0, |core| core.port.frames_taken());
        self.board.restart_at_ns = None;
    }

    /// See [`crate::device::Device::wakes_at`].
    pub(crate) fn wakes_at(&self) -> u64 {
        let Some(core) = &self.core else { return u64::MAX };
        let timeout = core.sensor.poll_timeout().map(|at| self.board.nanos(at));
        let event = core.port.next_event().map(|at| at.0);
        let others = [timeout, event, self.board.restart_at_ns].into_iter().flatten();
        others.fold(core.read_at_ns, u64::min)
    }

    /// See [`crate::device::Device::deliver`].
    pub(crate) fn deliver(&mut self, delivery: Delivery) {
        if let Some(core) = &mut self.core {
            core.port.deliver(delivery);
        }
    }

    /// See [`crate::device::Device::port`].
    pub(crate) fn port(&self) -> PortState {
        self.core.as_ref().map_or(PortState::OFF, |core| core.port.state())
    }

    /// See [`crate::device::Device::run`].
    pub(crate) fn run(&mut self, now_ns: u64, world: &Surroundings) {
        if self.board.restart_at_ns.is_some_and(|at| at <= now_ns) {
            self.start(now_ns, Cause::Software);
        }
        let Some(core) = &mut self.core else { return };
        match core.run(now_ns, self.model, world, &mut self.board) {
            Kept::Yes => {}
            Kept::SupplyLost => self.stop(),
        }
    }

    /// See [`crate::device::Device::board`].
    pub(crate) fn board(&self, mcu: Mcu) -> &Board {
        match mcu {
            Mcu::Stm => &self.board,
            Mcu::Msp => &self.nothing,
        }
    }

    /// See [`world::Engine::cut_power_at_flash_operation`].
    pub(crate) fn cut_at(&mut self, mcu: Mcu, operation: u32) {
        match mcu {
            Mcu::Stm => self.board.memory.cut_at(operation),
            Mcu::Msp => self.nothing.memory.cut_at(operation),
        }
    }

    /// See [`crate::device::Device::stats`].
    pub(crate) fn stats(&self) -> [McuStats; 2] {
        let taken = self.core.as_ref().map_or(0, |core| core.port.frames_taken());
        let can_interrupts = self.frames_taken_before + taken;
        [McuStats { can_interrupts, ..self.board.stats() }, self.nothing.stats()]
    }
}

impl Core {
    /// Does what is due: frames, the shaft, time.
    fn run(&mut self, now_ns: u64, model: &Model, world: &Surroundings, board: &mut Board) -> Kept {
        let now = board.time(now_ns);
        let mut kept = Kept::Yes;
        while let Some(notice) = self.port.poll(Nanos(now_ns)) {
            match notice {
                Notice::Received(frame) => {
                    if self.sensor.reads_for(&frame) {
                        self.read(now_ns, model, world, board);
                    }
                    self.sensor.handle_frame(now, &frame);
                }
                Notice::Returned(frame) => self.sensor.give_back(frame),
                Notice::Other => {}
            }
            self.look_at_bus(now);
            kept = kept.and(self.drain(now_ns, board));
        }
        if self.read_at_ns <= now_ns {
            self.read_at_ns = now_ns + READ_EVERY_NS;
            if self.sensor.reads_cyclically() {
                self.read(now_ns, model, world, board);
            }
            // Getting better is no interrupt.
            self.look_at_bus(now);
        }
        if self.sensor.poll_timeout().is_some_and(|due| due <= now) {
            self.sensor.handle_timeout(now);
        }
        kept.and(self.drain(now_ns, board))
    }

    fn read(&mut self, now_ns: u64, model: &Model, world: &Surroundings, board: &Board) {
        let steps = world.spindle.position(now_ns) * i64::from(model.steps_per_turn());
        self.sensor.handle_steps(board.time(now_ns), steps.div_euclid(STEPS_PER_TURN.into()));
    }

    fn look_at_bus(&mut self, now: Instant) {
        let bus = self.port.bus_state();
        if bus != self.bus {
            self.bus = bus;
            self.sensor.handle_bus(now, bus);
        }
    }

    /// Hands on what the core brought about.
    fn drain(&mut self, now_ns: u64, board: &mut Board) -> Kept {
        let mut stored = Kept::Yes;
        self.port.set_recovery(self.sensor.recovers_from_bus_off());
        while let Some(event) = self.sensor.poll_event() {
            match event {
                Event::Keep(Record { key, value }) => {
                    stored = stored.and(board.memory.keep(key, value));
                }
                Event::Save(group) => {
                    let records = self.sensor.parameters(group);
                    let numbers = records.map(|record| (record.key, record.value));
                    let replaced = |key| group.contains(key);
                    stored = stored.and(board.memory.keep_instead(replaced, numbers));
                    self.sensor.handle_stored(board.time(now_ns), Ok(()));
                }
                Event::Forget(group) => {
                    let replaced = |key| group.contains(key);
                    stored = stored.and(board.memory.keep_instead(replaced, []));
                    self.sensor.handle_stored(board.time(now_ns), Ok(()));
                }
                Event::FiltersChanged => self.configure_bus(now_ns),
                Event::Restart => {
                    board.restart_at_ns.get_or_insert(now_ns);
                }
                Event::RestartCommunication => {
                    let now = board.time(now_ns);
                    self.sensor.restart_communication(now, kept(&board.memory));
                }
            }
        }
        while let Some(frame) = self.sensor.peek_transmit().copied() {
            let Ok(returned) = self.port.transmit(Nanos(now_ns), &frame) else { break };
            self.sensor.take_transmit();
            if let Some(returned) = returned {
                self.sensor.give_back(returned);
            }
        }
        stored
    }

    fn configure_bus(&mut self, now_ns: u64) {
        let Self { sensor, port, .. } = self;
        port.configure(Nanos(now_ns), sensor.bit_rate(), sensor.accepts());
    }
}

fn kept(memory: &Memory) -> impl Iterator<Item = Record> + Clone {
    memory.numbers().map(|(key, value)| Record { key, value })
}
