//! Protocol version 1, frozen: these are the bytes of devices in the field. A failure here means
//! that a message type has to be put back; the bytes below are never edited.
//!
//! NM17x LINK-02 and LINK-03 travel in these messages.

use shared_proto::{
    Hello, NodeState, ProcessData, Receiver, Supervision, ToApplication, ToInterface, Urgency,
    Urgent, Write, encode,
};

const HELLO: Hello = Hello {
    protocol: 1,
    product: 0x71,
    firmware: 105,
    dictionary: 0xDEAD_BEEF,
    nonce: 0x0102_0304,
    heard: 0,
    in_service: false,
};
const SUPERVISION: Supervision = Supervision { state: NodeState::Operational, node_id: 127 };

#[track_caller]
fn check<M>(message: &M, frozen: &str)
where
    M: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug,
{
    let wire: Vec<String> = encode(message).iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(wire.join(" "), frozen, "{message:?}");

    let mut receiver = Receiver::<M>::default();
    let bytes = frozen.split(' ').map(|byte| u8::from_str_radix(byte, 16).expect("two hex digits"));
    let received: Vec<M> = bytes.filter_map(|byte| receiver.push(byte)).collect();
    assert_eq!(received.iter().collect::<Vec<_>>(), [message]);
}

#[test]
fn to_application() {
    for (message, frozen) in [
        (ToApplication::Hello(HELLO), "01 0d 01 71 69 ef fd b6 f5 0d 84 86 88 08 01 03 c7 d7 00"),
        (ToApplication::Idle(SUPERVISION), "06 01 02 7f b6 12 00"),
        (
            ToApplication::Write(
                Supervision { state: NodeState::PreOperational, node_id: 1 },
                Write { sequence: 255, index: 0x2003, sub: 0, value: 320 },
            ),
            "07 02 01 01 ff 83 40 05 c0 02 90 e1 00",
        ),
        (
            ToApplication::RequestSnapshot {
                supervision: Supervision { state: NodeState::Initialising, node_id: 127 },
                from: 300,
            },
            "02 03 06 7f ac 02 b6 73 00",
        ),
        (
            ToApplication::Urgent(
                Supervision { state: NodeState::Stopped, node_id: 127 },
                Urgent { number: 7, urgency: Urgency::MotorStop },
            ),
            "05 04 03 7f 07 03 78 6e 00",
        ),
        (
            ToApplication::Urgent(
                SUPERVISION,
                Urgent { number: 1, urgency: Urgency::StateLowered },
            ),
            "08 04 02 7f 01 01 4b a2 00",
        ),
        (
            ToApplication::Urgent(
                SUPERVISION,
                Urgent { number: 1, urgency: Urgency::HeartbeatLost },
            ),
            "08 04 02 7f 01 02 28 92 00",
        ),
        (
            ToApplication::Urgent(SUPERVISION, Urgent { number: 1, urgency: Urgency::BusOff }),
            "08 04 02 7f 01 03 09 82 00",
        ),
    ] {
        check(&message, frozen);
    }
}

#[test]
fn to_interface() {
    for (message, frozen) in [
        (
            ToInterface::Hello(Hello { heard: 0xFFFF_FFFF, in_service: true, ..HELLO }),
            "01 15 01 71 69 ef fd b6 f5 0d 84 86 88 08 ff ff ff ff 0f 01 86 d0 00",
        ),
        (
            ToInterface::Process(ProcessData {
                cycle: 200,
                acknowledged: 3,
                urgent_acknowledged: 0,
                position_hundredths_mm: 500_000,
                status: 0x9001,
                errors: 0x0004,
            }),
            "04 01 c8 03 0a c0 84 3d 81 a0 02 04 91 44 00",
        ),
        (
            ToInterface::Process(ProcessData {
                position_hundredths_mm: -99_999,
                ..ProcessData::default()
            }),
            "02 01 01 01 04 bd 9a 0c 01 03 40 27 00",
        ),
        (
            ToInterface::Snapshot { from: 60, values: [0, 1000, u32::MAX].into_iter().collect() },
            "04 02 3c 03 0a e8 07 ff ff ff ff 0f 6d 7c 00",
        ),
        (ToInterface::Touched { offer: 3 }, "05 03 03 3f 78 00"),
    ] {
        check(&message, frozen);
    }
}
