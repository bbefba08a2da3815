//! Values of every length, in segments and in blocks.

use canopen::{Application, BlockTransfer, CanId, Frame, Node, NodeId, Settings, WriteError};
use object_dictionary::{Dictionary, Object, Row, Slot, row};
use units::Instant;

use crate::SDO_REQUEST;
use crate::client::{checksum, end, segments};

/// A text of `LEN` bytes at the sub-index `LEN`.
const fn text<const LEN: usize>() -> Row {
    row!(Object::<[u8; LEN]>::new(0x2000, LEN as u8, "Text").read_write())
}

macro_rules! texts {
    ($($len:literal)+) => { [$(text::<$len>()),+] };
}

/// Sub-index 1 has one byte, sub-index 2 two, and so on.
const ROWS: &[Row] = &texts! {
    1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
    33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63 64
};

const LEN_MAX: u8 = ROWS.len() as u8;

static DICTIONARY: Dictionary = object_dictionary::dictionary!(ROWS);

/// The texts by their lengths.
struct Store {
    texts: Vec<Vec<u8>>,
}

impl Application for Store {
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Served;

    fn text(&self, slot: Slot, _row: &Row) -> Option<&[u8]> {
        self.texts.get(usize::from(slot.position())).map(Vec::as_slice)
    }

    fn write_text(&mut self, slot: Slot, _row: &Row, text: &[u8]) -> Result<(), WriteError> {
        self.texts[usize::from(slot.position())] = text.to_vec();
        Ok(())
    }
}

struct Server {
    node: Node<{ LEN_MAX as usize }>,
    store: Store,
}

impl Server {
    fn new() -> Self {
        let mut node = Node::new(&DICTIONARY, NodeId::new(5).unwrap(), &Settings::CIA_301);
        node.boot(Instant::ZERO);
        while node.take_transmit().is_some() {}
        Self { node, store: Store { texts: vec![Vec::new(); usize::from(LEN_MAX)] } }
    }

    fn ask(&mut self, request: [u8; 8]) -> Vec<[u8; 8]> {
        let frame = Frame::full(CanId::new(SDO_REQUEST).unwrap(), request);
        self.node.handle_frame(Instant::ZERO, &frame, &mut self.store);
        let frames = std::iter::from_fn(|| self.node.take_transmit());
        let answers = frames.map(|frame| frame.data().try_into().unwrap()).collect();
        self.node.handle_timeout(Instant::ZERO, &mut self.store);
        answers
    }

    #[track_caller]
    fn answer(&mut self, request: [u8; 8]) -> [u8; 8] {
        let answers = self.ask(request);
        let [answer] = answers[..] else { panic!("{answers:02X?} to {request:02X?}") };
        answer
    }

    /// Writes a value in segments; the first answer that is an abort ends it.
    fn download(&mut self, len: u8, value: &[u8], begin: [u8; 8]) -> Result<(), u32> {
        failed(self.answer(begin))?;
        let count = value.len().div_ceil(7);
        for (number, chunk) in (1..).zip(value.chunks(7)) {
            let toggle = if number % 2 == 0 { 0x10 } else { 0 };
            let last = u8::from(number == count);
            let answer = self.answer(segment(toggle | (7 - chunk.len() as u8) << 1 | last, chunk));
            failed(answer)?;
            assert_eq!(answer, [0x20 | toggle, 0, 0, 0, 0, 0, 0, 0], "{len} bytes");
        }
        Ok(())
    }

    fn text(&self, len: u8) -> &[u8] {
        &self.store.texts[usize::from(len) - 1]
    }
}

fn failed([command, _, _, _, code @ ..]: [u8; 8]) -> Result<(), u32> {
    if command == 0x80 { Err(u32::from_le_bytes(code)) } else { Ok(()) }
}

fn segment(command: u8, data: &[u8]) -> [u8; 8] {
    let mut frame = [command, 0, 0, 0, 0, 0, 0, 0];
    frame[1..=data.len()].copy_from_slice(data);
    frame
}

fn value(len: u8) -> Vec<u8> {
    (1..=len).map(|byte| byte.wrapping_mul(37)).collect()
}

const LENGTH_MISMATCH: u32 = 0x0607_0010;

/// CiA 301, sections 7.2.4.3.3 and 7.2.4.3.4: with and without the size told before.
#[test]
fn every_length_is_written_in_segments() {
    for len in 1..=LEN_MAX {
        for begin in [[0x21, 0, 0x20, len, len, 0, 0, 0], [0x20, 0, 0x20, len, 0, 0, 0, 0]] {
            let mut server = Server::new();
            assert_eq!(server.download(len, &value(len), begin), Ok(()));
            assert_eq!((server.text(len), server.node.poll_timeout()), (&value(len)[..], None));
        }
    }
}

/// CiA 301, section 7.2.4.3.17: a size that is not the object's, told or sent, writes nothing.
#[test]
fn a_length_that_is_not_the_objects_writes_nothing() {
    for len in 1..=LEN_MAX {
        let untold = [0x20, 0, 0x20, len, 0, 0, 0, 0];
        for wrong in [len - 1, len + 1] {
            let mut server = Server::new();
            let told = [0x21, 0, 0x20, len, wrong, 0, 0, 0];
            assert_eq!(failed(server.answer(told)), Err(LENGTH_MISMATCH), "{wrong} for {len}");
            if wrong > 0 {
                let sent = server.download(len, &value(wrong), untold);
                assert_eq!(sent, Err(LENGTH_MISMATCH), "{wrong} for {len}");
            }
            assert_eq!((server.text(len), server.node.poll_timeout()), (&[][..], None));
        }
    }
}

