use core::num::NonZeroU32;

use lcd::View;
use object_dictionary::{Number, ObjectId};
use positioning::chain::{self, Correction, CountingDirection, Setpoint};
use positioning::encoder::TurnOffset;
use positioning::filter;
use profiles::nm17x::between_controllers::{MESSAGE_END, MESSAGE_PARTS, OFFER};
use profiles::{Equipment, Product, nm17x};
use shared_proto::limits::CYCLE_MS;
use shared_proto::{Encoded, Hello, ToInterface, encode};
use units::{Duration, Instant, Position, Scaling, Steps};

use crate::display::{
    Identity, LastDigit, LengthUnit, Mounting, Notice, Operation, Rest, Rounding, Settings,
};
use crate::errors::Errors;
use crate::guidance::{self, ArrowMode, Guidance, HideSetpoint};
use crate::link::{Link, Order, Report};
use crate::message::Message;
use crate::offer::{Key, Offer};
use crate::panel::Contact;
use crate::parameters::Parameters;
use crate::record::{Record, RecordKey};
use crate::sensor::{SSI_READ_LEN, Sensor};
use crate::status::Status;

/// Period of [`Application::step`].
pub const STEP: Duration = Duration::from_millis(2);
/// Steps in a cycle of the link.
const CYCLE_STEPS: u64 = Duration::from_millis(CYCLE_MS).as_micros() / STEP.as_micros();
/// The step of a cycle that may send values: apart from the process data, so that those are never
/// noticed late because the line goes on talking.
const VALUES_STEP: u64 = CYCLE_STEPS / 2;
/// A restart that was ordered waits for this long, so that the order is acknowledged first and not
/// repeated to the restarted controller. Room for three cycles.
const RESTART_AFTER: Duration = Duration::from_millis(3 * CYCLE_MS);

const _: () =
    assert!(CYCLE_STEPS * STEP.as_micros() == Duration::from_millis(CYCLE_MS).as_micros());

/// Objects that put a setpoint into force.
const SETPOINTS: [ObjectId; 7] = [
    nm17x::STANDARD_SETPOINT.id(),
    nm17x::START_STANDARD_SETPOINT.id(),
    nm17x::DIMENSION_SETPOINT.id(),
    nm17x::START_DIMENSION_SETPOINT.id(),
    nm17x::START_DIRECT_SETPOINT.id(),
    nm17x::SAW_IN_SETPOINT.id(),
    nm17x::START_SAW_IN_SETPOINT.id(),
];

/// What the application core is told when it starts.
#[derive(Clone, Copy, Debug)]
pub struct Boot {
    /// Differs from one start to the next.
    pub nonce: NonZeroU32,
}

/// Everything that is read in a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs {
    /// The bytes clocked out of the sensor.
    pub ssi: [u8; SSI_READ_LEN],
    /// The left key is pressed.
    pub left_key: bool,
    /// The right key is pressed.
    pub right_key: bool,
    /// External input F is active.
    pub input_f: bool,
    /// External input G is active.
    pub input_g: bool,
    /// The motor reports a fault.
    pub motor_fault: bool,
}

/// Levels of the motor lines; `true` is high, the active level (NM17x MOTOR-01, A-112).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MotorOutputs {
    /// IN1, left.
    pub in1: bool,
    /// IN2, right.
    pub in2: bool,
    /// IN3, speed bit 1.
    pub in3: bool,
    /// IN4, speed bit 2.
    pub in4: bool,
}

impl MotorOutputs {
    /// Nothing is driven, the clamp is closed.
    pub const OFF: Self = Self { in1: false, in2: false, in3: false, in4: false };
}

