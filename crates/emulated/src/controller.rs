//! One running controller: a microcontroller on its board, executing its image on a thread of its
//! own, and doing nothing but what it is told over a channel.
use std::fmt::Write as _;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use rigless::device::{Level, ResetCause};
use rigless::emulator::{
    self, Access, AccessKind, Driver, Hit, Host, Settled, Start, Stop, StopReason, Watch,
};
use rigless::image::Image;
use rigless::machine::{Board, Target, armv7m};
use rigless::mcu::{Mcu as _, Operate as _};
use rigless::session::Session;
use rigless::snapshot::Store;
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use std::num::{NonZeroU32, NonZeroU64};
use std::path::Path;
use units::Instant;
use world::can::{Delivery, PortState, Presence};
use world::{Dice, EngineError, LogLine, Mcu, McuStats, MotorOutputs, Panel, Reset, Surroundings};

use crate::firmware::{Firmware, MaskingInstruction};
use crate::flash_array::FlashArray;
use crate::log_channel::{LogChannel, READ_EVERY_NS};
use crate::memory_map::{
    BOOT_REGION, CCM_BASE, CCM_LEN, DMA, FLASH_BASE, FLASH_LEN, FLASH_SIZE, SRAM_BASE, SRAM_LEN,
    UNIQUE_ID,
};
use crate::serial_line::Byte;
use crate::stm32f429::{PinOf, Stm32f429};

/// The clock of a core, which the emulator has to know beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoreClock {
    /// What the part starts with.
    Mhz16,
    /// Set up by the firmware.
    Mhz160,
}

impl CoreClock {
    const fn hz(self) -> NonZeroU64 {
        match self {
            Self::Mhz16 => NonZeroU64::new(16_000_000).expect("a clock that runs"),
            Self::Mhz160 => NonZeroU64::new(160_000_000).expect("a clock that runs"),
        }
    }

    /// Virtual time for each instruction: 1.28 cycles, about what a Cortex-M4 takes with the flash
    /// accelerator on.
    const fn nanos_per_instruction(self) -> u64 {
        match self {
            Self::Mhz16 => 80,
            Self::Mhz160 => 8,
        }
    }

    const fn instructions_per_second(self) -> NonZeroU64 {
        let rate = NonZeroU64::new(1_000_000_000 / self.nanos_per_instruction());
        rate.expect("a core that runs")
    }
}

/// Of the interrupt controller (RM0090 12.1.1).
const PRIORITY_BITS: u8 = 4;
/// SysTick's reference clock is HCLK / 8 (RM0090 6.2).
const SYSTICK_DIVIDER: NonZeroU32 = NonZeroU32::new(8).expect("a divider");

/// What the board of a controller wires to its pins.
mod pins {
    use super::PinOf;

    pub(super) const LEFT_KEY: PinOf = PinOf::new('F', 13);
    pub(super) const RIGHT_KEY: PinOf = PinOf::new('F', 14);
    pub(super) const INPUT_F: PinOf = PinOf::new('F', 15);
    pub(super) const INPUT_G: PinOf = PinOf::new('E', 13);
    pub(super) const IN1: PinOf = PinOf::new('E', 9);
    pub(super) const IN2: PinOf = PinOf::new('E', 11);
    pub(super) const IN3: PinOf = PinOf::new('F', 12);
    pub(super) const IN4: PinOf = PinOf::new('D', 15);
    pub(super) const MOTOR: [PinOf; 4] = [IN1, IN2, IN3, IN4];
    pub(super) const MOTOR_FAULT: PinOf = PinOf::new('D', 14);
    pub(super) const LINK_TX: PinOf = PinOf::new('D', 5);
    pub(super) const LINK_RX: PinOf = PinOf::new('D', 6);
    pub(super) const CAN: [PinOf; 2] = [PinOf::new('D', 0), PinOf::new('D', 1)];
}

/// The alternate function of USART2 on its pins.
const LINK_FUNCTION: u8 = 7;
/// The alternate function of CAN1 on its pins.
const CAN_FUNCTION: u8 = 9;

/// Which controller of which device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    pub(crate) node: usize,
    pub(crate) mcu: Mcu,
}

