//! One line of a client: a JSON object that asks for one thing.

use serde_json::{Map, Value};
use units::Duration;
use world::Mcu;
use world::can::{Frame, Id};

use crate::hex;

/// A line, read.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// What the client calls this request; null when it gave no name, or none could be read.
    pub id: Value,
    /// The device meant.
    pub node: usize,
    /// What is asked for, or a sentence why nothing is.
    pub request: Result<Request, String>,
}

/// What can be asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// Virtual time.
    Now,
    /// Let virtual time pass.
    Advance(Duration),
    /// Turn the shaft.
    Shaft(Turn),
    /// Press or let go a front key.
    Key(Key, bool),
    /// Set an external input.
    Input(Input, bool),
    /// The motor lines.
    Motor,
    /// Change how the motor behaves.
    MotorModel(MotorChange),
    /// Change the condition of the sensor.
    Sensor(SensorChange),
    /// What the glass shows.
    Display,
    /// Switch the supply.
    Power(bool),
    /// Cut the supply of one controller in the middle of this flash operation, 1 being the next.
    PowerCut(Mcu, u32),
    /// Change the faults of the line between the controllers.
    Link(LinkChange),
    /// Send a frame.
    CanSend(Frame),
    /// Frames since the last call.
    CanLog,
    /// Change the faults of the bus.
    CanFault(CanChange),
    /// Log lines since the last call.
    Log,
    /// Figures of both controllers.
    Stats,
    /// A verb for hardware other products have.
    Elsewhere(Elsewhere),
}

/// How the shaft turns. Sensor steps: 4096 to the turn, right positive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// So many steps at once.
    By(i32),
    /// So many steps per second until told otherwise.
    Steadily(i32),
}

/// A front key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// Left.
    Left,
    /// Right.
    Right,
}

/// An external input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Pin F.
    F,
    /// Pin G.
    G,
}

/// Fields of `motor_model` that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(missing_docs, reason = "the fields of world::spindle::MotorModel")]
pub struct MotorChange {
    pub slow: Option<u32>,
    pub middle: Option<u32>,
    pub fast: Option<u32>,
    pub run_out: Option<u32>,
    pub stuck: Option<bool>,
    pub reversed: Option<bool>,
    pub fault: Option<bool>,
}

/// Fields of `sensor` that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorChange {
    /// Whether its wires are.
    pub connected: Option<bool>,
    /// Whether its output is dead.
    pub error: Option<bool>,
}

/// Fields of `link` that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the fields of world::Link")]
pub struct LinkChange {
    pub cut: Option<bool>,
    pub bit_error_rate: Option<f64>,
    pub drop_rate: Option<f64>,
}

/// Fields of `can_fault` that were given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the fields of world::can::Faults")]
pub struct CanChange {
    pub error_rate: Option<f64>,
    pub no_ack: Option<bool>,
    pub stuck_dominant: Option<bool>,
}

/// Hardware of other products.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elsewhere {
    /// Light-emitting diodes.
    Leds,
    /// Rotary switches for node-ID and bit rate.
    Switches,
    /// A battery.
    Battery,
    /// A key of this name.
    Key(&'static str),
    /// A sensor whose raw word can be set.
    SensorValue,
}

/// Reads a line.
#[must_use]
pub fn parse(line: &[u8]) -> Asked {
    let mut object = match serde_json::from_slice(line) {
        Ok(Value::Object(object)) => object,
        Ok(_) => return unreadable("a request is a JSON object"),
        Err(error) => return unreadable(&format!("this is no JSON: {error}")),
    };
    let id = object.remove("id").unwrap_or(Value::Null);
    let mut fields = Fields(object);
    match fields.node() {
        Ok(node) => Asked { node, request: request(fields, &id), id },
        Err(sentence) => Asked { id, node: 0, request: Err(sentence) },
    }
}

/// A line nothing could be read from.
#[must_use]
pub fn unreadable(sentence: &str) -> Asked {
    Asked { id: Value::Null, node: 0, request: Err(sentence.to_owned()) }
}

