use heapless::Vec;
use object_dictionary::ObjectId;
use units::{Duration, Instant};

use super::abort::AbortCode;
use super::block;
use super::message::{Message, SEGMENT_LEN, segment};
use super::objects::{Effect, Entry, Objects, VALUE_MAX};
use crate::application::{Application, WriteError};
use crate::frame::{DATA_MAX, Frame};
use crate::settings::{BlockTransfer, Expedited, Settings};

/// A transfer whose client stays silent for this long is given up.
const SEGMENT_TIMEOUT: Duration = Duration::from_millis(1_000);

/// A client waits no longer than this for parameters to be stored or restored.
const STORAGE_TIMEOUT: Duration = Duration::from_millis(5_000);

/// Bytes before the data of an expedited transfer.
const HEAD_LEN: u8 = 4;

/// Commands of the client (CiA 301, section 7.2.4.3).
const UPLOAD: u8 = 0x40;
const ABORT: u8 = 0x80;
/// Answers.
const UPLOAD_ANSWER: u8 = 0x40;
const DOWNLOAD_ANSWER: u8 = 0x60;
const DOWNLOAD_SEGMENT_ANSWER: u8 = 0x20;

/// Flags of an initiate message: the data are in it, and their length or that of the value too.
const EXPEDITED: u8 = 1 << 1;
const SIZE_INDICATED: u8 = 1;
/// Flags of a segment: it alternates, and it is the last.
const TOGGLE: u8 = 1 << 4;
const LAST: u8 = 1;

/// The SDO server (CiA 301, section 7.2.4): expedited, segmented and block transfers, one at a
/// time.
///
/// Every request gets one answer: a response or an abort; in a block transfer the segments that
/// [`Self::next_segment`] has, or one answer to the block. The client's own abort and frames
/// shorter than their command announces get none. A new initiate request in the middle of a
/// transfer takes its place.
///
/// The answer to a command to store or restore comes when that is done. A request in between is
/// served as ever and takes the place of that answer; only a second command of this kind is refused
/// until the first is done, whether its client still waits or not.
#[derive(Debug, Default)]
pub(crate) struct Server {
    transfer: Option<Transfer>,
    storage: Storage,
    /// A value of several messages: as far as it has come, or as it was at the start.
    value: Vec<u8, VALUE_MAX>,
}

#[derive(Clone, Copy, Debug)]
struct Transfer {
    entry: Entry,
    expires_at: Instant,
    step: Step,
}

/// What comes next.
#[derive(Clone, Copy, Debug)]
enum Step {
    /// The client asks for the bytes from `sent` on.
    Upload {
        toggle: u8,
        sent: usize,
    },
    /// The client has more bytes.
    Download {
        toggle: u8,
    },
    /// A block, in either direction.
    BlockUpload(block::Upload),
    BlockDownload(block::Download),
    /// The storage has done what this is the answer to.
    Storage {
        answer: Message,
    },
}

/// What the storage does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Storage {
    #[default]
    Idle,
    Busy,
}

/// What is answered; `None` when the client is to say more first, or the server sends segments.
type Answer = Result<Option<Message>, AbortCode>;

impl Server {
    /// Serves a request.
    pub(crate) fn handle<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        frame: &Frame,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Option<Message> {
        let request = Message::from_bytes(frame.padded());
        let room = frame.dlc().checked_sub(HEAD_LEN)?;
        let answer = match request.command() {
            _ if self.expects_block_segment() => return self.handle_segmented(now, frame, objects),
            UPLOAD => self.upload(now, request, objects),
            0x22 | 0x23 | 0x27 | 0x2B | 0x2F => {
                self.download_expedited(now, request, room, objects)
            }
            _ => return self.handle_segmented(now, frame, objects),
        };
        answer.unwrap_or_else(|code| Some(self.fail(request, code)))
    }

