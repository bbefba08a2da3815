//! SDO transfers of several messages as clients meet them.
#![expect(
    clippy::cast_possible_truncation,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a test that meets what it does not expect has to fail"
)]

mod client;
mod download;
mod lengths;
mod upload;

use canopen::{Application, BlockTransfer, CanId, Frame, Node, NodeId, Settings, WriteError};
use object_dictionary::{Object, Row, Slot};
use units::{Duration, Instant};

const HEARTBEAT: Object<u16> = Object::new(0x1017, 0, "Heartbeat time").read_write();
const NAME: Object<[u8; 32]> = Object::new(0x2007, 0, "Name").read_write();
const LOG: Object<[u8; 255]> = Object::new(0x2008, 0, "Log");
const NOTE: Object<[u8; 20]> = Object::new(0x2009, 0, "Note").read_write();
const COMMAND: Object<u8> = Object::new(0x200A, 0, "Command").write_only().within(0, 1);

object_dictionary::product! { pub(crate) HEARTBEAT, NAME, LOG, NOTE, COMMAND }

const SDO_REQUEST: u16 = 0x605;
const SDO_RESPONSE: u16 = 0x585;

/// The texts behind the dictionary.
#[derive(Default)]
struct Texts {
    name: Vec<u8>,
    log: Vec<u8>,
    note: Vec<u8>,
}

impl Application for Texts {
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Served;

    fn text(&self, _slot: Slot, row: &Row) -> Option<&[u8]> {
        match row.id() {
            id if id == NAME.id() => Some(&self.name),
            id if id == LOG.id() => Some(&self.log),
            _ => Some(&self.note),
        }
    }

    fn write_text(&mut self, _slot: Slot, row: &Row, text: &[u8]) -> Result<(), WriteError> {
        let place = if row.id() == NAME.id() { &mut self.name } else { &mut self.note };
        *place = text.to_vec();
        Ok(())
    }
}

/// A node that serves block transfers, and the texts behind it.
struct Server {
    node: Node<LEN>,
    texts: Texts,
    now: Instant,
}

impl Server {
    fn new() -> Self {
        let now = Instant::ZERO;
        let mut node = Node::new(&DICTIONARY, NodeId::new(5).unwrap(), &Settings::CIA_301);
        node.boot(now);
        while node.take_transmit().is_some() {}
        Self { node, texts: Texts::default(), now }
    }

    /// Sends the bytes of a request; the answers to it.
    fn ask(&mut self, request: [u8; 8]) -> Vec<[u8; 8]> {
        let frame = Frame::full(CanId::new(SDO_REQUEST).unwrap(), request);
        self.node.handle_frame(self.now, &frame, &mut self.texts);
        let answers = self.answers();
        self.node.handle_timeout(self.now, &mut self.texts);
        answers
    }

    fn answers(&mut self) -> Vec<[u8; 8]> {
        let frames = std::iter::from_fn(|| self.node.take_transmit());
        frames
            .filter(|frame| frame.id().get() == SDO_RESPONSE)
            .map(|frame| {
                assert_eq!(frame.dlc(), 8);
                frame.data().try_into().unwrap()
            })
            .collect()
    }

    /// What it says in so many milliseconds without a request.
    fn answers_in(&mut self, ms: u64) -> Vec<[u8; 8]> {
        self.now = self.now + Duration::from_millis(ms);
        self.node.handle_timeout(self.now, &mut self.texts);
        self.answers()
    }

    /// The one answer to a request.
    fn answer(&mut self, request: [u8; 8]) -> [u8; 8] {
        let answers = self.ask(request);
        let [answer] = answers[..] else { panic!("{answers:02X?} to {request:02X?}") };
        answer
    }
}

/// The abort of a transfer of this object.
fn abort(object: u16, code: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (object.to_le_bytes(), code.to_le_bytes());
    [0x80, low, high, 0, a, b, c, d]
}
