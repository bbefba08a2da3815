use core::mem;

use heapless::Vec;

use super::abort::AbortCode;
use super::message::{Message, size, word};
use super::objects::{Effect, Entry, Objects, Purpose, VALUE_MAX};
use super::transfer::{Step, Transfer};
use crate::application::{Application, WriteError};
use crate::deadline::{Deadline, Moment};
use crate::frame::Frame;
use crate::settings::{BlockTransfer, Expedited, ProductSettings, Settings};

/// Bytes of a whole message, and of its command and object.
const LEN_MAX: u8 = 8;
const HEAD_LEN: u8 = 4;

/// Commands of the client (CiA 301, section 7.2.4.3).
const UPLOAD: u8 = 0x40;
const ABORT: u8 = 0x80;
/// Answers.
const UPLOAD_ANSWER: u8 = 0x40;
const DOWNLOAD_ANSWER: u8 = 0x60;

/// Flags of an initiate message: the data are in it, and their length or that of the value too.
const EXPEDITED: u8 = 1 << 1;
const SIZE_INDICATED: u8 = 1;

/// The SDO server (CiA 301, section 7.2.4): expedited, segmented and block transfers, one at a
/// time.
///
/// Every request gets one answer: a response or an abort; in a block transfer the segments that
/// [`Self::send_segment`] has, or one answer to the block. The client's own abort and frames
/// shorter than their command announces get none. A new initiate request in the middle of a
/// transfer takes its place.
///
/// The answer to a command to store or restore comes when that is done. A request in between is
/// served as ever and takes the place of that answer; only a second command of this kind is refused
/// until the first is done, whether its client still waits or not.
#[derive(Debug, Default)]
pub(crate) struct Server {
    pub(super) transfer: Option<Transfer>,
    storage: Storage,
    /// What goes to the client now.
    pub(super) answer: Option<Message>,
    /// A value of several messages: as far as it has come, or as it was at the start.
    pub(super) value: Vec<u8, VALUE_MAX>,
}

/// What the storage does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Storage {
    #[default]
    Idle,
    /// What a command asked for. This is the answer when it is done, if the client still waits.
    Busy { answer: Message },
}