    /// Serves what belongs to transfers of several messages, and what is unknown.
    #[inline(never)]
    fn handle_segmented<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        frame: &Frame,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Option<Message> {
        let (bytes, len) = (frame.padded(), frame.dlc());
        let [command, ..] = bytes;
        let in_block = self.expects_block_segment();
        if in_block && len < 8 {
            return None;
        }
        let answer = match command {
            ABORT => {
                self.transfer = None;
                return None;
            }
            _ if in_block => self.block_segment(bytes, objects),
            0x20 | 0x21 if objects.settings().expedited != Expedited::FourOnly => {
                if command & SIZE_INDICATED != 0 && len < 8 {
                    return None;
                }
                self.download(now, Message::from_bytes(bytes), objects)
            }
            0x60 | 0x70 => self.upload_segment(command),
            0x00..=0x1F => {
                let (_, data) = frame.data().split_first()?;
                let data = data.get(..SEGMENT_LEN - usize::from(command >> 1 & 7))?;
                self.download_segment(now, command, data, objects)
            }
            0xA0..=0xDF if len == 8 && A::BLOCK_TRANSFER == BlockTransfer::Served => {
                self.block(now, bytes, objects)
            }
            _ => {
                self.transfer = None;
                Err(AbortCode::UNKNOWN_COMMAND)
            }
        };
        self.renew(now);
        answer.unwrap_or_else(|code| Some(self.fail(Message::from_bytes(bytes), code)))
    }

    /// The client goes on with its transfer.
    fn renew(&mut self, now: Instant) {
        match &mut self.transfer {
            Some(Transfer { step: Step::Storage { .. }, .. }) | None => {}
            Some(transfer) => transfer.expires_at = now + SEGMENT_TIMEOUT,
        }
    }

    /// Ends the transfer in progress, or refuses to begin one.
    fn fail(&mut self, request: Message, code: AbortCode) -> Message {
        let object = self.object().unwrap_or(request.object());
        self.transfer = None;
        Message::new(ABORT, object, code.get())
    }

    /// The storage is done with what [`Effect::Store`] or [`Effect::Restore`] asked for.
    pub(crate) fn handle_stored(
        &mut self,
        outcome: Result<(), WriteError>,
        settings: &Settings,
    ) -> Option<Message> {
        self.storage = Storage::Idle;
        let Some(Transfer { step: Step::Storage { answer }, entry, .. }) = self.transfer else {
            return None;
        };
        self.transfer = None;
        Some(outcome.map_or_else(
            |error| abort(entry, AbortCode::of_write(error, &settings.abort_codes)),
            |()| answer,
        ))
    }

    /// Gives a transfer up that waited too long.
    pub(crate) fn handle_timeout(&mut self, now: Instant, settings: &Settings) -> Option<Message> {
        let expired = self.transfer.take_if(|transfer| transfer.expires_at <= now)?;
        let code = match expired.step {
            Step::Storage { .. } => settings.abort_codes.not_stored,
            Step::Upload { .. }
            | Step::Download { .. }
            | Step::BlockUpload(_)
            | Step::BlockDownload(_) => AbortCode::TIMEOUT,
        };
        Some(abort(expired.entry, code))
    }

    /// Whether a transfer is in progress.
    #[inline]
    pub(crate) const fn is_waiting(&self) -> bool {
        self.transfer.is_some()
    }

