//! The control port: one JSON object per line, answered in order.
//!
//! A client turns the shaft, presses keys, reads the glass, breaks wires and, with the clock
//! standing, lets virtual time pass. Each client is a node of the CAN bus as well, at whatever bit
//! rate the devices use: it acknowledges, and `can_send` sends through it.

mod request;

pub use request::{
    Asked, CanChange, Elsewhere, Input, Key, LinkChange, MotorChange, Request, SensorChange, Turn,
    parse, unreadable,
};

use serde_json::{Value, json};
use world::can::{Bus, LogCursor, Logged, Rate, Role, Source};
use world::ssi_encoder::Line as SensorLine;
use world::{LogLine, Mcu, McuStats};

use crate::hex;
use crate::lines::Lines;
use crate::node::Attachment;
use crate::stage::{LogPlace, Stage};

/// Longest request of a client, in bytes.
pub const LINE_MAX: usize = 4096;

/// One client.
#[derive(Debug)]
pub struct Desk {
    /// What of its requests has come.
    pub lines: Lines,
    node: Attachment,
    can_log: LogCursor,
    logs: Vec<LogPlace>,
}

/// The fields of an answer, or a sentence why there is none.
pub type Answer = Result<Vec<(&'static str, Value)>, String>;

/// An answer as it goes over the wire, newline included.
#[must_use]
pub fn write(id: &Value, answer: &Answer) -> String {
    match answer {
        Ok(fields) => {
            let fields: String =
                fields.iter().map(|(name, value)| format!(",\"{name}\":{value}")).collect();
            format!("{{\"id\":{id},\"ok\":true{fields}}}\n")
        }
        Err(sentence) => {
            format!("{{\"id\":{id},\"ok\":false,\"error\":{}}}\n", json!(sentence))
        }
    }
}

impl Desk {
    /// A client that has just come.
    #[must_use]
    pub fn new(stage: &Stage) -> Self {
        Self {
            lines: Lines::new(b'\n', LINE_MAX),
            node: Attachment::attach(&mut stage.engine.bus(), Rate::Automatic, Role::Normal),
            can_log: LogCursor::default(),
            logs: vec![LogPlace::default(); stage.engine.node_count()],
        }
    }

    /// Drops what the bus has for its node: the log tells all of it.
    pub fn poll(&mut self, bus: &mut Bus) {
        while self.node.receive(bus).is_some() {}
    }

    /// Takes its node off the bus.
    pub fn leave(self, bus: &mut Bus) {
        self.node.detach(bus);
    }

    /// Does what is asked, except letting time pass.
    ///
    /// # Errors
    /// A sentence; nothing has changed then.
    pub fn perform(&mut self, stage: &mut Stage, node: usize, request: &Request) -> Answer {
        match request {
            Request::CanSend(frame) => {
                let sent = self.node.send(&mut stage.engine.bus(), *frame);
                sent.map(|()| Vec::new()).map_err(|error| error.to_string())
            }
            Request::CanLog => {
                let (frames, next) = stage.engine.bus().log_since(self.can_log);
                self.can_log = next;
                Ok(vec![("frames", frames.iter().map(frame).collect())])
            }
            Request::Log => {
                let places = self.logs.get_mut(node).zip(stage.logs.get(node));
                let lines = places.map(|(place, book)| book.since(place)).unwrap_or_default();
                Ok(vec![("lines", lines.iter().map(log_line).collect())])
            }
            Request::Now
            | Request::Advance(_)
            | Request::Shaft(_)
            | Request::Key(..)
            | Request::Input(..)
            | Request::Motor
            | Request::MotorModel(_)
            | Request::Sensor(_)
            | Request::Display
            | Request::Power(_)
            | Request::PowerCut(..)
            | Request::Link(_)
            | Request::CanFault(_)
            | Request::Stats
            | Request::Elsewhere(_) => perform(stage, node, request),
        }
    }
}

/// Does what is asked, as far as it does not depend on who asks.
///
/// # Errors
/// A sentence; nothing has changed then.
pub fn perform(stage: &mut Stage, node: usize, request: &Request) -> Answer {
    let now_ns = stage.now_ns();
    match *request {
        Request::Now => Ok(vec![("us", json!(stage.engine.now().as_micros()))]),
        Request::Shaft(turn) => {
            let mut around = stage.engine.surroundings(node);
            match turn {
                Turn::By(steps) => around.spindle.turn(i64::from(steps)),
                Turn::Steadily(speed) => around.spindle.turn_steadily(now_ns, i64::from(speed)),
            }
            Ok(vec![("raw", json!(around.spindle.raw(now_ns)))])
        }
        Request::Key(key, down) => {
            let panel = &mut stage.engine.surroundings(node).panel;
            match key {
                Key::Left => panel.left_key = down,
                Key::Right => panel.right_key = down,
            }
            Ok(Vec::new())
        }
        Request::Input(input, high) => {
            let panel = &mut stage.engine.surroundings(node).panel;
            match input {
                Input::F => panel.input_f = high,
                Input::G => panel.input_g = high,
            }
            Ok(Vec::new())
        }
        Request::Motor => Ok(motor(stage, node)),
        Request::MotorModel(change) => {
            let spindle = &mut stage.engine.surroundings(node).spindle;
            spindle.set_model(now_ns, change.applied(spindle.model()));
            Ok(Vec::new())
        }
        Request::Sensor(change) => {
            let encoder = &mut stage.engine.surroundings(node).encoder;
            encoder.line = change.applied(encoder.line);
            Ok(Vec::new())
        }
        Request::Display => Ok(display(stage, node)),
        Request::Power(on) => {
            stage.set_power(node, on);
            Ok(Vec::new())
        }
        Request::PowerCut(mcu, operation) => {
            stage.engine.cut_power_at_flash_operation(node, mcu, operation);
            Ok(Vec::new())
        }
        Request::Link(change) => {
            let link = &mut stage.engine.surroundings(node).link;
            *link = change.applied(*link);
            Ok(Vec::new())
        }
        Request::CanFault(change) => {
            let mut bus = stage.engine.bus();
            let faults = change.applied(bus.faults());
            bus.set_faults(faults);
            Ok(Vec::new())
        }
        Request::Stats => Ok(stats(stage, node)),
        Request::Elsewhere(hardware) => Err(format!("{} has {}", stage.product, hardware.lack())),
        Request::Advance(_) | Request::CanSend(_) | Request::CanLog | Request::Log => {
            Err("only a client of the control port can ask for that".to_owned())
        }
    }
}

impl MotorChange {
    fn applied(self, mut model: world::spindle::MotorModel) -> world::spindle::MotorModel {
        model.slow = self.slow.unwrap_or(model.slow);
        model.middle = self.middle.unwrap_or(model.middle);
        model.fast = self.fast.unwrap_or(model.fast);
        model.run_out = self.run_out.unwrap_or(model.run_out);
        model.stuck = self.stuck.unwrap_or(model.stuck);
        model.reversed = self.reversed.unwrap_or(model.reversed);
        model.fault = self.fault.unwrap_or(model.fault);
        model
    }
}

impl SensorChange {
    /// A dead output shows only while the wires are connected; connecting them again heals it.
    fn applied(self, line: SensorLine) -> SensorLine {
        let connected = self.connected.unwrap_or(line != SensorLine::Open);
        let error = self.error.unwrap_or(line == SensorLine::StuckLow);
        match (connected, error) {
            (false, _) => SensorLine::Open,
            (true, true) => SensorLine::StuckLow,
            (true, false) => SensorLine::Connected,
        }
    }
}

impl LinkChange {
    fn applied(self, link: world::Link) -> world::Link {
        world::Link {
            cut: self.cut.unwrap_or(link.cut),
            bit_error_rate: self.bit_error_rate.unwrap_or(link.bit_error_rate),
            drop_rate: self.drop_rate.unwrap_or(link.drop_rate),
        }
    }
}

impl CanChange {
    fn applied(self, faults: world::can::Faults) -> world::can::Faults {
        world::can::Faults {
            error_rate: self.error_rate.unwrap_or(faults.error_rate),
            no_ack: self.no_ack.unwrap_or(faults.no_ack),
            stuck_dominant: self.stuck_dominant.unwrap_or(faults.stuck_dominant),
        }
    }
}

impl Elsewhere {
    fn lack(self) -> String {
        match self {
            Self::Leds => "no LEDs".to_owned(),
            Self::Switches => "no switches for node-ID and bit rate".to_owned(),
            Self::Battery => "no battery".to_owned(),
            Self::Key(name) => format!("no key {name:?}: its keys are \"left\" and \"right\""),
            Self::SensorValue => "no sensor whose word can be set: turn its shaft".to_owned(),
        }
    }
}

fn motor(stage: &Stage, node: usize) -> Vec<(&'static str, Value)> {
    let now_ns = stage.now_ns();
    let around = stage.engine.surroundings(node);
    vec![
        ("in1", json!(around.motor.in1)),
        ("in2", json!(around.motor.in2)),
        ("in3", json!(around.motor.in3)),
        ("in4", json!(around.motor.in4)),
        ("steps_per_s", json!(around.spindle.steps_per_s(now_ns))),
    ]
}

/// The display memory goes out as the chip gets it, two columns to the byte.
fn display(stage: &Stage, node: usize) -> Vec<(&'static str, Value)> {
    let around = stage.engine.surroundings(node);
    let lcd = &around.lcd;
    let columns = lcd.segments();
    let pairs: Vec<u8> =
        columns.as_chunks::<2>().0.iter().map(|&[even, odd]| even << 4 | odd).collect();
    vec![
        ("upper", json!(lcd.upper())),
        ("lower", json!(lcd.lower())),
        ("left_arrow", json!(lcd.left_arrow())),
        ("right_arrow", json!(lcd.right_arrow())),
        ("segments", json!(hex::lower(&pairs))),
        ("ascii", json!(lcd.ascii())),
    ]
}

fn stats(stage: &Stage, node: usize) -> Vec<(&'static str, Value)> {
    let [stm, msp] = stage.engine.stats(node);
    vec![(Mcu::Stm.name(), figures(&stm)), (Mcu::Msp.name(), figures(&msp))]
}

fn figures(stats: &McuStats) -> Value {
    let resets: Vec<Value> = stats
        .resets
        .iter()
        .map(|reset| json!({"us": reset.at.as_micros(), "cause": reset.cause}))
        .collect();
    json!({
        "instructions": stats.instructions,
        "awake_fraction": stats.awake_fraction,
        "stack_used": stats.stack_used,
        "resets": resets,
        "flash_ops": stats.flash_ops,
        "sector_erases": stats.sector_erases,
        "can_interrupts": stats.can_interrupts,
        "can_reaction_ns": stats.can_reaction_ns,
        "can_wait_ns": stats.can_wait_ns,
        "masked_ns": stats.masked_ns,
    })
}

fn frame(logged: &Logged) -> Value {
    let mut entry = json!({
        "us": logged.end.instant().as_micros(),
        "id": logged.frame.id().value(),
        "data": hex::lower(logged.frame.data()),
        "rtr": logged.frame.is_remote(),
        "extended": logged.frame.id().is_extended(),
        "dir": match logged.source {
            Source::Device(_) => "out",
            Source::Outside(_) => "in",
        },
    });
    if let (Source::Device(node), Value::Object(fields)) = (logged.source, &mut entry) {
        fields.insert("node".to_owned(), json!(node));
    }
    entry
}

fn log_line(line: &LogLine) -> Value {
    json!({
        "mcu": line.mcu.name(),
        "us": line.at.as_micros(),
        "level": line.level,
        "text": line.text,
    })
}