/// CiA 301, sections 7.2.4.3.6 and 7.2.4.3.7; up to four bytes need no segments.
#[test]
fn every_length_is_read_in_segments() {
    for len in 1..=LEN_MAX {
        let mut server = Server::new();
        server.store.texts[usize::from(len) - 1] = value(len);
        let [command, .., a, b, c, d] = server.answer([0x40, 0, 0x20, len, 0, 0, 0, 0]);
        if len <= 4 {
            assert_eq!(command, 0x43 | (4 - len) << 2);
            assert_eq!([a, b, c, d][..usize::from(len)], value(len));
            continue;
        }
        assert_eq!((command, [a, b, c, d]), (0x41, [len, 0, 0, 0]));
        let mut read = Vec::new();
        let mut toggle = 0;
        loop {
            let [command, data @ ..] = server.answer([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
            assert_eq!(command & 0x10, toggle);
            read.extend(&data[..7 - usize::from(command >> 1 & 7)]);
            toggle ^= 0x10;
            if command & 1 != 0 {
                break;
            }
        }
        assert_eq!((read, server.node.poll_timeout()), (value(len), None));
    }
}

/// CiA 301, section 7.2.4.3.17: a toggle bit that does not alternate ends the transfer, whichever
/// segment has it.
#[test]
fn a_wrong_toggle_ends_the_transfer_at_every_segment() {
    const TOGGLE: u32 = 0x0503_0000;
    for right in 0..LEN_MAX.div_ceil(7) {
        let mut server = Server::new();
        server.store.texts[usize::from(LEN_MAX) - 1] = value(LEN_MAX);
        server.answer([0x40, 0, 0x20, LEN_MAX, 0, 0, 0, 0]);
        let toggle = |number: u8| number % 2 * 0x10;
        for number in 0..right {
            server.answer([0x60 | toggle(number), 0, 0, 0, 0, 0, 0, 0]);
        }
        let wrong = server.answer([0x60 | toggle(right + 1), 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(failed(wrong), Err(TOGGLE), "segment {right}");
        server.answer([0x21, 0, 0x20, LEN_MAX, LEN_MAX, 0, 0, 0]);
        for number in 0..right {
            server.answer(segment(toggle(number), &[1; 7]));
        }
        let wrong = server.answer(segment(toggle(right + 1), &[1; 7]));
        assert_eq!(failed(wrong), Err(TOGGLE), "segment {right}");
        assert_eq!((server.text(LEN_MAX), server.node.poll_timeout()), (&value(LEN_MAX)[..], None));
    }
}

/// CiA 301, sections 7.2.4.3.9 to 7.2.4.3.16: every length in blocks both ways.
#[test]
fn every_length_is_written_and_read_in_blocks() {
    for len in 1..=LEN_MAX {
        let mut server = Server::new();
        let begin = [0xC6, 0, 0x20, len, len, 0, 0, 0];
        let frames = segments(&value(len));
        assert_eq!(server.answer(begin), [0xA4, 0, 0x20, len, len / 7 + 1, 0, 0, 0]);
        let (last, before) = frames.split_last().unwrap();
        for frame in before {
            assert_eq!(server.ask(*frame), [[0; 8]; 0]);
        }
        assert_eq!(server.answer(*last), [0xA2, frames.len() as u8, 1, 0, 0, 0, 0, 0]);
        assert_eq!(server.answer(end(&value(len))), [0xA1, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(server.text(len), value(len));
        assert_eq!(read_in_blocks(&mut server, len, 127), value(len));
    }
}

/// CiA 301, section 7.2.4.3.15: a client may ask for blocks of any size.
#[test]
fn blocks_have_the_size_that_the_client_asks_for() {
    let mut server = Server::new();
    server.store.texts[usize::from(LEN_MAX) - 1] = value(LEN_MAX);
    for block_len in 1..=127 {
        assert_eq!(read_in_blocks(&mut server, LEN_MAX, block_len), value(LEN_MAX));
    }
}

fn read_in_blocks(server: &mut Server, len: u8, block_len: u8) -> Vec<u8> {
    let begin = [0xA4, 0, 0x20, len, block_len, 0, 0, 0];
    assert_eq!(server.answer(begin), [0xC6, 0, 0x20, len, len, 0, 0, 0]);
    let mut read = Vec::new();
    let mut answers = server.ask([0xA3, 0, 0, 0, 0, 0, 0, 0]);
    loop {
        if let [[command @ 0xC1..=0xDD, crc @ .., 0, 0, 0, 0, 0]] = answers[..] {
            read.truncate(read.len() - usize::from(command >> 2 & 7));
            assert_eq!(crc, checksum(&read).to_le_bytes());
            assert_eq!(server.ask([0xA1, 0, 0, 0, 0, 0, 0, 0]), [[0; 8]; 0]);
            return read;
        }
        let missing = (usize::from(len) - read.len()).div_ceil(7);
        assert_eq!(answers.len(), missing.min(block_len.into()));
        for (number, [command, data @ ..]) in (1..).zip(&answers) {
            assert_eq!(command & 0x7F, number);
            read.extend(data);
        }
        answers = server.ask([0xA2, answers.len() as u8, block_len, 0, 0, 0, 0, 0]);
    }
}
