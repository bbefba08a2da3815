//! The socketcand protocol in raw mode: `< frame … >` and `< send … >` over TCP.
//!
//! A session is one node of the bus. The protocol has no word for the bit rate, because on the
//! computer where socketcand runs somebody set it before: `can0` works at the rate of the devices,
//! and `can0@500000` at another one. A message of the protocol that is not offered here (the
//! broadcast manager, statistics) is refused by an error message.

use world::can::{Bus, Frame, Id, Nanos, Rate, Role};

use crate::hex;
use crate::node::Attachment;

/// What a client is told when it connects.
pub const GREETING: &[u8] = b"< hi >";

/// Longest message of a client, brackets included. The longest `send` of 8 bytes has 42.
pub const MESSAGE_MAX: usize = 256;

/// The name of the virtual bus.
pub const BUS_NAME: &str = "can0";

/// `CAN_ERR_FLAG | CAN_ERR_PROT | CAN_ERR_BUSERROR` of the kernel, without the flag.
const BUS_ERROR_CLASS: u32 = 0x088;

/// What a client can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Message {
    /// `open`: join the bus.
    Open(Rate),
    /// `rawmode`: hand over every frame from now on.
    RawMode,
    /// `echo`: say the same.
    Echo,
    /// `send`.
    Send(Frame),
}

/// Why a message was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// Nobody knows such a message, or not in this form.
    Unknown,
    /// The identifier, the length and the bytes of a `send` make no frame.
    NoFrame,
    /// There is no such bus.
    NoSuchBus,
    /// More than the bound.
    TooLong,
    /// It makes no sense before, or after, `open` and `rawmode`.
    OutOfOrder,
    /// As many frames are waiting as may.
    QueueFull,
}

impl Refusal {
    const fn text(self) -> &'static str {
        match self {
            Self::Unknown => "unknown command",
            Self::NoFrame => "that is no CAN frame",
            Self::NoSuchBus => "could not open bus",
            Self::TooLong => "message too long",
            Self::OutOfOrder => "not in this state",
            Self::QueueFull => "too many frames are waiting",
        }
    }

    fn answer(self) -> Vec<u8> {
        format!("< error {} >", self.text()).into_bytes()
    }
}

impl Message {
    /// Reads a message, without its brackets.
    ///
    /// # Errors
    /// When it is not one this protocol has, or names something that does not exist.
    pub fn parse(text: &[u8]) -> Result<Self, Refusal> {
        let text = std::str::from_utf8(text).map_err(|_| Refusal::Unknown)?;
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words.as_slice() {
            ["open", bus] => open(bus),
            ["rawmode"] => Ok(Self::RawMode),
            ["echo"] => Ok(Self::Echo),
            ["send", id, len, bytes @ ..] => send(id, len, bytes).ok_or(Refusal::NoFrame),
            _ => Err(Refusal::Unknown),
        }
    }
}

fn open(bus: &str) -> Result<Message, Refusal> {
    let rate = match bus.strip_prefix(BUS_NAME) {
        Some("") => Rate::Automatic,
        Some(rate) => {
            let rate = rate.strip_prefix('@').and_then(|rate| rate.parse().ok());
            Rate::Fixed(rate.filter(|&rate| rate > 0).ok_or(Refusal::NoSuchBus)?)
        }
        None => return Err(Refusal::NoSuchBus),
    };
    Ok(Message::Open(rate))
}

/// Identifiers come as socketcand takes them, 3 or 8 digits telling 11 bits from 29, or with the
/// flags of the kernel's `can_id` as some clients send them.
fn send(id: &str, len: &str, bytes: &[&str]) -> Option<Message> {
    const EXTENDED_FLAG: u32 = 1 << 31;
    const REMOTE_FLAG: u32 = 1 << 30;
    const ERROR_FLAG: u32 = 1 << 29;
    const FLAGS: u32 = EXTENDED_FLAG | REMOTE_FLAG | ERROR_FLAG;
    const EXTENDED_DIGITS: usize = 8;
    let word = hex::number(id.as_bytes())?;
    if word & ERROR_FLAG != 0 {
        return None;
    }
    let extended =
        if word & FLAGS == 0 { id.len() == EXTENDED_DIGITS } else { word & EXTENDED_FLAG != 0 };
    let number = word & !FLAGS;
    let id = if extended { Id::Extended(number) } else { Id::Standard(number.try_into().ok()?) };
    let dlc = u8::try_from(hex::number(len.as_bytes())?).ok()?;
    if word & REMOTE_FLAG != 0 {
        return bytes.is_empty().then(|| Frame::remote(id, dlc).ok())?.map(Message::Send);
    }
    if bytes.len() != usize::from(dlc) {
        return None;
    }
    let byte = |text: &&str| u8::try_from(hex::number(text.as_bytes())?).ok();
    let data: Vec<u8> = bytes.iter().map(byte).collect::<Option<_>>()?;
    Frame::new(id, &data).ok().map(Message::Send)
}

