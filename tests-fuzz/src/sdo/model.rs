//! What an SDO server has to answer (CiA 301, section 7.2.4), written to be read.

use canopen::{Expedited, ReadError, Settings, WriteError};
use units::{Duration, Instant};

const TOGGLE_NOT_ALTERNATED: u32 = 0x0503_0000;
const TIMED_OUT: u32 = 0x0504_0000;
const UNKNOWN_COMMAND: u32 = 0x0504_0001;
const BLOCK_SIZE: u32 = 0x0504_0002;
const SEQUENCE_NUMBER: u32 = 0x0504_0003;
const CRC: u32 = 0x0504_0004;
const WRITE_ONLY: u32 = 0x0601_0001;
const READ_ONLY: u32 = 0x0601_0002;
const NO_OBJECT: u32 = 0x0602_0000;
const NO_SUB_INDEX: u32 = 0x0609_0011;

const PATIENCE: Duration = Duration::from_millis(1_000);
/// While segments of a block go to the client.
const PATIENCE_IN_BLOCKS: Duration = Duration::from_millis(5_000);

/// An entry of the dictionary, as a data sheet has it.
pub(super) struct Entry {
    pub(super) object: (u16, u8),
    pub(super) kind: Kind,
    pub(super) rights: Rights,
    pub(super) limits: Limits,
}

/// A type of so many bytes.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Unsigned(u8),
    Signed(u8),
    Text(u8),
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Rights {
    Read,
    Write,
    Both,
}

pub(super) enum Limits {
    None,
    One(i64, i64),
    Two((i64, i64), (i64, i64)),
}

/// What the product does not want at present.
#[derive(Clone, Copy)]
pub(super) enum Refusal {
    Read(ReadError),
    Write(WriteError),
    /// Writes succeed without an effect on numbers.
    Silently,
}

/// The frames that have to come.
pub(super) struct Answer {
    pub(super) frames: Vec<Vec<u8>>,
}

/// A server at the moment.
pub(super) struct Model {
    entries: &'static [Entry],
    values: Vec<Vec<u8>>,
    settings: &'static Settings,
    transfer: Option<Transfer>,
}

struct Transfer {
    /// Which entry.
    at: usize,
    until: Instant,
    phase: Phase,
}

#[derive(Clone)]
enum Phase {
    Upload { left: Vec<u8>, toggle: u8 },
    Download { got: Vec<u8>, toggle: u8 },
    BlockUpload { left: Vec<u8>, crc: Option<u16>, block: u8, stage: Stage },
    BlockDownload { got: Vec<u8>, checked: bool, number: u8, asked: u8, complete: bool },
}

impl Phase {
    const fn patience(&self) -> Duration {
        match self {
            Self::BlockUpload { stage: Stage::Sent(_), .. } => PATIENCE_IN_BLOCKS,
            Self::Upload { .. }
            | Self::Download { .. }
            | Self::BlockUpload { .. }
            | Self::BlockDownload { .. } => PATIENCE,
        }
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Offered,
    /// So many segments of the block are under way.
    Sent(u8),
    Ended,
}

/// Why nothing but an abort is the answer, or nothing at all.
enum No {
    Abort(u32),
    Silence,
}

type Outcome = Result<(Answer, Option<Phase>), No>;

impl Answer {
    pub(super) const NONE: Self = Self { frames: Vec::new() };

    fn frame(head: &[u8], tail: &[u8]) -> Self {
        let mut frame = [head, tail].concat();
        frame.resize(8, 0);
        Self { frames: vec![frame] }
    }
}

impl Model {
    pub(super) const fn new(
        entries: &'static [Entry],
        values: Vec<Vec<u8>>,
        settings: &'static Settings,
    ) -> Self {
        Self { entries, values, settings, transfer: None }
    }

    pub(super) fn values(&self) -> &[Vec<u8>] {
        &self.values
    }

