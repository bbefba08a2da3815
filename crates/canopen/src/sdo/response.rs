use object_dictionary::ObjectId;

use super::abort::AbortCode;
use super::block;
use super::request::SEGMENT_LEN;
use crate::frame::DATA_MAX;

/// What the server answers (CiA 301, section 7.2.4.3). Always eight bytes on the bus, filled with
/// zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Response {
    /// The whole value, 1 to 4 bytes.
    UploadExpedited { object: ObjectId, data: [u8; 4], len: u8 },
    /// The value follows in segments.
    Upload { object: ObjectId, size: u32 },
    /// Up to seven bytes of the value.
    UploadSegment { data: [u8; SEGMENT_LEN], len: u8, toggle: bool, last: bool },
    /// The value was taken over, or its segments may follow.
    Download { object: ObjectId },
    /// The segment arrived.
    DownloadSegment { toggle: bool },
    /// A step of a block transfer.
    Block { object: ObjectId, response: block::Response },
    /// The transfer failed.
    Abort { object: ObjectId, code: AbortCode },
}

impl Response {
    pub(crate) const fn encode(self) -> [u8; DATA_MAX] {
        match self {
            Self::UploadExpedited { object, data, len } => {
                initiate(0x43 | 4_u8.saturating_sub(len) << 2, object, data)
            }
            Self::Upload { object, size } => initiate(0x41, object, size.to_le_bytes()),
            Self::UploadSegment { data: [a, b, c, d, e, f, g], len, toggle, last } => {
                let unused = 7_u8.saturating_sub(len);
                [(toggle as u8) << 4 | unused << 1 | last as u8, a, b, c, d, e, f, g]
            }
            Self::Download { object } => initiate(0x60, object, [0; 4]),
            Self::DownloadSegment { toggle } => [0x20 | (toggle as u8) << 4, 0, 0, 0, 0, 0, 0, 0],
            Self::Block { object, response } => {
                let [low, high] = object.index.to_le_bytes();
                response.encode([low, high, object.sub])
            }
            Self::Abort { object, code } => initiate(0x80, object, code.get().to_le_bytes()),
        }
    }
}

const fn initiate(command: u8, object: ObjectId, [a, b, c, d]: [u8; 4]) -> [u8; DATA_MAX] {
    let [low, high] = object.index.to_le_bytes();
    [command, low, high, object.sub, a, b, c, d]
}