fn request(mut fields: Fields, name: &Value) -> Result<Request, String> {
    let verb: String = fields.needed("do", text)?;
    let request = match verb.as_str() {
        "now" => Request::Now,
        "advance" => Request::Advance(Duration::from_micros(fields.needed("us", micros)?)),
        "shaft" => Request::Shaft(turn(&mut fields)?),
        "key" => key(&mut fields)?,
        "input" => Request::Input(fields.needed("pin", input)?, fields.needed("high", truth)?),
        "motor" => Request::Motor,
        "motor_model" => Request::MotorModel(MotorChange {
            slow: fields.given("slow", count)?,
            middle: fields.given("middle", count)?,
            fast: fields.given("fast", count)?,
            run_out: fields.given("run_out", count)?,
            stuck: fields.given("stuck", truth)?,
            reversed: fields.given("reversed", truth)?,
            fault: fields.given("fault", truth)?,
        }),
        "sensor" => sensor(&mut fields)?,
        "display" => Request::Display,
        "power" => Request::Power(fields.needed("on", truth)?),
        "power_cut" => {
            Request::PowerCut(fields.needed("mcu", mcu)?, fields.needed("flash_op", from_one)?)
        }
        "link" => Request::Link(LinkChange {
            cut: fields.given("cut", truth)?,
            bit_error_rate: fields.given("bit_error_rate", probability)?,
            drop_rate: fields.given("drop_rate", probability)?,
        }),
        "can_send" => Request::CanSend(frame(&mut fields, name)?),
        "can_log" => Request::CanLog,
        "can_fault" => Request::CanFault(CanChange {
            error_rate: fields.given("error_rate", probability)?,
            no_ack: fields.given("no_ack", truth)?,
            stuck_dominant: fields.given("stuck_dominant", truth)?,
        }),
        "log" => Request::Log,
        "stats" => Request::Stats,
        "leds" => Request::Elsewhere(Elsewhere::Leds),
        "switches" => Request::Elsewhere(Elsewhere::Switches),
        "battery" => Request::Elsewhere(Elsewhere::Battery),
        _ => return Err(format!("there is no verb {verb:?}")),
    };
    fields.done(&verb)?;
    Ok(request)
}

fn turn(fields: &mut Fields) -> Result<Turn, String> {
    match (fields.given("steps", steps)?, fields.given("steps_per_s", steps)?) {
        (Some(by), None) => Ok(Turn::By(by)),
        (None, Some(speed)) => Ok(Turn::Steadily(speed)),
        (None, None) => Err("the field \"steps\" or \"steps_per_s\" is missing".to_owned()),
        (Some(_), Some(_)) => Err("give \"steps\" or \"steps_per_s\", not both".to_owned()),
    }
}

fn key(fields: &mut Fields) -> Result<Request, String> {
    let name = fields.needed("name", key_name)?;
    let down = fields.needed("down", truth)?;
    Ok(match name {
        Ok(key) => Request::Key(key, down),
        Err(elsewhere) => Request::Elsewhere(elsewhere),
    })
}

fn sensor(fields: &mut Fields) -> Result<Request, String> {
    let change = SensorChange {
        connected: fields.given("connected", truth)?,
        error: fields.given("error", truth)?,
    };
    if fields.given("battery_low", truth)?.is_some() {
        return Ok(Request::Elsewhere(Elsewhere::Battery));
    }
    if fields.given("value", count)?.is_some() {
        return Ok(Request::Elsewhere(Elsewhere::SensorValue));
    }
    Ok(Request::Sensor(change))
}

/// The identifier of the frame stands in `id`, so it is the name of the request as well, unless
/// `can_id` holds it. Of a remote frame the bytes only tell how many are asked for.
fn frame(fields: &mut Fields, name: &Value) -> Result<Frame, String> {
    let id = match fields.given("can_id", count)? {
        Some(id) => id,
        None if name.is_null() => return Err("the field \"id\" is missing".to_owned()),
        None => count(name).map_err(|wanted| format!("the field \"id\" is {wanted}"))?,
    };
    let data = fields.needed("data", bytes)?;
    let id = if fields.given("extended", truth)?.unwrap_or(false) {
        Id::Extended(id)
    } else {
        Id::Standard(u16::try_from(id).unwrap_or(u16::MAX))
    };
    let frame = if fields.given("rtr", truth)?.unwrap_or(false) {
        Frame::remote(id, u8::try_from(data.len()).unwrap_or(u8::MAX))
    } else {
        Frame::new(id, &data)
    };
    frame.map_err(|error| format!("that is no CAN frame: {error}"))
}

/// What is left of a request to be read.
struct Fields(Map<String, Value>);

/// Reads a value, or says what it should be.
type Read<T> = fn(&Value) -> Result<T, &'static str>;

impl Fields {
    /// The device meant.
    fn node(&mut self) -> Result<usize, String> {
        Ok(self.given("node", count)?.map_or(0, |node| usize::try_from(node).unwrap_or(usize::MAX)))
    }

    fn given<T>(&mut self, name: &str, read: Read<T>) -> Result<Option<T>, String> {
        let Some(value) = self.0.remove(name) else { return Ok(None) };
        read(&value).map(Some).map_err(|wanted| format!("the field {name:?} is {wanted}"))
    }

    fn needed<T>(&mut self, name: &str, read: Read<T>) -> Result<T, String> {
        self.given(name, read)?.ok_or_else(|| format!("the field {name:?} is missing"))
    }

    fn done(self, verb: &str) -> Result<(), String> {
        match self.0.keys().next() {
            None => Ok(()),
            Some(name) => Err(format!("{verb:?} has no field {name:?}")),
        }
    }
}

