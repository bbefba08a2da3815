use heapless::Vec;

use super::abort::AbortCode;
use super::message::{Message, SEGMENT_LEN, segment};
use super::objects::VALUE_MAX;
use crate::frame::DATA_MAX;

/// Most segments in a block (CiA 301, section 7.2.4.3.9), and what the server asks for.
pub(super) const BLOCK_LEN_MAX: u8 = 127;

/// Answers to the initiate requests, and to the end of a download.
pub(super) const UPLOAD_ANSWER: u8 = 0xC6;
pub(super) const DOWNLOAD_ANSWER: u8 = 0xA4;
pub(super) const DOWNLOAD_END_ANSWER: u8 = 0xA1;
const DOWNLOAD_BLOCK_ANSWER: u8 = 0xA2;
const UPLOAD_END: u8 = 0xC1;

/// The flag of the last segment.
const LAST: u8 = 1 << 7;

/// What a client asks for in a block transfer (CiA 301, sections 7.2.4.3.9 to 7.2.4.3.16), segments
/// apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Download { size: Option<u32>, crc: Crc },
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

impl Command {
    /// The command in a frame whose first byte is one of a block transfer, 0xA0 to 0xDF.
    pub(super) fn parse([command, a, b, _, e, f, g, h]: [u8; DATA_MAX]) -> Self {
        let crc = if command & 1 << 2 == 0 { Crc::Unused } else { Crc::Used };
        match (command & 1 << 6 == 0, command & 3) {
            (true, 0) => Self::Upload { crc, block_len: e, threshold: f },
            (true, 1) => Self::UploadEnd,
            (true, 2) => Self::UploadAcknowledge { number: a, block_len: b },
            (true, _) => Self::UploadStart,
            (false, 0) => Self::Download { size: None, crc },
            (false, 2) => Self::Download { size: Some(u32::from_le_bytes([e, f, g, h])), crc },
            (false, _) => {
                let unused = command >> 2 & 7;
                Self::DownloadEnd { unused, crc: u16::from_le_bytes([a, b]) }
            }
        }
    }
}

/// A value on its way to the server.
#[derive(Clone, Copy, Debug)]
pub(super) struct Download {
    crc: Crc,
    /// The last segment of this block that came in order.
    in_order: u8,
    complete: bool,
}

/// The client sends more than the entry holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TooLong;

impl Download {
    pub(super) const fn new(crc: Crc) -> Self {
        Self { crc, in_order: 0, complete: false }
    }

    pub(super) const fn is_complete(&self) -> bool {
        self.complete
    }

    /// Takes a segment of a value of `len` bytes, and answers the last one of a block. What is not in
    /// order is asked for again after the block.
    pub(super) fn take(
        &mut self,
        [command, data @ ..]: [u8; DATA_MAX],
        value: &mut Vec<u8, VALUE_MAX>,
        len: usize,
    ) -> Result<Option<Message>, TooLong> {
        let (number, last) = (command & !LAST, command & LAST != 0);
        if number == self.in_order + 1 {
            let fits = value.len() < len.max(1);
            if !fits || value.extend_from_slice(&data).is_err() {
                return Err(TooLong);
            }
            self.in_order = number;
            self.complete = last;
        }
        if !last && number != BLOCK_LEN_MAX {
            return Ok(None);
        }
        let number = core::mem::take(&mut self.in_order);
        Ok(Some(segment(DOWNLOAD_BLOCK_ANSWER, &[number, BLOCK_LEN_MAX])))
    }

    /// The value, all of it.
    pub(super) fn end<'a>(
        &self,
        value: &'a [u8],
        unused: u8,
        crc: u16,
    ) -> Result<&'a [u8], AbortCode> {
        if !self.complete {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        let len = value.len().saturating_sub(usize::from(unused));
        let value = value.get(..len).unwrap_or(&[]);
        match self.crc {
            Crc::Used if checksum(value) != crc => Err(AbortCode::CRC),
            Crc::Used | Crc::Unused => Ok(value),
        }
    }
}

/// A value on its way to the client.
#[derive(Clone, Copy, Debug)]
pub(super) struct Upload {
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
    pub(super) fn new(crc: Crc, block_len: u8) -> Result<Self, AbortCode> {
        check_block_len(block_len)?;
        Ok(Self { crc, block_len, acknowledged: 0, sent: 0, phase: Phase::Offered })
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
    pub(super) fn next_segment(&mut self, value: &[u8]) -> Option<Message> {
        let rest = value.get(self.next_from(value)?..)?;
        let last = if rest.len() <= SEGMENT_LEN { LAST } else { 0 };
        self.sent += 1;
        Some(segment(last | self.sent, rest))
    }

    /// The client has the segments of the block up to this one. The frame that ends the transfer, if
    /// it now has all.
    pub(super) fn acknowledge(
        &mut self,
        value: &[u8],
        number: u8,
        block_len: u8,
    ) -> Result<Option<Message>, AbortCode> {
        if self.phase != Phase::Sending {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        if number > self.sent || self.next_from(value).is_some() {
            return Err(AbortCode::SEQUENCE_NUMBER);
        }
        self.acknowledged += usize::from(number) * SEGMENT_LEN;
        if let Some(unused) = self.acknowledged.checked_sub(value.len())
            && number > 0
        {
            self.phase = Phase::Ending;
            let crc = match self.crc {
                Crc::Used => checksum(value),
                Crc::Unused => 0,
            };
            let [unused, ..] = unused.to_le_bytes();
            return Ok(Some(segment(UPLOAD_END | unused << 2, &crc.to_le_bytes())));
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
    fn next_from(&self, value: &[u8]) -> Option<usize> {
        let from = self.acknowledged + usize::from(self.sent) * SEGMENT_LEN;
        let more = from < value.len() || from == 0;
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