/// What a controller is started with.
#[derive(Debug)]
pub(crate) struct Setup {
    pub(crate) identity: Identity,
    pub(crate) firmware: Arc<Firmware>,
    pub(crate) clock: CoreClock,
    /// The flash of an earlier run.
    pub(crate) kept: Option<Vec<u8>>,
    pub(crate) seed: u64,
    /// What surrounds the device.
    pub(crate) surroundings: Arc<Mutex<Surroundings>>,
}

/// What a controller is told.
#[derive(Debug)]
pub(crate) enum Command {
    /// Run up to an instant.
    Run(Order),
    /// The supply from now on.
    Supply(Supply),
    /// Lose the supply in the middle of a flash operation to come.
    CutAtFlashOperation(u32),
    /// Report figures.
    Stats,
    /// Report the flash.
    Flash,
    /// End.
    End,
}

/// What to run, and with what.
#[derive(Debug)]
pub(crate) struct Order {
    pub(crate) until_ns: u64,
    /// Bytes arriving from the other controller.
    pub(crate) bytes: Vec<Byte>,
    /// What the CAN bus made of the requests of the last report.
    pub(crate) can: Option<Delivery>,
}

/// The supply of a controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Supply {
    On,
    Off,
}

/// What a controller answers.
#[derive(Debug)]
pub(crate) enum Answer {
    Stopped(Box<Report>),
    Stats(Box<McuStats>),
    Flash(Vec<u8>),
    /// It does not run any more.
    Ended(EngineError),
}

/// Where a controller stands at the end of an order.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) at_ns: u64,
    /// The instant before which it does nothing unless something arrives.
    pub(crate) wakes_at_ns: u64,
    pub(crate) supply: Supply,
    pub(crate) sent: Vec<Byte>,
    /// What its CAN controller wants from the bus.
    pub(crate) can: PortState,
    pub(crate) lines: Vec<LogLine>,
    /// Why the run must end.
    pub(crate) fault: Option<EngineError>,
}

/// A controller's thread, seen from outside.
#[derive(Debug)]
pub(crate) struct Controller {
    commands: Sender<Command>,
    answers: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
    identity: Identity,
}

impl Controller {
    /// Starts one, at time zero and with the supply on.
    ///
    /// # Errors
    /// When the image cannot run on the part at all.
    pub(crate) fn start(setup: Setup) -> Result<(Self, Report), EngineError> {
        let (commands, for_pilot) = channel();
        let (to_fleet, answers) = channel();
        let identity = setup.identity;
        let name = format!("{}{}", identity.mcu.name(), identity.node);
        let thread = std::thread::Builder::new()
            .name(name)
            .spawn(move || {
                if let Err(error) = run(setup, for_pilot, to_fleet.clone()) {
                    // Nobody is left to hear it when the fleet is gone.
                    let _unheard = to_fleet.send(Answer::Ended(error));
                }
            })
            .map_err(|error| EngineError(format!("no thread for a controller: {error}")))?;
        let mut controller = Self { commands, answers, thread: Some(thread), identity };
        let report = controller.stopped()?;
        Ok((controller, report))
    }

    /// Sends a command; whether it arrived shows in the answer.
    pub(crate) fn tell(&self, command: Command) {
        // A controller that ended has said why; `Controller::answer` finds it.
        let _unheard = self.commands.send(command);
    }

    fn answer(&self) -> Result<Answer, EngineError> {
        match self.answers.recv() {
            Ok(Answer::Ended(error)) => Err(error),
            Ok(answer) => Ok(answer),
            Err(_) => Err(EngineError(format!("{} does not run any more", self.name()))),
        }
    }

    /// The end of an order.
    pub(crate) fn stopped(&mut self) -> Result<Report, EngineError> {
        match self.answer()? {
            Answer::Stopped(report) => Ok(*report),
            Answer::Stats(_) | Answer::Flash(_) | Answer::Ended(_) => Err(self.confused()),
        }
    }

    pub(crate) fn stats(&self) -> Result<McuStats, EngineError> {
        self.tell(Command::Stats);
        match self.answer()? {
            Answer::Stats(stats) => Ok(*stats),
            Answer::Stopped(_) | Answer::Flash(_) | Answer::Ended(_) => Err(self.confused()),
        }
    }

    pub(crate) fn flash(&self) -> Result<Vec<u8>, EngineError> {
        self.tell(Command::Flash);
        match self.answer()? {
            Answer::Flash(cells) => Ok(cells),
            Answer::Stopped(_) | Answer::Stats(_) | Answer::Ended(_) => Err(self.confused()),
        }
    }

