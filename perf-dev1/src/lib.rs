//! How many instructions a stack takes for what a CANopen device does all day.
//!
//! Every stack runs the same device, DEV1, and the same operations, once on an emulated Cortex-M4
//! and once on the host. An operation is everything from a received frame to the reply in the hands
//! of the controller: frame in, all work, reply out, and the question when to come back.
//!
//! Before it is counted, each operation is run and its replies and effects are compared with what
//! CiA 301 demands, so that no figure belongs to a stack that did not do the work.
#![cfg_attr(target_os = "none", no_std)]

#[cfg(feature = "peers")]
pub mod canopen_rs;
#[cfg(any(feature = "image", not(target_os = "none")))]
mod operations;
pub mod spindle;
#[cfg(feature = "peers")]
pub mod zencan;

#[cfg(any(feature = "image", not(target_os = "none")))]
#[cfg_attr(target_os = "none", path = "m4.rs")]
#[cfg_attr(not(target_os = "none"), path = "host.rs")]
mod platform;

#[cfg(any(feature = "image", not(target_os = "none")))]
pub use platform::main;

use core::sync::atomic::{AtomicU32, Ordering};

/// A CANopen stack that runs DEV1.
pub trait Stack {
    /// A frame as the stack receives it.
    type Frame;

    /// DEV1 at the time 0.
    fn new() -> Self;

    /// What is left to do until it is in Pre-operational, its inputs 0x6000 and 0x6001 are
    /// [`input_32`] and [`input_8`] of their sub-indices, and its boot-up message waits or is sent.
    fn start(&mut self) {}

    /// A data frame of `len` bytes, at most 8.
    fn frame(id: u16, len: u8, data: [u8; 8]) -> Self::Frame;

    /// A remote frame that asks for `len` bytes, at most 8.
    fn remote_frame(id: u16, len: u8) -> Self::Frame;

    /// One operation: takes `frame`, does all that follows from it, sends to `bus`.
    fn handle(&mut self, now_us: u64, frame: &Self::Frame, bus: &impl Bus);

    /// What a device does that looks again and again whether time has brought anything.
    fn tick(&mut self, now_us: u64, bus: &impl Bus);

    /// The question when to come back, which ends an operation. A stack that is looked after again and
    /// again has none.
    fn ask_when_due(&self) {}

    /// The value of output 0x6200:`sub`.
    fn output_32(&mut self, sub: u8) -> u32;

    /// The value of output 0x6201:`sub`.
    fn output_8(&mut self, sub: u8) -> u8;
}

/// Where frames go.
pub trait Bus {
    /// Whether a frame would be taken now.
    fn is_free(&self) -> bool;

    /// Takes a frame. `data` is zero beyond `len`.
    fn send(&self, id: u32, len: u32, data: [u8; 8]);
}

/// What input 0x6000:`sub` holds.
#[must_use]
pub const fn input_32(sub: u8) -> u32 {
    u32::from_le_bytes([sub, 0x22, 0x44, 0x88])
}

/// What input 0x6001:`sub` holds.
#[must_use]
pub const fn input_8(sub: u8) -> u8 {
    0xA0 + sub
}

/// The bytes of a frame as [`Bus::send`] takes them; none beyond eight count.
fn padded(data: &[u8]) -> [u8; 8] {
    data.try_into().unwrap_or_else(|_| {
        let mut bytes = [0; 8];
        for (byte, &sent) in bytes.iter_mut().zip(data) {
            *byte = sent;
        }
        bytes
    })
}

/// Memory in place of the mailbox of a controller, written a word at a time.
#[derive(Debug, Default)]
struct Memory {
    sent: AtomicU32,
    id: AtomicU32,
    len: AtomicU32,
    data: [AtomicU32; 2],
}

impl Bus for Memory {
    fn is_free(&self) -> bool {
        true
    }

    #[inline]
    fn send(&self, id: u32, len: u32, data: [u8; 8]) {
        let [a, b, c, d, e, f, g, h] = data;
        let [low, high] = &self.data;
        low.store(u32::from_le_bytes([a, b, c, d]), Ordering::Relaxed);
        high.store(u32::from_le_bytes([e, f, g, h]), Ordering::Relaxed);
        self.len.store(len, Ordering::Relaxed);
        self.id.store(id, Ordering::Relaxed);
        self.sent.store(self.sent.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }
}
