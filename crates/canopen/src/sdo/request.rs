use object_dictionary::ObjectId;

use super::block;
use crate::frame::DATA_MAX;

/// Data bytes in an SDO segment.
pub(super) const SEGMENT_LEN: usize = 7;

/// What a client asks for (CiA 301, section 7.2.4.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Request {
    /// Bytes 1 to 3: the object, or in a segment just the bytes.
    pub(super) object: ObjectId,
    pub(super) command: Command,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Upload,
    UploadSegment { toggle: bool },
    DownloadExpedited(Expedited),
    Download { size: Option<u32> },
    DownloadSegment(Segment),
    Block(block::Command),
    Abort,
    Unknown,
}

/// The data of an expedited download.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Expedited {
    /// Its length is indicated, 1 to 4.
    Indicated { data: [u8; 4], len: u8 },
    /// It has the object's length; the frame has room for `room` bytes.
    AsObject { data: [u8; 4], room: u8 },
}

/// The data of a download segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    data: [u8; SEGMENT_LEN],
    len: u8,
    pub(super) toggle: bool,
    pub(super) last: bool,
}

impl Segment {
    pub(super) fn bytes(&self) -> &[u8] {
        self.data.get(..usize::from(self.len)).unwrap_or(&[])
    }
}

impl Request {
    /// Where segments of a block are expected every whole frame is one, except the abort.
    pub(super) fn parse_segment(data: &[u8]) -> Option<Self> {
        let frame: [u8; DATA_MAX] = data.try_into().ok()?;
        let [command, index_low, index_high, sub, ..] = frame;
        let object = ObjectId { index: u16::from_le_bytes([index_low, index_high]), sub };
        let command = match command {
            0x80 => Command::Abort,
            _ => Command::Block(block::Command::segment(frame)),
        };
        Some(Self { object, command })
    }

    /// Every frame is a request, except one that is shorter than its own command says: `None`.
    pub(crate) fn parse(data: &[u8]) -> Option<Self> {
        let dlc = u8::try_from(data.len()).ok()?;
        let &[command, index_low, index_high, sub, ref rest @ ..] = data else { return None };
        let mut bytes = [0; 4];
        for (byte, &sent) in bytes.iter_mut().zip(rest) {
            *byte = sent;
        }
        let room = dlc.saturating_sub(4);
        let object = ObjectId { index: u16::from_le_bytes([index_low, index_high]), sub };
        let expedited = |len| {
            let data = Expedited::Indicated { data: bytes, len };
            (room >= len).then_some(Command::DownloadExpedited(data))
        };
        let command = match command {
            0x40 => Command::Upload,
            0x22 => Command::DownloadExpedited(Expedited::AsObject { data: bytes, room }),
            0x23 => expedited(4)?,
            0x27 => expedited(3)?,
            0x2B => expedited(2)?,
            0x2F => expedited(1)?,
            0x20 => Command::Download { size: None },
            0x21 if room == 4 => Command::Download { size: Some(u32::from_le_bytes(bytes)) },
            0x21 => return None,
            0x60 | 0x70 => Command::UploadSegment { toggle: command & TOGGLE != 0 },
            0x00..=0x1F => Command::DownloadSegment(segment(command, data)?),
            0x80 => Command::Abort,
            0xA0..=0xDF => block(data).map_or(Command::Unknown, Command::Block),
            _ => Command::Unknown,
        };
        Some(Self { object, command })
    }
}

/// `None` when the frame is not whole or no request of a block transfer.
fn block(data: &[u8]) -> Option<block::Command> {
    block::Command::parse(data.try_into().ok()?)
}

const TOGGLE: u8 = 1 << 4;

/// `None` when the frame ends before the data that the command announces.
fn segment(command: u8, data: &[u8]) -> Option<Segment> {
    const LAST: u8 = 1;
    let unused = usize::from(command >> 1 & 7);
    let sent = data.get(1..=SEGMENT_LEN - unused)?;
    let mut bytes = [0; SEGMENT_LEN];
    for (byte, &sent) in bytes.iter_mut().zip(sent) {
        *byte = sent;
    }
    Some(Segment {
        data: bytes,
        len: u8::try_from(sent.len()).ok()?,
        toggle: command & TOGGLE != 0,
        last: command & LAST != 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: [u8; 4] = [1, 2, 3, 4];

    /// NM17x SDO-01, SDO-02; decision A-18: shorter frames than the command says are dropped.
    #[test]
    fn a_request_needs_the_bytes_its_command_announces() {
        let indicated =
            |data, len| Some(Command::DownloadExpedited(Expedited::Indicated { data, len }));
        for (command, dlc, expected) in [
            (0x40, 3, None),
            (0x40, 4, Some(Command::Upload)),
            (0x23, 8, indicated(BYTES, 4)),
            (0x23, 7, None),
            (0x2B, 6, indicated([1, 2, 0, 0], 2)),
            (0x2B, 5, None),
            (0x2F, 8, indicated(BYTES, 1)),
            (0x2F, 4, None),
            (
                0x22,
                5,
                Some(Command::DownloadExpedited(Expedited::AsObject {
                    data: [1, 0, 0, 0],
                    room: 1,
                })),
            ),
            (0x20, 4, Some(Command::Download { size: None })),
            (0x21, 8, Some(Command::Download { size: Some(0x0403_0201) })),
            (0x21, 7, None),
            (0x70, 8, Some(Command::UploadSegment { toggle: true })),
            (0x80, 8, Some(Command::Abort)),
            (0xA0, 7, Some(Command::Unknown)),
            (0xE0, 8, Some(Command::Unknown)),
            (0x41, 8, Some(Command::Unknown)),
        ] {
            let frame = [command, 0x05, 0x20, 0x07, 1, 2, 3, 4];
            let request = Request::parse(&frame[..dlc]);
            assert_eq!(request.map(|r| r.command), expected, "{command:#04x} in {dlc} bytes");
            let object = ObjectId { index: 0x2005, sub: 7 };
            assert!(request.is_none_or(|r| r.object == object));
        }
    }

    #[test]
    fn a_segment_says_how_much_of_it_counts() {
        let frame = [0x1B, 1, 2, 3, 4, 5, 6, 7];
        let Some(Command::DownloadSegment(segment)) = Request::parse(&frame).map(|r| r.command)
        else {
            panic!("not a segment");
        };
        assert_eq!((segment.bytes(), segment.toggle, segment.last), (&[1, 2][..], true, true));
        assert_eq!(Request::parse(&[0x00, 1, 2, 3, 4, 5, 6]), None);
    }
}
