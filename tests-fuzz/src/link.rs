//! The serial line between the controllers: damage is noticed, and forgotten at the next zero.

use std::fmt::Debug;

use serde::Serialize;
use serde::de::DeserializeOwned;
use shared_proto::{Receiver, ToApplication, ToInterface, encode};

use crate::bytes::Bytes;

/// Feeds a receiver of each side with noise and with frames around any body.
pub fn converse(input: &[u8]) {
    let mut bytes = Bytes::new(input);
    let mut line = Vec::new();
    while let Some(choice) = bytes.u8() {
        let Some(piece) = bytes.up_to(80) else { break };
        match choice % 4 {
            0 => line.extend(piece),
            1 => line.push(0),
            _ => line.extend(framed(piece)),
        }
    }
    check::<ToInterface>(&line);
    check::<ToApplication>(&line);
}

/// A receiver finds in a line what a new one finds in each of its frames, and counts the others.
fn check<M: DeserializeOwned + Serialize + PartialEq + Debug>(line: &[u8]) {
    let mut receiver = Receiver::<M>::default();
    let mut damaged = 0;
    for frame in line.split_inclusive(|&byte| byte == 0) {
        let message = received(&mut receiver, frame);
        assert_eq!(message, received(&mut Receiver::default(), frame), "{frame:02X?}");
        let is_frame = frame.len() > 1 && frame.ends_with(&[0]);
        damaged += u32::from(is_frame && message.is_none());
        if let Some(message) = message {
            let again = received(&mut Receiver::default(), &encode(&message));
            assert_eq!(again, Some(message), "a message that cannot be sent");
        }
    }
    assert_eq!(receiver.damaged(), damaged);
}

/// What comes out with the last byte; nothing may come before.
fn received<M: DeserializeOwned>(receiver: &mut Receiver<M>, frame: &[u8]) -> Option<M> {
    let mut messages: Vec<_> = frame.iter().map(|&byte| receiver.push(byte)).collect();
    let last = messages.pop()?;
    assert!(messages.iter().all(Option::is_none), "a message in the middle");
    last
}

/// CRC-16 (polynomial 0x1021, beginning with 0xFFFF) and COBS around `body`, and the zero.
fn framed(body: &[u8]) -> Vec<u8> {
    let crc = body.iter().fold(0xFFFF_u16, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte) << 8, |crc, _| {
            crc << 1 ^ if crc & 1 << 15 == 0 { 0 } else { 0x1021 }
        })
    });
    let whole = [body, &crc.to_le_bytes()].concat();
    let mut frame = Vec::new();
    for run in whole.split(|&byte| byte == 0) {
        frame.push(run.len() as u8 + 1);
        frame.extend(run);
    }
    frame.push(0);
    frame
}
