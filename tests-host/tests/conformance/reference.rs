//! Devices that are no products: the stack with a memory, on a bus that takes everything at once.

use canopen::{CanId, Event, Frame, Node, NodeId};
use object_dictionary::{Access, Dictionary, Slot};
use profiles::OBJECTS_MAX;
use units::{Duration, Instant};

use crate::master::Sent;

/// The device, its memory and the bus.
pub(crate) struct Reference {
    dictionary: &'static Dictionary,
    node_id: NodeId,
    node: Node<OBJECTS_MAX>,
    device: dev1::Device,
    now: Instant,
    memory: Vec<(Slot, u32)>,
    sent: Vec<Sent>,
}

impl Reference {
    /// With supply, at delivery.
    pub(crate) fn new(dictionary: &'static Dictionary, node_id: u8) -> Self {
        let node_id = NodeId::new(node_id).expect("a node-ID");
        let mut reference = Self {
            dictionary,
            node_id,
            node: Node::new(dictionary, node_id, &dev1::SETTINGS),
            device: dev1::Device::new(),
            now: Instant::ZERO,
            memory: Vec::new(),
            sent: Vec::new(),
        };
        reference.node.boot(reference.now);
        reference.drain();
        reference
    }

    /// Lets time pass, from deadline to deadline.
    pub(crate) fn advance(&mut self, us: u64) {
        let until = self.now + Duration::from_micros(us);
        while let Some(due_at) = self.node.poll_timeout().filter(|&due_at| due_at <= until) {
            self.now = self.now.max(due_at);
            self.node.handle_timeout(self.now, &mut self.device);
            self.drain();
        }
        self.now = until;
    }

    /// Gives it a data frame, or a remote frame without data.
    pub(crate) fn receive(&mut self, id: u16, data: Option<&[u8]>) {
        let id = CanId::new(id).expect("11 bits");
        let frame = match data {
            Some(data) => Frame::new(id, data),
            None => Frame::new_remote(id, 0),
        };
        let frame = frame.expect("at most 8 bytes");
        self.node.handle_frame(self.now, &frame, &mut self.device);
        self.drain();
    }

    /// What it sent since the last look.
    pub(crate) fn take_sent(&mut self) -> Vec<Sent> {
        std::mem::take(&mut self.sent)
    }

    fn drain(&mut self) {
        self.transmit();
        while let Some(event) = self.node.poll_event() {
            match event {
                Event::ResetNode | Event::ResetCommunication => self.restart(),
                Event::Store { .. } => {
                    self.memory = self.parameters();
                    self.node.handle_stored(Ok(()));
                }
                Event::Restore { .. } => {
                    self.memory.clear();
                    self.node.handle_stored(Ok(()));
                }
                Event::StateChanged { .. }
                | Event::HeartbeatLost { .. }
                | Event::HeartbeatRecovered { .. }
                | Event::GuardingLost
                | Event::GuardingRecovered
                | Event::BusStateChanged { .. }
                | Event::Time(_)
                | Event::Lss(_)
                | Event::PdoOverdue { .. }
                | Event::FiltersChanged
                | Event::TransmitOverflow { .. } => {}
            }
            self.transmit();
        }
    }

    fn transmit(&mut self) {
        while let Some(frame) = self.node.take_transmit() {
            self.sent.push(Sent {
                us: self.now.as_micros(),
                id: frame.id().get(),
                data: frame.data().to_vec(),
            });
        }
    }

    /// All numbers that masters may write.
    fn parameters(&self) -> Vec<(Slot, u32)> {
        let written = self.dictionary.slots().filter(|(_, row)| row.access() == Access::ReadWrite);
        written.map(|(slot, _)| (slot, self.node.values().raw(slot))).collect()
    }

    fn restart(&mut self) {
        self.node = Node::new(self.dictionary, self.node_id, &dev1::SETTINGS);
        for &(slot, raw) in &self.memory {
            self.node.set_value(self.now, slot, raw);
        }
        self.node.boot(self.now);
    }
}
