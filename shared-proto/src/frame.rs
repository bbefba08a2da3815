//! Framing: postcard, CRC-16, COBS, zero.

use core::marker::PhantomData;

use crc::{CRC_16_IBM_3740, Crc};
use heapless::Vec;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::limits::{CRC_LEN, FRAME_MAX, MESSAGE_MAX};

/// A message ready for the wire.
pub type Encoded = Vec<u8, FRAME_MAX>;

/// Detects every error of up to three bits in a frame of this length.
static CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// The bytes of `message` on the wire.
#[must_use]
pub fn encode(message: &impl Serialize) -> Encoded {
    let mut buffer = [0; MESSAGE_MAX];
    // `limits` proves at compile time that every message fits.
    let Ok(bytes) = postcard::to_slice(message, &mut buffer) else {
        debug_assert!(false, "a message longer than its bound");
        return Encoded::new();
    };
    let crc = CRC.checksum(bytes).to_le_bytes();
    stuff(bytes.iter().chain(&crc))
}

/// COBS: each zero, and one before all bytes, gives way to the distance to the next. The zero behind
/// all bytes ends the frame.
fn stuff<'a>(bytes: impl Iterator<Item = &'a u8>) -> Encoded {
    let mut frame = Encoded::new();
    let mut zero_at = 0;
    let _ = frame.push(0);
    for &byte in bytes.chain(&[0]) {
        if byte == 0 {
            let distance = frame.len() - zero_at;
            if let (Some(place), Ok(distance)) = (frame.get_mut(zero_at), u8::try_from(distance)) {
                *place = distance;
            }
            zero_at = frame.len();
        }
        let _ = frame.push(byte);
    }
    frame
}

/// The bytes that became `frame`, which comes without its closing zero. `None` when a distance leads
/// out of it.
fn unstuff(frame: &[u8]) -> Option<Vec<u8, FRAME_MAX>> {
    let mut bytes = Vec::new();
    let mut rest = frame;
    while let [distance, behind @ ..] = rest {
        let run_len = usize::from(*distance).checked_sub(1)?;
        let (run, next) = behind.split_at_checked(run_len)?;
        bytes.extend_from_slice(run).ok()?;
        if !next.is_empty() {
            bytes.push(0).ok()?;
        }
        rest = next;
    }
    Some(bytes)
}

/// Collects bytes from the wire and finds the messages `M` in them.
#[derive(Debug)]
pub struct Receiver<M> {
    frame: Vec<u8, FRAME_MAX>,
    overrun: bool,
    damaged: u32,
    message: PhantomData<fn() -> M>,
}

impl<M> Default for Receiver<M> {
    fn default() -> Self {
        Self { frame: Vec::new(), overrun: false, damaged: 0, message: PhantomData }
    }
}

impl<M: DeserializeOwned> Receiver<M> {
    /// Takes the next byte. A message comes out with the zero that ends an undamaged frame.
    pub fn push(&mut self, byte: u8) -> Option<M> {
        if byte != 0 {
            self.overrun |= self.frame.push(byte).is_err();
            return None;
        }
        let frame_is_empty = self.frame.is_empty();
        let message = if self.overrun { None } else { self.decode() };
        self.damaged += u32::from(message.is_none() && !frame_is_empty);
        self.frame.clear();
        self.overrun = false;
        message
    }

    fn decode(&self) -> Option<M> {
        let bytes = unstuff(&self.frame)?;
        let (message, crc) = bytes.split_last_chunk::<CRC_LEN>()?;
        if CRC.checksum(message).to_le_bytes() != *crc {
            return None;
        }
        let (message, rest) = postcard::take_from_bytes(message).ok()?;
        rest.is_empty().then_some(message)
    }

    /// Frames dropped because they were damaged.
    #[must_use]
    pub fn damaged(&self) -> u32 {
        self.damaged
    }
}
