//! Bytes between the two controllers: protocol version 1.

use shared_proto::{
    NodeState, ProcessData, Receiver, Supervision, ToApplication, ToInterface, Urgency, Urgent,
    Write, encode,
};

const SUPERVISION: Supervision = Supervision { state: NodeState::Operational, node_id: 127 };

/// NM17x LINK-03, LINK-07.
#[rustfmt::skip]
const COMMANDS: &[(&str, ToApplication, &[u8])] = &[
    ("nothing to command", ToApplication::Idle(SUPERVISION), b"\x06\x01\x02\x7F\xB6\x12\x00"),
    (
        "a write",
        ToApplication::Write(
            Supervision { state: NodeState::PreOperational, node_id: 1 },
            Write { sequence: 255, index: 0x2003, sub: 0, value: 320 },
        ),
        b"\x07\x02\x01\x01\xFF\x83\x40\x05\xC0\x02\x90\xE1\x00",
    ),
    (
        "a motor stop",
        ToApplication::Urgent(
            Supervision { state: NodeState::Stopped, node_id: 127 },
            Urgent { number: 7, urgency: Urgency::MotorStop },
        ),
        b"\x05\x04\x03\x7F\x07\x03\x78\x6E\x00",
    ),
];

/// NM17x LINK-02.
const PROCESS: ProcessData = ProcessData {
    cycle: 255,
    acknowledged: 3,
    urgent_acknowledged: 0,
    position_hundredths_mm: -99_999,
    status: 0x8001,
    errors: 0,
};

pub(crate) fn run(differs: &mut impl FnMut(&str)) -> usize {
    for (name, message, wire) in COMMANDS {
        let mut receiver = Receiver::<ToApplication>::default();
        let received = wire.iter().find_map(|&byte| receiver.push(byte));
        if encode(message).as_slice() != *wire || received.as_ref() != Some(message) {
            differs(name);
        }
    }
    let process = ToInterface::Process(PROCESS);
    let mut receiver = Receiver::<ToInterface>::default();
    let received = encode(&process).iter().find_map(|&byte| receiver.push(byte));
    if received != Some(process) {
        differs("process data");
    }
    COMMANDS.len() + 1
}
