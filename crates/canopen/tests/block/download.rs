use proptest::prelude::*;

use crate::client::{begin, end, segments};
use crate::{Server, abort};

const NAME: &[u8; 32] = b"A name of thirty-two characters.";

/// The server asks for no more segments than the value has.
fn initiated(server: &mut Server, index: u16, size: u32) {
    let ([low, high], block_len) = (index.to_le_bytes(), (size / 7 + 1) as u8);
    assert_eq!(server.answer(begin(index, size)), [0xA4, low, high, 0, block_len, 0, 0, 0]);
}

/// The server has some of the segments, and asks for those that are missing: for one at least.
fn acknowledged(server: &mut Server, frames: &[[u8; 8]], number: u8, missing: u8) {
    let (last, before) = frames.split_last().unwrap();
    for frame in before {
        assert_eq!(server.ask(*frame), [[0; 8]; 0], "{frame:02X?}");
    }
    assert_eq!(server.answer(*last), [0xA2, number, missing, 0, 0, 0, 0, 0]);
}

const DONE: [u8; 8] = [0xA1, 0, 0, 0, 0, 0, 0, 0];

/// CiA 301, sections 7.2.4.3.9 to 7.2.4.3.12.
#[test]
fn texts_and_numbers_are_written() {
    let mut server = Server::new();
    initiated(&mut server, 0x2007, 32);
    acknowledged(&mut server, &segments(NAME), 5, 1);
    assert_eq!(server.answer(end(NAME)), DONE);
    assert_eq!(server.texts.name, NAME);
    initiated(&mut server, 0x1017, 2);
    acknowledged(&mut server, &segments(&[0x10, 0x27]), 1, 1);
    assert_eq!(server.ask(end(&[0x10, 0x27])), [DONE]);
    assert_eq!(server.answer([0x40, 0x17, 0x10, 0, 0, 0, 0, 0])[4..], [0x10, 0x27, 0, 0]);
}

proptest! {
    /// CiA 301, section 7.2.4.3.10: after a gap the client goes on behind the last segment in
    /// order, numbered from 1 again.
    #[test]
    fn a_lost_segment_is_sent_again(lost in 0..4_usize) {
        let mut server = Server::new();
        initiated(&mut server, 0x2007, 32);
        let mut frames = segments(NAME);
        frames.remove(lost);
        acknowledged(&mut server, &frames, lost as u8, 5 - lost as u8);
        acknowledged(&mut server, &segments(&NAME[lost * 7..]), 5 - lost as u8, 1);
        prop_assert_eq!(server.answer(end(NAME)), DONE);
        prop_assert_eq!(&server.texts.name[..], NAME);
    }
}

/// CiA 301, section 7.2.4.3.17; nothing is written when anything is wrong.
#[test]
fn a_mistake_writes_nothing() {
    let mut server = Server::new();
    for (value, last, code) in [
        (&NAME[..], end(b"Another"), 0x0504_0004),
        (&NAME[..], [0xC6, 0x07, 0x20, 0, 33, 0, 0, 0], 0x0607_0010),
        (&NAME[..28], end(&NAME[..28]), 0x0607_0010),
        (&NAME[..], [0x60, 0, 0, 0, 0, 0, 0, 0], 0x0504_0001),
        (&NAME[..], [0xA3, 0, 0, 0, 0, 0, 0, 0], 0x0504_0001),
    ] {
        initiated(&mut server, 0x2007, 32);
        let frames = segments(value);
        acknowledged(&mut server, &frames, frames.len() as u8, 1);
        assert_eq!(server.answer(last), abort(0x2007, code), "{last:02X?}");
        assert_eq!((server.texts.name.len(), server.node.poll_timeout()), (0, None));
    }
    for (index, code) in [(0x2008, 0x0601_0002), (0x200B, 0x0602_0000)] {
        assert_eq!(server.answer(begin(index, 1)), abort(index, code));
    }
    initiated(&mut server, 0x200A, 1);
    acknowledged(&mut server, &segments(&[2]), 1, 1);
    assert_eq!(server.answer(end(&[2])), abort(0x200A, 0x0609_0031));
}

/// CiA 301, section 7.2.4.3.10: more than the object holds ends the transfer. The client hears so before
/// it sends what would be taken for requests of their own: the number of segment 0x2B is a command.
#[test]
fn too_much_ends_the_transfer() {
    let mut server = Server::new();
    assert_eq!(server.answer([0xC4, 0x17, 0x10, 0, 0, 0, 0, 0]), [0xA4, 0x17, 0x10, 0, 1, 0, 0, 0]);
    assert_eq!(server.answer([1, 0, 0, 0, 0, 0, 0, 0]), [0xA2, 1, 1, 0, 0, 0, 0, 0]);
    assert_eq!(server.answer([1, 0, 0, 0, 0, 0, 0, 0]), abort(0x1017, 0x0607_0010));
}

/// CiA 301, section 7.2.4.3.12: the checksum counts only where the client uses it.
#[test]
fn a_client_without_checksum_needs_none() {
    let mut server = Server::new();
    assert_eq!(server.answer([0xC2, 0x17, 0x10, 0, 2, 0, 0, 0])[0], 0xA4);
    acknowledged(&mut server, &segments(&[0, 0]), 1, 1);
    assert_eq!(server.answer([0xD5, 0xAA, 0x55, 0, 0, 0, 0, 0]), DONE);
}

/// CiA 301, section 7.2.4.3.17: the abort counts among segments too, and silence has its answer.
#[test]
fn an_abort_or_silence_ends_the_transfer() {
    let mut server = Server::new();
    initiated(&mut server, 0x2007, 32);
    assert_eq!(server.ask(abort(0x2007, 0x0800_0000)), [[0; 8]; 0]);
    assert_eq!(server.node.poll_timeout(), None);
    initiated(&mut server, 0x2007, 32);
    assert_eq!(server.answers_in(1_000), [abort(0x2007, 0x0504_0000)]);
}
