use super::abort::AbortCode;
use super::message::SEGMENT_LEN;
use super::objects::Entry;
use crate::deadline::{Deadline, Moment, Span};

/// A transfer whose client stays silent for this long is given up.
const SEGMENT_TIMEOUT: Span = Span::from_millis(1_000);

/// A client waits no longer than this for parameters to be stored or restored, and for the segments of
/// a block, which take half a second at 10 kbit/s where the bus is free.
const LONG_TIMEOUT: Span = Span::from_millis(5_000);

/// A request that is not answered yet, or whose value goes in several messages.
#[derive(Clone, Copy, Debug)]
pub(super) struct Transfer {
    pub(super) entry: Entry,
    pub(super) step: Step,
    pub(super) expires_at: Deadline,
    /// Segments so far: of the present block; of the value, where that goes without blocks.
    pub(super) segments: u8,
    /// Bytes before the present block, which the client has.
    pub(super) acknowledged: usize,
    /// Segments of a block: those that the client takes, or those that it is asked for.
    pub(super) block_len: u8,
    /// The command that began it.
    pub(super) command: u8,
}

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The client asks for the next segment.
    Upload,
    /// The client has a segment.
    Download,
    /// The client says when blocks may come.
    BlockOffered,
    /// Segments of a block go out; then the client says which it has.
    BlockUpload,
    /// The client says that it has all.
    BlockUploaded,
    /// The client has segments of a block.
    BlockDownload,
    /// The client says that this was all.
    BlockDownloaded,
    /// The storage does what it was asked for.
    Storage,
}

impl Transfer {
    pub(super) const fn new(entry: Entry, step: Step) -> Self {
        Self {
            entry,
            step,
            expires_at: Deadline::NEVER,
            segments: 0,
            acknowledged: 0,
            block_len: 0,
            command: 0,
        }
    }

    /// The request that began or went on with the transfer was served at `now`.
    pub(super) fn wait(&mut self, now: Moment) {
        let timeout = match self.step {
            Step::Storage | Step::BlockUpload => LONG_TIMEOUT,
            Step::Upload
            | Step::Download
            | Step::BlockOffered
            | Step::BlockUploaded
            | Step::BlockDownload
            | Step::BlockDownloaded => SEGMENT_TIMEOUT,
        };
        self.expires_at = Deadline::after(now, timeout);
    }

    /// Where the next segment to the client begins.
    pub(super) fn position(&self) -> usize {
        self.acknowledged + usize::from(self.segments) * SEGMENT_LEN
    }
}

/// The transfer that a request goes on with, if this is what comes next.
pub(super) fn going_on(
    transfer: &mut Option<Transfer>,
    step: Step,
) -> Result<&mut Transfer, AbortCode> {
    match transfer {
        Some(transfer) if transfer.step == step => Ok(transfer),
        Some(_) | None => Err(AbortCode::UNKNOWN_COMMAND),
    }
}
