//! How many instructions a stack takes for what a CANopen device does all day.
//!
//! Every stack runs the same device, DEV1, and the same operations, once on an emulated Cortex-M4
//! and once on the host. An operation is everything from a received frame to the reply in the hands
//! of the controller: frame in, all work, reply out, and the question when to come back.
//!
//! Before it is counted, each operation is run and its replies and effects are compared with what
//! CiA 301 demands, so that no figure belongs to a stack that did not do the work.
#![cfg_attr(target_os = "none", no_std)]

mod operations;
pub mod spindle;

#[cfg_attr(target_os = "none", path = "m4.rs")]
#[cfg_attr(not(target_os = "none"), path = "host.rs")]
mod platform;

pub use operations::OPERATIONS;
pub use platform::main;

use core::sync::atomic::{AtomicU32, Ordering};

/// A CANopen stack that runs DEV1.
pub trait Stack {
    /// A frame as the stack receives it.
    type Frame;

    /// DEV1 after its boot-up message, in Pre-operational. Its inputs 0x6000 and 0x6001 hold
    /// [`input_32`] and [`input_8`] of their sub-indices.
    fn new() -> Self;

    /// A data frame. `data` has at most 8 bytes.
    fn frame(id: u16, data: &[u8]) -> Self::Frame;

    /// One operation: takes `frame`, does all that follows from it, sends to `bus`.
    fn handle(&mut self, frame: &Self::Frame, bus: &Bus);

    /// What the stack asks for when nothing happens: every millisecond, or never.
    fn tick(&mut self, bus: &Bus);

    /// The value of output 0x6200:`sub`.
    fn output_32(&mut self, sub: u8) -> u32;

    /// The value of output 0x6201:`sub`.
    fn output_8(&mut self, sub: u8) -> u8;
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

/// Where replies go: memory in place of the mailbox of a controller, written a word at a time.
#[derive(Debug, Default)]
pub struct Bus {
    sent: AtomicU32,
    id: AtomicU32,
    len: AtomicU32,
    data: [AtomicU32; 2],
}

/// What was sent last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sent {
    id: u32,
    len: u32,
    data: [u8; 8],
}

impl Bus {
    /// Takes a frame. `data` is zero beyond `len`.
    #[inline]
    pub fn send(&self, id: u32, len: u32, data: [u8; 8]) {
        let [a, b, c, d, e, f, g, h] = data;
        let [low, high] = &self.data;
        low.store(u32::from_le_bytes([a, b, c, d]), Ordering::Relaxed);
        high.store(u32::from_le_bytes([e, f, g, h]), Ordering::Relaxed);
        self.len.store(len, Ordering::Relaxed);
        self.id.store(id, Ordering::Relaxed);
        self.sent.store(self.sent.load(Ordering::Relaxed) + 1, Ordering::Relaxed);
    }

    /// How many frames were sent since the last call.
    fn take_sent(&self) -> u32 {
        let sent = self.sent.load(Ordering::Relaxed);
        self.sent.store(0, Ordering::Relaxed);
        sent
    }

    fn last(&self) -> Sent {
        let [low, high] = &self.data;
        let low = low.load(Ordering::Relaxed).to_le_bytes();
        let high = high.load(Ordering::Relaxed).to_le_bytes();
        let mut data = [0; 8];
        for (byte, sent) in data.iter_mut().zip(low.into_iter().chain(high)) {
            *byte = sent;
        }
        Sent { id: self.id.load(Ordering::Relaxed), len: self.len.load(Ordering::Relaxed), data }
    }
}

/// The function whose instructions are counted.
#[inline(never)]
fn operate<S: Stack>(stack: &mut S, frame: &S::Frame, bus: &Bus) {
    stack.handle(frame, bus);
}

/// The same for what happens without a frame.
#[inline(never)]
fn operate_idle<S: Stack>(stack: &mut S, _: &S::Frame, bus: &Bus) {
    stack.tick(bus);
}
