use heapless::Vec;
use object_dictionary::ObjectId;
use units::{Duration, Instant};

use super::abort::AbortCode;
use super::block;
use super::objects::{Entry, Objects};
use super::request::{Command, Expedited, Request, SEGMENT_LEN, Segment};
use super::response::Response;
use crate::application::Application;
use crate::frame::DATA_MAX;
use crate::settings::{self, BlockTransfer};

/// A segmented transfer whose client stays silent for this long is given up.
const SEGMENT_TIMEOUT: Duration = Duration::from_millis(1_000);

/// Longest value that can be downloaded in segments, in bytes.
const DOWNLOAD_MAX: usize = 32;

/// The SDO server (CiA 301, section 7.2.4): expedited, segmented and block transfers, one at a
/// time.
///
/// Every request gets one answer: a response or an abort; in a block transfer the segments that
/// [`Self::next_segment`] has, or one answer to the block. The client's own abort and frames
/// shorter than their command announces get none. A new initiate request in the middle of a
/// transfer takes its place.
#[derive(Debug, Default)]
pub(crate) struct Server {
    transfer: Option<Transfer>,
}

#[derive(Debug)]
struct Transfer {
    entry: Entry,
    /// The toggle bit of the next segment.
    toggle: bool,
    expires_at: Instant,
    direction: Direction,
}

#[derive(Debug)]
enum Direction {
    /// Bytes up to `offset` are sent.
    Upload {
        offset: usize,
    },
    /// These bytes have arrived.
    Download {
        received: Vec<u8, DOWNLOAD_MAX>,
    },
    BlockUpload(block::Upload),
    BlockDownload(block::Download),
}

impl Server {
    /// The request in a frame, as it is to be read now. `None` for frames that are none.
    pub(crate) fn parse(&self, data: &[u8]) -> Option<Request> {
        let segment = self.transfer.as_ref().is_some_and(|transfer| match &transfer.direction {
            Direction::BlockDownload(download) => download.expects_segment(),
            Direction::BlockUpload(_) | Direction::Upload { .. } | Direction::Download { .. } => {
                false
            }
        });
        if segment { Request::parse_segment(data) } else { Request::parse(data) }
    }

    /// The next segment of a block on its way to the client, as soon as there is room for it.
    pub(crate) fn next_segment(&mut self) -> Option<[u8; DATA_MAX]> {
        match &mut self.transfer.as_mut()?.direction {
            Direction::BlockUpload(upload) => upload.next_segment(),
            Direction::BlockDownload(_) | Direction::Upload { .. } | Direction::Download { .. } => {
                None
            }
        }
    }

    /// Serves a request.
    pub(crate) fn handle<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        request: Request,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Option<Response> {
        let mut object = request.object;
        let outcome = match request.command {
            Command::Upload => {
                self.transfer = None;
                self.upload(now, object, objects)
            }
            Command::DownloadExpedited(data) => {
                self.transfer = None;
                download_expedited(object, data, objects).transpose()?
            }
            Command::Download { size } => {
                self.transfer = None;
                self.download(now, object, size, objects)
            }
            Command::UploadSegment { toggle } => {
                object = self.object().unwrap_or(object);
                self.upload_segment(now, toggle, objects)
            }
            Command::DownloadSegment(segment) => {
                object = self.object().unwrap_or(object);
                self.download_segment(now, &segment, objects)
            }
            Command::Block(command) => match objects.settings().block_transfer {
                BlockTransfer::Served => {
                    object = match command {
                        block::Command::Upload { .. } | block::Command::Download { .. } => object,
                        block::Command::DownloadSegment(_)
                        | block::Command::DownloadEnd { .. }
                        | block::Command::UploadStart
                        | block::Command::UploadAcknowledge { .. }
                        | block::Command::UploadEnd => self.object().unwrap_or(object),
                    };
                    self.block(now, object, command, objects).transpose()?
                }
                BlockTransfer::Unknown => Err(AbortCode::UNKNOWN_COMMAND),
            },
            Command::Abort => {
                self.transfer = None;
                return None;
            }
            Command::Unknown => Err(AbortCode::UNKNOWN_COMMAND),
        };
        Some(outcome.unwrap_or_else(|code| {
            self.transfer = None;
            Response::Abort { object, code }
        }))
    }