    /// The length of an object; 0 for one that is not there.
    pub(super) fn len(&self, index: u16, sub: u8) -> u8 {
        let entry = self.entries.iter().find(|entry| entry.object == (index, sub));
        entry.map_or(0, |entry| entry.kind.len())
    }

    pub(super) fn stop(&mut self) {
        self.transfer = None;
    }

    /// When the transfer in progress is given up.
    pub(super) fn until(&self) -> Option<Instant> {
        self.transfer.as_ref().map(|transfer| transfer.until)
    }

    pub(super) fn wait(&mut self, now: Instant) -> Answer {
        match self.transfer.take_if(|transfer| transfer.until <= now) {
            Some(transfer) => abort(self.object_at(transfer.at), TIMED_OUT),
            None => Answer::NONE,
        }
    }

    /// A request that belongs to the transfer in progress: rightly by most seeds.
    pub(super) fn continuation(&self, seed: [u8; 9]) -> Vec<u8> {
        let [mut luck, data @ ..] = seed;
        let mut slip = |one_in: u8| {
            let slips = luck % one_in == 0;
            luck /= 2;
            slips
        };
        let phase = self.transfer.as_ref().map(|transfer| &transfer.phase);
        let [spare, bytes @ ..] = data;
        let (command, rest) = match phase {
            None => (0x60, [0; 7]),
            Some(Phase::Upload { toggle, .. }) => {
                (0x60 | if slip(16) { 0x10 } else { toggle << 4 }, [0; 7])
            }
            Some(Phase::Download { got, toggle }) => {
                let wanted = self.missing(got.len());
                let (unused, last) = (7_u8.saturating_sub(wanted), wanted <= 7 || slip(16));
                let unused = if slip(16) { spare & 7 } else { unused };
                let toggle = if slip(16) { 1 } else { *toggle };
                (toggle << 4 | unused << 1 | u8::from(last), bytes)
            }
            Some(Phase::BlockUpload { stage: Stage::Offered, .. }) => (0xA3, [0; 7]),
            Some(Phase::BlockUpload { stage: Stage::Ended, .. }) => (0xA1, [0; 7]),
            Some(Phase::BlockUpload { stage: Stage::Sent(sent), .. }) => {
                let acknowledged = if slip(2) { spare % 8 } else { *sent };
                (0xA2, [acknowledged, spare & 0x7F, 0, 0, 0, 0, 0])
            }
            Some(Phase::BlockDownload { got, complete: true, checked, .. }) => {
                let len = self.transfer.as_ref().map_or(0, |t| self.entries[t.at].kind.len());
                let unused = (got.len() as u8).saturating_sub(len) & 7;
                let value = &got[..got.len() - usize::from(unused).min(got.len())];
                let [low, high] = checksum(value).to_le_bytes();
                let low = if *checked && slip(16) { low ^ 1 } else { low };
                (0xC1 | unused << 2, [low, high, 0, 0, 0, 0, 0])
            }
            Some(Phase::BlockDownload { got, number, .. }) => {
                let last = self.missing(got.len()) <= 7 || slip(16);
                let number = if slip(16) { spare & 0x7F } else { number + 1 };
                (if last { 0x80 | number } else { number }, bytes)
            }
        };
        [&[command][..], &rest].concat()
    }

    /// How much of the object is still to come after so many bytes.
    fn missing(&self, got: usize) -> u8 {
        let len = self.transfer.as_ref().map_or(0, |t| self.entries[t.at].kind.len());
        len.saturating_sub(got as u8)
    }

