use std::collections::VecDeque;
use std::io::{BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};

use crate::ANSWER_TIME_MAX;

/// A CAN adapter behind the gateway (LAWICEL ASCII over TCP).
pub struct Slcan {
    out: TcpStream,
    input: BufReader<TcpStream>,
    frames: VecDeque<Frame>,
}

/// A data frame with an 11-bit identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// 0..=0x7FF.
    pub id: u16,
    /// 0..=8 bytes.
    pub data: Vec<u8>,
}

/// What ends a command and an answer.
const OK: u8 = b'\r';
/// The answer to a command that was refused.
const BELL: u8 = 7;

impl Slcan {
    /// An adapter at `address` with its channel closed.
    ///
    /// # Panics
    /// If nobody listens there.
    #[must_use]
    pub fn connect(address: SocketAddr) -> Self {
        let out = TcpStream::connect(address).expect("the gateway listens");
        out.set_read_timeout(Some(ANSWER_TIME_MAX)).expect("a time above zero");
        out.set_nodelay(true).expect("an open socket");
        let input = BufReader::new(out.try_clone().expect("an open socket"));
        Self { out, input, frames: VecDeque::new() }
    }

    /// Opens the channel at the bit rate of the command `Sn`: 4 is 125 kbit/s.
    ///
    /// # Panics
    /// If the adapter refuses.
    pub fn open(&mut self, rate: u8) {
        for command in [format!("S{rate}"), "O".to_owned()] {
            assert!(self.command(&command), "{command} was refused");
        }
    }

    /// Sends a command line and tells whether it was accepted. Frames that come in between are kept.
    ///
    /// # Panics
    /// If the gateway is gone.
    pub fn command(&mut self, line: &str) -> bool {
        self.out.write_all(format!("{line}\r").as_bytes()).expect("the gateway is up");
        loop {
            match self.answer() {
                Answer::Refused => return false,
                Answer::Line(text) => match frame_in(&text) {
                    Some(frame) => self.frames.push_back(frame),
                    None => return true,
                },
            }
        }
    }

    /// Sends a frame.
    ///
    /// # Panics
    /// If the adapter refuses it.
    pub fn send(&mut self, id: u16, data: &[u8]) {
        let hex: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
        assert!(self.command(&format!("t{id:03X}{}{hex}", data.len())), "{id:#x} was refused");
    }

    /// The next frame from the bus; waits for it.
    ///
    /// # Panics
    /// If none comes.
    pub fn receive(&mut self) -> Frame {
        loop {
            if let Some(frame) = self.frames.pop_front() {
                return frame;
            }
            if let Answer::Line(text) = self.answer() {
                self.frames.extend(frame_in(&text));
            }
        }
    }

    fn answer(&mut self) -> Answer {
        let mut text = String::new();
        loop {
            let mut byte = [0];
            self.input.read_exact(&mut byte).expect("the gateway answers");
            match byte {
                [OK] => return Answer::Line(text),
                [BELL] => return Answer::Refused,
                [other] => text.push(char::from(other)),
            }
        }
    }
}

enum Answer {
    Line(String),
    Refused,
}

/// `tIIILDD…`, with or without a time stamp behind it.
fn frame_in(line: &str) -> Option<Frame> {
    let rest = line.strip_prefix('t')?;
    let (id, rest) = rest.split_at_checked(3)?;
    let (len, rest) = rest.split_at_checked(1)?;
    let len: usize = len.parse().ok()?;
    let data = (0..len).map(|i| u8::from_str_radix(rest.get(2 * i..2 * i + 2)?, 16).ok());
    Some(Frame { id: u16::from_str_radix(id, 16).ok()?, data: data.collect::<Option<_>>()? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_told_from_answers() {
        let frame = |id, data: &[u8]| Some(Frame { id, data: data.to_vec() });
        for (line, expected) in [
            ("t77F100", frame(0x77F, &[0])),
            ("t0000", frame(0, &[])),
            ("t12330102031234", frame(0x123, &[1, 2, 3])),
            ("z", None),
            ("", None),
            ("t12", None),
            ("t12321", None),
            ("r1230", None),
        ] {
            assert_eq!(frame_in(line), expected, "{line}");
        }
    }
}