/// The application controller without its pins.
///
/// Contract: call [`Self::step`] every [`STEP`], [`Self::handle_link`] with whatever came over the
/// line, and after either drain [`Self::poll_link`] and [`Self::poll_store`] to `None`. What is to
/// be driven and shown can be asked at any time.
#[derive(Debug)]
pub struct Application {
    product: &'static Product,
    now: Instant,
    steps: u64,
    parameters: Parameters,
    preset_offset: Record,
    turn_offset: Record,
    setpoint: Setpoint,
    sensor: Sensor,
    left_key: Contact,
    right_key: Contact,
    rest: Rest,
    message: Message,
    offer: Option<Offer>,
    link: Link,
    restart_at: Option<Instant>,
}

impl Application {
    /// The core at the start of the clock. `stored` are keys and values that earlier
    /// [`Self::poll_store`]s gave, in any order. Nothing is ever driven because of what was stored
    /// (NM17x BOOT-06).
    pub fn new(
        product: &'static Product,
        boot: Boot,
        stored: impl IntoIterator<Item = (u32, u32)>,
    ) -> Self {
        let mut parameters = Parameters::new(product.dictionary);
        let mut preset_offset = Record::new(RecordKey::PresetOffset);
        let mut turn_offset = Record::new(RecordKey::TurnOffset);
        for (key, value) in stored {
            parameters.restore(key, value);
            preset_offset.restore(key, value);
            turn_offset.restore(key, value);
        }
        let own = Hello {
            protocol: shared_proto::PROTOCOL,
            product: product.code,
            firmware: product.firmware,
            dictionary: product.fingerprint,
            nonce: boot.nonce.get(),
            heard: 0,
            in_service: false,
        };
        let mut application = Self {
            product,
            now: Instant::ZERO,
            steps: 0,
            parameters,
            preset_offset,
            turn_offset,
            setpoint: Setpoint::new(Position::ZERO, Correction::Off),
            sensor: Sensor::default(),
            left_key: Contact::default(),
            right_key: Contact::default(),
            rest: Rest::default(),
            message: Message::default(),
            offer: None,
            link: Link::new(own),
            restart_at: None,
        };
        application.start_from_standard_setpoint();
        application.follow_clamping();
        application
    }

    /// Takes in what the sensor and the keys say now.
    pub fn step(&mut self, now: Instant, inputs: &Inputs) {
        self.now = now;
        let filter = filter::Params {
            width_steps: self.parameters.get(&nm17x::FILTER_WIDTH),
            jumps_max: u8::try_from(self.parameters.get(&nm17x::FILTER_COUNT)).unwrap_or(u8::MAX),
        };
        self.sensor = self.sensor.step(&inputs.ssi, self.turns(), &filter);
        let (left, right) = match self.product.equipment {
            Equipment::Nothing => (false, false),
            Equipment::KeysAndMotor => (inputs.left_key, inputs.right_key),
        };
        let before = (self.left_key, self.right_key);
        self.left_key = self.left_key.step(left);
        self.right_key = self.right_key.step(right);
        let any_active = self.left_key.active() || self.right_key.active();
        let pressed =
            self.left_key.is_pressed_since(before.0) || self.right_key.is_pressed_since(before.1);
        let key = if pressed { Key::Pressed } else { Key::Untouched };
        self.rest = self.rest.step(now, self.displayed(), any_active);
        self.offer = self.offer.map(|offer| offer.step(self.sensor.valid_steps(), key));
        self.link.handle_time(now);
        match self.steps % CYCLE_STEPS {
            0 => self.link.start_cycle(),
            VALUES_STEP => self.link.offer_values(),
            _ => {}
        }
        self.steps = self.steps.wrapping_add(1);
    }

    /// Takes in bytes from the line, in any portions.
    pub fn handle_link(&mut self, now: Instant, bytes: &[u8]) {
        for byte in bytes {
            match self.link.handle_byte(now, *byte) {
                Some(Order::Write(id, raw)) => self.write(now, id, raw),
                Some(Order::StartAnew) => {
                    self.message.end();
                    self.offer = None;
                }
                // Nothing moves on its own yet; the acknowledgement says so.
                Some(Order::Stop(_)) | None => {}
            }
        }
    }

