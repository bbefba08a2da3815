//! A master with one device in front of it: what a conformance test tool has.

use std::fmt::Debug;

use object_dictionary::{Access, Dictionary, ObjectId, Row};
use serde_json::{Value, json};
use tests_host::Bench;

use crate::reference::Reference;

/// What a device lacks.
pub(crate) type Lacking = String;

/// Passed, or why not. What is simply wrong panics.
pub(crate) type Verdict = Result<(), Reason>;

/// Why a case is not passed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reason {
    /// The device can not be asked: it lacks something.
    Lacks(Lacking),
    /// The device does something else, which its manual has to justify ([`Device::deviations`]).
    Deviates(String),
}

impl<T: Into<String>> From<T> for Reason {
    fn from(lacking: T) -> Self {
        Self::Lacks(lacking.into())
    }
}

/// An SDO abort code.
pub(crate) type AbortCode = u32;

/// Long enough for one answer at any of the bit rates in use.
const ANSWER_US_MAX: u64 = 100_000;
const GLANCE_US: u64 = 500;

/// A device under test.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Device {
    /// Name on the command line of the bench.
    pub(crate) product: &'static str,
    /// An engine of the bench, or `process`.
    pub(crate) engine: &'static str,
    pub(crate) node_id: u8,
    pub(crate) dictionary: &'static Dictionary,
    pub(crate) expedited: Expedited,
    /// What a master leaves between two writes of objects from 0x2000 on.
    pub(crate) pause_ms: u64,
    /// Objects whose write is a command, has a condition or reads back as something else.
    pub(crate) commands: &'static [u16],
    /// An object that 0x1010 stores, with a value that is not its default.
    pub(crate) stored: Option<(ObjectId, u32)>,
    /// What lets transmit PDOs answer remote frames: sub-indices with their values.
    pub(crate) remote: Result<&'static [(u8, u32)], &'static str>,
    /// The transmission type that follows changes.
    pub(crate) follows_changes: Result<u32, &'static str>,
    /// What changes the data of transmit PDOs: an object to write, where the mapping is dynamic;
    /// otherwise the shaft.
    pub(crate) output: Option<ObjectId>,
    /// Cases in which the device does what its manual says instead: number and justification.
    pub(crate) deviations: &'static [(&'static str, &'static str)],
}

/// How short values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Expedited {
    /// With their length.
    Indicated,
    /// As four bytes.
    FourBytes,
}

/// A frame from the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Sent {
    pub(crate) us: u64,
    pub(crate) id: u16,
    pub(crate) data: Vec<u8>,
}

/// Where a device runs.
enum Place {
    Bench(Bench),
    /// What is no product.
    Process(Box<Reference>),
}

/// The master.
pub(crate) struct Master {
    place: Place,
    pub(crate) device: Device,
    sent: Vec<Sent>,
}

impl Master {
    /// In front of a device that has just come up.
    pub(crate) fn new(device: Device) -> Self {
        let place = match device.engine {
            "process" => {
                Place::Process(Box::new(Reference::new(device.dictionary, device.node_id)))
            }
            engine => Place::Bench(Bench::step(device.product, &["--engine", engine])),
        };
        let mut master = Self { place, device, sent: Vec::new() };
        master.run_ms(1_000);
        master.sent.clear();
        master
    }

    /// The device as after power-on, in Pre-operational.
    pub(crate) fn restart(&mut self) {
        self.nmt(0x81);
        for _ in 0..50 {
            self.run_ms(100);
            if self.take(0x700).iter().any(|frame| frame.data == [0]) {
                self.run_ms(20);
                self.sent.clear();
                return;
            }
        }
        panic!("the device does not come back");
    }

    /// The identifier of one of its services in the pre-defined connection set.
    pub(crate) fn id(&self, function_code: u16) -> u16 {
        function_code + u16::from(self.device.node_id)
    }

