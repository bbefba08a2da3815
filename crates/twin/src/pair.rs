//! A device with two controllers and the line between them.

use profiles::Product;
use world::can::{Delivery, PortState};
use world::{Dice, EngineError, FlashImage, Link, Mcu, McuStats, MotorOutputs, Surroundings};

use crate::board::{Board, Cause};
use crate::device::Make;
use crate::line::Line;
use crate::memory::Kept;
use crate::msp::Msp;
use crate::stm::Stm;

/// Both controllers.
#[derive(Debug)]
pub(crate) struct Pair {
    product: &'static Product,
    make: Make,
    stm: Option<Stm>,
    msp: Option<Msp>,
    stm_board: Board,
    msp_board: Board,
    to_stm: Line,
    to_msp: Line,
    line_noise: Dice,
    frames_taken_before: u64,
}

/// What a core's shell reaches while it hands on what the core brought about.
#[derive(Debug)]
pub(crate) struct Outgoing<'a> {
    pub(crate) now_ns: u64,
    pub(crate) board: &'a mut Board,
    line: &'a mut Line,
    faults: Link,
    noise: &'a mut Dice,
}

impl Outgoing<'_> {
    pub(crate) fn has_room(&self) -> bool {
        self.line.has_room(self.now_ns)
    }

    pub(crate) fn send(&mut self, frame: &[u8]) {
        self.line.send(self.now_ns, frame, self.faults, self.noise);
    }

    pub(crate) fn keep(&mut self, key: u32, number: u32) -> Kept {
        self.board.memory.keep(key, number)
    }

    pub(crate) fn keep_set(&mut self, set: impl IntoIterator<Item = (u32, u32)>) -> Kept {
        self.board.memory.keep_set(set)
    }

    pub(crate) fn forget(&mut self) -> Kept {
        self.board.memory.forget()
    }

    /// The controller restarts once the other one has been sent everything.
    pub(crate) fn restart(&mut self) {
        let at = self.line.sent_at().max(self.now_ns);
        self.board.restart_at_ns.get_or_insert(at);
    }
}

impl Pair {
    /// Both without supply, with what was `kept` from an earlier run: STM, MSP.
    ///
    /// # Errors
    /// When that is not this engine's.
    pub(crate) fn new(
        product: &'static Product,
        make: Make,
        kept: &[Option<FlashImage>; 2],
    ) -> Result<Self, EngineError> {
        let [stm, msp] = kept;
        Ok(Self {
            product,
            make,
            stm: None,
            msp: None,
            stm_board: Board::new(stm.as_ref())?,
            msp_board: Board::new(msp.as_ref())?,
            to_stm: Line::default(),
            to_msp: Line::default(),
            line_noise: Dice::new(make.seed, make.serial_number.into()),
            frames_taken_before: 0,
        })
    }

    /// The supply comes.
    pub(crate) fn power_on(&mut self, now_ns: u64, world: &mut Surroundings) {
        if self.stm.is_none() {
            self.start_stm(now_ns, Cause::PowerOn);
        }
        if self.msp.is_none() {
            self.start_msp(now_ns, Cause::PowerOn, world);
        }
    }

    /// The supply goes.
    pub(crate) fn power_off(&mut self, now_ns: u64, world: &mut Surroundings) {
        self.stop_stm();
        self.stop_msp(now_ns, world);
        self.to_stm = Line::default();
        self.to_msp = Line::default();
    }

    fn start_stm(&mut self, now_ns: u64, cause: Cause) {
        self.stop_stm();
        self.stm_board.start(now_ns, cause);
        let serial_number = self.make.serial_number;
        self.stm = Some(Stm::new(now_ns, self.product, serial_number, &self.stm_board));
    }

    fn start_msp(&mut self, now_ns: u64, cause: Cause, world: &mut Surroundings) {
        world.drive_motor(now_ns, MotorOutputs::default());
        self.msp_board.start(now_ns, cause);
        self.msp = Some(Msp::new(now_ns, self.product, &self.msp_board));
    }

