//! The operations: what is received, and what has to come of it.

use core::sync::atomic::Ordering;

use crate::{Memory, Stack, input_8, input_32, padded};

/// A frame as plain data.
type Frame<'a> = (u16, &'a [u8]);

/// Something a device does all day. It is done by turns with one frame and another, so that values
/// do change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Operation {
    /// What it is called in the tables.
    pub(crate) name: &'static str,
    /// What configures the device for it, in Pre-operational; all are SDO downloads.
    configuration: &'static [[u8; 8]],
    /// What starts it, by turns. Nothing for the passage of time.
    requests: Option<[Frame<'static>; 2]>,
    /// What the device sends each time, if anything.
    replies: Option<[Frame<'static>; 2]>,
    /// What it leaves behind.
    effect: Effect,
}

#[derive(Clone, Copy, Debug)]
enum Effect {
    None,
    /// 0x6200:04 is the last four bytes of the request.
    Downloaded,
    /// 0x6200:01 and 02 are the bytes of the request.
    Outputs32,
    /// 0x6201:01 to 08 are the bytes of the request.
    Outputs8,
}

const NMT: u16 = 0x000;
const SYNC: u16 = 0x080;
const RPDO_1: u16 = 0x210;
const RPDO_2: u16 = 0x310;
const TPDO_1: u16 = 0x190;
const TPDO_2: u16 = 0x290;
const REQUEST: u16 = 0x610;
const RESPONSE: u16 = 0x590;

const START: &[u8] = &[0x01, 0x10];

/// TPDO1 off, TPDO2 with every SYNC.
const TPDO_2_WITH_SYNC: &[[u8; 8]] = &[
    [0x23, 0x00, 0x18, 0x01, 0x90, 0x01, 0x00, 0xC0],
    [0x2F, 0x01, 0x18, 0x02, 0x01, 0x00, 0x00, 0x00],
];

/// All of them, in the order of the tables.
pub(crate) const OPERATIONS: [Operation; 10] = [
    Operation {
        name: "SDO upload 0x1017",
        configuration: &[],
        requests: Some([(REQUEST, &[0x40, 0x17, 0x10, 0x00, 0, 0, 0, 0]); 2]),
        replies: Some([(RESPONSE, &[0x4B, 0x17, 0x10, 0x00, 0xE8, 0x03, 0, 0]); 2]),
        effect: Effect::None,
    },
    Operation {
        name: "SDO upload 0x6200:04 (end of the dictionary)",
        configuration: &[[0x23, 0x00, 0x62, 0x04, 0x78, 0x56, 0x34, 0x12]],
        requests: Some([(REQUEST, &[0x40, 0x00, 0x62, 0x04, 0, 0, 0, 0]); 2]),
        replies: Some([(RESPONSE, &[0x43, 0x00, 0x62, 0x04, 0x78, 0x56, 0x34, 0x12]); 2]),
        effect: Effect::None,
    },
    Operation {
        name: "SDO download 0x6200:04",
        configuration: &[],
        requests: Some([
            (REQUEST, &[0x23, 0x00, 0x62, 0x04, 0x11, 0x22, 0x33, 0x44]),
            (REQUEST, &[0x23, 0x00, 0x62, 0x04, 0x55, 0x66, 0x77, 0x88]),
        ]),
        replies: Some([(RESPONSE, &[0x60, 0x00, 0x62, 0x04, 0, 0, 0, 0]); 2]),
        effect: Effect::Downloaded,
    },
    Operation {
        name: "SDO abort, no object",
        configuration: &[],
        requests: Some([(REQUEST, &[0x40, 0x00, 0x70, 0x00, 0, 0, 0, 0]); 2]),
        replies: Some([(RESPONSE, &[0x80, 0x00, 0x70, 0x00, 0x00, 0x00, 0x02, 0x06]); 2]),
        effect: Effect::None,
    },
    Operation {
        name: "SYNC to TPDO 2 × u32",
        configuration: &[],
        requests: Some([(SYNC, &[]); 2]),
        replies: Some([(TPDO_1, &INPUTS_32); 2]),
        effect: Effect::None,
    },
    Operation {
        name: "SYNC to TPDO 8 × u8",
        configuration: TPDO_2_WITH_SYNC,
        requests: Some([(SYNC, &[]); 2]),
        replies: Some([(TPDO_2, &INPUTS_8); 2]),
        effect: Effect::None,
    },
    Operation {
        name: "RPDO 2 × u32 to values",
        configuration: &[],
        requests: Some([(RPDO_1, &[1, 2, 3, 4, 5, 6, 7, 8]), (RPDO_1, &[8, 7, 6, 5, 4, 3, 2, 1])]),
        replies: None,
        effect: Effect::Outputs32,
    },
    Operation {
        name: "RPDO 8 × u8 to values",
        configuration: &[],
        requests: Some([(RPDO_2, &[1, 2, 3, 4, 5, 6, 7, 8]), (RPDO_2, &[8, 7, 6, 5, 4, 3, 2, 1])]),
        replies: None,
        effect: Effect::Outputs8,
    },
    Operation {
        name: "foreign frame",
        configuration: &[],
        requests: Some([(0x2A5, &[1, 2, 3, 4, 5, 6, 7, 8]); 2]),
        replies: None,
        effect: Effect::None,
    },
    Operation {
        name: "idle",
        configuration: &[],
        requests: None,
        replies: None,
        effect: Effect::None,
    },
];

const INPUTS_32: [u8; 8] = {
    let ([a, b, c, d], [e, f, g, h]) = (input_32(1).to_le_bytes(), input_32(2).to_le_bytes());
    [a, b, c, d, e, f, g, h]
};

const INPUTS_8: [u8; 8] = [
    input_8(1),
    input_8(2),
    input_8(3),
    input_8(4),
    input_8(5),
    input_8(6),
    input_8(7),
    input_8(8),
];

impl Operation {
    /// A device that is ready for it, with the frames that start it.
    ///
    /// # Panics
    /// When the stack refuses the configuration.
    pub(crate) fn prepare<S: Stack>(&self, bus: &Memory) -> (S, [S::Frame; 2]) {
        let mut stack = S::new();
        stack.start();
        stack.tick(NOW_US, bus);
        for request in self.configuration {
            operate(&mut stack, &frame::<S>((REQUEST, request)), bus);
            let [_, low, high, sub, ..] = *request;
            let taken = [0x60, low, high, sub, 0, 0, 0, 0];
            assert_eq!(bus.last(), sent((RESPONSE, &taken)), "{}: configuration", self.name);
        }
        operate(&mut stack, &frame::<S>((NMT, START)), bus);
        let [first, second] = self.requests.unwrap_or([(0x7FF, &[]); 2]);
        (stack, [first, second].map(frame::<S>))
    }

    /// Does it once.
    pub(crate) fn run<S: Stack>(&self, stack: &mut S, frame: &S::Frame, bus: &Memory) {
        (self.function())(stack, frame, bus);
    }

    /// The function that does it.
    pub(crate) fn function<S: Stack>(&self) -> fn(&mut S, &S::Frame, &Memory) {
        if self.requests.is_some() { operate } else { operate_idle }
    }

    /// Does it some times and compares what comes of it each time.
    ///
    /// # Panics
    /// When something else comes of it.
    pub(crate) fn check<S: Stack>(&self) {
        let bus = Memory::default();
        let (mut stack, frames) = self.prepare::<S>(&bus);
        bus.take_sent();
        for turn in (0..frames.len()).cycle().take(10) {
            let Some(frame) = frames.get(turn) else { break };
            self.run(&mut stack, frame, &bus);
            let reply = self.replies.and_then(|replies| replies.get(turn).copied());
            assert_eq!(bus.take_sent(), u32::from(reply.is_some()), "{}: replies", self.name);
            if let Some(reply) = reply {
                assert_eq!(bus.last(), sent(reply), "{}", self.name);
            }
            let request = self.requests.and_then(|requests| requests.get(turn).copied());
            self.check_effect(&mut stack, request.map_or(&[], |(_, data)| data));
        }
    }

    fn check_effect<S: Stack>(&self, stack: &mut S, request: &[u8]) {
        let (low, high) = request.split_at_checked(4).unwrap_or_default();
        let number = |bytes: &[u8]| bytes.try_into().map_or(0, u32::from_le_bytes);
        match self.effect {
            Effect::None => {}
            Effect::Downloaded => assert_eq!(stack.output_32(4), number(high), "{}", self.name),
            Effect::Outputs32 => {
                assert_eq!(stack.output_32(1), number(low), "{}", self.name);
                assert_eq!(stack.output_32(2), number(high), "{}", self.name);
            }
            Effect::Outputs8 => {
                for (sub, &byte) in (1..).zip(request) {
                    assert_eq!(stack.output_8(sub), byte, "{}", self.name);
                }
            }
        }
    }
}

/// All operations happen at once: nothing is due.
const NOW_US: u64 = 1_000;

/// The function whose instructions are counted.
#[inline(never)]
fn operate<S: Stack>(stack: &mut S, frame: &S::Frame, bus: &Memory) {
    stack.handle(NOW_US, frame, bus);
    stack.ask_when_due();
}

/// The same for what happens without a frame.
#[inline(never)]
fn operate_idle<S: Stack>(stack: &mut S, _: &S::Frame, bus: &Memory) {
    stack.tick(NOW_US, bus);
}

/// What was sent last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sent {
    id: u32,
    len: u32,
    data: [u8; 8],
}

impl Memory {
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

fn frame<S: Stack>((id, data): Frame<'_>) -> S::Frame {
    S::frame(id, len(data), padded(data))
}

fn sent((id, data): Frame<'_>) -> Sent {
    Sent { id: u32::from(id), len: u32::from(len(data)), data: padded(data) }
}

fn len(data: &[u8]) -> u8 {
    u8::try_from(data.len()).unwrap_or(u8::MAX)
}
