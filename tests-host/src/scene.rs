use std::fmt::Write as _;

use serde_json::{Value, json};

use crate::Bench;

/// Long enough for a request and its answer at 10 kbit/s.
const TRANSFER_US_MAX: u64 = 40_000;
/// How finely time passes while an answer is awaited.
const GLANCE_US: u64 = 500;

/// A bench on step clock whose first device is written about in a transcript.
pub struct Scene {
    /// The bench.
    pub bench: Bench,
    node_id: u16,
    transcript: String,
}

impl Scene {
    /// A device that has just been powered, with node-ID 127.
    #[must_use]
    pub fn powered(product: &str, options: &[&str]) -> Self {
        let bench = Bench::step(product, options);
        Self { bench, node_id: 127, transcript: String::new() }
    }

    /// A device that has been on for a second: it is on the bus, and still shows who it is.
    #[must_use]
    pub fn booted(product: &str, options: &[&str]) -> Self {
        let mut scene = Self::powered(product, options);
        scene.bench.advance_ms(1_000);
        scene.frames();
        scene
    }

    /// A device that has been on for six seconds, with the normal display on the glass.
    #[must_use]
    pub fn running(product: &str, options: &[&str]) -> Self {
        let mut scene = Self::booted(product, options);
        scene.bench.advance_ms(5_000);
        scene
    }

    /// The device has another node-ID from here on.
    pub fn node_id(&mut self, node_id: u16) -> &mut Self {
        self.node_id = node_id;
        self
    }

    /// Lets time pass.
    pub fn run_ms(&mut self, ms: u64) -> &mut Self {
        self.bench.advance_ms(ms);
        self
    }

    /// Asks the control port.
    pub fn tell(&mut self, verb: &str, fields: Value) -> &mut Self {
        self.bench.tell(verb, fields);
        self
    }

    /// A frame from a master, `id#data` in hexadecimal.
    ///
    /// # Panics
    /// If it is none.
    pub fn send(&mut self, frame: &str) -> &mut Self {
        let (id, data) = frame.split_once('#').expect("id#data");
        let id = u32::from_str_radix(id, 16).expect("hexadecimal");
        let data: String = data.split_whitespace().collect();
        self.tell("can_send", json!({ "id": id, "data": data }))
    }

    /// Frames of all devices since the last look, `id#data`.
    ///
    /// # Panics
    /// If the bench answers something else.
    pub fn frames(&mut self) -> Vec<String> {
        let log = self.bench.tell("can_log", json!({}));
        let frames = log.get("frames").and_then(Value::as_array).expect("frames");
        let out = frames.iter().filter(|frame| frame["dir"] == "out");
        out.map(|frame| {
            let data = frame["data"].as_str().unwrap_or_default();
            format!("{:03X}#{}", frame["id"].as_u64().unwrap_or_default(), spaced(data))
        })
        .collect()
    }

    /// A request to the SDO server and the answer, eight bytes each.
    ///
    /// # Panics
    /// If none comes.
    pub fn request(&mut self, bytes: &str) -> String {
        self.send(&format!("{:03X}#{bytes}", 0x600 + self.node_id));
        let answer = format!("{:03X}#", 0x580 + self.node_id);
        for _ in 0..TRANSFER_US_MAX / GLANCE_US {
            self.bench.advance(GLANCE_US);
            let answers = self.frames();
            if let Some(found) = answers.iter().find_map(|frame| frame.strip_prefix(&answer)) {
                return found.to_owned();
            }
        }
        panic!("no answer to {bytes}");
    }

    /// A request and its answer, for the transcript.
    pub fn sdo(&mut self, bytes: &str) -> &mut Self {
        let answer = self.request(bytes);
        self.note(&format!("{bytes} -> {answer}"))
    }

    /// Frames since the last look, for the transcript.
    pub fn note_frames(&mut self) -> &mut Self {
        for frame in self.frames() {
            self.note(&frame);
        }
        self
    }

    /// What the glass shows, for the transcript.
    pub fn note_display(&mut self) -> &mut Self {
        let seen = self.bench.tell("display", json!({}));
        let text = |name: &str| seen[name].as_str().unwrap_or_default().to_owned();
        let arrow = |name: &str, sign| if seen[name] == true { sign } else { ' ' };
        let left = arrow("left_arrow", '<');
        let right = arrow("right_arrow", '>');
        self.note(&format!("[{}] {left}{right}", text("upper")));
        self.note(&format!("[{}]", text("lower")))
    }

    /// A line of the transcript.
    pub fn note(&mut self, line: &str) -> &mut Self {
        let now = self.bench.tell("now", json!({}));
        let ms = now["us"].as_u64().unwrap_or_default() / 1_000;
        let _ = writeln!(self.transcript, "{ms:<6} ms  {}", line.trim_end());
        self
    }

    /// The transcript so far.
    #[must_use]
    pub fn transcript(&self) -> &str {
        &self.transcript
    }
}

/// `0a0b` as `0A 0B`.
fn spaced(hex: &str) -> String {
    let pairs: Vec<String> =
        hex.as_bytes().chunks(2).map(|pair| String::from_utf8_lossy(pair).to_uppercase()).collect();
    pairs.join(" ")
}
