//! DEV1 on the stack of this repository.

use canopen::{Application, CanId, Event, Frame, Node, NodeId, WriteError, lss};
use dev1::{BuiltIn, DICTIONARY, Device, LEN, NODE_ID};
use object_dictionary::{ObjectId, Row, Slot};
use units::Instant;

use crate::{Bus, Stack, input_8, input_32};

/// The stack of this repository.
#[derive(Debug)]
pub struct Spindle<D = Device> {
    node: Node<LEN, BuiltIn>,
    device: D,
}

/// A device that does not serve block transfer.
#[derive(Debug, Default)]
pub struct WithoutBlocks(Device);

impl Application for WithoutBlocks {
    fn text(&self, slot: Slot, row: &Row) -> Option<&[u8]> {
        self.0.text(slot, row)
    }

    fn write_text(&mut self, slot: Slot, row: &Row, text: &[u8]) -> Result<(), WriteError> {
        self.0.write_text(slot, row, text)
    }
}

impl<D: Application + Default> Stack for Spindle<D> {
    type Frame = Frame;

    fn new() -> Self {
        Self { node: dev1::node(NODE_ID), device: D::default() }
    }

    fn start(&mut self) {
        self.boot(Instant::ZERO);
    }

    fn frame(id: u16, len: u8, data: [u8; 8]) -> Frame {
        Frame::prefix(CanId::from_low_bits(u32::from(id)), data, len)
    }

    fn remote_frame(id: u16, len: u8) -> Frame {
        let id = CanId::from_low_bits(u32::from(id));
        Frame::new_remote(id, len).unwrap_or(Frame::full(id, [0; 8]))
    }

    fn handle(&mut self, now_us: u64, frame: &Frame, bus: &impl Bus) {
        let now = Instant::from_micros(now_us);
        self.node.handle_frame(now, frame, &mut self.device);
        self.drain(now, bus);
    }

    fn tick(&mut self, now_us: u64, bus: &impl Bus) {
        let now = Instant::from_micros(now_us);
        self.node.handle_timeout(now, &mut self.device);
        self.drain(now, bus);
    }

    fn ask_when_due(&self) {
        core::hint::black_box(self.node.poll_timeout());
    }

    fn output_32(&mut self, sub: u8) -> u32 {
        self.node.values().raw(slot(0x6200, sub))
    }

    fn output_8(&mut self, sub: u8) -> u8 {
        let [value, ..] = self.node.values().raw(slot(0x6201, sub)).to_le_bytes();
        value
    }
}

impl<D: Application + Default> Spindle<D> {
    /// The inputs are there before the boot-up message.
    fn boot(&mut self, now: Instant) {
        for (slot, row) in DICTIONARY.slots() {
            let value = match row.id() {
                ObjectId { index: 0x6000, sub: sub @ 1.. } => input_32(sub),
                ObjectId { index: 0x6001, sub: sub @ 1.. } => input_8(sub).into(),
                _ => continue,
            };
            self.node.set_value(now, slot, value);
        }
        self.node.boot(now);
    }

    fn restart(&mut self, now: Instant, node_id: Option<NodeId>) {
        self.node = dev1::node(node_id.unwrap_or(NODE_ID));
        match node_id {
            Some(_) => self.boot(now),
            None => self.node.wait_for_node_id(),
        }
    }

    fn drain(&mut self, now: Instant, bus: &impl Bus) {
        while let Some(event) = self.node.poll_event() {
            self.follow(now, event);
        }
        while bus.is_free()
            && let Some(frame) = self.node.take_transmit()
        {
            bus.send(u32::from(frame.id().get()), u32::from(frame.dlc()), frame.padded());
        }
    }

    /// What a device without a memory and without other bit rates does. Apart from what every frame
    /// passes, since events are rare.
    #[inline(never)]
    #[expect(clippy::wildcard_enum_match_arm, reason = "nothing else asks for anything")]
    fn follow(&mut self, now: Instant, event: Event) {
        match event {
            Event::ResetNode => self.restart(now, Some(NODE_ID)),
            Event::ResetCommunication => self.restart(now, self.node.pending_node_id()),
            Event::Lss(lss::Event::Configured { node_id }) => self.restart(now, Some(node_id)),
            Event::Store { .. } | Event::Restore { .. } => {
                self.node.handle_stored(Err(WriteError::NotStored));
            }
            Event::Lss(lss::Event::Store { .. }) => {
                self.node.handle_lss_stored(Err(lss::StoreError::NotSupported));
            }
            _ => {}
        }
    }
}

fn slot(index: u16, sub: u8) -> Slot {
    DICTIONARY.find(ObjectId { index, sub }).expect("DEV1 has the object")
}