    /// The next frame for the line.
    pub fn poll_link(&mut self) -> Option<Encoded> {
        let message = match self.link.poll_greeting() {
            Some(hello) => ToInterface::Hello(hello),
            None if self.link.take_process_due() => self.link.process(self.report()),
            None => {
                let touched = self.offer.and_then(|offer| offer.touched());
                self.link.poll_values(touched, &mut self.parameters)?
            }
        };
        Some(encode(&message))
    }

    /// The next value to store, with its key: at once, and only when it changed (NM17x STORE-02,
    ///
    pub fn poll_store(&mut self) -> Option<(u32, u32)> {
        self.preset_offset
            .poll_store()
            .or_else(|| self.turn_offset.poll_store())
            .or_else(|| self.parameters.poll_store())
    }

    /// What to drive.
    #[must_use]
    pub fn motor(&self) -> MotorOutputs {
        MotorOutputs::OFF
    }

    /// The picture in the memory of the display driver.
    #[must_use]
    pub fn picture(&self) -> [u8; lcd::pcf8576::RAM_LEN] {
        self.view().ram()
    }

    /// What the display shows.
    #[must_use]
    pub fn view(&self) -> View {
        let settings = self.display_settings();
        if self.link.mismatched() {
            return settings.mismatch();
        }
        let identity = Identity {
            designation: self.product.designation,
            firmware: self.link.partner_firmware(),
            node_id: self.link.node_id(),
        };
        let operation = Operation {
            setpoint: self.setpoint.displayed(self.correction()),
            actual: self.displayed(),
            guidance: self.guidance(),
            error: self.errors().text(),
            rest: self.rest,
            notice: self.notice(),
        };
        settings.view(self.now, &identity, &operation)
    }

    /// Whether the two controllers work together.
    #[must_use]
    pub fn in_service(&self) -> bool {
        self.link.in_service()
    }

    /// Whether the controller has been told to restart (NM17x OD-2015-5). Store first what
    /// [`Self::poll_store`] gives.
    #[must_use]
    pub fn restart_due(&self) -> bool {
        self.restart_at.is_some_and(|at| self.now >= at)
    }

    fn write(&mut self, now: Instant, id: ObjectId, raw: u32) {
        if let Some(part) = MESSAGE_PARTS.iter().position(|part| *part == id) {
            return self.message.take_part(part, raw);
        }
        if id == OFFER {
            self.offer = Offer::from_raw(raw);
            return;
        }
        self.message.end();
        if id == MESSAGE_END {
            return;
        }
        if self.parameters.check(id, raw).is_err() || self.act(now, id, raw).is_err() {
            self.parameters.tell(id);
        } else if !nm17x::COMMANDS.contains(&id) {
            self.parameters.write(id, raw);
            self.follow(id, raw);
        }
    }

    /// What follows from a value that has been taken over.
    fn follow(&mut self, id: ObjectId, raw: u32) {
        if id == nm17x::START_STANDARD_SETPOINT.id() {
            self.parameters.change(&nm17x::STANDARD_SETPOINT, raw.cast_signed());
        }
        if SETPOINTS.contains(&id) {
            self.latch_setpoint(raw.cast_signed());
        }
        self.follow_clamping();
    }

    /// Object 0x2048: with a clamp it is closed, because nothing is driven (NM17x OD-2048-1).
    fn follow_clamping(&mut self) {
        const NO_CLAMP: u8 = 0;
        const CLOSED: u8 = 2;
        let clamp = match self.parameters.get(&nm17x::CLAMPING) {
            1..=799 => CLOSED,
            _ => NO_CLAMP,
        };
        self.parameters.change(&nm17x::CLAMP, clamp);
    }

