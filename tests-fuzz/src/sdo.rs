//! An SDO client that asks anything, and a model that says what the server has to answer.

mod model;

use canopen::{
    Application, BlockTransfer, CanId, Frame, Node, NodeId, ReadError, Settings, WriteError,
    Written,
};
use object_dictionary::{Object, ObjectId, Row, Slot};
use units::{Duration, Instant};

use crate::bytes::Bytes;
use crate::device;
use model::{Answer, Entry, Kind, Limits, Model, Refusal, Rights};

const DEVICE_TYPE: Object<u32> = Object::new(0x1000, 0, "Device type").default(0x0003_0191);
const BYTE: Object<u8> = Object::new(0x2000, 0, "Byte").read_write();
const WORD: Object<u16> = Object::new(0x2001, 0, "Word").read_write().within(0, 9_999);
const LONG: Object<u32> = Object::new(0x2002, 0, "Long")
    .read_write()
    .within(5, 300)
    .or_within(&[(1_000, 2_000)])
    .default(5);
const SIGNED_BYTE: Object<i8> = Object::new(0x2003, 0, "Signed byte").read_write().within(-5, 5);
const SIGNED_WORD: Object<i16> =
    Object::new(0x2004, 0, "Signed word").read_write().within(-9_999, 9_999);
const SIGNED_LONG: Object<i32> = Object::new(0x2005, 0, "Signed long").read_write();
const COMMAND: Object<u16> = Object::new(0x2006, 0, "Command").write_only();
const COUNT: Object<u8> = Object::new(0x2007, 0, "Highest sub-index").default(3);
const FIRST: Object<u8> = Object::new(0x2007, 1, "First").read_write();
const THIRD: Object<u16> = Object::new(0x2007, 3, "Third").read_write();
const TEXT_1: Object<[u8; 1]> = Object::new(0x2010, 0, "Text").read_write();
const TEXT_4: Object<[u8; 4]> = Object::new(0x2010, 1, "Text").read_write();
const TEXT_5: Object<[u8; 5]> = Object::new(0x2010, 2, "Text").read_write();
const TEXT_7: Object<[u8; 7]> = Object::new(0x2010, 3, "Text").read_write();
const TEXT_8: Object<[u8; 8]> = Object::new(0x2010, 4, "Text").read_write();
const TEXT_14: Object<[u8; 14]> = Object::new(0x2010, 5, "Text").read_write();
const TEXT_32: Object<[u8; 32]> = Object::new(0x2010, 6, "Text").read_write();
const TEXT_64: Object<[u8; 64]> = Object::new(0x2010, 7, "Text").read_write();
const LOG: Object<[u8; 255]> = Object::new(0x2011, 0, "Log");
const SECRET: Object<[u8; 9]> = Object::new(0x2012, 0, "Secret").write_only();

object_dictionary::product! {
    pub(crate)
    DEVICE_TYPE, BYTE, WORD, LONG, SIGNED_BYTE, SIGNED_WORD, SIGNED_LONG, COMMAND, COUNT, FIRST,
    THIRD, TEXT_1, TEXT_4, TEXT_5, TEXT_7, TEXT_8, TEXT_14, TEXT_32, TEXT_64, LOG, SECRET,
}

/// The same device once more, as the client knows it.
#[rustfmt::skip]
const ENTRIES: [Entry; LEN] = [
    Entry { object: (0x1000, 0), kind: Kind::Unsigned(4), rights: Rights::Read, limits: Limits::None },
    Entry { object: (0x2000, 0), kind: Kind::Unsigned(1), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2001, 0), kind: Kind::Unsigned(2), rights: Rights::Both, limits: Limits::One(0, 9_999) },
    Entry { object: (0x2002, 0), kind: Kind::Unsigned(4), rights: Rights::Both, limits: Limits::Two((5, 300), (1_000, 2_000)) },
    Entry { object: (0x2003, 0), kind: Kind::Signed(1), rights: Rights::Both, limits: Limits::One(-5, 5) },
    Entry { object: (0x2004, 0), kind: Kind::Signed(2), rights: Rights::Both, limits: Limits::One(-9_999, 9_999) },
    Entry { object: (0x2005, 0), kind: Kind::Signed(4), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2006, 0), kind: Kind::Unsigned(2), rights: Rights::Write, limits: Limits::None },
    Entry { object: (0x2007, 0), kind: Kind::Unsigned(1), rights: Rights::Read, limits: Limits::None },
    Entry { object: (0x2007, 1), kind: Kind::Unsigned(1), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2007, 3), kind: Kind::Unsigned(2), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 0), kind: Kind::Text(1), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 1), kind: Kind::Text(4), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 2), kind: Kind::Text(5), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 3), kind: Kind::Text(7), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 4), kind: Kind::Text(8), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 5), kind: Kind::Text(14), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 6), kind: Kind::Text(32), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2010, 7), kind: Kind::Text(64), rights: Rights::Both, limits: Limits::None },
    Entry { object: (0x2011, 0), kind: Kind::Text(255), rights: Rights::Read, limits: Limits::None },
    Entry { object: (0x2012, 0), kind: Kind::Text(9), rights: Rights::Write, limits: Limits::None },
];