    pub(super) fn ask(&mut self, now: Instant, request: &[u8], refusal: Option<Refusal>) -> Answer {
        let transfer = self.transfer.take();
        let in_block = matches!(
            transfer.as_ref().map(|transfer| &transfer.phase),
            Some(Phase::BlockDownload { complete: false, .. })
        );
        // A frame that is no request leaves everything as it is.
        if request.len() < if in_block { 8 } else { 4 } || is_cut_short(request, in_block) {
            self.transfer = transfer;
            return Answer::NONE;
        }
        let mut frame = [0; 8];
        frame[..request.len()].copy_from_slice(request);
        let [command, low, high, sub, ..] = frame;
        let named = (u16::from_le_bytes([low, high]), sub);
        if command == 0x80 {
            return Answer::NONE;
        }
        let blocks = request.len() == 8;
        let of_transfer = in_block
            || matches!(command, 0x00..=0x1F | 0x60 | 0x70)
            || blocks && matches!((command & 0xE0, command & 3), (0xA0 | 0xC0, 1 | 3) | (0xA0, 2));
        let (object, at, outcome) = if of_transfer {
            let at = transfer.as_ref().map(|transfer| transfer.at);
            let object = at.map_or(named, |at| self.object_at(at));
            let outcome = match transfer {
                Some(transfer) => self.follow(transfer, frame, refusal),
                None => Err(No::Abort(UNKNOWN_COMMAND)),
            };
            (object, at, outcome)
        } else {
            let at = self.entries.iter().position(|entry| entry.object == named);
            (named, at, self.begin(named, frame, request.len(), refusal))
        };
        match outcome {
            Ok((answer, phase)) => {
                let next = at.zip(phase);
                self.transfer =
                    next.map(|(at, phase)| Transfer { at, until: now + phase.patience(), phase });
                answer
            }
            Err(No::Abort(code)) => abort(object, code),
            Err(No::Silence) => Answer::NONE,
        }
    }

    /// The first request of a transfer. Checks in their order: command, object, sub-index, access,
    /// length, value, product.
    fn begin(
        &mut self,
        object: (u16, u8),
        frame: [u8; 8],
        dlc: usize,
        refusal: Option<Refusal>,
    ) -> Outcome {
        let [command, low, high, sub, data @ ..] = frame;
        let size = u32::from_le_bytes(data);
        let blocks = dlc == 8;
        match command {
            0x40 => {
                let at = self.readable(object, refusal)?;
                Ok(self.offer(at))
            }
            0x27 if self.settings.expedited == Expedited::OneTwoOrFour => {
                Err(No::Abort(UNKNOWN_COMMAND))
            }
            0x22 | 0x23 | 0x27 | 0x2B | 0x2F => {
                let at = self.writable(object)?;
                let len = usize::from(self.entries[at].kind.len());
                let sent = if command == 0x22 { len } else { 4 - usize::from(command >> 2 & 3) };
                if sent != len || len > 4 {
                    return Err(self.wrong_length(at));
                }
                if command == 0x22 && dlc < 4 + len {
                    return Err(No::Silence);
                }
                if let (0x22, Some(code)) = (command, self.settings.abort_codes.excess_bytes)
                    && data[len..].iter().any(|&byte| byte != 0)
                {
                    return Err(No::Abort(code.get()));
                }
                self.write(at, &data[..len], refusal)?;
                Ok((Answer::frame(&[0x60, low, high, sub], &[]), None))
            }
            0x20 | 0x21 => {
                self.downloadable(object, (command == 0x21).then_some(size))?;
                let phase = Phase::Download { got: Vec::new(), toggle: 0 };
                Ok((Answer::frame(&[0x60, low, high, sub], &[]), Some(phase)))
            }
            0xA0..=0xBF if blocks && command & 3 == 0 => {
                let at = self.readable(object, refusal)?;
                let ([block, threshold, ..], value) = (data, self.values[at].clone());
                if !(1..=127).contains(&block) {
                    return Err(No::Abort(BLOCK_SIZE));
                }
                if threshold != 0 && value.len() <= usize::from(threshold) {
                    return Ok(self.offer(at));
                }
                let size = (value.len() as u32).to_le_bytes();
                let crc = (command & 4 != 0).then(|| checksum(&value));
                let phase = Phase::BlockUpload { left: value, crc, block, stage: Stage::Offered };
                Ok((Answer::frame(&[0xC6, low, high, sub], &size), Some(phase)))
            }
            0xC0..=0xDF if blocks && command & 1 == 0 => {
                self.downloadable(object, (command & 2 != 0).then_some(size))?;
                let (got, checked) = (Vec::new(), command & 4 != 0);
                let asked = self.entries[self.writable(object)?].kind.len() / 7 + 1;
                let phase =
                    Phase::BlockDownload { got, checked, number: 0, asked, complete: false };
                Ok((Answer::frame(&[0xA4, low, high, sub, asked], &[]), Some(phase)))
            }
            _ => Err(No::Abort(UNKNOWN_COMMAND)),
        }
    }