    fn name(&self) -> String {
        format!("{} of node {}", self.identity.mcu.name(), self.identity.node)
    }

    fn confused(&self) -> EngineError {
        EngineError(format!("{} answered out of turn", self.name()))
    }
}

impl Drop for Controller {
    fn drop(&mut self) {
        self.tell(Command::End);
        if let Some(thread) = self.thread.take() {
            // A panic there has been printed there.
            let _panicked = thread.join();
        }
    }
}

/// Builds the board and runs the image on it until told to end.
fn run(
    setup: Setup,
    commands: Receiver<Command>,
    answers: Sender<Answer>,
) -> Result<(), EngineError> {
    let Setup { identity, firmware, clock, kept, seed, surroundings } = setup;
    let name = identity.mcu.name();
    let failed = |what: String| EngineError(format!("{name}: {what}"));
    let cells = firmware.flashed(kept.as_deref());
    let purpose = 2 * u64::try_from(identity.node).unwrap_or(0) + identity.mcu as u64;
    let image = Image::new(Path::new(firmware.name()), cells.clone(), Some(FLASH_BASE))
        .map_err(|error| failed(error.to_string()))?;
    let flash = FlashArray::new(cells, Dice::new(seed, 2 * purpose));
    let mut part = Stm32f429::new(flash).map_err(|error| failed(error.to_string()))?;
    if identity.mcu == Mcu::Msp {
        part.attach(&surroundings);
    }
    let images = [image];
    let session =
        Session::new(Box::new(CircuitBoard { part, identity, clock }), 0, VirtualNanos(0))
            .map_err(|error| failed(error.to_string()))?;
    let pilot = Pilot {
        identity,
        clock,
        firmware,
        surroundings,
        commands,
        answers,
        log: LogChannel::default(),
        log_due_ns: 0,
        lines: Vec::new(),
        panel: None,
        motor: MotorOutputs::default(),
        noise: Dice::new(seed, 2 * purpose + 1),
        refused: 0,
        resets: 0,
        powered_ns: 0,
        powered_since_ns: Some(0),
        masking: Masking::default(),
        complaint: None,
        on_the_way: None,
    };
    let finished = emulator::run(session, &Start::new(&images), pilot)
        .map_err(|error| failed(error.to_string()))?;
    if finished.stop.is_none() {
        return Err(failed("the firmware ended the run".to_owned()));
    }
    Ok(())
}

/// The board of one controller, as the emulator takes it.
#[derive(Debug)]
struct CircuitBoard {
    part: Stm32f429,
    identity: Identity,
    clock: CoreClock,
}

impl Store for CircuitBoard {}

impl Board for CircuitBoard {
    fn name(&self) -> &'static str {
        "spindle"
    }

    fn target_names(&self) -> Vec<&'static str> {
        vec![self.identity.mcu.name()]
    }

    fn mcu(&mut self, target: usize) -> Option<&mut dyn rigless::mcu::Mcu> {
        if target == 0 { Some(&mut self.part) } else { None }
    }

    fn targets(&mut self) -> Vec<Target<'_>> {
        let lines = NonZeroU32::new(u32::from(self.part.cpu().interrupt_lines));
        let core = armv7m::Core {
            variant: armv7m::Variant::M4,
            clock_hz: self.clock.hz(),
            interrupt_lines: lines.expect("the part has interrupts"),
            priority_bits: PRIORITY_BITS,
            refclk_divider: SYSTICK_DIVIDER,
            instructions_per_second: self.clock.instructions_per_second(),
            boot: BOOT_REGION,
        };
        let windows = rigless::cpu::armv7m::windows(self.part.bus());
        let mut spec =
            core.spec_with_parts(&windows, armv7m::Fpu::FpV4Sp, armv7m::MpuRegions::Eight);
        spec.factory_images = factory_programmed(self.identity);
        vec![Target::new(self.identity.mcu.name(), &mut self.part, spec)]
    }
}

