//! A bench whose devices are nothing but a CAN controller that sends.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::sync::{Mutex, MutexGuard};

use units::Instant;
use world::can::{
    BitTime, Bus, ErrorCounters, Frame, Id, Nanos, PortState, Presence, Request, SendOrder, What,
    greatest_quantum,
};
use world::{Engine, EngineError, FlashImage, LogLine, Mcu, McuStats, Surroundings};

/// What the devices are set to.
pub(crate) const RATE: u32 = 125_000;

/// How often a device sends its sign of life, in nanoseconds.
const SIGN_EVERY_NS: u64 = 100_000_000;

/// When the engine comes to an end of its own, in nanoseconds.
const FAILS_AT_NS: u64 = 10_000_000_000;

/// Device k sends 0x701 + k with one byte of 5 every 100 ms, and logs that it did.
pub(crate) struct Senders {
    bus: Mutex<Bus>,
    surroundings: Vec<Mutex<Surroundings>>,
    ports: Vec<PortState>,
    sign_due: Nanos,
    now: Nanos,
    log: Vec<Vec<LogLine>>,
    flash_ops: u64,
}

impl Senders {
    pub(crate) fn boxed(nodes: usize) -> Box<dyn Engine> {
        let port = PortState {
            presence: Presence::Normal,
            bit: BitTime::from_rate(RATE),
            since: Nanos::ZERO,
            counters: ErrorCounters::NONE,
            order: SendOrder::Identifier,
            waits: false,
            requests: [None; 3],
        };
        Box::new(Self {
            bus: Mutex::new(Bus::new(0)),
            surroundings: (0..nodes).map(|_| Mutex::new(Surroundings::default())).collect(),
            ports: vec![port; nodes],
            sign_due: Nanos(SIGN_EVERY_NS),
            now: Nanos::ZERO,
            log: vec![Vec::new(); nodes],
            flash_ops: 0,
        })
    }

    fn request_signs(&mut self) {
        if self.now < self.sign_due {
            return;
        }
        for (id, port) in (0x701..).zip(&mut self.ports) {
            let frame = Frame::new(Id::Standard(id), &[5]).unwrap();
            port.requests[0] = Some(Request { at: self.now, withdrawn_at: None, frame });
        }
        self.sign_due = self.sign_due.after(SIGN_EVERY_NS);
    }
}

impl Engine for Senders {
    fn node_count(&self) -> usize {
        self.ports.len()
    }

    fn now(&self) -> Instant {
        self.now.instant()
    }

    fn run_until(&mut self, at: Instant) -> Result<(), EngineError> {
        let until = Nanos::from_instant(at);
        while self.now < until {
            if self.now.0 >= FAILS_AT_NS {
                return Err(EngineError("nobody knows what comes after 10 s".to_owned()));
            }
            self.request_signs();
            self.now = self.now.after(greatest_quantum(BitTime::from_rate(RATE))).min(until);
            let deliveries = self.bus.lock().unwrap().resolve(self.now, &self.ports);
            for (node, delivery) in deliveries.into_iter().enumerate() {
                for outcome in delivery.outcomes {
                    self.ports[node].counters = outcome.counters;
                    if let What::Transmitted(mailbox) = outcome.what {
                        self.ports[node].requests[mailbox] = None;
                        self.flash_ops += 1;
                        self.log[node].push(LogLine {
                            mcu: Mcu::Stm,
                            at: outcome.at.instant(),
                            level: "info".to_owned(),
                            text: "sent".to_owned(),
                        });
                    }
                }
            }
        }
        Ok(())
    }

    fn surroundings(&self, node: usize) -> MutexGuard<'_, Surroundings> {
        self.surroundings[node].lock().unwrap()
    }

    fn bus(&self) -> MutexGuard<'_, Bus> {
        self.bus.lock().unwrap()
    }

    fn set_power(&mut self, node: usize, on: bool) {
        self.ports[node].presence = if on { Presence::Normal } else { Presence::Off };
    }

    fn cut_power_at_flash_operation(&mut self, _: usize, _: Mcu, _: u32) {}

    fn stats(&self, _: usize) -> [McuStats; 2] {
        [McuStats { flash_ops: self.flash_ops, ..McuStats::default() }, McuStats::default()]
    }

    fn take_log(&mut self, node: usize) -> Vec<LogLine> {
        std::mem::take(&mut self.log[node])
    }

    fn flash(&self, node: usize, mcu: Mcu) -> FlashImage {
        format!("{node} {} after {}", mcu.name(), self.flash_ops).into_bytes()
    }
}

/// A TCP client that says lines and reads what comes back.
pub(crate) struct Talk {
    stream: BufReader<TcpStream>,
}

impl Talk {
    pub(crate) fn with(address: SocketAddr) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        stream.set_nodelay(true).unwrap();
        Self { stream: BufReader::new(stream) }
    }

    pub(crate) fn say(&mut self, bytes: &str) {
        self.stream.get_mut().write_all(bytes.as_bytes()).unwrap();
    }

    pub(crate) fn close_own_direction(&mut self) {
        self.stream.get_mut().shutdown(Shutdown::Write).unwrap();
    }

    /// Everything up to the next `end`, included.
    pub(crate) fn hear(&mut self, end: u8) -> String {
        let mut bytes = Vec::new();
        self.stream.read_until(end, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// Exactly `len` bytes.
    pub(crate) fn hear_bytes(&mut self, len: usize) -> String {
        let mut bytes = vec![0; len];
        self.stream.read_exact(&mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    /// One request of the control port and its answer, without the newline.
    pub(crate) fn ask(&mut self, request: &str) -> String {
        self.say(&format!("{request}\n"));
        self.hear(b'\n').trim_end().to_owned()
    }
}