    fn stop_stm(&mut self) {
        self.frames_taken_before += self.stm.take().map_or(0, |stm| stm.frames_taken());
        self.stm_board.restart_at_ns = None;
    }

    fn stop_msp(&mut self, now_ns: u64, world: &mut Surroundings) {
        self.msp = None;
        self.msp_board.restart_at_ns = None;
        world.lose_power(now_ns);
    }

    /// When the next thing happens, if nobody disturbs.
    pub(crate) fn wakes_at(&self, now_ns: u64) -> u64 {
        let stm = self.stm.as_ref().map(|stm| {
            [stm.due_ns(&self.stm_board), self.stm_board.restart_at_ns, self.to_msp.room_at(now_ns)]
        });
        let msp = self.msp.as_ref().map(|msp| {
            [Some(msp.due_ns()), self.msp_board.restart_at_ns, self.to_stm.room_at(now_ns)]
        });
        let lines = [self.to_stm.arrives_at(), self.to_msp.arrives_at()];
        let all = stm.into_iter().chain(msp).flatten().chain(lines).flatten();
        all.min().unwrap_or(u64::MAX)
    }

    /// Takes in what the bus decided.
    pub(crate) fn deliver(&mut self, delivery: Delivery) {
        if let Some(stm) = &mut self.stm {
            stm.deliver(delivery);
        }
    }

    /// What its CAN controller wants from the bus.
    pub(crate) fn port(&self) -> PortState {
        self.stm.as_ref().map_or(PortState::OFF, Stm::port)
    }

    /// Does what is due.
    pub(crate) fn run(&mut self, now_ns: u64, world: &mut Surroundings) {
        if self.stm_board.restart_at_ns.is_some_and(|at| at <= now_ns) {
            self.start_stm(now_ns, Cause::Software);
        }
        if self.msp_board.restart_at_ns.is_some_and(|at| at <= now_ns) {
            self.start_msp(now_ns, Cause::Software, world);
        }
        self.run_stm(now_ns, world);
        self.run_msp(now_ns, world);
    }

    fn run_stm(&mut self, now_ns: u64, world: &Surroundings) {
        let arrived = self.to_stm.arrived(now_ns);
        let Some(stm) = &mut self.stm else { return };
        let mut out = Outgoing {
            now_ns,
            board: &mut self.stm_board,
            line: &mut self.to_msp,
            faults: world.link,
            noise: &mut self.line_noise,
        };
        match stm.run(arrived.as_deref(), &mut out) {
            Kept::Yes => {}
            Kept::SupplyLost => self.stop_stm(),
        }
    }

    fn run_msp(&mut self, now_ns: u64, world: &mut Surroundings) {
        let arrived = self.to_msp.arrived(now_ns);
        let Some(msp) = &mut self.msp else { return };
        let mut out = Outgoing {
            now_ns,
            board: &mut self.msp_board,
            line: &mut self.to_stm,
            faults: world.link,
            noise: &mut self.line_noise,
        };
        match msp.run(arrived.as_deref(), world, &mut out) {
            Kept::Yes => {}
            Kept::SupplyLost => self.stop_msp(now_ns, world),
        }
    }

    /// One controller without its core.
    pub(crate) fn board(&self, mcu: Mcu) -> &Board {
        match mcu {
            Mcu::Stm => &self.stm_board,
            Mcu::Msp => &self.msp_board,
        }
    }

    /// See [`world::Engine::cut_power_at_flash_operation`].
    pub(crate) fn cut_at(&mut self, mcu: Mcu, operation: u32) {
        match mcu {
            Mcu::Stm => self.stm_board.memory.cut_at(operation),
            Mcu::Msp => self.msp_board.memory.cut_at(operation),
        }
    }

    /// Figures of both controllers.
    pub(crate) fn stats(&self) -> [McuStats; 2] {
        let taken = self.stm.as_ref().map_or(0, Stm::frames_taken);
        let can_interrupts = self.frames_taken_before + taken;
        [McuStats { can_interrupts, ..self.stm_board.stats() }, self.msp_board.stats()]
    }
}
