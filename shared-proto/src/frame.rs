//! Framing: postcard, CRC-16, COBS, zero.

use core::marker::PhantomData;

use crc::{CRC_16_IBM_3740, Crc};
use heapless::Vec;
use postcard::de_flavors::crc::take_from_bytes_u16;
use postcard::ser_flavors::crc::CrcModifier;
use postcard::ser_flavors::{Cobs, Slice};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::limits::FRAME_MAX;

/// A message ready for the wire.
pub type Encoded = Vec<u8, FRAME_MAX>;

/// Detects every error of up to three bits in a frame of this length.
static CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

/// The bytes of `message` on the wire.
#[must_use]
pub fn encode(message: &impl Serialize) -> Encoded {
    let mut frame = Encoded::new();
    let mut buffer = [0; FRAME_MAX];
    let written = Cobs::try_new(Slice::new(&mut buffer))
        .map(|cobs| CrcModifier::new(cobs, CRC.digest()))
        .and_then(|flavor| postcard::serialize_with_flavor(message, flavor));
    // `limits` proves at compile time that every message fits.
    debug_assert!(written.is_ok(), "a message longer than its bound");
    if let Ok(bytes) = written {
        let _ = frame.extend_from_slice(bytes);
    }
    frame
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

    fn decode(&mut self) -> Option<M> {
        let decoded = cobs::decode_in_place(&mut self.frame).ok()?;
        let bytes = self.frame.get(..decoded)?;
        let (message, rest) = take_from_bytes_u16(bytes, CRC.digest()).ok()?;
        rest.is_empty().then_some(message)
    }

    /// Frames dropped because they were damaged.
    #[must_use]
    pub fn damaged(&self) -> u32 {
        self.damaged
    }
}
