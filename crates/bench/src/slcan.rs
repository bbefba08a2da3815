//! SLCAN: a CAN channel as a USB adapter of the LAWICEL family offers it, over any byte stream.
//!
//! A channel belongs to one client and is one node of the bus: it acknowledges, takes part in
//! arbitration and, at a wrong bit rate, sees and causes error frames. Those reach the client in
//! the way of the kernel's slcan driver, as a line `e1F`; bit 7 of the status flags tells of them
//! too.

mod command;

pub use command::{Command, Malformed, Stamps};

use world::can::{Bus, Confinement, Frame, Id, Nanos, Rate, Role, SEND_MAX, Status};

use crate::hex;
use crate::lines::{Line, Lines};
use crate::node::Attachment;

/// Longest line of a client. The longest command, an extended frame of 8 bytes, has 26 bytes.
pub const LINE_MAX: usize = 64;

/// Done, after a command that asks for nothing.
const OK: &[u8] = b"\r";
/// Not done.
const BELL: &[u8] = b"\x07";
/// A failed frame was seen on the bus.
const BUS_ERROR: &[u8] = b"e1F\r";

/// One client's channel.
#[derive(Debug)]
pub struct Channel {
    lines: Lines,
    rate: Option<Rate>,
    stamps: Stamps,
    node: Option<Attachment>,
    /// Figures of the node when the client last asked for its status.
    errors_told: u64,
    dropped_told: u64,
}

impl Default for Channel {
    fn default() -> Self {
        Self {
            lines: Lines::new(b'\r', LINE_MAX),
            rate: None,
            stamps: Stamps::Off,
            node: None,
            errors_told: 0,
            dropped_told: 0,
        }
    }
}

impl Channel {
    /// A channel whose bit rate is set already.
    #[must_use]
    pub fn at(rate: Rate) -> Self {
        Self { rate: Some(rate), ..Self::default() }
    }

    /// Takes bytes of the client; returns the answers, one for each line they complete.
    pub fn handle(&mut self, bus: &mut Bus, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        for line in self.lines.push(bytes) {
            let command = match line {
                // Terminals end a line with CR LF: the LF then leads the next line.
                Line::Whole(line) => Command::parse(line.strip_prefix(b"\n").unwrap_or(&line)),
                Line::TooLong => Err(Malformed),
            };
            match command.ok().and_then(|command| self.execute(bus, command)) {
                Some(answer) => answers.extend_from_slice(&answer),
                None => answers.extend_from_slice(BELL),
            }
        }
        answers
    }

    /// What the bus has for the client: frames received, errors seen.
    pub fn poll(&mut self, bus: &mut Bus) -> Vec<u8> {
        let mut lines = Vec::new();
        let Some(node) = &mut self.node else { return lines };
        while let Some((at, frame)) = node.receive(bus) {
            lines.extend_from_slice(write(at, &frame, self.stamps).as_bytes());
        }
        if node.new_errors(bus) > 0 {
            lines.extend_from_slice(BUS_ERROR);
        }
        lines
    }

    /// Takes the channel off the bus, when its client is gone.
    pub fn leave(&mut self, bus: &mut Bus) {
        if let Some(node) = self.node.take() {
            node.detach(bus);
        }
    }

    /// The answer; none when the command can not be carried out now.
    fn execute(&mut self, bus: &mut Bus, command: Command) -> Option<Vec<u8>> {
        match command {
            Command::Nothing => Some(OK.to_vec()),
            Command::BitRate(rate) => {
                self.configure(|channel| channel.rate = Some(Rate::Fixed(rate)))
            }
            Command::Stamps(stamps) => self.configure(|channel| channel.stamps = stamps),
            Command::Ignored => self.configure(|_| {}),
            Command::Open => self.open(bus, Role::Normal),
            Command::Listen => self.open(bus, Role::ListenOnly),
            Command::Close => {
                self.node.take()?.detach(bus);
                Some(OK.to_vec())
            }
            Command::Transmit(frame) => self.transmit(bus, frame),
            Command::Version => Some(b"V0101\r".to_vec()),
            Command::Firmware => Some(b"v0101\r".to_vec()),
            Command::Serial => Some(b"N0001\r".to_vec()),
            Command::Status => self.status(bus),
        }
    }