    /// What a write does besides changing the value. An error leaves everything as it was. Commands
    /// to the motor do nothing: there is no drive that could follow them yet.
    fn act(&mut self, now: Instant, id: ObjectId, raw: u32) -> Result<(), NotPossible> {
        if id == nm17x::PRESET.id() {
            let preset = Number::from_raw(raw);
            self.preset(Position::from_hundredths_mm(preset))
        } else if id == nm17x::RESET_FUNCTION.id() {
            self.reset(now, ResetFunction::from_raw(raw).ok_or(NotPossible)?)
        } else {
            Ok(())
        }
    }

    /// The actual value becomes `preset` (NM17x POS-08).
    fn preset(&mut self, preset: Position) -> Result<(), NotPossible> {
        let steps = self.sensor.valid_steps().ok_or(NotPossible)?;
        let offset = self.chain().preset(steps, preset).map_err(|_| NotPossible)?;
        let offset = i32::try_from(offset.count()).map_err(|_| NotPossible)?;
        self.preset_offset.set(offset.cast_unsigned());
        Ok(())
    }

    /// NM17x OD-2015-1 to OD-2015-6, A-52.
    fn reset(&mut self, now: Instant, function: ResetFunction) -> Result<(), NotPossible> {
        match function {
            ResetFunction::Parameters => self.parameters.restore_defaults(&[
                nm17x::CORRECTION.id(),
                nm17x::STANDARD_SETPOINT.id(),
                nm17x::START_STANDARD_SETPOINT.id(),
                nm17x::PRESET.id(),
            ]),
            ResetFunction::TurnCounter => {
                let (offset, sensor) = self.sensor.centred().ok_or(NotPossible)?;
                self.turn_offset.set(offset.turns());
                self.sensor = sensor;
            }
            ResetFunction::ParametersAndOffsets => {
                self.parameters.restore_defaults(&[]);
                self.preset_offset.set(0);
                self.latch_setpoint(self.parameters.get(&nm17x::STANDARD_SETPOINT));
            }
            ResetFunction::Correction => self.parameters.change(&nm17x::CORRECTION, 0),
            ResetFunction::Restart => self.restart_at = Some(now + RESTART_AFTER),
            ResetFunction::PresetOffset => self.preset_offset.set(0),
        }
        Ok(())
    }

    /// The stored setpoint is in force, and all others are the same (NM17x BOOT-05, A-71).
    fn start_from_standard_setpoint(&mut self) {
        let standard = self.parameters.get(&nm17x::STANDARD_SETPOINT);
        for object in [
            nm17x::DIMENSION_SETPOINT,
            nm17x::START_DIMENSION_SETPOINT,
            nm17x::START_DIRECT_SETPOINT,
            nm17x::SAW_IN_SETPOINT,
            nm17x::START_SAW_IN_SETPOINT,
        ] {
            self.parameters.write(object.id(), standard.cast_unsigned());
        }
        self.latch_setpoint(standard);
    }

    /// A setpoint comes into force with the correction of this moment (NM17x POS-11).
    fn latch_setpoint(&mut self, hundredths_mm: i32) {
        let sent = Position::from_hundredths_mm(hundredths_mm);
        self.setpoint = Setpoint::new(sent, self.correction());
    }

    fn notice(&self) -> Notice {
        if let Some(offer) = self.offer {
            Notice::Offer(offer.node_id())
        } else if let Some((upper, lower)) = self.message.lines() {
            Notice::Message(upper, lower)
        } else if self.parameters.get(&nm17x::SHOW_NODE_ID) == 1 {
            Notice::NodeId
        } else {
            Notice::None
        }
    }

    fn report(&self) -> Report {
        Report {
            position_hundredths_mm: self.position().hundredths_mm(),
            status: self.status().bits(),
            errors: self.errors().bits(),
        }
    }

    fn status(&self) -> Status {
        Status {
            left_key: self.left_key.active(),
            right_key: self.right_key.active(),
            arrows: self.guidance().arrows.any(),
            error: self.errors().any(),
        }
    }

    fn errors(&self) -> Errors {
        match self.product.equipment {
            Equipment::Nothing => Errors::default(),
            Equipment::KeysAndMotor => Errors::at(self.position()),
        }
    }

