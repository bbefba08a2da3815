use std::io::{BufRead, BufReader, Read};
use std::net::SocketAddr;
use std::process::{Child, Command, ExitStatus, Stdio};

use serde_json::{Value, json};

use crate::build::{self, bench_program, images};
use crate::{Control, Slcan};

/// A bench in a process of its own. It ends with this value.
pub struct Bench {
    process: Child,
    control: Control,
    slcan: SocketAddr,
    ended: bool,
}

impl Bench {
    /// A bench whose virtual time moves only by [`Bench::advance`]. `options` are added to the
    /// command line.
    ///
    /// # Panics
    /// If it does not come up.
    #[must_use]
    pub fn step(product: &str, options: &[&str]) -> Self {
        Self::start(product, &[&["--clock", "step"], options].concat())
    }

    /// A bench whose virtual time follows the wall clock.
    ///
    /// # Panics
    /// If it does not come up.
    #[must_use]
    pub fn real(product: &str, options: &[&str]) -> Self {
        Self::start(product, &[&["--clock", "real"], options].concat())
    }

    fn start(product: &str, options: &[&str]) -> Self {
        let mut command = Command::new(bench_program());
        if !options.contains(&"twin") {
            command.env("SPINDLE_IMAGES", images());
        }
        let mut process = command
            .current_dir(build::root())
            .args(["up", product, "--no-tui"])
            .args(["--slcan", "127.0.0.1:0", "--control", "127.0.0.1:0"])
            .args(options)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the bench was built");
        let mut line = String::new();
        let output = process.stdout.take().expect("its output is a pipe");
        BufReader::new(output).read_line(&mut line).expect("its output is text");
        let Ok(ready) = serde_json::from_str::<Value>(&line) else {
            let mut reason = String::new();
            if let Some(mut errors) = process.stderr.take() {
                let _ = errors.read_to_string(&mut reason);
            }
            panic!("the bench is not up: {line}{reason}");
        };
        let address = |name: &str| {
            let text = ready.get(name).and_then(Value::as_str).unwrap_or_default();
            text.parse().unwrap_or_else(|_| panic!("no address of {name} in {ready}"))
        };
        let (control, slcan) = (Control::connect(address("control")), address("slcan"));
        Self { process, control, slcan, ended: false }
    }

    /// Asks the control port and expects an answer that it was done.
    ///
    /// # Panics
    /// With the bench's sentence if it was not.
    pub fn tell(&mut self, verb: &str, fields: Value) -> Value {
        let answer = self.control.ask(verb, fields.clone());
        answer.unwrap_or_else(|sentence| panic!("{verb} {fields}: {sentence}"))
    }

    /// Asks the control port; the sentence of the bench if it refuses.
    ///
    /// # Errors
    /// What the bench says.
    pub fn ask(&mut self, verb: &str, fields: Value) -> Result<Value, String> {
        self.control.ask(verb, fields)
    }

    /// Lets `us` microseconds of virtual time pass.
    pub fn advance(&mut self, us: u64) {
        self.tell("advance", json!({ "us": us }));
    }

    /// Lets `ms` milliseconds of virtual time pass.
    pub fn advance_ms(&mut self, ms: u64) {
        self.advance(ms * 1_000);
    }

    /// Both lines of the display as they are seen now.
    pub fn display(&mut self) -> (String, String) {
        let seen = self.tell("display", json!({}));
        let line = |name: &str| seen.get(name).and_then(Value::as_str).unwrap_or_default();
        (line("upper").to_owned(), line("lower").to_owned())
    }

    /// Another client of the control port.
    #[must_use]
    pub fn control(&self) -> Control {
        Control::connect(self.control.address())
    }

    /// A new client of the CAN gateway.
    #[must_use]
    pub fn slcan(&self) -> Slcan {
        Slcan::connect(self.slcan)
    }

    /// Where CAN masters attach.
    #[must_use]
    pub const fn slcan_address(&self) -> SocketAddr {
        self.slcan
    }

    /// Ends the bench as a user does, so that it writes its state and says what was wrong with the
    /// run. Returns how it ended and what it wrote to standard error.
    ///
    /// # Panics
    /// If it cannot be ended.
    pub fn stop(mut self) -> (ExitStatus, String) {
        self.ended = true;
        let interrupted =
            Command::new("kill").args(["-INT", &self.process.id().to_string()]).status();
        assert!(interrupted.is_ok_and(|status| status.success()), "kill -INT");
        let mut errors = String::new();
        if let Some(mut pipe) = self.process.stderr.take() {
            let _ = pipe.read_to_string(&mut errors);
        }
        (self.process.wait().expect("it was started"), errors)
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        if !self.ended {
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}
