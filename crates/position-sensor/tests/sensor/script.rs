//! A sensor with a memory, and a transcript of what is said to it and what it answers.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use canopen::{CanId, Frame, WriteError};
use position_sensor::{Event, MODELS, Model, Record, Sensor};
use units::{Duration, Instant};

/// A device and what happened to it so far.
pub(crate) struct Script {
    model: &'static Model,
    sensor: Sensor,
    memory: BTreeMap<u32, u32>,
    memory_fails: Option<WriteError>,
    now: Instant,
    shaft_steps: i64,
    transcript: String,
}

fn kept(memory: &BTreeMap<u32, u32>) -> impl Iterator<Item = Record> + Clone {
    memory.iter().map(|(&key, &value)| Record { key, value })
}

impl Script {
    /// A device as it is delivered, after its boot-up message.
    pub(crate) fn new(slug: &str) -> Self {
        let model = MODELS.iter().find(|model| model.slug == slug).expect("a model");
        let memory = BTreeMap::new();
        let now = Instant::ZERO;
        let sensor = Sensor::new(now, model, 7, kept(&memory));
        let transcript = String::new();
        let memory_fails = None;
        let mut script =
            Self { model, sensor, memory, memory_fails, now, shaft_steps: 0, transcript };
        script.settle();
        script.transcript.clear();
        script
    }

    /// A frame from the master, `id#data`.
    pub(crate) fn send(&mut self, text: &str) -> &mut Self {
        let (id, data) = text.split_once('#').expect("id#data");
        let id = CanId::new(u16::from_str_radix(id, 16).expect("hexadecimal")).expect("an id");
        let bytes: Vec<u8> = data
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16).expect("hexadecimal"))
            .collect();
        let _ = writeln!(self.transcript, "> {text}");
        self.receive(&Frame::new(id, &bytes).expect("at most 8 bytes"));
        self
    }

    /// A remote frame from the master.
    pub(crate) fn ask_remote(&mut self, id: u16) -> &mut Self {
        let _ = writeln!(self.transcript, "> {id:03X} remote");
        self.receive(&Frame::new_remote(CanId::new(id).expect("an id"), 0).expect("no bytes"));
        self
    }

    fn receive(&mut self, frame: &Frame) {
        if self.sensor.reads_for(frame) {
            self.sensor.handle_steps(self.now, self.shaft_steps);
        }
        self.sensor.handle_frame(self.now, frame);
        self.settle();
        if self.sensor.poll_timeout().is_some_and(|due_at| due_at <= self.now) {
            self.sensor.handle_timeout(self.now);
            self.settle();
        }
    }

    /// SDO requests to node 1.
    pub(crate) fn ask(&mut self, requests: &[&str]) -> &mut Self {
        for request in requests {
            self.send(&format!("601#{request}"));
        }
        self
    }

    /// The shaft is turned to `steps` from where it was at the start.
    pub(crate) fn steps(&mut self, steps: i64) -> &mut Self {
        self.turn(steps).read()
    }

    /// As [`Self::steps`], and the device has not read its sensor since.
    pub(crate) fn turn(&mut self, steps: i64) -> &mut Self {
        let _ = writeln!(self.transcript, "{steps} steps");
        self.shaft_steps = steps;
        self
    }

    /// It is time to read the sensor.
    pub(crate) fn read(&mut self) -> &mut Self {
        if self.sensor.reads_cyclically() {
            self.sensor.handle_steps(self.now, self.shaft_steps);
            self.settle();
        }
        self
    }

    /// Time passes, in steps of one millisecond.
    pub(crate) fn run_ms(&mut self, ms: u64) -> &mut Self {
        let _ = writeln!(self.transcript, "{ms} ms");
        for _ in 0..ms {
            self.now = self.now + Duration::from_millis(1);
            self.sensor.handle_timeout(self.now);
            self.settle();
        }
        self
    }

    /// The supply fails and comes back.
    pub(crate) fn power_cycle(&mut self) -> &mut Self {
        let _ = writeln!(self.transcript, "supply");
        self.restart();
        self.settle();
        self
    }

    /// Whether the memory takes anything from here on.
    pub(crate) fn memory_fails(&mut self, fails: Option<WriteError>) -> &mut Self {
        self.memory_fails = fails;
        self
    }

    /// What was said, once.
    pub(crate) fn transcript(&mut self) -> String {
        std::mem::take(&mut self.transcript)
    }

    /// The bit rate the device uses.
    pub(crate) fn bit_rate(&self) -> u32 {
        self.sensor.bit_rate()
    }

    fn restart(&mut self) {
        self.sensor = Sensor::new(self.now, self.model, 7, kept(&self.memory));
    }

    fn settle(&mut self) {
        while let Some(event) = self.sensor.poll_event() {
            let outcome = self.memory_fails.map_or(Ok(()), Err);
            match event {
                Event::Keep(Record { key, value }) => {
                    self.memory.insert(key, value);
                }
                Event::Save(group) | Event::Forget(group) if outcome.is_ok() => {
                    self.memory.retain(|key, _| !group.contains(*key));
                    if matches!(event, Event::Save(_)) {
                        let saved = self.sensor.parameters(group);
                        self.memory.extend(saved.map(|record| (record.key, record.value)));
                    }
                    self.sensor.handle_stored(self.now, outcome);
                }
                Event::Save(_) | Event::Forget(_) => self.sensor.handle_stored(self.now, outcome),
                Event::FiltersChanged => {}
                Event::Restart => self.restart(),
                Event::RestartCommunication => {
                    self.sensor.restart_communication(self.now, kept(&self.memory));
                }
            }
        }
        while let Some(frame) = self.sensor.take_transmit() {
            let data: Vec<String> = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
            let _ = writeln!(self.transcript, "< {:03X}#{}", frame.id().get(), data.join(" "));
        }
    }
}