    /// Lets time pass.
    pub(crate) fn run_ms(&mut self, ms: u64) {
        self.run_us(ms * 1_000);
    }

    fn run_us(&mut self, us: u64) {
        let bench = match &mut self.place {
            Place::Process(reference) => {
                reference.advance(us);
                self.sent.extend(reference.take_sent());
                return;
            }
            Place::Bench(bench) => bench,
        };
        bench.advance(us);
        let log = bench.tell("can_log", json!({}));
        let frames = log["frames"].as_array().cloned().unwrap_or_default();
        let number = |value: &Value| value.as_u64().unwrap_or_default();
        for frame in frames.iter().filter(|frame| frame["dir"] == "out") {
            self.sent.push(Sent {
                us: number(&frame["us"]),
                id: u16::try_from(number(&frame["id"])).expect("11 bits"),
                data: bytes(frame["data"].as_str().unwrap_or_default()),
            });
        }
    }

    /// What the device sent in this time.
    pub(crate) fn watch_ms(&mut self, ms: u64) -> Vec<Sent> {
        self.watch(ms, |_| {})
    }

    /// What the device sent while something was done and in the time after it.
    pub(crate) fn watch(&mut self, ms: u64, during: impl FnOnce(&mut Self)) -> Vec<Sent> {
        self.sent.clear();
        during(self);
        self.run_ms(ms);
        std::mem::take(&mut self.sent)
    }

    /// What the device sent with this function code or, above 0x7F of it, this identifier.
    fn take(&mut self, function_code: u16) -> Vec<Sent> {
        let id = self.id(function_code);
        let (taken, rest) = std::mem::take(&mut self.sent).into_iter().partition(|s| s.id == id);
        self.sent = rest;
        taken
    }

    pub(crate) fn send(&mut self, id: u16, data: &[u8]) {
        match &mut self.place {
            Place::Process(reference) => reference.receive(id, Some(data)),
            Place::Bench(bench) => {
                bench.tell("can_send", json!({ "can_id": id, "data": hex(data) }));
            }
        }
    }

    pub(crate) fn send_remote(&mut self, id: u16) {
        match &mut self.place {
            Place::Process(reference) => reference.receive(id, None),
            Place::Bench(bench) => {
                bench.tell("can_send", json!({ "can_id": id, "data": "", "rtr": true }));
            }
        }
    }

    /// A command of the network management to the device.
    pub(crate) fn nmt(&mut self, command: u8) {
        self.send(0, &[command, self.device.node_id]);
        self.run_ms(5);
    }

    /// Something that turns changes at the device.
    pub(crate) fn turn_shaft(&mut self) {
        match &mut self.place {
            Place::Process(_) => panic!("it has no shaft"),
            Place::Bench(bench) => {
                bench.tell("shaft", json!({ "steps": 4_096 }));
            }
        }
    }

    /// A request to the SDO server and its answer.
    pub(crate) fn request(&mut self, bytes: [u8; 8]) -> [u8; 8] {
        self.try_request(bytes).unwrap_or_else(|| panic!("no answer to {bytes:02X?}"))
    }

    /// A request to the SDO server and its answer, if one comes.
    pub(crate) fn try_request(&mut self, bytes: [u8; 8]) -> Option<[u8; 8]> {
        self.take(0x580);
        self.send(self.id(0x600), &bytes);
        self.answer()
    }

    /// The next frame of the SDO server.
    fn answer(&mut self) -> Option<[u8; 8]> {
        for _ in 0..ANSWER_US_MAX / GLANCE_US {
            let id = self.id(0x580);
            if let Some(place) = self.sent.iter().position(|sent| sent.id == id) {
                let answer = self.sent.remove(place);
                return Some(answer.data.try_into().expect("an SDO frame has eight bytes"));
            }
            self.run_us(GLANCE_US);
        }
        None
    }