/// The unique device ID and the flash size. The ID tells node and controller, nothing else about
/// the run, so that a device keeps its serial number.
fn factory_programmed(identity: Identity) -> Vec<Image> {
    let node = u16::try_from(identity.node).unwrap_or(u16::MAX).to_le_bytes();
    let mut id = *b"\0\0\0\0SPINDLE\0";
    id[..2].copy_from_slice(&node);
    id[2] = identity.mcu as u8;
    let kilobytes = u16::try_from(FLASH_LEN >> 10).expect("2048 KB").to_le_bytes();
    [(UNIQUE_ID, id.to_vec()), (FLASH_SIZE, kilobytes.to_vec())]
        .into_iter()
        .filter_map(|(at, bytes)| Image::new(Path::new("factory"), bytes, Some(at)).ok())
        .collect()
}

/// Sits between the emulator and the fleet.
struct Pilot {
    identity: Identity,
    clock: CoreClock,
    firmware: Arc<Firmware>,
    surroundings: Arc<Mutex<Surroundings>>,
    commands: Receiver<Command>,
    answers: Sender<Answer>,
    log: LogChannel,
    log_due_ns: u64,
    lines: Vec<LogLine>,
    /// What the keys, the inputs and the fault line were last; `None` before the first look.
    panel: Option<(Panel, bool)>,
    motor: MotorOutputs,
    noise: Dice,
    /// Accesses the part refused, resets taken: to notice another one.
    refused: usize,
    resets: usize,
    powered_ns: u64,
    powered_since_ns: Option<u64>,
    masking: Masking,
    complaint: Option<String>,
    /// The last stop on the way to the end of the order in hand.
    on_the_way: Option<OnTheWay>,
}

/// What tells, at the end of an order, whether the core slept through it.
#[derive(Clone, Copy, Debug)]
struct OnTheWay {
    instructions: u64,
    /// When something was due next.
    due_at: Option<VirtualNanos>,
}

/// For how long the firmware masks all interrupts.
#[derive(Debug, Default)]
struct Masking {
    /// Whether the run tells of the instructions that do it.
    watched: bool,
    depth: u32,
    since_ns: u64,
    longest_ns: u64,
}

type Run = Session<CircuitBoard>;

impl Driver<CircuitBoard> for Pilot {
    fn on_settled(&mut self, session: &mut Run, _: &mut dyn Host, settled: Settled) {
        match settled {
            Settled::Access { access, .. } => self.watch_access(session, access),
            Settled::Stop(stop) => {
                self.watch_restarts(session, stop.at.0);
                if stop.at < session.until() {
                    self.on_the_way = Some(OnTheWay {
                        instructions: stop.instruction_count,
                        due_at: session.board().part.next_event(),
                    });
                }
            }
            Settled::Hit(hit) => self.follow_masking(session, hit),
            _ => {}
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Run,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        self.watch_masking(host);
        self.report(session, stop, host).ok()?;
        loop {
            match self.commands.recv().ok()? {
                Command::Run(order) => return Some(self.take_up(session, stop.at, order)),
                Command::Supply(supply) => self.switch(session, stop.at, supply, host),
                Command::CutAtFlashOperation(operation) => {
                    session.board_mut().part.flash.cut_at(operation);
                }
                Command::Stats => {
                    let stats = self.stats(session, stop, host);
                    self.answers.send(Answer::Stats(Box::new(stats))).ok()?;
                }
                Command::Flash => {
                    let cells = session.board().part.flash.cells().to_vec();
                    self.answers.send(Answer::Flash(cells)).ok()?;
                }
                Command::End => return None,
            }
        }
    }
}

impl Pilot {
    fn world(&self) -> MutexGuard<'_, Surroundings> {
        self.surroundings.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn complain(&mut self, what: impl FnOnce() -> String) {
        if self.complaint.is_none() {
            self.complaint = Some(what());
        }
    }

    fn watch_masking(&mut self, host: &mut dyn Host) {
        if std::mem::replace(&mut self.masking.watched, true) {
            return;
        }
        for (at, _) in self.firmware.masking() {
            host.watch(Watch::Instruction(at));
        }
    }

    /// The core has come to an instruction that masks interrupts, or to one that puts back what was
    /// before. They come in pairs, which may lie in one another. What counts is the time on the bus:
    /// before that there is nothing to be late for.
    fn follow_masking(&mut self, session: &Run, hit: Hit) {
        let masking = &mut self.masking;
        match self.firmware.masking_at(hit.address) {
            Some(MaskingInstruction::Mask) => {
                if masking.depth == 0 {
                    masking.since_ns = hit.at.0;
                }
                masking.depth += 1;
            }
            Some(MaskingInstruction::Restore) => {
                masking.depth = masking.depth.saturating_sub(1);
                if masking.depth == 0 && session.board().part.can().is_on_the_bus() {
                    masking.longest_ns = masking.longest_ns.max(hit.at.0 - masking.since_ns);
                }
            }
            None => {}
        }
    }