/// One client.
#[derive(Debug, Default)]
pub struct Session {
    brackets: Brackets,
    state: State,
}

#[derive(Debug, Default)]
enum State {
    #[default]
    NoBus,
    Opened(Attachment),
    Raw(Attachment),
}

impl Session {
    /// Takes bytes of the client; returns the answers to the messages they complete.
    pub fn handle(&mut self, bus: &mut Bus, bytes: &[u8]) -> Vec<u8> {
        let mut answers = Vec::new();
        for message in self.brackets.push(bytes) {
            let done = message
                .and_then(|text| Message::parse(&text))
                .and_then(|message| self.execute(bus, message));
            answers.extend(done.unwrap_or_else(Refusal::answer));
        }
        answers
    }

    /// What the bus has for the client.
    ///
    /// Remote frames are left out: the protocol can not express them.
    pub fn poll(&mut self, bus: &mut Bus) -> Vec<u8> {
        let mut messages = Vec::new();
        let State::Raw(node) = &mut self.state else { return messages };
        while let Some((at, frame)) = node.receive(bus) {
            if !frame.is_remote() {
                messages.extend(received(at, &frame).into_bytes());
            }
        }
        if node.new_errors(bus) > 0 {
            let now = bus.now();
            messages.extend(format!("< error {BUS_ERROR_CLASS:03X} {} >", stamp(now)).into_bytes());
        }
        messages
    }

    /// Takes the client off the bus, when it is gone.
    pub fn leave(&mut self, bus: &mut Bus) {
        match std::mem::take(&mut self.state) {
            State::NoBus => {}
            State::Opened(node) | State::Raw(node) => node.detach(bus),
        }
    }

    fn execute(&mut self, bus: &mut Bus, message: Message) -> Result<Vec<u8>, Refusal> {
        const DONE: &[u8] = b"< ok >";
        match (message, std::mem::take(&mut self.state)) {
            (Message::Echo, state) => {
                self.state = state;
                Ok(b"< echo >".to_vec())
            }
            (Message::Open(rate), State::NoBus) => {
                self.state = State::Opened(Attachment::attach(bus, rate, Role::Normal));
                Ok(DONE.to_vec())
            }
            (Message::RawMode, State::Opened(node)) => {
                self.state = State::Raw(node);
                Ok(DONE.to_vec())
            }
            (Message::Send(frame), State::Raw(node)) => {
                let sent = node.send(bus, frame);
                self.state = State::Raw(node);
                sent.map(|()| Vec::new()).map_err(|_| Refusal::QueueFull)
            }
            (Message::Open(_) | Message::RawMode | Message::Send(_), state) => {
                self.state = state;
                Err(Refusal::OutOfOrder)
            }
        }
    }
}

fn received(at: Nanos, frame: &Frame) -> String {
    let data = hex::upper(frame.data());
    match frame.id() {
        Id::Standard(id) => format!("< frame {id:03X} {} {data} >", stamp(at)),
        Id::Extended(id) => format!("< frame {id:08X} {} {data} >", stamp(at)),
    }
}

/// Seconds, with microseconds.
fn stamp(at: Nanos) -> String {
    let us = at.instant().as_micros();
    format!("{}.{:06}", us / 1_000_000, us % 1_000_000)
}

/// Finds messages in a stream: everything from a `<` to the next `>`. What is between messages is
/// white space, and not looked at.
#[derive(Debug, Default)]
struct Brackets {
    inside: Option<Vec<u8>>,
}