    /// Object 0x6004: the last one known. Zero before the first read of the sensor.
    fn position(&self) -> Position {
        self.sensor.steps().map_or(Position::ZERO, |steps| self.chain().position(steps))
    }

    /// The actual value of the display.
    fn displayed(&self) -> Option<Position> {
        self.sensor.valid_steps().map(|steps| self.chain().displayed(steps))
    }

    /// Nothing leads to the setpoint while the position is not known.
    fn guidance(&self) -> Guidance {
        let params = guidance::Params {
            arrow_mode: ArrowMode::from_raw(self.parameters.get(&nm17x::ARROWS)),
            hide_setpoint: HideSetpoint::from_raw(self.parameters.get(&nm17x::HIDE_SETPOINT)),
            tolerance: Position::from_hundredths_mm(
                i32::try_from(self.parameters.get(&nm17x::TOLERANCE_WINDOW)).unwrap_or(i32::MAX),
            ),
        };
        let setpoint = self.setpoint.displayed(self.correction());
        match self.displayed() {
            Some(actual) => guidance::guidance(setpoint, actual, &params),
            None => guidance::astray(&params),
        }
    }

    fn chain(&self) -> chain::Params {
        chain::Params {
            direction: match self.parameters.get(&nm17x::COUNTING_DIRECTION) {
                1 => CountingDirection::ClockwiseDown,
                _ => CountingDirection::ClockwiseUp,
            },
            scaling: Scaling::from_ten_millionths(self.parameters.get(&nm17x::SCALING)),
            preset_offset: Steps::new(self.preset_offset.value().cast_signed().into()),
            correction: self.correction(),
        }
    }

    fn correction(&self) -> Correction {
        match self.parameters.get(&nm17x::CORRECTION_ENABLED) {
            0 => Correction::Off,
            _ => Correction::On(Position::from_hundredths_mm(
                self.parameters.get(&nm17x::CORRECTION),
            )),
        }
    }

    fn turns(&self) -> TurnOffset {
        TurnOffset::from_turns(self.turn_offset.value())
    }

    fn display_settings(&self) -> Settings {
        let hidden = HideSetpoint::from_raw(self.parameters.get(&nm17x::HIDE_SETPOINT));
        Settings {
            unit: match self.parameters.get(&nm17x::LENGTH_UNIT) {
                1 => LengthUnit::Inch,
                _ => LengthUnit::Millimetre,
            },
            mounting: match self.parameters.get(&nm17x::ROTATE_DISPLAY) {
                1 => Mounting::Inverted,
                _ => Mounting::Normal,
            },
            last_digit: match self.parameters.get(&nm17x::HIDE_LAST_DIGIT) {
                1 => LastDigit::Hidden,
                _ => LastDigit::Shown,
            },
            rounding: match self.parameters.get(&nm17x::ROUND_ACTUAL_VALUE) {
                1 if hidden != HideSetpoint::Always => Rounding::On,
                _ => Rounding::Off,
            },
        }
    }
}

/// A write that the state of the device does not allow: a preset without a position, or without a
/// scaling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct NotPossible;

/// Object 0x2015.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ResetFunction {
    /// Stored parameters, but no offset and no setpoint.
    Parameters,
    /// The turn counter reads its middle.
    TurnCounter,
    /// Everything that is stored.
    ParametersAndOffsets,
    /// The actual value correction.
    Correction,
    /// This controller.
    Restart,
    /// The preset offset.
    PresetOffset,
}

impl ResetFunction {
    fn from_raw(raw: u32) -> Option<Self> {
        match raw {
            1 => Some(Self::Parameters),
            2 => Some(Self::TurnCounter),
            3 => Some(Self::ParametersAndOffsets),
            4 => Some(Self::Correction),
            5 => Some(Self::Restart),
            6 => Some(Self::PresetOffset),
            _ => None,
        }
    }
}