    /// Every access of the core.
    fn watch_access(&mut self, session: &Run, access: Access) {
        let pc = access.program_counter.unwrap_or_default();
        if session.refused().len() > self.refused {
            self.refused = session.refused().len();
            let fault = session.refused().get(&access.address);
            self.complain(|| {
                let why = fault.map_or_else(|| "refused".to_owned(), ToString::to_string);
                format!("access to {:#010x} at pc {pc:#010x}: {why}", access.address)
            });
        }
        if access.kind == AccessKind::Write {
            self.watch_dma(access, pc);
            if self.identity.mcu == Mcu::Msp {
                self.follow_motor(session, access.virtual_time.0);
            }
        }
    }

    /// A memory address of a DMA stream in the core-coupled memory: the controller does not reach
    /// it (RM0090 2.3.1), and would raise a transfer error much later, if anybody looked.
    fn watch_dma(&mut self, access: Access, pc: u64) {
        const STREAM_LEN: u64 = 0x18;
        const FIRST_STREAM: u64 = 0x10;
        const MEMORY_ADDRESSES: [u64; 2] = [0x0C, 0x10];
        let offset = access.address & 0x3FF;
        let in_stream = offset.wrapping_sub(FIRST_STREAM) % STREAM_LEN;
        if DMA.contains(&access.address)
            && offset >= FIRST_STREAM
            && MEMORY_ADDRESSES.contains(&in_stream)
            && (CCM_BASE..CCM_BASE + CCM_LEN).contains(&access.value)
        {
            self.complain(|| {
                format!(
                    "DMA memory address register {:#010x} is set to {:#010x} at pc {pc:#010x}: no \
                     DMA controller reaches the core-coupled memory",
                    access.address, access.value
                )
            });
        }
    }

    fn follow_motor(&mut self, session: &Run, at_ns: u64) {
        let part = &session.board().part;
        let [in1, in2, in3, in4] = pins::MOTOR.map(|pin| part.pin(pin) == Level::High);
        let outputs = MotorOutputs { in1, in2, in3, in4 };
        if outputs != self.motor {
            self.motor = outputs;
            self.world().drive_motor(at_ns, outputs);
        }
    }

    /// A restart puts every pin back to an input.
    fn watch_restarts(&mut self, session: &Run, at_ns: u64) {
        if session.resets().len() > self.resets {
            self.resets = session.resets().len();
            self.panel = None;
            self.log.restart();
            self.masking.depth = 0;
            if self.identity.mcu == Mcu::Msp {
                self.follow_motor(session, at_ns);
            }
        }
        match (session.unpowered(), self.powered_since_ns) {
            (true, Some(since)) => {
                self.powered_ns += at_ns - since;
                self.powered_since_ns = None;
                if self.identity.mcu == Mcu::Msp {
                    self.motor = MotorOutputs::default();
                    self.world().lose_power(at_ns);
                }
            }
            (false, None) => self.powered_since_ns = Some(at_ns),
            (true, None) | (false, Some(_)) => {}
        }
    }

    fn report(&mut self, session: &mut Run, stop: Stop, host: &mut dyn Host) -> Result<(), Gone> {
        let at_ns = stop.at.0;
        if at_ns >= self.log_due_ns {
            self.log_due_ns = at_ns + READ_EVERY_NS;
            self.read_log(at_ns, host);
            self.look_for_gaps(session);
        }
        let idle = self.sleeps(stop) || session.unpowered();
        let supply = if session.unpowered() { Supply::Off } else { Supply::On };
        let part = &mut session.board_mut().part;
        let wakes_at_ns = match (idle, part.next_event()) {
            (true, Some(event)) => event.0,
            (true, None) => u64::MAX,
            (false, _) => at_ns,
        };
        let mut sent = part.serial_line().take_sent();
        if !sent.is_empty() && !part.carries(&[pins::LINK_TX], LINK_FUNCTION) {
            sent.clear();
            self.complain(|| "USART2 sends, but PD5 does not carry it".to_owned());
        }
        let can = part.can().requests();
        if can.presence != Presence::Off && !part.carries(&pins::CAN, CAN_FUNCTION) {
            self.complain(|| "CAN1 is on the bus, but PD0 and PD1 do not carry it".to_owned());
        }
        let name = self.identity.mcu.name();
        let node = self.identity.node;
        let report = Report {
            at_ns,
            wakes_at_ns,
            supply,
            sent,
            can,
            lines: std::mem::take(&mut self.lines),
            fault: self
                .complaint
                .take()
                .map(|what| EngineError(format!("{name} of node {node}: {what}"))),
        };
        self.answers.send(Answer::Stopped(Box::new(report))).map_err(|_| Gone)
    }

