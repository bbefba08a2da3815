use proptest::prelude::*;

use crate::client::upload;
use crate::{Server, abort};

proptest! {
    /// CiA 301, sections 7.2.4.3.13 to 7.2.4.3.16: a text of any length arrives in blocks of any
    /// size, whatever part of each block the client misses.
    #[test]
    fn a_text_arrives_whole_whatever_is_missed(
        log in prop::collection::vec(any::<u8>(), 0..=255),
        block_len in 1..=127_u8,
        kept in prop::collection::vec(0..40_usize, 0..12),
    ) {
        let mut server = Server::new();
        server.texts.log.clone_from(&log);
        let mut kept = kept.into_iter();
        let read = upload(&mut server, 0x2008, block_len, |_| kept.next().unwrap_or(usize::MAX));
        prop_assert_eq!(read, log);
        prop_assert_eq!(server.node.poll_timeout(), None);
    }
}

/// CiA 301, section 7.2.4.3.13: a number is a value like any other.
#[test]
fn a_number_arrives_in_one_segment() {
    let mut server = Server::new();
    assert_eq!(upload(&mut server, 0x1017, 127, |sent| sent), [0, 0]);
}

/// CiA 301, section 7.2.4.3.13: up to the client's threshold the server leaves blocks out.
#[test]
fn a_short_value_goes_without_blocks() {
    let mut server = Server::new();
    server.texts.note = b"ABCDE".to_vec();
    let answer = server.answer([0xA4, 0x09, 0x20, 0, 127, 5, 0, 0]);
    assert_eq!(answer, [0x41, 0x09, 0x20, 0, 5, 0, 0, 0]);
    assert_eq!(server.answer([0x60, 0, 0, 0, 0, 0, 0, 0]), *b"\x05ABCDE\0\0");
    let answer = server.answer([0xA4, 0x09, 0x20, 0, 127, 4, 0, 0]);
    assert_eq!(answer, [0xC6, 0x09, 0x20, 0, 5, 0, 0, 0]);
}

/// CiA 301, section 7.2.4.3.15: without a checksum of the client there is none of the server.
#[test]
fn a_client_without_checksum_gets_zero() {
    let mut server = Server::new();
    server.texts.note = b"ABC".to_vec();
    assert_eq!(server.answer([0xA0, 0x09, 0x20, 0, 1, 0, 0, 0])[0], 0xC6);
    assert_eq!(server.answer([0xA3, 0, 0, 0, 0, 0, 0, 0]), *b"\x81ABC\0\0\0\0");
    assert_eq!(server.answer([0xA2, 1, 1, 0, 0, 0, 0, 0]), [0xD1, 0, 0, 0, 0, 0, 0, 0]);
}

/// CiA 301, section 7.2.4.3.17: every mistake of the client has its code and ends the transfer.
#[test]
fn a_mistake_ends_the_transfer() {
    const START: [u8; 8] = [0xA3, 0, 0, 0, 0, 0, 0, 0];
    const INITIATE: [u8; 8] = [0xA4, 0x09, 0x20, 0, 2, 0, 0, 0];
    for (requests, last, code) in [
        (&[][..], [0xA4, 0x09, 0x20, 0, 0, 0, 0, 0], 0x0504_0002),
        (&[], [0xA4, 0x09, 0x20, 0, 128, 0, 0, 0], 0x0504_0002),
        (&[INITIATE], [0xA1, 0, 0, 0, 0, 0, 0, 0], 0x0504_0001),
        (&[INITIATE], [0xA2, 0, 2, 0, 0, 0, 0, 0], 0x0504_0001),
        (&[INITIATE], [0x60, 0, 0, 0, 0, 0, 0, 0], 0x0504_0001),
        (&[INITIATE, START], START, 0x0504_0001),
        (&[INITIATE, START], [0xA2, 3, 2, 0, 0, 0, 0, 0], 0x0504_0003),
        (&[INITIATE, START], [0xA2, 2, 128, 0, 0, 0, 0, 0], 0x0504_0002),
        (&[INITIATE, START], [0xC1, 0, 0, 0, 0, 0, 0, 0], 0x0504_0001),
    ] {
        let mut server = Server::new();
        server.texts.note = b"12345678901234567890".to_vec();
        for request in requests {
            let _ = server.ask(*request);
        }
        assert_eq!(server.answer(last), abort(0x2009, code), "{last:02X?}");
        assert_eq!(server.node.poll_timeout(), None);
    }
    let mut server = Server::new();
    assert_eq!(server.answer([0xA4, 0x0A, 0x20, 0, 2, 0, 0, 0]), abort(0x200A, 0x0601_0001));
    assert_eq!(server.answer([0xA4, 0x0B, 0x20, 0, 2, 0, 0, 0]), abort(0x200B, 0x0602_0000));
}

/// CiA 301, section 7.2.4.3.17: the client's abort ends it without an answer, its silence with one.
#[test]
fn an_abort_or_silence_ends_the_transfer() {
    let mut server = Server::new();
    server.texts.log = vec![7; 255];
    let _ = server.ask([0xA4, 0x08, 0x20, 0, 2, 0, 0, 0]);
    assert_eq!(server.ask(abort(0x2008, 0x0800_0000)), [[0; 8]; 0]);
    assert_eq!(server.node.poll_timeout(), None);
    let _ = server.ask([0xA4, 0x08, 0x20, 0, 2, 0, 0, 0]);
    assert_eq!(server.ask([0xA3, 0, 0, 0, 0, 0, 0, 0]).len(), 2);
    assert_eq!(server.answers_in(4_999), [[0; 8]; 0]);
    assert_eq!(server.answers_in(1), [abort(0x2008, 0x0504_0000)]);
    let _ = server.ask([0xA4, 0x08, 0x20, 0, 127, 0, 0, 0]);
    assert_eq!(server.answers_in(1_000), [abort(0x2008, 0x0504_0000)]);
}