    /// Reads a value, expedited or in segments as the server has it.
    pub(crate) fn upload(&mut self, object: ObjectId) -> Result<Vec<u8>, AbortCode> {
        let answer = self.request(initiate(0x40, object, [0; 4]));
        let rest = served(answer, object)?;
        match answer[0] {
            0x41 => {
                let size = usize::try_from(u32::from_le_bytes(rest)).expect("a size");
                let value = self.upload_segments()?;
                assert_eq!(value.len(), size, "{object:04X?} has the size that was announced");
                Ok(value)
            }
            0x42 => {
                let len = self.row(object).map_or(4, |row| row.data_type().len());
                Ok(rest[..len].to_vec())
            }
            expedited => {
                assert_eq!(expedited & 0xF3, 0x43, "{object:04X?}: an upload with its length");
                let len = 4 - usize::from(expedited >> 2 & 3);
                Ok(rest[..len].to_vec())
            }
        }
    }

    fn upload_segments(&mut self) -> Result<Vec<u8>, AbortCode> {
        let mut value = Vec::new();
        for toggle in [0x00, 0x10].into_iter().cycle() {
            let segment = self.upload_segment(toggle)?;
            value.extend_from_slice(&segment.0);
            if segment.1 {
                break;
            }
        }
        Ok(value)
    }

    /// The bytes of the next segment and whether it is the last.
    pub(crate) fn upload_segment(&mut self, toggle: u8) -> Result<(Vec<u8>, bool), AbortCode> {
        let answer = self.request([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0]);
        if answer[0] == 0x80 {
            return Err(abort_code(answer));
        }
        assert_eq!(answer[0] & 0xF0, toggle, "the segment that was asked for");
        let len = 7 - usize::from(answer[0] >> 1 & 7);
        Ok((answer[1..=len].to_vec(), answer[0] & 1 == 1))
    }

    /// Writes a value: expedited up to four bytes, else in segments.
    pub(crate) fn download(&mut self, object: ObjectId, value: &[u8]) -> Result<(), AbortCode> {
        let mut data = [0; 4];
        let Some(place) = data.get_mut(..value.len()) else {
            return self.download_in_segments(object, value);
        };
        place.copy_from_slice(value);
        let command = match self.device.expedited {
            Expedited::Indicated => 0x23 | u8::try_from(4 - value.len()).expect("at most 4") << 2,
            Expedited::FourBytes => 0x23,
        };
        let answer = self.request(initiate(command, object, data));
        served(answer, object)?;
        assert_eq!(answer[0], 0x60);
        if object.index >= 0x2000 {
            self.run_ms(self.device.pause_ms);
        }
        Ok(())
    }

    /// Writes a number of the object's length.
    pub(crate) fn set(&mut self, object: ObjectId, number: u32) -> Result<(), AbortCode> {
        let len = self.row(object).map_or(4, |row| row.data_type().len());
        let bytes = number.to_le_bytes();
        self.download(object, &bytes[..len])
    }

    /// Writes a value in segments whatever its length.
    pub(crate) fn download_in_segments(
        &mut self,
        object: ObjectId,
        value: &[u8],
    ) -> Result<(), AbortCode> {
        let size = u32::try_from(value.len()).expect("a short value");
        served(self.request(initiate(0x21, object, size.to_le_bytes())), object)?;
        let segments = value.chunks(7).count();
        for (number, chunk) in value.chunks(7).enumerate() {
            let toggle = if number % 2 == 0 { 0x00 } else { 0x10 };
            let last = u8::from(number + 1 == segments);
            let unused = u8::try_from(7 - chunk.len()).expect("at most 7");
            let mut frame = [0; 8];
            frame[0] = toggle | unused << 1 | last;
            frame[1..=chunk.len()].copy_from_slice(chunk);
            let answer = self.request(frame);
            if answer[0] == 0x80 {
                return Err(abort_code(answer));
            }
            assert_eq!(answer[0], 0x20 | toggle);
        }
        Ok(())
    }