    /// Whether the core sleeps until the next event. A stop is called idle before what is due at its
    /// own instant happens, and that may wake the core. So it still sleeps only if it has executed
    /// nothing since the stop before, and nothing was due since.
    fn sleeps(&self, stop: Stop) -> bool {
        stop.reason == StopReason::Idle
            && self.on_the_way.is_some_and(|before| {
                before.instructions == stop.instruction_count
                    && before.due_at.is_none_or(|due_at| due_at > stop.at)
            })
    }

    fn read_log(&mut self, at_ns: u64, host: &mut dyn Host) {
        let lines = self.log.read(&self.firmware, host);
        let mcu = self.identity.mcu;
        let at = Instant::from_micros(at_ns / 1_000);
        self.lines.extend(lines.into_iter().map(|line| LogLine {
            mcu,
            at,
            level: line.level,
            text: line.text,
        }));
    }

    /// Anything no part of the bench stood in for.
    fn look_for_gaps(&mut self, session: &Run) {
        let mut gaps = String::new();
        if let Some(gap) = session.unmapped().first() {
            let _ = write!(
                gaps,
                "access to {:#010x} at pc {:#010x}: the bench has nothing there",
                gap.address, gap.program_counter
            );
        } else if let Some((address, fault)) = session.refused().first_key_value() {
            let _ = write!(gaps, "access to {address:#010x}: {fault}");
        } else if let Some((address, gap)) = session.unimplemented().first_key_value() {
            let _ = write!(
                gaps,
                "access to {}.{} ({address:#010x}) at pc {:#010x}: the bench has no model of it",
                gap.instance, gap.register, gap.program_counter
            );
        } else if let Some(told) = session.told().next() {
            let _ = write!(gaps, "{}.{}: {}", told.instance, told.register, told.reason);
        } else if let Some((instance, line)) = session.unrouted().first() {
            let _ =
                write!(gaps, "{instance} raised interrupt {line}, which the core does not have");
        }
        if !gaps.is_empty() {
            self.complain(|| gaps);
        }
    }

    fn take_up(&mut self, session: &mut Run, at: VirtualNanos, order: Order) -> VirtualNanos {
        let listening =
            session.board().part.carries(&[pins::LINK_RX], LINK_FUNCTION) && !session.unpowered();
        let part = &mut session.board_mut().part;
        if let Some(delivery) = &order.can {
            part.deliver(at, delivery);
        }
        if listening {
            for byte in &order.bytes {
                part.look_at_serial_line(at, VirtualNanos(byte.at_ns));
            }
            part.serial_line().bring(order.bytes);
        } else {
            part.serial_line().clear();
        }
        if self.identity.mcu == Mcu::Msp {
            self.look_at_panel(session, at);
        }
        // A stop in the last nanosecond, for what the one at the end does not say.
        self.on_the_way = None;
        session.pause_at(Some(VirtualNanos(order.until_ns.saturating_sub(1))));
        VirtualNanos(order.until_ns.max(at.0))
    }

    /// Keys close to ground, inputs are driven high, the motor's fault output too.
    fn look_at_panel(&mut self, session: &mut Run, at: VirtualNanos) {
        let seen = {
            let world = self.world();
            (world.panel, world.spindle.model().fault)
        };
        if self.panel == Some(seen) {
            return;
        }
        let first = self.panel.is_none();
        self.panel = Some(seen);
        let (panel, fault) = seen;
        let part = &mut session.board_mut().part;
        let closed = |pressed| if pressed { Some(Level::Low) } else { None };
        let driven = |high| if high { Some(Level::High) } else { None };
        part.drive_pin(at, pins::LEFT_KEY, closed(panel.left_key));
        part.drive_pin(at, pins::RIGHT_KEY, closed(panel.right_key));
        part.drive_pin(at, pins::INPUT_F, driven(panel.input_f));
        part.drive_pin(at, pins::INPUT_G, driven(panel.input_g));
        part.drive_pin(at, pins::MOTOR_FAULT, driven(fault));
        if first {
            for pin in pins::MOTOR {
                part.drive_pin(at, pin, Some(Level::Low));
            }
        }
    }

