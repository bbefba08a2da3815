//! DEV1 on the stack of this repository.

use canopen::{CanId, Frame, Node};
use dev1::{DICTIONARY, Device, LEN};
use object_dictionary::{ObjectId, Slot};
use units::Instant;

use crate::{Bus, Stack, input_8, input_32};

/// All operations happen at once.
const NOW: Instant = Instant::from_micros(1_000);

/// The stack of this repository.
#[derive(Debug)]
pub struct Spindle {
    node: Node<LEN>,
    device: Device,
}

impl Stack for Spindle {
    type Frame = Frame;

    fn new() -> Self {
        let mut stack = Self { node: dev1::node(), device: Device::new() };
        for sub in 1..=4 {
            stack.node.set_value(NOW, slot(0x6000, sub), input_32(sub));
        }
        for sub in 1..=8 {
            stack.node.set_value(NOW, slot(0x6001, sub), u32::from(input_8(sub)));
        }
        stack.node.boot(NOW);
        stack.drain(&Bus::default());
        stack
    }

    fn frame(id: u16, data: &[u8]) -> Frame {
        let frame = CanId::new(id).and_then(|id| Frame::new(id, data));
        frame.expect("11 bits and at most 8 bytes")
    }

    fn handle(&mut self, frame: &Frame, bus: &Bus) {
        self.node.handle_frame(NOW, frame, &mut self.device);
        self.drain(bus);
    }

    fn tick(&mut self, bus: &Bus) {
        self.node.handle_timeout(NOW, &mut self.device);
        self.drain(bus);
    }

    fn output_32(&mut self, sub: u8) -> u32 {
        self.node.values().raw(slot(0x6200, sub))
    }

    fn output_8(&mut self, sub: u8) -> u8 {
        let [value, ..] = self.node.values().raw(slot(0x6201, sub)).to_le_bytes();
        value
    }
}

impl Spindle {
    fn drain(&mut self, bus: &Bus) {
        while let Some(event) = self.node.poll_event() {
            core::hint::black_box(event);
        }
        while let Some(frame) = self.node.take_transmit() {
            bus.send(u32::from(frame.id().get()), u32::from(frame.dlc()), frame.bytes());
        }
        core::hint::black_box(self.node.poll_timeout());
    }
}

fn slot(index: u16, sub: u8) -> Slot {
    DICTIONARY.find(ObjectId { index, sub }).expect("DEV1 has the object")
}