    /// Reads a value in blocks of up to 127 segments.
    pub(crate) fn upload_in_blocks(
        &mut self,
        object: ObjectId,
        crc: Crc,
    ) -> Result<Vec<u8>, AbortCode> {
        let answer = self.request(initiate(0xA0 | crc.bit(), object, [127, 0, 0, 0]));
        let rest = served(answer, object)?;
        assert_eq!(answer[0] & 0xF9, 0xC0, "an upload in blocks");
        let size = usize::try_from(u32::from_le_bytes(rest)).expect("a size");
        let (value, last) = self.block([0xA3, 0, 0, 0, 0, 0, 0, 0])?;
        let end = self.request([0xA2, last, 127, 0, 0, 0, 0, 0]);
        assert_eq!(end[0] & 0xE3, 0xC1, "the end of the blocks");
        let value = value[..value.len() - usize::from(end[0] >> 2 & 7)].to_vec();
        assert_eq!(value.len(), size, "the size that was announced");
        if crc == Crc::Asked && answer[0] & 4 != 0 {
            assert_eq!(u16::from_le_bytes([end[1], end[2]]), checksum(&value));
        }
        self.send(self.id(0x600), &[0xA1, 0, 0, 0, 0, 0, 0, 0]);
        self.run_ms(5);
        Ok(value)
    }

    /// The segments of a block that is started by `request`, and the number of the last one.
    fn block(&mut self, request: [u8; 8]) -> Result<(Vec<u8>, u8), AbortCode> {
        let mut segment = self.request(request);
        let mut value = Vec::new();
        for number in 1..=127 {
            if segment[0] == 0x80 {
                return Err(abort_code(segment));
            }
            assert_eq!(segment[0] & 0x7F, number, "segments in order");
            value.extend_from_slice(&segment[1..]);
            if segment[0] & 0x80 != 0 {
                return Ok((value, number));
            }
            segment = self.answer().expect("the next segment");
        }
        panic!("a block has at most 127 segments");
    }

    /// Writes a value in blocks.
    pub(crate) fn download_in_blocks(
        &mut self,
        object: ObjectId,
        value: &[u8],
        crc: Crc,
    ) -> Result<(), AbortCode> {
        let size = u32::try_from(value.len()).expect("a short value");
        let answer = self.request(initiate(0xC2 | crc.bit(), object, size.to_le_bytes()));
        let rest = served(answer, object)?;
        assert_eq!(answer[0] & 0xFB, 0xA0, "a download in blocks");
        let (mut left, mut block_len) = (value, rest[0]);
        let mut unused = 0;
        while !left.is_empty() {
            let mut acknowledged = None;
            for number in 1..=block_len {
                let (chunk, rest) = left.split_at(left.len().min(7));
                left = rest;
                unused = u8::try_from(7 - chunk.len()).expect("at most 7");
                let mut segment = [0; 8];
                segment[0] = number | if left.is_empty() { 0x80 } else { 0 };
                segment[1..=chunk.len()].copy_from_slice(chunk);
                if left.is_empty() || number == block_len {
                    acknowledged = Some((number, self.request(segment)));
                    break;
                }
                self.send(self.id(0x600), &segment);
            }
            let (number, answer) = acknowledged.expect("a block has an end");
            if answer[0] == 0x80 {
                return Err(abort_code(answer));
            }
            assert_eq!((answer[0], answer[1]), (0xA2, number), "all segments arrived");
            block_len = answer[2];
        }
        let checksum = if crc == Crc::Asked { checksum(value) } else { 0 };
        let [low, high] = checksum.to_le_bytes();
        let end = self.request([0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]);
        if end[0] == 0x80 {
            return Err(abort_code(end));
        }
        assert_eq!(end[0], 0xA1);
        Ok(())
    }

    /// Reads a number.
    pub(crate) fn number(&mut self, object: ObjectId) -> u32 {
        let bytes = self.upload(object).unwrap_or_else(|code| panic!("{object:04X?}: {code:08X}"));
        let mut le = [0; 4];
        le[..bytes.len()].copy_from_slice(&bytes);
        u32::from_le_bytes(le)
    }