impl Brackets {
    fn push(&mut self, bytes: &[u8]) -> Vec<Result<Vec<u8>, Refusal>> {
        let mut messages = Vec::new();
        for &byte in bytes {
            match (byte, &mut self.inside) {
                (b'<', inside) => *inside = Some(Vec::new()),
                (b'>', inside) => messages.extend(inside.take().map(Ok)),
                (_, Some(text)) if text.len() + 2 == MESSAGE_MAX => {
                    self.inside = None;
                    messages.push(Err(Refusal::TooLong));
                }
                (byte, Some(text)) => text.push(byte),
                (_, None) => {}
            }
        }
        messages
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_understood_as_clients_write_them() {
        let data = |id, data: &[u8]| Ok(Message::Send(Frame::new(id, data).unwrap()));
        let remote = |id, dlc| Ok(Message::Send(Frame::remote(id, dlc).unwrap()));
        for (text, expected) in [
            (" open can0 ", Ok(Message::Open(Rate::Automatic))),
            ("open can0@500000", Ok(Message::Open(Rate::Fixed(500_000)))),
            ("open can1", Err(Refusal::NoSuchBus)),
            ("open can0@", Err(Refusal::NoSuchBus)),
            ("open can0@0", Err(Refusal::NoSuchBus)),
            ("open vcan0", Err(Refusal::NoSuchBus)),
            ("rawmode", Ok(Message::RawMode)),
            ("echo", Ok(Message::Echo)),
            (" send 000 2 1 7f ", data(Id::Standard(0), &[1, 0x7F])),
            (" send 080 0  ", data(Id::Standard(0x80), &[])),
            ("send 7E5 1 AB", data(Id::Standard(0x7E5), &[0xAB])),
            ("send 0000007E 1 AB", data(Id::Extended(0x7E), &[0xAB])),
            ("send 8000007E 1 AB", data(Id::Extended(0x7E), &[0xAB])),
            ("send 40000701 1", remote(Id::Standard(0x701), 1)),
            ("send C0000701 8", remote(Id::Extended(0x701), 8)),
            ("send 800 0", Err(Refusal::NoFrame)),
            ("send 20000000 0", Err(Refusal::NoFrame)),
            ("send 7E5 2 AB", Err(Refusal::NoFrame)),
            ("send 7E5 9 1 2 3 4 5 6 7 8 9", Err(Refusal::NoFrame)),
            ("send 7E5 1 ABC", Err(Refusal::NoFrame)),
            ("send 7E5 1 G", Err(Refusal::NoFrame)),
            ("send 7E5", Err(Refusal::Unknown)),
            ("bcmmode", Err(Refusal::Unknown)),
            ("", Err(Refusal::Unknown)),
            ("open", Err(Refusal::Unknown)),
            ("\u{fffd}", Err(Refusal::Unknown)),
        ] {
            assert_eq!(Message::parse(text.as_bytes()), expected, "{text:?}");
        }
    }

    #[test]
    fn messages_are_found_wherever_the_stream_is_cut() {
        let text = |text: &str| Ok(text.as_bytes().to_vec());
        for (chunks, expected) in [
            (&["< echo >"][..], vec![text(" echo ")]),
            (&["< ec", "ho", " >< echo >\n"], vec![text(" echo "), text(" echo ")]),
            (&["noise > < a >"], vec![text(" a ")]),
            (&["< lost < a >"], vec![text(" a ")]),
        ] {
            let mut brackets = Brackets::default();
            let found: Vec<_> = chunks.iter().flat_map(|c| brackets.push(c.as_bytes())).collect();
            assert_eq!(found, expected, "{chunks:?}");
        }
        let long = format!("<{}><ok>", "x".repeat(MESSAGE_MAX));
        assert_eq!(Brackets::default().push(long.as_bytes()), [Err(Refusal::TooLong), text("ok")]);
    }

    #[test]
    fn received_frames_are_written_as_python_can_reads_them() {
        let at = Nanos(23_424_242_999);
        for (id, data, message) in [
            (Id::Standard(0x123), &[0x11, 0xA2][..], "< frame 123 23.424242 11A2 >"),
            (Id::Standard(0x001), &[], "< frame 001 23.424242  >"),
            (Id::Extended(0x123), &[0x11], "< frame 00000123 23.424242 11 >"),
        ] {
            assert_eq!(received(at, &Frame::new(id, data).unwrap()), message);
        }
    }
}