    /// When the transfer in progress is given up.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        self.transfer.as_ref().map(|transfer| transfer.expires_at)
    }

    /// Forgets the transfer in progress without a word.
    pub(crate) fn stop(&mut self) {
        self.transfer = None;
    }

    /// Whether a block is on its way to the client.
    pub(crate) const fn is_sending_block(&self) -> bool {
        matches!(self.transfer, Some(Transfer { step: Step::BlockUpload(_), .. }))
    }

    /// The next segment of a block on its way to the client, as soon as there is room for it.
    pub(crate) fn next_segment(&mut self) -> Option<Message> {
        match &mut self.transfer {
            Some(Transfer { step: Step::BlockUpload(upload), .. }) => {
                upload.next_segment(&self.value)
            }
            Some(_) | None => None,
        }
    }

    fn size(&self) -> u32 {
        u32::try_from(self.value.len()).unwrap_or(u32::MAX)
    }

    fn object(&self) -> Option<ObjectId> {
        self.transfer.as_ref().map(|transfer| transfer.entry.row.id())
    }

    /// Whether the next frame is a segment of a block, whatever its first byte.
    const fn expects_block_segment(&self) -> bool {
        match &self.transfer {
            Some(Transfer { step: Step::BlockDownload(download), .. }) => !download.is_complete(),
            Some(_) | None => false,
        }
    }

    fn upload<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        request: Message,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Answer {
        self.transfer = None;
        let entry = objects.readable(request.object())?;
        if entry.row.data_type().is_text() {
            objects.load(entry, &mut self.value)?;
            return Ok(Some(self.offer(now, entry, objects.settings().expedited)));
        }
        let number = objects.number(entry);
        let answer = match objects.settings().expedited {
            Expedited::FourOnly => request.answer(UPLOAD_ANSWER | EXPEDITED, number),
            Expedited::AnyLength | Expedited::OneTwoOrFour | Expedited::LongerToo => {
                let (command, mask) = match entry.row.data_type().len() {
                    1 => (0x4F, 0xFF),
                    2 => (0x4B, 0xFFFF),
                    _ => (0x43, 0xFFFF_FFFF),
                };
                request.answer(command, number & mask)
            }
        };
        Ok(Some(answer))
    }

    /// The loaded value, or that it follows in segments.
    fn offer(&mut self, now: Instant, entry: Entry, expedited: Expedited) -> Message {
        let size = self.size();
        if (1..=4).contains(&size) {
            let [_, a, b, c, d, ..] = segment(0, &self.value).to_bytes();
            let [len, ..] = size.to_le_bytes();
            let told = match expedited {
                Expedited::FourOnly => 0,
                Expedited::AnyLength | Expedited::OneTwoOrFour | Expedited::LongerToo => {
                    SIZE_INDICATED | (4 - len) << 2
                }
            };
            let command = UPLOAD_ANSWER | EXPEDITED | told;
            Message::new(command, entry.row.id(), u32::from_le_bytes([a, b, c, d]))
        } else {
            self.begin(now, entry, Step::Upload { toggle: 0, sent: 0 });
            Message::new(UPLOAD_ANSWER | SIZE_INDICATED, entry.row.id(), size)
        }
    }

    fn upload_segment(&mut self, command: u8) -> Answer {
        let Some(Transfer { step: Step::Upload { toggle, sent }, .. }) = &mut self.transfer else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        let told = command & TOGGLE;
        if told != *toggle {
            return Err(AbortCode::TOGGLE);
        }
        let rest = self.value.get(*sent..).unwrap_or(&[]);
        let Some(unused) = SEGMENT_LEN.checked_sub(rest.len()) else {
            *toggle ^= TOGGLE;
            *sent += SEGMENT_LEN;
            return Ok(Some(segment(told, rest)));
        };
        let [unused, ..] = unused.to_le_bytes();
        let answer = segment(told | unused << 1 | LAST, rest);
        self.transfer = None;
        Ok(Some(answer))
    }

    fn download_expedited<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        request: Message,
        room: u8,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Answer {
        let command = request.command();
        let indicated = (command & SIZE_INDICATED != 0).then_some(4 - (command >> 2 & 3));
        if indicated.is_some_and(|indicated| room < indicated) {
            return Ok(None);
        }
        self.transfer = None;
        let expedited = objects.settings().expedited;
        if indicated == Some(3) && expedited == Expedited::OneTwoOrFour {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        let entry = objects.writable(request.object())?;
        let len = entry.row.data_type().len();
        if indicated.map(usize::from) != Some(len) || expedited == Expedited::FourOnly {
            if indicated.is_none() && usize::from(room) < len && len <= 4 {
                return Ok(None);
            }
            objects.check_other_len(entry.row, indicated, request.data())?;
        }
        let effect = if entry.row.data_type().is_text() {
            objects.write_text(entry, request.data().to_le_bytes().get(..len).unwrap_or(&[]))?
        } else {
            objects.write_number(entry, request.data())?
        };
        self.finish(now, entry, effect, request.answer(DOWNLOAD_ANSWER, 0), objects)
    }

    fn download<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        request: Message,
        objects: &Objects<'_, A, LEN>,
    ) -> Answer {
        let size = (request.command() & SIZE_INDICATED != 0).then_some(request.data());
        let entry = self.accept(request, size, objects)?;
        self.begin(now, entry, Step::Download { toggle: 0 });
        Ok(Some(request.answer(DOWNLOAD_ANSWER, 0)))
    }

    /// The entry that a value of several messages is for.
    fn accept<A: Application, const LEN: usize>(
        &mut self,
        request: Message,
        size: Option<u32>,
        objects: &Objects<'_, A, LEN>,
    ) -> Result<Entry, AbortCode> {
        self.transfer = None;
        let entry = objects.writable(request.object())?;
        if let Some(size) = size {
            let size = usize::try_from(size).map_err(|_| objects.length_code(entry.row))?;
            objects.check_len(entry.row, size)?;
        }
        self.value.clear();
        Ok(entry)
    }

    fn download_segment<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        command: u8,
        data: &[u8],
        objects: &mut Objects<'_, A, LEN>,
    ) -> Answer {
        let Some(Transfer { entry, step: Step::Download { toggle }, .. }) = &mut self.transfer
        else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        let (entry, told) = (*entry, command & TOGGLE);
        if told != *toggle {
            return Err(AbortCode::TOGGLE);
        }
        let fits = self.value.len() + data.len() <= entry.row.data_type().len();
        if !fits || self.value.extend_from_slice(data).is_err() {
            return Err(objects.length_code(entry.row));
        }
        let answer = segment(DOWNLOAD_SEGMENT_ANSWER | told, &[]);
        if command & LAST == 0 {
            *toggle ^= TOGGLE;
            return Ok(Some(answer));
        }
        let effect = objects.write(entry, &self.value)?;
        self.finish(now, entry, effect, answer, objects)
    }

    /// A request of a block transfer, other than a segment.
    fn block<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        bytes: [u8; DATA_MAX],
        objects: &mut Objects<'_, A, LEN>,
    ) -> Answer {
        let request = Message::from_bytes(bytes);
        match block::Command::parse(bytes) {
            block::Command::Upload { crc, block_len, threshold } => {
                self.transfer = None;
                let entry = objects.readable(request.object())?;
                let upload = block::Upload::new(crc, block_len)?;
                objects.load(entry, &mut self.value)?;
                if self.size() <= threshold.into() && threshold != 0 {
                    return Ok(Some(self.offer(now, entry, objects.settings().expedited)));
                }
                self.begin(now, entry, Step::BlockUpload(upload));
                Ok(Some(request.answer(block::UPLOAD_ANSWER, self.size())))
            }
            block::Command::Download { size, crc } => {
                let entry = self.accept(request, size, objects)?;
                self.begin(now, entry, Step::BlockDownload(block::Download::new(crc)));
                let block_len = block::BLOCK_LEN_MAX.into();
                Ok(Some(request.answer(block::DOWNLOAD_ANSWER, block_len)))
            }
            block::Command::DownloadEnd { unused, crc } => {
                let Some(Transfer { entry, step: Step::BlockDownload(download), .. }) =
                    self.transfer
                else {
                    return Err(AbortCode::UNKNOWN_COMMAND);
                };
                let effect = objects.write(entry, download.end(&self.value, unused, crc)?)?;
                self.finish(now, entry, effect, segment(block::DOWNLOAD_END_ANSWER, &[]), objects)
            }
            block::Command::UploadStart => self.block_upload()?.0.start().map(|()| None),
            block::Command::UploadAcknowledge { number, block_len } => {
                let (upload, value) = self.block_upload()?;
                upload.acknowledge(value, number, block_len)
            }
            block::Command::UploadEnd => {
                self.block_upload()?.0.end()?;
                self.transfer = None;
                Ok(None)
            }
        }
    }

    fn block_segment<A: Application, const LEN: usize>(
        &mut self,
        bytes: [u8; DATA_MAX],
        objects: &Objects<'_, A, LEN>,
    ) -> Answer {
        let Some(Transfer { entry, step: Step::BlockDownload(download), .. }) = &mut self.transfer
        else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        let len = entry.row.data_type().len();
        download.take(bytes, &mut self.value, len).map_err(|_| objects.length_code(entry.row))
    }

    /// The block upload in progress, which the client goes on with, and the value.
    fn block_upload(&mut self) -> Result<(&mut block::Upload, &[u8]), AbortCode> {
        match &mut self.transfer {
            Some(Transfer { step: Step::BlockUpload(upload), .. }) => Ok((upload, &self.value)),
            Some(_) | None => Err(AbortCode::UNKNOWN_COMMAND),
        }
    }

    #[inline(never)]
    fn begin(&mut self, now: Instant, entry: Entry, step: Step) {
        self.transfer = Some(Transfer { entry, expires_at: now + SEGMENT_TIMEOUT, step });
    }

    /// A value was written. The answer waits for the storage if that has to act.
    fn finish<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        entry: Entry,
        effect: Effect,
        answer: Message,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Answer {
        self.transfer = None;
        match (effect, self.storage) {
            (Effect::None | Effect::Changed(_), _) => {
                objects.bring_about(effect);
                Ok(Some(answer))
            }
            (Effect::Store { .. } | Effect::Restore { .. }, Storage::Idle) => {
                objects.bring_about(effect);
                self.storage = Storage::Busy;
                let expires_at = now + STORAGE_TIMEOUT;
                self.transfer =
                    Some(Transfer { entry, expires_at, step: Step::Storage { answer } });
                Ok(None)
            }
            (Effect::Store { .. } | Effect::Restore { .. }, Storage::Busy) => {
                Err(AbortCode::DEVICE_STATE)
            }
        }
    }
}

fn abort(entry: Entry, code: AbortCode) -> Message {
    Message::new(ABORT, entry.row.id(), code.get())
}
