//! DEV1 on zencan-node. It has neither 0x1003:00 nor three of the four sub-indices of 0x1010, and
//! no inhibit time, event timer or SYNC start value; 0x1017 is constant.

use zencan_node::common::NodeId;
use zencan_node::common::messages::{CanId, CanMessage};
use zencan_node::{Callbacks, Node};

use crate::{Bus, Memory, Stack, input_8, input_32, padded};

#[allow(
    missing_docs,
    missing_debug_implementations,
    unreachable_pub,
    unsafe_code,
    clippy::all,
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "written by the build script of zencan"
)]
mod generated {
    zencan_node::include_modules!(DEV1);
}

/// On the host there is one thread and no interrupt, as in a program without an operating system:
/// nothing has to be kept out.
#[cfg(not(target_os = "none"))]
#[expect(unsafe_code, reason = "the programs of this package have one thread")]
mod one_thread {
    struct OneThread;

    critical_section::set_impl!(OneThread);

    unsafe impl critical_section::Impl for OneThread {
        unsafe fn acquire() {}

        unsafe fn release((): critical_section::RawRestoreState) {}
    }
}

/// The stack zencan-node.
#[expect(missing_debug_implementations, reason = "its node has none")]
pub struct Zencan {
    node: Node<'static>,
}

impl Stack for Zencan {
    type Frame = CanMessage;

    fn new() -> Self {
        for sub in 1..=4 {
            let _ = generated::OBJECT6000.set(usize::from(sub) - 1, input_32(sub));
        }
        for sub in 1..=8 {
            let _ = generated::OBJECT6001.set(usize::from(sub) - 1, input_8(sub));
        }
        let node = Node::new(
            NodeId::new(0x10).expect("16 is a node-ID"),
            Callbacks::new(),
            &generated::NODE_MBOX,
            &generated::NODE_STATE,
            &generated::OD_TABLE,
        );
        let mut stack = Self { node };
        stack.tick(0, &Memory::default());
        stack
    }

    fn frame(id: u16, len: u8, data: [u8; 8]) -> CanMessage {
        CanMessage::new(CanId::std(id), data.get(..usize::from(len)).unwrap_or(&[]))
    }

    fn remote_frame(id: u16, _: u8) -> CanMessage {
        CanMessage::new_rtr(CanId::std(id))
    }

    fn handle(&mut self, now_us: u64, frame: &CanMessage, bus: &impl Bus) {
        if generated::NODE_MBOX.store_message(*frame).is_ok() {
            self.tick(now_us, bus);
        }
    }

    fn tick(&mut self, now_us: u64, bus: &impl Bus) {
        self.node.process(now_us);
        while bus.is_free()
            && let Some(message) = generated::NODE_MBOX.next_transmit_message()
        {
            let data = message.data();
            let len = u32::try_from(data.len()).unwrap_or(0);
            bus.send(message.id().raw(), len, padded(data));
        }
    }

    fn output_32(&mut self, sub: u8) -> u32 {
        generated::OBJECT6200.get(usize::from(sub) - 1).expect("DEV1 has the object")
    }

    fn output_8(&mut self, sub: u8) -> u8 {
        generated::OBJECT6201.get(usize::from(sub) - 1).expect("DEV1 has the object")
    }
}