impl Server {
    /// Serves a request. What is answered is in [`Self::take_answer`].
    pub(crate) fn handle<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        now: Moment,
        frame: &Frame,
        objects: &mut Objects<'_, A, S, LEN>,
    ) {
        let request = Message::received(frame);
        let (command, len) = (request.command(), frame.dlc());
        let is_segment = self.is_receiving_block();
        if len < LEN_MAX && (is_segment || len < len_min(command)) {
            return;
        }
        let outcome = match command {
            _ if is_segment => self.go_on(request, len, objects),
            UPLOAD => self.upload(request, objects),
            0x22 | 0x23 | 0x27 | 0x2B | 0x2F => self.download_expedited(request, len, objects),
            _ => self.go_on(request, len, objects),
        };
        if let Err(code) = outcome {
            match self.transfer.take() {
                Some(transfer) => self.abort(transfer, code),
                None => self.answer = Some(request.answer(ABORT, code.get())),
            }
        }
        if let Some(transfer) = &mut self.transfer {
            transfer.wait(now);
        }
    }

    /// Serves what belongs to transfers of several messages, and what is unknown.
    #[inline(never)]
    fn go_on<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        len: u8,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        let serves_blocks = A::BLOCK_TRANSFER == BlockTransfer::Served && len == LEN_MAX;
        match request.command() {
            ABORT => {
                self.transfer = None;
                Ok(())
            }
            _ if self.is_receiving_block() => self.block_segment(request, objects),
            command @ (0x20 | 0x21) if objects.settings().expedited != Expedited::FourOnly => {
                let has_size = command & SIZE_INDICATED != 0;
                self.accept(request, has_size, Step::Download, objects)?;
                self.answer = Some(request.answer(DOWNLOAD_ANSWER, 0));
                Ok(())
            }
            0x60 | 0x70 => self.upload_segment(request.command()),
            0x00..=0x1F => self.download_segment(request, objects),
            0xA0..=0xBF if serves_blocks => self.block_upload(request, objects),
            0xC0..=0xDF if serves_blocks => self.block_download(request, objects),
            _ => {
                self.transfer = None;
                Err(AbortCode::UNKNOWN_COMMAND)
            }
        }
    }

    fn abort(&mut self, ended: Transfer, code: AbortCode) {
        self.answer = Some(Message::new(ABORT, ended.entry.row.id(), code.get()));
    }

    /// The storage is done with what [`Effect::Store`] or [`Effect::Restore`] asked for.
    pub(crate) fn handle_stored(&mut self, outcome: Result<(), WriteError>, settings: &Settings) {
        let storage = mem::take(&mut self.storage);
        let waits = |transfer: &mut Transfer| transfer.step == Step::Storage;
        let Some(transfer) = self.transfer.take_if(waits) else { return };
        match (outcome, storage) {
            (Ok(()), Storage::Busy { answer }) => self.answer = Some(answer),
            (Err(error), Storage::Busy { .. }) => {
                let code = AbortCode::of_write(error, &settings.abort_codes);
                self.abort(transfer, code);
            }
            (_, Storage::Idle) => {}
        }
    }

    /// Gives a transfer up that waited too long.
    pub(crate) fn handle_timeout(&mut self, now: Moment, settings: &Settings) {
        let is_late = |transfer: &mut Transfer| transfer.expires_at.is_due(now);
        if let Some(transfer) = self.transfer.take_if(is_late) {
            let code = match transfer.step {
                Step::Storage => settings.abort_codes.not_stored,
                Step::Upload
                | Step::Download
                | Step::BlockOffered
                | Step::BlockUpload
                | Step::BlockUploaded
                | Step::BlockDownload
                | Step::BlockDownloaded => AbortCode::TIMEOUT,
            };
            self.abort(transfer, code);
        }
    }

    /// What goes to the client now, once.
    #[inline]
    pub(crate) const fn take_answer(&mut self) -> Option<Message> {
        self.answer.take()
    }

    /// Whether a transfer is in progress.
    #[inline]
    pub(crate) const fn is_waiting(&self) -> bool {
        self.transfer.is_some()
    }

    /// When the transfer in progress is given up.
    pub(crate) fn due_at(&self) -> Deadline {
        self.transfer.as_ref().map_or(Deadline::NEVER, |transfer| transfer.expires_at)
    }

    /// Forgets the transfer in progress without a word.
    pub(crate) const fn stop(&mut self) {
        self.transfer = None;
    }

    fn upload<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        self.transfer = None;
        let entry = objects.find(request.object(), Purpose::Read)?;
        let expedited = objects.settings().expedited;
        if entry.row.data_type().is_text() {
            objects.load(entry, &mut self.value)?;
            self.offer_loaded(request, entry, expedited);
        } else {
            self.offer(request, entry, expedited, entry.len.into(), objects.number(entry));
        }
        Ok(())
    }

    /// The loaded value, or that it follows in segments.
    pub(super) fn offer_loaded(&mut self, request: Message, entry: Entry, expedited: Expedited) {
        self.offer(request, entry, expedited, size(self.value.len()), word(&self.value));
    }

    /// A value of `size` bytes, of which these are the first, or that the loaded value follows in
    /// segments.
    #[inline]
    fn offer(
        &mut self,
        request: Message,
        entry: Entry,
        expedited: Expedited,
        size: u32,
        first: u32,
    ) {
        let [len, ..] = size.to_le_bytes();
        self.answer = Some(match (size, expedited) {
            (1..=4, Expedited::FourOnly) => request.answer(UPLOAD_ANSWER | EXPEDITED, first),
            (1..=4, Expedited::AnyLength | Expedited::OneTwoOrFour | Expedited::LongerToo) => {
                let command = UPLOAD_ANSWER | EXPEDITED | SIZE_INDICATED | (4 - len) << 2;
                request.answer(command, first & u32::MAX >> (32 - 8 * size))
            }
            _ => {
                self.begin(entry, Step::Upload);
                request.answer(UPLOAD_ANSWER | SIZE_INDICATED, size)
            }
        });
    }

    fn download_expedited<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        frame_len: u8,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        self.transfer = None;
        let indicated = indicated(request.command());
        let expedited = objects.settings().expedited;
        if indicated == Some(3) && expedited == Expedited::OneTwoOrFour {
            return Err(AbortCode::UNKNOWN_COMMAND);
        }
        let entry = objects.find(request.object(), Purpose::Write)?;
        let len = u32::from(entry.len);
        if indicated != Some(len) || expedited == Expedited::FourOnly {
            let room = u32::from(frame_len.saturating_sub(HEAD_LEN));
            if indicated.is_none() && room < len && len <= 4 {
                return Ok(());
            }
            objects.check_other_len(entry, indicated, request.data())?;
        }
        if entry.row.data_type().is_text() {
            let data = request.data().to_le_bytes();
            objects.write(entry, data.get(..usize::from(entry.len)).unwrap_or(&[]))?;
        } else {
            objects.write_number(entry, request.data())?;
        }
        self.finish(entry, request.answer(DOWNLOAD_ANSWER, 0), objects)
    }

    /// Begins to take a value of several messages, which may have its size in the request.
    pub(super) fn accept<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        request: Message,
        has_size: bool,
        step: Step,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<&mut Transfer, AbortCode> {
        self.transfer = None;
        let entry = objects.find(request.object(), Purpose::Write)?;
        if has_size && request.data() != u32::from(entry.len) {
            return Err(objects.length_code(entry.row));
        }
        self.value.clear();
        Ok(self.begin(entry, step))
    }

    #[inline(never)]
    pub(super) fn begin(&mut self, entry: Entry, step: Step) -> &mut Transfer {
        self.transfer.insert(Transfer::new(entry, step))
    }

    /// A value was written. The answer waits for the storage if that has to act.
    pub(super) fn finish<A: Application, S: ProductSettings, const LEN: usize>(
        &mut self,
        entry: Entry,
        answer: Message,
        objects: &mut Objects<'_, A, S, LEN>,
    ) -> Result<(), AbortCode> {
        match (objects.effect(), self.storage) {
            (Effect::None | Effect::Changed(_) | Effect::Configured(_), _) => {
                self.transfer = None;
                self.answer = Some(answer);
            }
            (Effect::Store { .. } | Effect::Restore { .. }, Storage::Idle) => {
                self.storage = Storage::Busy { answer };
                self.begin(entry, Step::Storage);
            }
            (Effect::Store { .. } | Effect::Restore { .. }, Storage::Busy { .. }) => {
                objects.give_up();
                return Err(AbortCode::DEVICE_STATE);
            }
        }
        Ok(())
    }
}

/// Bytes of data that an initiate message of an expedited download says it has.
fn indicated(command: u8) -> Option<u32> {
    (command & SIZE_INDICATED != 0).then_some(4 - u32::from(command >> 2 & 3))
}

/// Bytes of the shortest frame that may have this command; there is none with fewer than the four of
/// the head.
fn len_min(command: u8) -> u8 {
    match command {
        0x00..=0x1F => LEN_MAX - (command >> 1 & 7).min(4),
        0x21 | 0x23 | 0x27 | 0x2B | 0x2F => LEN_MAX - (command >> 2 & 3),
        _ => HEAD_LEN,
    }
}