    /// A request in the middle of a transfer.
    fn follow(&mut self, transfer: Transfer, frame: [u8; 8], refusal: Option<Refusal>) -> Outcome {
        let Transfer { at, phase, .. } = transfer;
        let [command, data @ ..] = frame;
        let toggle = command >> 4 & 1;
        match phase {
            Phase::Upload { mut left, toggle: expected } if matches!(command, 0x60 | 0x70) => {
                if toggle != expected {
                    return Err(No::Abort(TOGGLE_NOT_ALTERNATED));
                }
                let sent: Vec<u8> = left.drain(..left.len().min(7)).collect();
                let unused = 7 - sent.len() as u8;
                let head = toggle << 4 | unused << 1 | u8::from(left.is_empty());
                let next = (!left.is_empty()).then_some(Phase::Upload { left, toggle: 1 - toggle });
                Ok((Answer::frame(&[head], &sent), next))
            }
            Phase::Download { mut got, toggle: expected } if command <= 0x1F => {
                if toggle != expected {
                    return Err(No::Abort(TOGGLE_NOT_ALTERNATED));
                }
                got.extend(&data[..7 - usize::from(command >> 1 & 7)]);
                let is_last = command & 1 != 0;
                if got.len() > usize::from(self.entries[at].kind.len()) {
                    return Err(self.wrong_length(at));
                }
                let answer = Answer::frame(&[0x20 | toggle << 4], &[]);
                if !is_last {
                    return Ok((answer, Some(Phase::Download { got, toggle: 1 - toggle })));
                }
                self.write(at, &got, refusal)?;
                Ok((answer, None))
            }
            Phase::BlockUpload { left, crc, block, stage } => {
                upload_block(command, data, left, crc, block, stage)
            }
            Phase::BlockDownload { mut got, checked, number, asked, complete: false } => {
                let (sent, is_last) = (command & 0x7F, command & 0x80 != 0);
                let in_order = sent == number + 1;
                if in_order {
                    if got.len() >= usize::from(self.entries[at].kind.len()).max(1) {
                        return Err(self.wrong_length(at));
                    }
                    got.extend(data);
                }
                let number = if in_order { sent } else { number };
                let complete = is_last && in_order;
                if is_last || sent == asked {
                    let asked = asked.saturating_sub(number).max(1);
                    let phase = Phase::BlockDownload { got, checked, number: 0, asked, complete };
                    return Ok((Answer::frame(&[0xA2, number, asked], &[]), Some(phase)));
                }
                let phase = Phase::BlockDownload { got, checked, number, asked, complete };
                Ok((Answer::NONE, Some(phase)))
            }
            Phase::BlockDownload { got, checked, complete: true, .. }
                if matches!((command & 0xE0, command & 3), (0xC0, 1 | 3)) =>
            {
                let len = got.len().saturating_sub(usize::from(command >> 2 & 7));
                let value = &got[..len];
                if checked && checksum(value).to_le_bytes() != data[..2] {
                    return Err(No::Abort(CRC));
                }
                self.write(at, value, refusal)?;
                Ok((Answer::frame(&[0xA1], &[]), None))
            }
            Phase::Upload { .. } | Phase::Download { .. } | Phase::BlockDownload { .. } => {
                Err(No::Abort(UNKNOWN_COMMAND))
            }
        }
    }