fn truth(value: &Value) -> Result<bool, &'static str> {
    value.as_bool().ok_or("true or false")
}

fn text(value: &Value) -> Result<String, &'static str> {
    value.as_str().map(str::to_owned).ok_or("a text")
}

fn count(value: &Value) -> Result<u32, &'static str> {
    value.as_u64().and_then(|n| u32::try_from(n).ok()).ok_or("a number from 0 to 4294967295")
}

fn from_one(value: &Value) -> Result<u32, &'static str> {
    count(value).ok().filter(|&n| n > 0).ok_or("a number from 1 to 4294967295")
}

fn micros(value: &Value) -> Result<u64, &'static str> {
    value.as_u64().ok_or("a number of microseconds, 0 or more")
}

fn steps(value: &Value) -> Result<i32, &'static str> {
    let wanted = "a whole number from -2147483648 to 2147483647";
    value.as_i64().and_then(|n| i32::try_from(n).ok()).ok_or(wanted)
}

fn probability(value: &Value) -> Result<f64, &'static str> {
    value.as_f64().filter(|p| (0.0..=1.0).contains(p)).ok_or("a number from 0 to 1")
}

fn bytes(value: &Value) -> Result<Vec<u8>, &'static str> {
    let wanted = "a text of hexadecimal digits, two to the byte";
    value.as_str().and_then(|text| hex::bytes(text.as_bytes())).ok_or(wanted)
}

fn key_name(value: &Value) -> Result<Result<Key, Elsewhere>, &'static str> {
    match value.as_str() {
        Some("left") => Ok(Ok(Key::Left)),
        Some("right") => Ok(Ok(Key::Right)),
        Some("chain") => Ok(Err(Elsewhere::Key("chain"))),
        Some("zero") => Ok(Err(Elsewhere::Key("zero"))),
        Some("config") => Ok(Err(Elsewhere::Key("config"))),
        _ => Err("\"left\" or \"right\""),
    }
}

fn input(value: &Value) -> Result<Input, &'static str> {
    match value.as_str() {
        Some("F") => Ok(Input::F),
        Some("G") => Ok(Input::G),
        _ => Err("\"F\" or \"G\""),
    }
}