    fn switch(&mut self, session: &mut Run, at: VirtualNanos, supply: Supply, host: &mut dyn Host) {
        let part = &mut session.board_mut().part;
        part.switch_supply(at, supply == Supply::On);
        part.serial_line().clear();
        if supply == Supply::On && self.powered_since_ns.is_none() {
            self.forget_memory(host);
        }
    }

    /// Memory after a power-on: random, but for the stack's, which starts out 0 so that its depth
    /// can be told.
    fn forget_memory(&mut self, host: &mut dyn Host) {
        for at in (SRAM_BASE..SRAM_BASE + SRAM_LEN).step_by(8) {
            let _ = host.write(at, Width::W64, self.noise.draw());
        }
        for at in (CCM_BASE..CCM_BASE + CCM_LEN).step_by(8) {
            let _ = host.write(at, Width::W64, 0);
        }
    }

    fn stats(&self, session: &Run, stop: Stop, host: &mut dyn Host) -> McuStats {
        let powered_ns =
            self.powered_ns + self.powered_since_ns.map_or(0, |since| stop.at.0 - since);
        let awake_ns = stop.instruction_count * self.clock.nanos_per_instruction();
        let unused = (CCM_BASE..CCM_BASE + CCM_LEN)
            .step_by(4)
            .take_while(|&at| host.read(at, Width::W32).is_ok_and(|word| word == 0))
            .count();
        let counts = session.board().part.flash.counts();
        let power_on = Reset { at: Instant::ZERO, cause: "power-on".to_owned() };
        let restarts = session.resets().iter().map(|reset| Reset {
            at: Instant::from_micros(reset.at.0 / 1_000),
            cause: cause(reset.cause).to_owned(),
        });
        McuStats {
            instructions: stop.instruction_count,
            awake_fraction: fraction(awake_ns, powered_ns),
            stack_used: u32::try_from(CCM_LEN).expect("64 KB")
                - 4 * u32::try_from(unused).expect("at most 16 Ki words"),
            resets: std::iter::once(power_on).chain(restarts).collect(),
            flash_ops: counts.programs,
            sector_erases: counts.erases,
            can_interrupts: session.board().part.can().interrupts().total(),
            can_reaction_ns: session.board().part.can().reaction().0,
            can_wait_ns: session.board().part.can().longest_wait().0,
            masked_ns: self.masking.longest_ns,
        }
    }
}

/// The fleet has gone.
struct Gone;

fn cause(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Core => "software",
        ResetCause::Model("IWDG") => "watchdog",
        ResetCause::Model(instance) => instance,
        ResetCause::Pin => "pin",
        ResetCause::PowerOn => "power-on",
        _ => "unknown",
    }
}

/// `part` of `whole`, 0 to 1.
fn fraction(part: u64, whole: u64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a figure for people: 53 bits are plenty")]
    let fraction = part as f64 / whole.max(1) as f64;
    fraction.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is due at the end of an order has happened then, and the core that waited for it is
    /// awake: it does not wait for the event after it.
    #[test]
    fn an_event_at_the_end_of_an_order_wakes_the_core() {
        let firmware = crate::build("firmware-probe", "probe-time").unwrap();
        let (mut controller, mut report) = Controller::start(Setup {
            identity: Identity { node: 0, mcu: Mcu::Msp },
            firmware: Arc::new(firmware),
            clock: CoreClock::Mhz160,
            kept: None,
            seed: 1,
            surroundings: Arc::default(),
        })
        .unwrap();
        let mut run_until = |until_ns| {
            controller.tell(Command::Run(Order { until_ns, bytes: Vec::new(), can: None }));
            controller.stopped().unwrap()
        };
        for _ in 0..10 {
            while report.wakes_at_ns <= report.at_ns {
                report = run_until(report.at_ns + 10_000);
            }
            let event_ns = report.wakes_at_ns;
            report = run_until(event_ns);
            assert_eq!((report.at_ns, report.wakes_at_ns), (event_ns, event_ns));
        }
    }
}