    /// The value at once, if it fits an answer, or that it follows in segments.
    fn offer(&self, at: usize) -> (Answer, Option<Phase>) {
        let (index, sub) = self.object_at(at);
        let [low, high] = index.to_le_bytes();
        let value = self.values[at].clone();
        match value.len() as u8 {
            len @ 1..=4 => (Answer::frame(&[0x43 | (4 - len) << 2, low, high, sub], &value), None),
            len => {
                let phase = Phase::Upload { left: value, toggle: 0 };
                (Answer::frame(&[0x41, low, high, sub, len], &[]), Some(phase))
            }
        }
    }

    fn find(&self, object: (u16, u8)) -> Result<usize, No> {
        if !self.entries.iter().any(|entry| entry.object.0 == object.0) {
            return Err(No::Abort(NO_OBJECT));
        }
        let at = self.entries.iter().position(|entry| entry.object == object);
        at.ok_or(No::Abort(NO_SUB_INDEX))
    }

    fn readable(&self, object: (u16, u8), refusal: Option<Refusal>) -> Result<usize, No> {
        let at = self.find(object)?;
        if self.entries[at].rights == Rights::Write {
            return Err(No::Abort(WRITE_ONLY));
        }
        match refusal {
            Some(Refusal::Read(error)) => Err(No::Abort(match error {
                ReadError::NoData => 0x0800_0024,
                ReadError::Hardware => 0x0606_0000,
                ReadError::DeviceState => 0x0800_0022,
                ReadError::Failed => 0x0800_0000,
            })),
            Some(Refusal::Write(_) | Refusal::Silently) | None => Ok(at),
        }
    }

    fn writable(&self, object: (u16, u8)) -> Result<usize, No> {
        let at = self.find(object)?;
        if self.entries[at].rights == Rights::Read {
            return Err(No::Abort(READ_ONLY));
        }
        Ok(at)
    }

    fn downloadable(&self, object: (u16, u8), size: Option<u32>) -> Result<(), No> {
        let at = self.writable(object)?;
        match size {
            Some(size) if size != u32::from(self.entries[at].kind.len()) => {
                Err(self.wrong_length(at))
            }
            Some(_) | None => Ok(()),
        }
    }

    fn wrong_length(&self, at: usize) -> No {
        let codes = &self.settings.abort_codes;
        No::Abort(match self.entries[at].kind {
            Kind::Text(_) => codes.text_length.get(),
            Kind::Unsigned(_) | Kind::Signed(_) => codes.number_length.get(),
        })
    }

    fn write(&mut self, at: usize, bytes: &[u8], refusal: Option<Refusal>) -> Result<(), No> {
        let Entry { kind, limits, .. } = &self.entries[at];
        let codes = &self.settings.abort_codes;
        if bytes.len() != usize::from(kind.len()) {
            return Err(self.wrong_length(at));
        }
        if let Some(number) = kind.number(bytes) {
            let within = |(low, high)| (low..=high).contains(&number);
            let code = match *limits {
                Limits::One(_, high) if number > high => Some(codes.above_maximum),
                Limits::One(low, _) if number < low => Some(codes.below_minimum),
                Limits::Two(first, second) if !within(first) && !within(second) => {
                    Some(codes.value_range)
                }
                Limits::None | Limits::One(..) | Limits::Two(..) => None,
            };
            if let Some(code) = code {
                return Err(No::Abort(code.get()));
            }
        }
        match refusal {
            Some(Refusal::Write(error)) => Err(No::Abort(match error {
                WriteError::ValueRange => codes.value_range.get(),
                WriteError::AboveMaximum => codes.above_maximum.get(),
                WriteError::NotStored => codes.not_stored.get(),
                WriteError::Hardware => 0x0606_0000,
                WriteError::DeviceState => 0x0800_0022,
                WriteError::Failed => 0x0800_0000,
            })),
            Some(Refusal::Silently) if kind.number(bytes).is_some() => Ok(()),
            Some(Refusal::Silently | Refusal::Read(_)) | None => {
                self.values[at] = bytes.to_vec();
                Ok(())
            }
        }
    }

