//! DEV1 on canopen-rs. Its block of bytes is half as long, the most that the stack can hold. It has
//! no timers, and a caller that sends what a SYNC asks for.

use canopen_rs::{
    AccessType, Address, ByteString, Entry, Node, NodeId, ObjectDictionary, Value, nmt, sync,
};

use crate::{Bus, Stack, input_8, input_32, padded};

/// Entries of the dictionary.
const ENTRIES: usize = 127;

/// The type of an entry.
#[derive(Clone, Copy)]
enum Kind {
    U8,
    U16,
    U32,
}

use AccessType::{Ro, Rw};
use Kind::{U8, U16, U32};

/// Index, first sub-index, how many of them, type, access, and the value of all of them.
type Span = (u16, u8, u8, Kind, AccessType, u32);

#[rustfmt::skip]
const SPANS: &[Span] = &[
    (0x1000, 0, 1, U32, Ro, 0x0003_0191),
    (0x1001, 0, 1, U8, Ro, 0),
    (0x1003, 0, 1, U8, Rw, 0), (0x1003, 1, 8, U32, Ro, 0),
    (0x1005, 0, 1, U32, Rw, 0x80),
    (0x1006, 0, 1, U32, Rw, 0),
    (0x1007, 0, 1, U32, Rw, 0),
    (0x1010, 0, 1, U8, Ro, 4), (0x1010, 1, 4, U32, Rw, 1),
    (0x1011, 0, 1, U8, Ro, 4), (0x1011, 1, 4, U32, Rw, 1),
    (0x1014, 0, 1, U32, Rw, 0x90),
    (0x1015, 0, 1, U16, Rw, 0),
    (0x1016, 0, 1, U8, Ro, 4), (0x1016, 1, 4, U32, Rw, 0),
    (0x1017, 0, 1, U16, Rw, 1_000),
    (0x1018, 0, 1, U8, Ro, 4), (0x1018, 1, 1, U32, Ro, 0x1234),
    (0x1018, 2, 1, U32, Ro, 2), (0x1018, 3, 1, U32, Ro, 3), (0x1018, 4, 1, U32, Ro, 4),
    (0x1019, 0, 1, U8, Rw, 0),
    (0x1200, 0, 1, U8, Ro, 2), (0x1200, 1, 1, U32, Ro, 0x610), (0x1200, 2, 1, U32, Ro, 0x590),
    (0x1400, 0, 1, U8, Ro, 5), (0x1400, 1, 1, U32, Rw, 0x210), (0x1400, 2, 1, U8, Rw, 254), (0x1400, 5, 1, U16, Rw, 0),
    (0x1401, 0, 1, U8, Ro, 5), (0x1401, 1, 1, U32, Rw, 0x310), (0x1401, 2, 1, U8, Rw, 254), (0x1401, 5, 1, U16, Rw, 0),
    (0x1600, 0, 1, U8, Rw, 2), (0x1600, 1, 1, U32, Rw, 0x6200_0120), (0x1600, 2, 1, U32, Rw, 0x6200_0220), (0x1600, 3, 6, U32, Rw, 0),
    (0x1601, 0, 1, U8, Rw, 8),
    (0x1601, 1, 1, U32, Rw, 0x6201_0108), (0x1601, 2, 1, U32, Rw, 0x6201_0208), (0x1601, 3, 1, U32, Rw, 0x6201_0308), (0x1601, 4, 1, U32, Rw, 0x6201_0408),
    (0x1601, 5, 1, U32, Rw, 0x6201_0508), (0x1601, 6, 1, U32, Rw, 0x6201_0608), (0x1601, 7, 1, U32, Rw, 0x6201_0708), (0x1601, 8, 1, U32, Rw, 0x6201_0808),
    (0x1800, 0, 1, U8, Ro, 6), (0x1800, 1, 1, U32, Rw, 0x4000_0190), (0x1800, 2, 1, U8, Rw, 1),
    (0x1800, 3, 1, U16, Rw, 0), (0x1800, 5, 1, U16, Rw, 0), (0x1800, 6, 1, U8, Rw, 0),
    (0x1801, 0, 1, U8, Ro, 6), (0x1801, 1, 1, U32, Rw, 0x4000_0290), (0x1801, 2, 1, U8, Rw, 254),
    (0x1801, 3, 1, U16, Rw, 0), (0x1801, 5, 1, U16, Rw, 0), (0x1801, 6, 1, U8, Rw, 0),
    (0x1A00, 0, 1, U8, Rw, 2), (0x1A00, 1, 1, U32, Rw, 0x6000_0120), (0x1A00, 2, 1, U32, Rw, 0x6000_0220), (0x1A00, 3, 6, U32, Rw, 0),
    (0x1A01, 0, 1, U8, Rw, 8),
    (0x1A01, 1, 1, U32, Rw, 0x6001_0108), (0x1A01, 2, 1, U32, Rw, 0x6001_0208), (0x1A01, 3, 1, U32, Rw, 0x6001_0308), (0x1A01, 4, 1, U32, Rw, 0x6001_0408),
    (0x1A01, 5, 1, U32, Rw, 0x6001_0508), (0x1A01, 6, 1, U32, Rw, 0x6001_0608), (0x1A01, 7, 1, U32, Rw, 0x6001_0708), (0x1A01, 8, 1, U32, Rw, 0x6001_0808),
    (0x6000, 0, 1, U8, Ro, 4), (0x6000, 1, 4, U32, Ro, 0),
    (0x6001, 0, 1, U8, Ro, 8), (0x6001, 1, 8, U8, Ro, 0),
    (0x6200, 0, 1, U8, Ro, 4), (0x6200, 1, 4, U32, Rw, 0),
    (0x6201, 0, 1, U8, Ro, 8), (0x6201, 1, 8, U8, Rw, 0),
];