    /// The row of an object in the product's dictionary.
    pub(crate) fn row(&self, object: ObjectId) -> Option<Row> {
        self.device.dictionary.row(self.device.dictionary.find(object).ok()?)
    }

    /// All rows of the product.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row> + use<> {
        self.device.dictionary.rows()
    }

    /// The object, if the product has it.
    pub(crate) fn has(&self, index: u16, sub: u8) -> Result<ObjectId, Lacking> {
        let object = ObjectId { index, sub };
        self.row(object).map(|row| row.id()).ok_or_else(|| format!("no object {}", name(object)))
    }

    /// The object, if the product has it and lets masters write it.
    pub(crate) fn writes(&self, index: u16, sub: u8) -> Result<ObjectId, Lacking> {
        let object = self.has(index, sub)?;
        match self.row(object).map(|row| row.access()) {
            Some(Access::ReadWrite | Access::WriteOnly) => Ok(object),
            Some(Access::ReadOnly) | None => Err(format!("{} is read only", name(object))),
        }
    }

    /// Whether a write of the object would do more than change a value.
    pub(crate) fn is_command(&self, row: Row) -> bool {
        matches!(row.id().index, 0x1010 | 0x1011) || self.device.commands.contains(&row.id().index)
    }
}

/// Whether a request failed with one of these codes.
pub(crate) fn refused<T: Debug>(outcome: Result<T, AbortCode>, codes: &[AbortCode]) -> Verdict {
    match outcome {
        Err(code) if codes.contains(&code) => Ok(()),
        Err(code) => Err(Reason::Deviates(format!("refused with 0x{code:08X}"))),
        Ok(_) => Err(Reason::Deviates("not refused".to_owned())),
    }
}

/// Whether a block transfer asks for a checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crc {
    Asked,
    Without,
}

impl Crc {
    const fn bit(self) -> u8 {
        match self {
            Self::Asked => 4,
            Self::Without => 0,
        }
    }
}

/// `0x1017` or `0x1018:01`.
pub(crate) fn name(object: ObjectId) -> String {
    match object.sub {
        0 => format!("0x{:04X}", object.index),
        sub => format!("0x{:04X}:{sub:02X}", object.index),
    }
}

pub(crate) const fn object(index: u16, sub: u8) -> ObjectId {
    ObjectId { index, sub }
}

/// The first frame of a transfer.
pub(crate) fn initiate(command: u8, object: ObjectId, [a, b, c, d]: [u8; 4]) -> [u8; 8] {
    let [low, high] = object.index.to_le_bytes();
    [command, low, high, object.sub, a, b, c, d]
}

/// The last four bytes of an answer about this object that is no abort.
fn served(answer: [u8; 8], object: ObjectId) -> Result<[u8; 4], AbortCode> {
    let [_, low, high, sub, a, b, c, d] = answer;
    assert_eq!((u16::from_le_bytes([low, high]), sub), (object.index, object.sub));
    if answer[0] == 0x80 { Err(abort_code(answer)) } else { Ok([a, b, c, d]) }
}

pub(crate) fn abort_code(answer: [u8; 8]) -> AbortCode {
    let [.., a, b, c, d] = answer;
    u32::from_le_bytes([a, b, c, d])
}

/// CRC-16 of CiA 301, section 7.2.4.3.16: polynomial 0x1021, start value 0.
fn checksum(bytes: &[u8]) -> u16 {
    crc::Crc::<u16>::new(&crc::CRC_16_XMODEM).checksum(bytes)
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn bytes(hex: &str) -> Vec<u8> {
    let digits = |at| u8::from_str_radix(hex.get(at..at + 2).unwrap_or_default(), 16);
    (0..hex.len()).step_by(2).map(|at| digits(at).expect("hexadecimal")).collect()
}