fn mcu(value: &Value) -> Result<Mcu, &'static str> {
    let name = value.as_str();
    Mcu::BOTH.into_iter().find(|mcu| name == Some(mcu.name())).ok_or("\"stm\" or \"msp\"")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(line: &str) -> Result<Request, String> {
        parse(line.as_bytes()).request
    }

    #[test]
    fn every_verb_is_understood() {
        let data = |id, data: &[u8]| Request::CanSend(Frame::new(id, data).unwrap());
        for (line, expected) in [
            (r#"{"do":"now"}"#, Request::Now),
            (r#"{"do":"advance","us":1500}"#, Request::Advance(Duration::from_micros(1_500))),
            (r#"{"do":"shaft","steps":-40}"#, Request::Shaft(Turn::By(-40))),
            (r#"{"do":"shaft","steps_per_s":0}"#, Request::Shaft(Turn::Steadily(0))),
            (r#"{"do":"key","name":"left","down":true}"#, Request::Key(Key::Left, true)),
            (r#"{"do":"key","name":"right","down":false}"#, Request::Key(Key::Right, false)),
            (
                r#"{"do":"key","name":"zero","down":true}"#,
                Request::Elsewhere(Elsewhere::Key("zero")),
            ),
            (r#"{"do":"input","pin":"F","high":true}"#, Request::Input(Input::F, true)),
            (r#"{"do":"input","pin":"G","high":false}"#, Request::Input(Input::G, false)),
            (r#"{"do":"motor"}"#, Request::Motor),
            (
                r#"{"do":"motor_model","slow":10,"stuck":true}"#,
                Request::MotorModel(MotorChange {
                    slow: Some(10),
                    stuck: Some(true),
                    ..MotorChange::default()
                }),
            ),
            (
                r#"{"do":"sensor","connected":false}"#,
                Request::Sensor(SensorChange { connected: Some(false), error: None }),
            ),
            (r#"{"do":"sensor","battery_low":true}"#, Request::Elsewhere(Elsewhere::Battery)),
            (r#"{"do":"sensor","value":1}"#, Request::Elsewhere(Elsewhere::SensorValue)),
            (r#"{"do":"display"}"#, Request::Display),
            (r#"{"do":"power","on":false}"#, Request::Power(false)),
            (r#"{"do":"power_cut","mcu":"msp","flash_op":3}"#, Request::PowerCut(Mcu::Msp, 3)),
            (
                r#"{"do":"link","cut":true,"bit_error_rate":1e-3}"#,
                Request::Link(LinkChange {
                    cut: Some(true),
                    bit_error_rate: Some(0.001),
                    drop_rate: None,
                }),
            ),
            (
                r#"{"do":"can_send","id":1663,"data":"4018100000000000"}"#,
                data(Id::Standard(0x67F), &[0x40, 0x18, 0x10, 0, 0, 0, 0, 0]),
            ),
            (r#"{"do":"can_send","id":1,"data":"","extended":true}"#, data(Id::Extended(1), &[])),
            (
                r#"{"do":"can_send","id":1793,"data":"00","rtr":true}"#,
                Request::CanSend(Frame::remote(Id::Standard(0x701), 1).unwrap()),
            ),
            (r#"{"do":"can_send","id":1,"can_id":2,"data":"03"}"#, data(Id::Standard(2), &[3])),
            (r#"{"do":"can_log"}"#, Request::CanLog),
            (
                r#"{"do":"can_fault","no_ack":true}"#,
                Request::CanFault(CanChange { no_ack: Some(true), ..CanChange::default() }),
            ),
            (r#"{"do":"log"}"#, Request::Log),
            (r#"{"do":"stats"}"#, Request::Stats),
            (r#"{"do":"leds"}"#, Request::Elsewhere(Elsewhere::Leds)),
            (r#"{"do":"switches"}"#, Request::Elsewhere(Elsewhere::Switches)),
            (r#"{"do":"battery"}"#, Request::Elsewhere(Elsewhere::Battery)),
        ] {
            assert_eq!(asked(line), Ok(expected), "{line}");
        }
    }

    #[test]
    fn a_refusal_names_what_is_wrong() {
        for (line, named) in [
            ("", "JSON"),
            ("{", "JSON"),
            ("[]", "object"),
            ("7", "object"),
            ("{}", "\"do\" is missing"),
            (r#"{"do":7}"#, "\"do\""),
            (r#"{"do":"fly"}"#, "\"fly\""),
            (r#"{"do":"advance"}"#, "\"us\" is missing"),
            (r#"{"do":"advance","us":-1}"#, "\"us\""),
            (r#"{"do":"advance","us":1.5}"#, "\"us\""),
            (r#"{"do":"advance","us":1,"s":1}"#, "\"s\""),
            (r#"{"do":"now","node":-1}"#, "\"node\""),
            (r#"{"do":"shaft"}"#, "\"steps\""),
            (r#"{"do":"shaft","steps":1,"steps_per_s":1}"#, "not both"),
            (r#"{"do":"shaft","steps":2147483648}"#, "\"steps\""),
            (r#"{"do":"key","name":"middle","down":true}"#, "\"name\""),
            (r#"{"do":"key","name":"left"}"#, "\"down\" is missing"),
            (r#"{"do":"key","name":"left","down":1}"#, "\"down\""),
            (r#"{"do":"input","pin":"H","high":true}"#, "\"pin\""),
            (r#"{"do":"motor_model","slow":-1}"#, "\"slow\""),
            (r#"{"do":"motor_model","speed":1}"#, "\"speed\""),
            (r#"{"do":"power"}"#, "\"on\" is missing"),
            (r#"{"do":"power_cut","mcu":"pic","flash_op":1}"#, "\"mcu\""),
            (r#"{"do":"power_cut","mcu":"stm","flash_op":0}"#, "\"flash_op\""),
            (r#"{"do":"link","bit_error_rate":1.5}"#, "\"bit_error_rate\""),
            (r#"{"do":"can_send","id":2048,"data":""}"#, "identifier"),
            (r#"{"do":"can_send","id":65536,"data":""}"#, "identifier"),
            (r#"{"do":"can_send","id":536870912,"data":"","extended":true}"#, "identifier"),
            (r#"{"do":"can_send","id":1,"data":"0"}"#, "\"data\""),
            (r#"{"do":"can_send","id":1,"data":"001122334455667788"}"#, "8 bytes"),
            (r#"{"do":"can_send","id":1}"#, "\"data\" is missing"),
            (r#"{"do":"can_send","data":""}"#, "\"id\" is missing"),
            (r#"{"do":"can_send","id":"1","data":""}"#, "\"id\""),
        ] {
            let sentence = asked(line).unwrap_err();
            assert!(sentence.contains(named), "{line}: {sentence}");
        }
    }

    #[test]
    fn the_name_of_a_request_comes_back_whatever_is_wrong_with_it() {
        for (line, id) in [
            (r#"{"id":1,"do":"now"}"#, serde_json::json!(1)),
            (r#"{"id":"a","do":"fly"}"#, serde_json::json!("a")),
            (r#"{"id":7,"do":"now","node":"x"}"#, serde_json::json!(7)),
            (r#"{"do":"now"}"#, Value::Null),
            (r#"{"id":1"#, Value::Null),
        ] {
            assert_eq!(parse(line.as_bytes()).id, id, "{line}");
        }
    }
}