/// The stack canopen-rs.
#[derive(Debug)]
pub struct CanopenRs {
    node: Node<ENTRIES>,
}

/// A frame as its functions take it.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    id: u16,
    remote: bool,
    len: u8,
    data: [u8; 8],
}

impl Stack for CanopenRs {
    type Frame = Frame;

    fn new() -> Self {
        let node_id = NodeId::new(0x10).expect("16 is a node-ID");
        let mut stack = Self { node: Node::new(node_id, dictionary()) };
        stack.node.configure_pdos_from_od();
        for sub in 1..=4 {
            stack.set(0x6000, sub, Value::Unsigned32(input_32(sub)));
        }
        for sub in 1..=8 {
            stack.set(0x6001, sub, Value::Unsigned8(input_8(sub)));
        }
        let _ = stack.node.boot();
        stack
    }

    fn frame(id: u16, len: u8, data: [u8; 8]) -> Frame {
        Frame { id, remote: false, len, data }
    }

    fn remote_frame(id: u16, len: u8) -> Frame {
        Frame { id, remote: true, len, data: [0; 8] }
    }

    fn handle(&mut self, _: u64, frame: &Frame, bus: &impl Bus) {
        let data = frame.data.get(..usize::from(frame.len)).unwrap_or(&[]);
        if frame.remote {
            if frame.id == nmt::heartbeat_cob_id(self.node.node_id()) {
                send(bus, &self.node.node_guard_response());
            }
        } else if frame.id == sync::SYNC_COB_ID {
            for frame in &self.node.sync_tpdos() {
                send(bus, frame);
            }
        } else if let Some(frame) = self.node.on_frame(frame.id, data) {
            send(bus, &frame);
            let written = self.node.take_written_object();
            if written.is_some_and(|object| (0x1400..=0x1BFF).contains(&object.index)) {
                self.node.configure_pdos_from_od();
            }
        }
    }

    /// There are no timers.
    fn tick(&mut self, _: u64, _: &impl Bus) {}

    fn output_32(&mut self, sub: u8) -> u32 {
        match self.node.od().read(Address::new(0x6200, sub)) {
            Ok(Value::Unsigned32(value)) => value,
            other => panic!("0x6200 is {other:?}"),
        }
    }

    fn output_8(&mut self, sub: u8) -> u8 {
        match self.node.od().read(Address::new(0x6201, sub)) {
            Ok(Value::Unsigned8(value)) => value,
            other => panic!("0x6201 is {other:?}"),
        }
    }
}

impl CanopenRs {
    fn set(&mut self, index: u16, sub: u8, value: Value) {
        self.node.od_mut().set(Address::new(index, sub), value).expect("DEV1 has the object");
    }
}

fn dictionary() -> ObjectDictionary<ENTRIES> {
    let mut dictionary = ObjectDictionary::new();
    let mut insert = |index, sub, access, value| {
        let entry = Entry { value, access };
        dictionary.insert(Address::new(index, sub), entry).expect("there is room");
    };
    for &(index, first, count, kind, access, value) in SPANS {
        let [low, high, ..] = value.to_le_bytes();
        let value = match kind {
            U8 => Value::Unsigned8(low),
            U16 => Value::Unsigned16(u16::from_le_bytes([low, high])),
            U32 => Value::Unsigned32(value),
        };
        for sub in (first..).take(usize::from(count)) {
            insert(index, sub, access, value);
        }
        if index == 0x1007 {
            let name = ByteString::from_bytes(b"bench device one").expect("16 bytes");
            insert(0x1008, 0, Ro, Value::VisibleString(name));
        } else if (index, first) == (0x1A01, 8) {
            let blob = ByteString::from_bytes(&[0; 32]).expect("32 bytes");
            insert(0x2000, 0, Rw, Value::Domain(blob));
        }
    }
    dictionary
}

fn send(bus: &impl Bus, frame: &canopen_rs::TxFrame) {
    let data = frame.data();
    let len = u32::try_from(data.len()).unwrap_or(0);
    bus.send(u32::from(frame.cob_id), len, padded(data));
}