    /// Gives a transfer up that waited too long.
    pub(crate) fn handle_timeout(&mut self, now: Instant) -> Option<Response> {
        let expired = self.transfer.take_if(|transfer| transfer.expires_at <= now)?;
        Some(Response::Abort { object: expired.entry.row.id, code: AbortCode::TIMEOUT })
    }

    /// When the transfer in progress is given up.
    pub(crate) fn poll_timeout(&self) -> Option<Instant> {
        self.transfer.as_ref().map(|transfer| transfer.expires_at)
    }

    /// Forgets the transfer in progress without a word.
    pub(crate) fn stop(&mut self) {
        self.transfer = None;
    }

    fn object(&self) -> Option<ObjectId> {
        self.transfer.as_ref().map(|transfer| transfer.entry.row.id)
    }

    fn upload<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        object: ObjectId,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let entry = objects.readable(object)?;
        self.offer(now, entry, objects)
    }

    /// The value, or that it follows in segments.
    fn offer<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        entry: Entry,
        objects: &Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let object = entry.row.id;
        let mut number = [0; 4];
        let bytes = objects.bytes(entry, &mut number);
        let len = u8::try_from(bytes.len()).map_err(|_| AbortCode::OUT_OF_MEMORY)?;
        if (1..=4).contains(&len) {
            return Ok(Response::UploadExpedited { object, data: padded(bytes), len });
        }
        self.begin(now, entry, Direction::Upload { offset: 0 });
        Ok(Response::Upload { object, size: u32::from(len) })
    }

    fn upload_segment<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        toggle: bool,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let Some(Transfer { entry, toggle: expected, expires_at, direction }) = &mut self.transfer
        else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        let Direction::Upload { offset } = direction else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        if toggle != *expected {
            return Err(AbortCode::TOGGLE);
        }
        let mut number = [0; 4];
        let left = objects.bytes(*entry, &mut number).get(*offset..).unwrap_or(&[]);
        let sent = left.get(..SEGMENT_LEN).unwrap_or(left);
        let len = u8::try_from(sent.len()).map_err(|_| AbortCode::OUT_OF_MEMORY)?;
        let last = sent.len() == left.len();
        let response = Response::UploadSegment { data: padded(sent), len, toggle, last };
        if last {
            self.transfer = None;
        } else {
            *offset += sent.len();
            *expected = !*expected;
            *expires_at = now + SEGMENT_TIMEOUT;
        }
        Ok(response)
    }

    fn download<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        object: ObjectId,
        size: Option<u32>,
        objects: &Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let entry = objects.writable(object)?;
        if let Some(size) = size {
            let size = usize::try_from(size).map_err(|_| objects.length_code(entry.row))?;
            objects.check_len(entry.row, size)?;
        }
        if entry.row.data_type.len() > DOWNLOAD_MAX {
            return Err(AbortCode::OUT_OF_MEMORY);
        }
        self.begin(now, entry, Direction::Download { received: Vec::new() });
        Ok(Response::Download { object })
    }

    fn download_segment<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        segment: &Segment,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let Some(Transfer { entry, toggle: expected, expires_at, direction }) = &mut self.transfer
        else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        let Direction::Download { received } = direction else {
            return Err(AbortCode::UNKNOWN_COMMAND);
        };
        if segment.toggle != *expected {
            return Err(AbortCode::TOGGLE);
        }
        let fits = received.len() + segment.bytes().len() <= entry.row.data_type.len();
        if !fits || received.extend_from_slice(segment.bytes()).is_err() {
            return Err(objects.length_code(entry.row));
        }
        if segment.last {
            objects.write(*entry, received)?;
            self.transfer = None;
        } else {
            *expected = !*expected;
            *expires_at = now + SEGMENT_TIMEOUT;
        }
        Ok(Response::DownloadSegment { toggle: segment.toggle })
    }

    /// `Ok(None)` when the client is to say more first, or the server sends segments.
    fn block<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        object: ObjectId,
        command: block::Command,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Result<Option<Response>, AbortCode> {
        let response = match command {
            block::Command::Upload { crc, block_len, threshold } => {
                self.transfer = None;
                return self
                    .block_upload(now, object, crc, block_len, threshold, objects)
                    .map(Some);
            }
            block::Command::Download { size, crc } => {
                self.download(now, object, size, objects)?;
                let direction = Direction::BlockDownload(block::Download::new(crc));
                if let Some(transfer) = &mut self.transfer {
                    transfer.direction = direction;
                }
                Some(block::Response::Download)
            }
            block::Command::DownloadSegment(segment) => {
                let (entry, download) = self.block_download()?;
                let len = entry.row.data_type.len();
                let taken = download.take(&segment, len);
                taken.ok_or_else(|| objects.length_code(entry.row))?
            }
            block::Command::DownloadEnd { unused, crc } => {
                let (entry, download) = self.block_download()?;
                objects.write(entry, download.end(unused, crc)?)?;
                self.transfer = None;
                Some(block::Response::DownloadEnd)
            }
            block::Command::UploadStart => {
                self.block_upload_in_progress()?.start()?;
                None
            }
            block::Command::UploadAcknowledge { number, block_len } => {
                self.block_upload_in_progress()?.acknowledge(number, block_len)?
            }
            block::Command::UploadEnd => {
                self.block_upload_in_progress()?.end()?;
                self.transfer = None;
                None
            }
        };
        if let Some(transfer) = &mut self.transfer {
            transfer.expires_at = now + SEGMENT_TIMEOUT;
        }
        Ok(response.map(|response| Response::Block { object, response }))
    }

    /// A value no longer than the client's threshold goes without blocks.
    fn block_upload<A: Application, const LEN: usize>(
        &mut self,
        now: Instant,
        object: ObjectId,
        crc: block::Crc,
        block_len: u8,
        threshold: u8,
        objects: &mut Objects<'_, A, LEN>,
    ) -> Result<Response, AbortCode> {
        let entry = objects.readable(object)?;
        let mut number = [0; 4];
        let value = objects.bytes(entry, &mut number);
        let upload = block::Upload::new(value, crc, block_len)?;
        let size = u32::try_from(value.len()).map_err(|_| AbortCode::OUT_OF_MEMORY)?;
        if size <= u32::from(threshold) && threshold != 0 {
            return self.offer(now, entry, objects);
        }
        self.begin(now, entry, Direction::BlockUpload(upload));
        Ok(Response::Block { object, response: block::Response::Upload { size } })
    }

    fn block_upload_in_progress(&mut self) -> Result<&mut block::Upload, AbortCode> {
        match self.transfer.as_mut().map(|transfer| &mut transfer.direction) {
            Some(Direction::BlockUpload(upload)) => Ok(upload),
            Some(
                Direction::BlockDownload(_) | Direction::Upload { .. } | Direction::Download { .. },
            )
            | None => Err(AbortCode::UNKNOWN_COMMAND),
        }
    }

    fn block_download(&mut self) -> Result<(Entry, &mut block::Download), AbortCode> {
        match &mut self.transfer {
            Some(Transfer { entry, direction: Direction::BlockDownload(download), .. }) => {
                Ok((*entry, download))
            }
            Some(_) | None => Err(AbortCode::UNKNOWN_COMMAND),
        }
    }

    fn begin(&mut self, now: Instant, entry: Entry, direction: Direction) {
        let expires_at = now + SEGMENT_TIMEOUT;
        self.transfer = Some(Transfer { entry, toggle: false, expires_at, direction });
    }
}

