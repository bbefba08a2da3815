use heapless::Vec;

use super::abort::AbortCode;
use super::request::SEGMENT_LEN;
use crate::frame::DATA_MAX;

/// Most segments in a block (CiA 301, section 7.2.4.3.9), and what the server asks for.
const BLOCK_LEN_MAX: u8 = 127;

/// Segments of the longest value there is.
const SEGMENTS_MAX: usize = 37;
/// Bytes of the longest value, in whole segments.
const VALUE_MAX: usize = SEGMENTS_MAX * SEGMENT_LEN;
/// The length of a text is one byte.
const _: () = assert!(VALUE_MAX >= u8::MAX as usize);

const LAST: u8 = 1 << 7;

/// What a client asks for in a block transfer (CiA 301, sections 7.2.4.3.9 to 7.2.4.3.16).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Download { size: Option<u32>, crc: Crc },
    DownloadSegment(Segment),
    DownloadEnd { unused: u8, crc: u16 },
    Upload { crc: Crc, block_len: u8, threshold: u8 },
    UploadStart,
    UploadAcknowledge { number: u8, block_len: u8 },
    UploadEnd,
}

/// Whether both sides check the value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Crc {
    Used,
    Unused,
}

/// A segment of a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    number: u8,
    last: bool,
    data: [u8; SEGMENT_LEN],
}

/// What the server answers in a block transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Response {
    Download,
    DownloadAcknowledge { number: u8 },
    DownloadEnd,
    Upload { size: u32 },
    UploadEnd { unused: u8, crc: u16 },
}

impl Command {
    /// `None` for other commands.
    pub(super) fn parse(frame: [u8; DATA_MAX]) -> Option<Self> {
        let [command, a, b, _, e, f, g, h] = frame;
        let crc = if command & 1 << 2 == 0 { Crc::Unused } else { Crc::Used };
        match (command & 0xE0, command & 3) {
            (0xA0, 0) => Some(Self::Upload { crc, block_len: e, threshold: f }),
            (0xA0, 1) => Some(Self::UploadEnd),
            (0xA0, 2) => Some(Self::UploadAcknowledge { number: a, block_len: b }),
            (0xA0, _) => Some(Self::UploadStart),
            (0xC0, 0) => Some(Self::Download { size: None, crc }),
            (0xC0, 2) => Some(Self::Download { size: Some(u32::from_le_bytes([e, f, g, h])), crc }),
            (0xC0, _) => {
                let unused = command >> 2 & 7;
                Some(Self::DownloadEnd { unused, crc: u16::from_le_bytes([a, b]) })
            }
            _ => None,
        }
    }

    /// Any frame where segments are expected.
    pub(super) const fn segment([command, data @ ..]: [u8; DATA_MAX]) -> Self {
        let (number, last) = (command & !LAST, command & LAST != 0);
        Self::DownloadSegment(Segment { number, last, data })
    }
}

impl Response {
    /// The whole frame. Answers to an initiate request have the object in bytes 1 to 3.
    pub(super) const fn encode(self, [i, j, k]: [u8; 3]) -> [u8; DATA_MAX] {
        match self {
            Self::Download => [0xA4, i, j, k, BLOCK_LEN_MAX, 0, 0, 0],
            Self::DownloadAcknowledge { number } => [0xA2, number, BLOCK_LEN_MAX, 0, 0, 0, 0, 0],
            Self::DownloadEnd => [0xA1, 0, 0, 0, 0, 0, 0, 0],
            Self::Upload { size } => {
                let [a, b, c, d] = size.to_le_bytes();
                [0xC6, i, j, k, a, b, c, d]
            }
            Self::UploadEnd { unused, crc } => {
                let [low, high] = crc.to_le_bytes();
                [0xC1 | unused << 2, low, high, 0, 0, 0, 0, 0]
            }
        }
    }
}

/// A value on its way to the server.
#[derive(Debug)]
pub(super) struct Download {
    received: Vec<u8, VALUE_MAX>,
    crc: Crc,
    /// The last segment of this block that came in order.
    in_order: u8,
    complete: bool,
}

impl Download {
    pub(super) const fn new(crc: Crc) -> Self {
        Self { received: Vec::new(), crc, in_order: 0, complete: false }
    }

    /// Whether the next frame is a segment, whatever its first byte.
    pub(super) const fn expects_segment(&self) -> bool {
        !self.complete
    }

    /// Takes a segment of a value of `len` bytes. What is not in order is asked for again after the
    /// block. `None` when the value gets too long.
    pub(super) fn take(&mut self, segment: &Segment, len: usize) -> Option<Option<Response>> {
        let &Segment { number, last, ref data } = segment;
        let in_order = number == self.in_order + 1;
        if in_order {
            let fits = self.received.len() < len.max(1);
            if !fits || self.received.extend_from_slice(data).is_err() {
                return None;
            }
            self.in_order = number;
            self.complete = last;
        }
        if !last && number != BLOCK_LEN_MAX {
            return Some(None);
        }
        let number = core::mem::take(&mut self.in_order);
        Some(Some(Response::DownloadAcknowledge { number }))
    }

