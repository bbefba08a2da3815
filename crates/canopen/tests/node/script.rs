//! Runs a node through a script and writes down everything it does.
//!
//! A script has one step a line: `MS boot`, `MS wait` for a node-ID, `MS < ID BYTES`,
//! `MS remote ID LEN`, `MS set INDEX:SUB VALUE …`, `MS errors REGISTER`,
//! `MS emergency CODE SUB-CODE`, `MS bus STATE`, `MS overrun`, `MS trigger PDO`, `MS stored`, `MS not stored`, `MS end`. Between the steps the
//! clock jumps from deadline to deadline. The transcript has `<` for what the node receives, `>` for
//! what it sends and `*` for its events; a frame is written as ID, length and bytes.

use std::fmt::Write as _;

use canopen::{Application, BusState, CanId, Event, Frame, Node, WriteError};
use object_dictionary::{ObjectId, Slot};
use units::{Duration, Instant};

struct Run<'a, A, const LEN: usize> {
    node: Node<LEN>,
    application: &'a mut A,
    now: Instant,
    transcript: String,
}

/// What happens on the node while the script runs.
pub(crate) fn transcript<A: Application, const LEN: usize>(
    node: Node<LEN>,
    application: &mut A,
    script: &str,
) -> String {
    let start = Instant::ZERO;
    let mut run = Run { node, application, now: start, transcript: String::new() };
    for line in script.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let (ms, step) = line.split_once(' ').expect("a time and a step");
        run.advance(start + Duration::from_millis(ms.parse().expect("milliseconds")));
        run.step(step);
    }
    run.transcript
}

impl<A: Application, const LEN: usize> Run<'_, A, LEN> {
    fn advance(&mut self, until: Instant) {
        while let Some(due_at) = self.node.poll_timeout().filter(|&due_at| due_at <= until) {
            self.now = self.now.max(due_at);
            self.node.handle_timeout(self.now, self.application);
            self.drain();
            assert!(
                self.node.poll_timeout().is_none_or(|next_at| next_at > self.now),
                "the node is never done\n{}",
                self.transcript
            );
        }
        self.now = until;
    }

    fn step(&mut self, step: &str) {
        let (verb, rest) = step.split_once(' ').unwrap_or((step, ""));
        match verb {
            "boot" => self.node.boot(self.now),
            "wait" => self.node.wait_for_node_id(),
            "<" => {
                let (id, data) = rest.split_once(' ').unwrap_or((rest, ""));
                let data: Vec<u8> = data.split_whitespace().map(hex).collect();
                self.receive(Frame::new(can_id(id), &data).expect("at most 8 bytes"));
            }
            "remote" => {
                let (id, len) = rest.split_once(' ').expect("ID and length");
                self.receive(Frame::new_remote(can_id(id), hex(len)).expect("at most 8 bytes"));
            }
            "set" => {
                for (object, value) in
                    rest.split(',').map(|set| set.trim().split_once(' ').unwrap())
                {
                    let value: i64 = value.parse().expect("a number");
                    let slot = self.slot(object);
                    self.node.set_value(self.now, slot, value as u32);
                }
            }
            "errors" => self.node.set_error_register(self.now, hex(rest)),
            "emergency" => {
                let (code, sub_code) = rest.split_once(' ').expect("code and sub-code");
                let code = u16::from_str_radix(code, 16).expect("hexadecimal");
                self.node.send_emergency(code, [0xA1, 0xA2, 0, 0, hex(sub_code)]);
            }
            "trigger" => self.node.trigger_tpdo(self.now, rest.parse().expect("a number")),
            "bus" => self.node.handle_bus(self.now, bus_state(rest)),
            "overrun" => self.node.handle_overrun(),
            "stored" => self.node.handle_stored(Ok(())),
            "not" => self.node.handle_stored(Err(WriteError::NotStored)),
            "end" => {}
            _ => panic!("unknown step: {step}"),
        }
        self.drain();
        self.advance(self.now);
    }

    fn receive(&mut self, frame: Frame) {
        self.line('<', &described(&frame));
        self.node.handle_frame(self.now, &frame, self.application);
    }

    fn drain(&mut self) {
        while let Some(event) = self.node.poll_event() {
            let event = match event {
                Event::StateChanged { from, to } => format!("{from:?} to {to:?}"),
                Event::ResetNode
                | Event::ResetCommunication
                | Event::Store { .. }
                | Event::Restore { .. }
                | Event::FiltersChanged
                | Event::PdoOverdue { .. }
                | Event::BusStateChanged { .. }
                | Event::GuardingLost
                | Event::GuardingRecovered
                | Event::HeartbeatLost { .. }
                | Event::HeartbeatRecovered { .. }
                | Event::Lss(_)
                | Event::Time(_)
                | Event::TransmitOverflow { .. } => format!("{event:?}"),
            };
            self.line('*', &event);
        }
        while let Some(frame) = self.node.take_transmit() {
            self.line('>', &described(&frame));
        }
    }

    /// The slot of an object written as `2003:00`.
    fn slot(&self, object: &str) -> Slot {
        let (index, sub) = object.split_once(':').expect("index and sub-index");
        let index = u16::from_str_radix(index, 16).expect("hexadecimal");
        let id = ObjectId { index, sub: hex(sub) };
        self.node.values().dictionary().find(id).expect("the device has the object")
    }

    fn line(&mut self, mark: char, text: &str) {
        let ms = self.now.since(Instant::ZERO).as_millis();
        writeln!(self.transcript, "{ms:04} {mark} {text}").expect("a string takes all");
    }
}

fn described(frame: &Frame) -> String {
    let mut text = format!("{:03X} [{}]", frame.id().get(), frame.dlc());
    if frame.is_remote() {
        text.push_str(" remote");
    }
    for byte in frame.data() {
        write!(text, " {byte:02X}").expect("a string takes all");
    }
    text
}

fn hex(digits: &str) -> u8 {
    u8::from_str_radix(digits, 16).expect("hexadecimal")
}

fn bus_state(name: &str) -> BusState {
    match name {
        "active" => BusState::Active,
        "warning" => BusState::Warning,
        "passive" => BusState::Passive,
        "off" => BusState::Off,
        _ => panic!("unknown state of the bus: {name}"),
    }
}

fn can_id(digits: &str) -> CanId {
    CanId::new(u16::from_str_radix(digits, 16).expect("hexadecimal")).expect("11 bits")
}