/// `Ok(None)` when the frame ends before the object's length: it is no request at all.
fn download_expedited<A: Application, const LEN: usize>(
    object: ObjectId,
    data: Expedited,
    objects: &mut Objects<'_, A, LEN>,
) -> Result<Option<Response>, AbortCode> {
    match data {
        Expedited::Indicated { data, len } => {
            if len == 3 && objects.settings().expedited == settings::Expedited::OneTwoOrFour {
                return Err(AbortCode::UNKNOWN_COMMAND);
            }
            let entry = objects.writable(object)?;
            objects.write(entry, data.get(..usize::from(len)).unwrap_or(&[]))?;
        }
        Expedited::AsObject { data, room } => {
            let entry = objects.writable(object)?;
            let len = entry.row.data_type.len();
            let (bytes, excess) =
                data.split_at_checked(len).ok_or_else(|| objects.length_code(entry.row))?;
            if usize::from(room) < len {
                return Ok(None);
            }
            objects.check_excess(excess)?;
            objects.write(entry, bytes)?;
        }
    }
    Ok(Some(Response::Download { object }))
}

/// The bytes, filled with zeros.
fn padded<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut filled = [0; N];
    for (place, &byte) in filled.iter_mut().zip(bytes) {
        *place = byte;
    }
    filled
}