    /// The value, all of it.
    pub(super) fn end(&self, unused: u8, crc: u16) -> Result<&[u8], AbortCode> {
        if !self.complete {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        let len = self.received.len().saturating_sub(usize::from(unused));
        let value = self.received.get(..len).unwrap_or(&[]);
        match self.crc {
            Crc::Used if checksum(value) != crc => Err(AbortCode::CRC),
            Crc::Used | Crc::Unused => Ok(value),
        }
    }
}

/// A value on its way to the client, as it was at the start.
#[derive(Debug)]
pub(super) struct Upload {
    value: Vec<u8, VALUE_MAX>,
    crc: Crc,
    block_len: u8,
    /// Bytes before the present block; the client has them.
    acknowledged: usize,
    /// Segments sent of the present block.
    sent: u8,
    phase: Phase,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Offered,
    Sending,
    Ending,
}

impl Upload {
    pub(super) fn new(value: &[u8], crc: Crc, block_len: u8) -> Result<Self, AbortCode> {
        check_block_len(block_len)?;
        let value = Vec::from_slice(value).map_err(|_| AbortCode::OUT_OF_MEMORY)?;
        Ok(Self { value, crc, block_len, acknowledged: 0, sent: 0, phase: Phase::Offered })
    }

    /// The client is ready.
    pub(super) fn start(&mut self) -> Result<(), AbortCode> {
        match self.phase {
            Phase::Offered => {
                self.phase = Phase::Sending;
                Ok(())
            }
            Phase::Sending | Phase::Ending => Err(AbortCode::UNKNOWN_COMMAND),
        }
    }

    /// The next segment of the block; `None` when the client has to say something.
    pub(super) fn next_segment(&mut self) -> Option<[u8; DATA_MAX]> {
        let from = self.next_from()?;
        let rest = self.value.get(from..)?;
        let last = rest.len() <= SEGMENT_LEN;
        self.sent += 1;
        let mut frame = [0; DATA_MAX];
        let (command, data) = frame.split_first_mut()?;
        *command = if last { LAST | self.sent } else { self.sent };
        for (place, &byte) in data.iter_mut().zip(rest) {
            *place = byte;
        }
        Some(frame)
    }

    /// The client has the segments of the block up to this one.
    pub(super) fn acknowledge(
        &mut self,
        number: u8,
        block_len: u8,
    ) -> Result<Option<Response>, AbortCode> {
        if self.phase != Phase::Sending {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        if number > self.sent || self.next_from().is_some() {
            return Err(AbortCode::SEQUENCE_NUMBER);
        }
        self.acknowledged += usize::from(number) * SEGMENT_LEN;
        if number > 0 && self.acknowledged >= self.value.len() {
            self.phase = Phase::Ending;
            let unused = self.acknowledged - self.value.len();
            let unused = u8::try_from(unused).map_err(|_| AbortCode::GENERAL)?;
            let crc = match self.crc {
                Crc::Used => checksum(&self.value),
                Crc::Unused => 0,
            };
            return Ok(Some(Response::UploadEnd { unused, crc }));
        }
        check_block_len(block_len)?;
        self.block_len = block_len;
        self.sent = 0;
        Ok(None)
    }

    /// The client has it all.
    pub(super) fn end(&self) -> Result<(), AbortCode> {
        match self.phase {
            Phase::Ending => Ok(()),
            Phase::Offered | Phase::Sending => Err(AbortCode::UNKNOWN_COMMAND),
        }
    }

    /// Where the next segment of the block begins. A value of no bytes has one segment.
    fn next_from(&self) -> Option<usize> {
        let from = self.acknowledged + usize::from(self.sent) * SEGMENT_LEN;
        let more = from < self.value.len() || from == 0;
        (self.phase == Phase::Sending && self.sent < self.block_len && more).then_some(from)
    }
}

fn check_block_len(block_len: u8) -> Result<(), AbortCode> {
    if (1..=BLOCK_LEN_MAX).contains(&block_len) { Ok(()) } else { Err(AbortCode::BLOCK_SIZE) }
}

/// The polynomial x^16 + x^12 + x^5 + 1, beginning with zero (CiA 301, section 7.2.4.3.16).
fn checksum(value: &[u8]) -> u16 {
    const POLYNOMIAL: u16 = 0x1021;
    value.iter().fold(0, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte) << 8, |crc, _| {
            if crc & 1 << 15 == 0 { crc << 1 } else { crc << 1 ^ POLYNOMIAL }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CiA 301, section 7.2.4.3.16 names this check value.
    #[test]
    fn the_checksum_is_that_of_the_standard() {
        assert_eq!((checksum(b"123456789"), checksum(b"")), (0x31C3, 0));
    }
}
