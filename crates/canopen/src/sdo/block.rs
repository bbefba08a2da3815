use super::abort::AbortCode;
use super::message::{Message, SEGMENT_LEN, segment, size};
use super::objects::{Entry, Objects, Purpose};
use super::server::Server;
use super::transfer::{Step, Transfer, going_on};
use crate::application::Application;
use crate::settings::ProductSettings;

/// Most segments in a block (CiA 301, section 7.2.4.3.9).
const BLOCK_LEN_MAX: u8 = 127;

/// Answers to the initiate requests, to a block and to the end of a download, and the end of an
/// upload.
const UPLOAD_ANSWER: u8 = 0xC6;
const DOWNLOAD_ANSWER: u8 = 0xA4;
const DOWNLOAD_BLOCK_ANSWER: u8 = 0xA2;
const DOWNLOAD_END_ANSWER: u8 = 0xA1;
const UPLOAD_END: u8 = 0xC1;

/// Flags of the initiate requests: the client checks the value, and says its size.
const HAS_CHECKSUM: u8 = 1 << 2;
const HAS_SIZE: u8 = 1 << 1;
/// The flag of the last segment.
const LAST: u8 = 1 << 7;

/// Values on their way in blocks (CiA 301, sections 7.2.4.3.9 to 7.2.4.3.16).
impl Server {
    /// A request of an upload.
    pub(super) fn block_upload<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        let command = request.command();
        match command & 3 {
            0 => {
                self.transfer = None;
                let entry = objects.find(request.object(), Purpose::Read)?;
                let [block_len, threshold, ..] = request.data().to_le_bytes();
                check_block_len(block_len)?;
                objects.load(entry, &mut self.value)?;
                if self.value.len() <= threshold.into() && threshold != 0 {
                    self.offer_loaded(request, entry, objects.settings().expedited);
                    return Ok(());
                }
                let transfer = self.begin(entry, Step::BlockOffered);
                transfer.block_len = block_len;
                transfer.command = command;
                self.answer = Some(request.answer(UPLOAD_ANSWER, size(self.value.len())));
            }
            1 => {
                going_on(&mut self.transfer, Step::BlockUploaded)?;
                self.transfer = None;
            }
            2 => self.acknowledge(request)?,
            _ => going_on(&mut self.transfer, Step::BlockOffered)?.step = Step::BlockUpload,
        }
        Ok(())
    }

    /// The client has some segments of the block. Answers with the end of the transfer, if it now has
    /// all.
    fn acknowledge(&mut self, request: Message) -> Result<(), AbortCode> {
        let [_, number, block_len, ..] = request.to_bytes();
        let transfer = going_on(&mut self.transfer, Step::BlockUpload)?;
        if number > transfer.segments || next_from(transfer, self.value.len()).is_some() {
            return Err(AbortCode::SEQUENCE_NUMBER);
        }
        transfer.segments = number;
        transfer.acknowledged = transfer.position();
        transfer.segments = 0;
        match transfer.acknowledged.checked_sub(self.value.len()) {
            Some(unused) if number > 0 => {
                transfer.step = Step::BlockUploaded;
                let crc =
                    if transfer.command & HAS_CHECKSUM != 0 { checksum(&self.value) } else { 0 };
                let [unused, ..] = unused.to_le_bytes();
                self.answer = Some(Message::short(UPLOAD_END | unused << 2, crc));
            }
            Some(_) | None => {
                check_block_len(block_len)?;
                transfer.block_len = block_len;
            }
        }
        Ok(())
    }

    /// A request of a download, other than a segment. The server asks for no more segments than the value
    /// has: what a client with a longer one sent behind the abort would be taken for requests.
    pub(super) fn block_download<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        let command = request.command();
        if command & 1 == 0 {
            let transfer =
                self.accept(request, command & HAS_SIZE != 0, Step::BlockDownload, objects)?;
            transfer.command = command;
            transfer.block_len = transfer.entry.len / 7 + 1;
            self.answer = Some(request.answer(DOWNLOAD_ANSWER, transfer.block_len.into()));
            return Ok(());
        }
        let transfer = going_on(&mut self.transfer, Step::BlockDownloaded)?;
        let (entry, has_checksum) = (transfer.entry, transfer.command & HAS_CHECKSUM != 0);
        let [_, low, high, ..] = request.to_bytes();
        let unused = usize::from(command >> 2 & 7);
        self.value.truncate(self.value.len().saturating_sub(unused));
        if has_checksum && checksum(&self.value) != u16::from_le_bytes([low, high]) {
            return Err(AbortCode::CRC);
        }
        objects.write(entry, &self.value)?;
        self.finish(entry, Message::short(DOWNLOAD_END_ANSWER, 0), objects)
    }

    /// Takes a segment, and answers the last one of a block. What is not in order is asked for again
    /// after the block.
    pub(super) fn block_segment<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        segment: Message,
        objects: &Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        let transfer = going_on(&mut self.transfer, Step::BlockDownload)?;
        let [command, data @ ..] = segment.to_bytes();
        let (number, is_last) = (command & !LAST, command & LAST != 0);
        if number == transfer.segments + 1 {
            let Entry { row, len, .. } = transfer.entry;
            let fits = self.value.len() < usize::from(len.max(1));
            if !fits || self.value.extend_from_slice(&data).is_err() {
                return Err(objects.length_code(row));
            }
            transfer.segments = number;
            if is_last {
                transfer.step = Step::BlockDownloaded;
            }
        }
        if is_last || number == transfer.block_len {
            let number = core::mem::take(&mut transfer.segments);
            transfer.block_len = transfer.block_len.saturating_sub(number).max(1);
            let taken = u16::from_le_bytes([number, transfer.block_len]);
            self.answer = Some(Message::short(DOWNLOAD_BLOCK_ANSWER, taken));
        }
        Ok(())
    }

    /// Whether the next frame is a segment of a block, whatever its first byte.
    pub(super) fn is_receiving_block(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.step == Step::BlockDownload)
    }

    /// Whether a block is on its way to the client.
    pub(crate) fn is_sending_block(&self) -> bool {
        self.transfer.as_ref().is_some_and(|transfer| transfer.step == Step::BlockUpload)
    }

    /// Answers with the next segment of a block on its way to the client, as soon as there is room for
    /// it.
    pub(crate) fn send_segment(&mut self) {
        self.answer = self.next_segment();
    }

    /// `None` when the client has to say something.
    fn next_segment(&mut self) -> Option<Message> {
        let transfer = going_on(&mut self.transfer, Step::BlockUpload).ok()?;
        let rest = self.value.get(next_from(transfer, self.value.len())?..)?;
        let last = if rest.len() <= SEGMENT_LEN { LAST } else { 0 };
        transfer.segments += 1;
        Some(segment(last | transfer.segments, rest))
    }
}

/// Where the next segment of the block begins, if the client is to have one before it says something.
/// A value of no bytes has one segment.
fn next_from(transfer: &Transfer, len: usize) -> Option<usize> {
    let from = transfer.position();
    let more = from < len || from == 0;
    (transfer.segments < transfer.block_len && more).then_some(from)
}

fn check_block_len(block_len: u8) -> Result<(), AbortCode> {
    if (1..=BLOCK_LEN_MAX).contains(&block_len) { Ok(()) } else { Err(AbortCode::BLOCK_SIZE) }
}

/// The polynomial x^16 + x^12 + x^5 + 1, beginning with zero (CiA 301, section 7.2.4.3.16).
///
/// The upper eight bits leave at once, mixed with the byte; where they come back follows from the
/// terms of the polynomial.
fn checksum(value: &[u8]) -> u16 {
    value.iter().fold(0, |crc: u16, &byte| {
        let out = crc >> 8 ^ u16::from(byte);
        let out = out ^ out >> 4;
        crc << 8 ^ out << 12 ^ out << 5 ^ out
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