const NODE_ID: NodeId = NodeId::new(5).expect("5 is a node-ID");
const REQUEST: CanId = CanId::new(0x605).expect("11 bits");
const RESPONSE: u16 = 0x585;

/// Lets a client ask what `input` says.
pub fn converse(input: &[u8]) {
    let mut bytes = Bytes::new(input);
    let Some(settings) = bytes.pick(&[&Settings::CIA_301, &device::SETTINGS]) else { return };
    let mut talk = Talk::new(settings);
    while talk.next(&mut bytes).is_some() {}
}

/// The product: texts, and its mood.
struct Product {
    texts: Vec<Vec<u8>>,
    refusal: Option<Refusal>,
}

impl Application for Product {
    const BLOCK_TRANSFER: BlockTransfer = BlockTransfer::Served;

    fn read(&mut self, _slot: Slot, _row: &Row) -> Result<(), ReadError> {
        match self.refusal {
            Some(Refusal::Read(error)) => Err(error),
            Some(Refusal::Write(_) | Refusal::Silently) | None => Ok(()),
        }
    }

    fn text(&self, slot: Slot, _row: &Row) -> Option<&[u8]> {
        self.texts.get(usize::from(slot.position())).map(Vec::as_slice)
    }

    fn write(&mut self, _slot: Slot, _row: &Row, _raw: u32) -> Result<Written, WriteError> {
        match self.refusal {
            Some(Refusal::Write(error)) => Err(error),
            Some(Refusal::Silently) => Ok(Written::Ignored),
            Some(Refusal::Read(_)) | None => Ok(Written::Taken),
        }
    }

    fn write_text(&mut self, slot: Slot, _row: &Row, text: &[u8]) -> Result<(), WriteError> {
        match self.refusal {
            Some(Refusal::Write(error)) => return Err(error),
            Some(Refusal::Silently | Refusal::Read(_)) | None => {}
        }
        self.texts[usize::from(slot.position())] = text.to_vec();
        Ok(())
    }
}

struct Talk {
    node: Node<LEN>,
    product: Product,
    model: Model,
    now: Instant,
}

impl Talk {
    fn new(settings: &'static Settings) -> Self {
        let now = Instant::ZERO;
        let mut node = Node::new(&DICTIONARY, NODE_ID, settings);
        node.boot(now);
        while node.take_transmit().is_some() {}
        let text = |entry: &Entry| match entry.kind {
            Kind::Unsigned(_) | Kind::Signed(_) => Vec::new(),
            Kind::Text(len) => (0..len).map(|at| at.wrapping_mul(3)).collect(),
        };
        let mut values: Vec<Vec<u8>> = ENTRIES.iter().map(text).collect();
        let product = Product { texts: values.clone(), refusal: None };
        for (entry, value) in ENTRIES.iter().zip(&mut values) {
            match (entry.kind, entry.object) {
                (Kind::Unsigned(_) | Kind::Signed(_), (0x1000, 0)) => {
                    *value = 0x0003_0191_u32.to_le_bytes().to_vec();
                }
                (Kind::Unsigned(len), (0x2002, 0)) => {
                    value.resize(usize::from(len), 0);
                    value[0] = 5;
                }
                (Kind::Unsigned(_), (0x2007, 0)) => *value = vec![3],
                (Kind::Unsigned(len) | Kind::Signed(len), _) => value.resize(usize::from(len), 0),
                (Kind::Text(_), _) => {}
            }
        }
        Self { node, product, model: Model::new(&ENTRIES, values, settings), now }
    }