    /// Settings are taken while the channel is closed.
    fn configure(&mut self, set: impl FnOnce(&mut Self)) -> Option<Vec<u8>> {
        if self.node.is_some() {
            return None;
        }
        set(self);
        Some(OK.to_vec())
    }

    fn open(&mut self, bus: &mut Bus, role: Role) -> Option<Vec<u8>> {
        let rate = self.rate?;
        if self.node.is_some() {
            return None;
        }
        self.node = Some(Attachment::attach(bus, rate, role));
        (self.errors_told, self.dropped_told) = (0, 0);
        Some(OK.to_vec())
    }

    fn transmit(&self, bus: &mut Bus, frame: Frame) -> Option<Vec<u8>> {
        let node = self.node.as_ref()?;
        match node.role() {
            Role::ListenOnly => None,
            Role::Normal => {
                node.send(bus, frame).ok()?;
                Some(if frame.id().is_extended() { b"Z\r".to_vec() } else { b"z\r".to_vec() })
            }
        }
    }

    fn status(&mut self, bus: &Bus) -> Option<Vec<u8>> {
        let status = self.node.as_ref()?.status(bus);
        let flags = self.flags(&status);
        (self.errors_told, self.dropped_told) = (status.errors, status.dropped);
        Some(format!("F{flags:02X}\r").into_bytes())
    }

    /// The flags of the LAWICEL manual, as far as there is something to tell.
    fn flags(&self, status: &Status) -> u8 {
        const TRANSMIT_FULL: u8 = 1 << 1;
        const WARNING: u8 = 1 << 2;
        const OVERRUN: u8 = 1 << 3;
        const PASSIVE: u8 = 1 << 5;
        const BUS_ERROR: u8 = 1 << 7;
        /// Error counters of an SJA1000 from which on it warns.
        const WARNING_FROM: u16 = 96;
        let counters = status.counters;
        let worst = counters.transmit().max(u16::from(counters.receive()));
        [
            (status.waiting >= SEND_MAX, TRANSMIT_FULL),
            (worst >= WARNING_FROM, WARNING),
            (status.dropped > self.dropped_told, OVERRUN),
            (counters.confinement() != Confinement::ErrorActive, PASSIVE),
            (status.errors > self.errors_told, BUS_ERROR),
        ]
        .iter()
        .filter_map(|&(holds, flag)| holds.then_some(flag))
        .sum()
    }
}

/// The line that hands over a frame received `at`. Without a stamp it is also the line that asks
/// for the frame to be sent.
#[must_use]
pub fn write(at: Nanos, frame: &Frame, stamps: Stamps) -> String {
    const STAMP_PERIOD_MS: u64 = 60_000;
    let head = match (frame.id(), frame.is_remote()) {
        (Id::Standard(id), false) => format!("t{id:03X}"),
        (Id::Standard(id), true) => format!("r{id:03X}"),
        (Id::Extended(id), false) => format!("T{id:08X}"),
        (Id::Extended(id), true) => format!("R{id:08X}"),
    };
    let stamp = match stamps {
        Stamps::Off => String::new(),
        Stamps::Milliseconds => {
            format!("{:04X}", at.instant().as_micros() / 1000 % STAMP_PERIOD_MS)
        }
    };
    format!("{head}{}{}{stamp}\r", frame.dlc(), hex::upper(frame.data()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn received_frames_are_written_as_adapters_write_them() {
        let data = |id, data: &[u8]| Frame::new(id, data).unwrap();
        let at = Nanos(61_234_567_890);
        for (frame, stamps, line) in [
            (data(Id::Standard(0x77F), &[0]), Stamps::Off, "t77F100\r"),
            (data(Id::Standard(0x001), &[]), Stamps::Off, "t0010\r"),
            (data(Id::Standard(0x2FF), &[0xAB, 0x0C]), Stamps::Milliseconds, "t2FF2AB0C04D2\r"),
            (data(Id::Extended(0x1F), &[0x5A]), Stamps::Off, "T0000001F15A\r"),
            (Frame::remote(Id::Standard(0x701), 1).unwrap(), Stamps::Off, "r7011\r"),
            (Frame::remote(Id::Extended(1), 8).unwrap(), Stamps::Off, "R000000018\r"),
        ] {
            assert_eq!(write(at, &frame, stamps), line);
        }
    }
}
