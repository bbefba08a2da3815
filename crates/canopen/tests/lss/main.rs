//! Layer setting services as masters meet them.
#![expect(
    clippy::cast_possible_truncation,
    clippy::unwrap_used,
    reason = "a test that meets what it does not expect has to fail"
)]

mod cia_305;
mod fastscan;
mod network;
mod nm17x;

use canopen::lss::{
    Addressing, BitRate, Event, Identification, Identity, Reaction, RequestLength, Selected,
    Selection, Settings, Slave, Unconfigured,
};
use canopen::{CanId, Frame, NodeId};

/// The choices of NM170, NM172 and NM174: decisions.
static NM17X: Settings = Settings {
    request_length: RequestLength::AsNeeded,
    selection: Selection::WhileWaitingOrConfiguring,
    selected: Selected::Confirmed,
    addressing: Addressing::ConfiguredOrOffered,
    identification: Identification::Ignored,
    unconfigured: Unconfigured::OutOfRange,
    bit_rates: BitRate::ALL,
};

/// The device of the manual's example, section 3.1.2.
const IDENTITY: Identity =
    Identity { vendor_id: 0xEC, product_code: 0x71, revision: 0x0001_0001, serial: 0x4D52_F567 };

const REQUEST: u16 = 0x7E5;
const RESPONSE: u16 = 0x7E4;

fn id(node_id: u8) -> NodeId {
    NodeId::new(node_id).unwrap()
}

fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::new(CanId::new(id).unwrap(), data).unwrap()
}

/// The bytes written as `04 01`.
fn bytes(hex: &str) -> Vec<u8> {
    hex.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).unwrap()).collect()
}

/// The eight bytes that start so, the rest zero.
fn full(hex: &str) -> Vec<u8> {
    let mut data = bytes(hex);
    data.resize(8, 0);
    data
}

/// Sends a request; what the slave answers and tells.
fn ask(slave: &mut Slave, data: &[u8]) -> (Option<Vec<u8>>, Option<Event>) {
    apart(slave.handle_frame(&frame(REQUEST, data)))
}

/// What a slave answers and what it tells.
fn apart(reaction: Option<Reaction>) -> (Option<Vec<u8>>, Option<Event>) {
    match reaction {
        Some(Reaction::Response(frame)) => {
            assert_eq!((frame.id().get(), frame.dlc()), (RESPONSE, 8));
            (Some(frame.data().to_vec()), None)
        }
        Some(Reaction::Event(event)) => (None, Some(event)),
        None => (None, None),
    }
}

/// Requests of eight bytes, and the start of the answer to each; `-` stands for none.
#[track_caller]
fn check(slave: &mut Slave, conversation: &[(&str, &str)]) {
    for (request, answer) in conversation {
        let expected = (*answer != "-").then(|| full(answer));
        assert_eq!(ask(slave, &full(request)).0, expected, "{request}");
    }
}

/// The four frames of a switch selective.
fn selection(identity: &Identity) -> [[u8; 8]; 4] {
    let Identity { vendor_id, product_code, revision, serial } = *identity;
    let frame = |command, value: u32| {
        let [a, b, c, d] = value.to_le_bytes();
        [command, a, b, c, d, 0, 0, 0]
    };
    [frame(0x40, vendor_id), frame(0x41, product_code), frame(0x42, revision), frame(0x43, serial)]
}

fn select(slave: &mut Slave, identity: &Identity) -> (Option<Vec<u8>>, Option<Event>) {
    selection(identity).map(|request| ask(slave, &request)).into_iter().next_back().unwrap()
}