    /// Lets one thing happen. `None` at the end of the input.
    fn next(&mut self, bytes: &mut Bytes<'_>) -> Option<()> {
        match bytes.u8()? % 16 {
            0..=7 => {
                let request = self.whole(bytes)?;
                self.ask(&request);
            }
            // What a client would say next, to get further than chance does.
            8..=11 => {
                let request = self.model.continuation(bytes.array()?);
                self.ask(&request);
            }
            12 => self.ask(bytes.up_to(8)?),
            13 => self.wait(Duration::from_millis(u64::from(bytes.u8()?) * 8)),
            14 => {
                self.product.refusal = bytes.pick(&[
                    None,
                    None,
                    None,
                    Some(Refusal::Silently),
                    Some(Refusal::Read(ReadError::NoData)),
                    Some(Refusal::Read(ReadError::Hardware)),
                    Some(Refusal::Read(ReadError::DeviceState)),
                    Some(Refusal::Read(ReadError::Failed)),
                    Some(Refusal::Write(WriteError::ValueRange)),
                    Some(Refusal::Write(WriteError::NotStored)),
                    Some(Refusal::Write(WriteError::Hardware)),
                    Some(Refusal::Write(WriteError::DeviceState)),
                    Some(Refusal::Write(WriteError::Failed)),
                ])?;
            }
            _ => self.stop(),
        }
        Some(())
    }

    fn whole(&self, bytes: &mut Bytes<'_>) -> Option<Vec<u8>> {
        let any = bytes.u8()?;
        let command = bytes.pick(&[
            0x40, 0x40, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x20, 0x21, 0x21, 0x60, 0x70, 0x80, 0xA0,
            0xA4, 0xA1, 0xA2, 0xA3, 0xC0, 0xC2, 0xC4, 0xC6, 0xC1, any,
        ])?;
        let (index, sub) = match any {
            0..=7 => (0x2007 + u16::from(any), any),
            _ => ENTRIES[usize::from(any) % ENTRIES.len()].object,
        };
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), bytes.array()?);
        let value = match (command, bytes.u8()? % 8) {
            (0x21 | 0xC2 | 0xC6, size @ 0..=5) => {
                [self.model.len(index, sub).saturating_add(size / 5), 0, 0, 0]
            }
            (0xA0 | 0xA4, 0..=6) => [a % 128, if b & 1 == 0 { 0 } else { b }, c, d],
            (_, 0..=1) => [a, 0, 0, 0],
            (_, 2) => [a, b, 0, 0],
            (_, 3) => [a, 0xFF, 0xFF, 0xFF],
            _ => [a, b, c, d],
        };
        Some([[command, low, high, sub], value].concat())
    }

    fn ask(&mut self, request: &[u8]) {
        let frame = Frame::new(REQUEST, request).unwrap();
        self.node.handle_frame(self.now, &frame, &mut self.product);
        let expected = self.model.ask(self.now, request, self.product.refusal);
        self.compare(&expected, format_args!("{request:02X?}"));
    }

    fn wait(&mut self, span: Duration) {
        if let Some(until) = self.model.until() {
            assert!(self.node.poll_timeout().is_some_and(|due_at| due_at <= until), "too late");
        }
        self.now = self.now + span;
        self.node.handle_timeout(self.now, &mut self.product);
        let expected = self.model.wait(self.now);
        self.compare(&expected, format_args!("the time"));
    }

    /// Stopped and back: the transfer in progress is forgotten.
    fn stop(&mut self) {
        for command in [2, 128] {
            let frame = Frame::new(CanId::new(0).unwrap(), &[command, 0]).unwrap();
            self.node.handle_frame(self.now, &frame, &mut self.product);
        }
        self.model.stop();
        self.compare(&Answer::NONE, format_args!("a stop"));
    }

    fn compare(&mut self, expected: &Answer, to: std::fmt::Arguments<'_>) {
        while self.node.poll_event().is_some() {}
        let frames = std::iter::from_fn(|| self.node.take_transmit());
        let answers: Vec<Vec<u8>> = frames
            .inspect(|frame| assert_eq!(frame.id().get(), RESPONSE))
            .map(|frame| frame.data().to_vec())
            .collect();
        assert_eq!(answers, expected.frames, "to {to}");
        for (entry, value) in ENTRIES.iter().zip(self.model.values()) {
            let (index, sub) = entry.object;
            let slot = DICTIONARY.find(ObjectId { index, sub }).unwrap();
            let found = match entry.kind {
                Kind::Text(_) => self.product.texts[usize::from(slot.position())].clone(),
                Kind::Unsigned(len) | Kind::Signed(len) => {
                    self.node.values().raw(slot).to_le_bytes()[..usize::from(len)].to_vec()
                }
            };
            assert_eq!(&found, value, "{index:04X}:{sub:02X} after {to}");
        }
    }
}