    const fn object_at(&self, at: usize) -> (u16, u8) {
        self.entries[at].object
    }
}

impl Kind {
    const fn len(self) -> u8 {
        match self {
            Self::Unsigned(len) | Self::Signed(len) | Self::Text(len) => len,
        }
    }

    /// `None` for texts.
    fn number(self, bytes: &[u8]) -> Option<i64> {
        let unsigned = bytes.iter().rev().take(4).fold(0, |n, &byte| n << 8 | i64::from(byte));
        match self {
            Self::Text(_) => None,
            Self::Unsigned(_) => Some(unsigned),
            Self::Signed(len) => {
                let half = 1 << (8 * i64::from(len) - 1);
                Some(if unsigned < half { unsigned } else { unsigned - 2 * half })
            }
        }
    }
}

/// Whether a frame has fewer bytes than its command announces.
fn is_cut_short(request: &[u8], in_block: bool) -> bool {
    let needed = match request[0] {
        _ if in_block => 8,
        0x00..=0x1F => 8 - usize::from(request[0] >> 1 & 7),
        0x21 | 0x23 => 8,
        0x27 => 7,
        0x2B => 6,
        0x2F => 5,
        _ => 4,
    };
    request.len() < needed
}

fn upload_block(
    command: u8,
    data: [u8; 7],
    left: Vec<u8>,
    crc: Option<u16>,
    block: u8,
    stage: Stage,
) -> Outcome {
    let [number, next_block, ..] = data;
    let is_upload = command & 0xE0 == 0xA0;
    match (stage, command & 3) {
        (Stage::Offered, 3) if is_upload => Ok(send_block(left, crc, block)),
        (Stage::Ended, 1) if is_upload => Ok((Answer::NONE, None)),
        (Stage::Sent(sent), 2) if is_upload => {
            if number > sent {
                return Err(No::Abort(SEQUENCE_NUMBER));
            }
            let taken = (usize::from(number) * 7).min(left.len());
            let unused = usize::from(number) * 7 - taken;
            let left = left[taken..].to_vec();
            if number > 0 && left.is_empty() {
                let head = 0xC1 | (unused as u8) << 2;
                let answer = Answer::frame(&[head], &crc.unwrap_or(0).to_le_bytes());
                let phase = Phase::BlockUpload { left, crc, block, stage: Stage::Ended };
                return Ok((answer, Some(phase)));
            }
            if !(1..=127).contains(&next_block) {
                return Err(No::Abort(BLOCK_SIZE));
            }
            Ok(send_block(left, crc, next_block))
        }
        _ => Err(No::Abort(UNKNOWN_COMMAND)),
    }
}

/// Segments until the block or the value ends; a value of no bytes has one.
fn send_block(left: Vec<u8>, crc: Option<u16>, block: u8) -> (Answer, Option<Phase>) {
    let mut frames = Vec::new();
    let count = left.len().div_ceil(7).max(1);
    for number in 1..=count.min(usize::from(block)) {
        let last = if number == count { 0x80 } else { 0 };
        let data = left.chunks(7).nth(number - 1).unwrap_or(&[]);
        frames.extend(Answer::frame(&[last | number as u8], data).frames);
    }
    let stage = Stage::Sent(frames.len() as u8);
    (Answer { frames }, Some(Phase::BlockUpload { left, crc, block, stage }))
}

fn abort((index, sub): (u16, u8), code: u32) -> Answer {
    let [low, high] = index.to_le_bytes();
    Answer::frame(&[0x80, low, high, sub], &code.to_le_bytes())
}

/// The checksum as CiA 301 writes it: a shift register over the bits.
fn checksum(value: &[u8]) -> u16 {
    let mut register = 0_u32;
    for &byte in value.iter().chain(&[0, 0]) {
        for bit in (0..8).rev() {
            register = register << 1 | u32::from(byte >> bit & 1);
            if register & 1 << 16 != 0 {
                register ^= 0x1_1021;
            }
        }
    }
    register as u16
}
