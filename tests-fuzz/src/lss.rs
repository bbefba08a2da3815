//! A master that asks anything of an LSS slave, and a model that says what has to come of it.

mod model;

use canopen::lss::{
    Addressing, BitRate, Event, Identification, Identity, Reaction, RequestLength, Selected,
    Selection, Settings, Slave, StoreError, Unconfigured,
};
use canopen::{CanId, Frame, NodeId};

use crate::bytes::Bytes;
use model::Model;

const REQUEST: u16 = 0x7E5;
const RESPONSE: u16 = 0x7E4;

/// The device of the NM17x manual's example, section 3.1.2.
const IDENTITY: Identity =
    Identity { vendor_id: 0xEC, product_code: 0x71, revision: 0x0001_0001, serial: 0x4D52_F567 };

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

/// A device that has three bit rates only.
static THREE_RATES: Settings = Settings {
    bit_rates: &[BitRate::Kbit1000, BitRate::Kbit125, BitRate::Kbit20],
    ..Settings::CIA_305
};

/// Lets a master ask what `input` says.
pub fn converse(input: &[u8]) {
    let mut bytes = Bytes::new(input);
    let settings = [&Settings::CIA_305, &NM17X, &THREE_RATES];
    let Some((settings, node_id)) = bytes.pick(&settings).zip(bytes.u8()) else { return };
    let node_id = NodeId::new(node_id);
    let mut slave = Slave::new(settings, IDENTITY, node_id);
    let mut model = Model::new(settings, IDENTITY, node_id);
    while let Some((reaction, wanted, what)) = step(&mut slave, &mut model, &mut bytes) {
        assert_eq!(apart(reaction), wanted, "{what}");
        assert_eq!(slave.pending_node_id(), model.pending(), "after {what}");
    }
}

type Wanted = (Option<[u8; 8]>, Option<Event>);

/// What comes of the next input, what should, and the input.
fn step(
    slave: &mut Slave,
    model: &mut Model,
    bytes: &mut Bytes<'_>,
) -> Option<(Option<Reaction>, Wanted, String)> {
    let frame = match bytes.u8()? % 16 {
        0..=9 => request(&whole(bytes)?),
        10 | 11 => request(bytes.up_to(8)?),
        12 => {
            let id = CanId::new(bytes.pick(&[REQUEST, RESPONSE, 0x7E3, 0x000])?)?;
            let remote = bytes.u8()? & 1 == 0;
            if remote { Frame::new_remote(id, 8)? } else { Frame::new(id, bytes.up_to(8)?)? }
        }
        13 => return Some((slave.take_offer(), model.touch(), "a touch".to_owned())),
        _ => {
            let outcome = bytes.pick(&[
                Ok(()),
                Ok(()),
                Err(StoreError::NotSupported),
                Err(StoreError::AccessFailed),
            ])?;
            return Some((
                slave.handle_stored(outcome),
                model.stored(outcome),
                format!("stored: {outcome:?}"),
            ));
        }
    };
    let is_request = frame.id().get() == REQUEST && !frame.is_remote();
    let wanted = if is_request { model.ask(frame.data()) } else { (None, None) };
    Some((slave.handle_frame(&frame), wanted, format!("{frame:02X?}")))
}

/// A request that is mostly about this device.
fn whole(bytes: &mut Bytes<'_>) -> Option<[u8; 8]> {
    let any = bytes.u8()?;
    let command = bytes.pick(&[
        0x04, 0x04, 0x11, 0x11, 0x13, 0x15, 0x17, 0x40, 0x41, 0x42, 0x43, 0x43, 0x46, 0x47, 0x48,
        0x49, 0x4A, 0x4B, 0x4C, 0x51, 0x51, 0x51, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E, any,
    ])?;
    let Identity { vendor_id, product_code, revision, serial } = IDENTITY;
    let own = [vendor_id, product_code, revision, serial];
    let mut choose = |part: u8| {
        let fitting = own[usize::from(part % 4)];
        let [a, b, c, d, e] = bytes.array()?;
        let value = match a % 8 {
            0..=4 => fitting,
            5 => fitting ^ 1 << (b % 32),
            6 => u32::MAX,
            _ => u32::from_le_bytes([b, c, d, e]),
        };
        Some((value.to_le_bytes(), [b, c, d]))
    };
    let ([a, b, c, d], [e, f, g]) = match command {
        0x40..=0x43 => choose(command & 3)?,
        0x46 | 0x47 => choose(command - 0x46)?,
        0x48 | 0x49 => choose(2)?,
        0x4A | 0x4B => choose(3)?,
        0x51 => {
            let (number, [e, f, g]) = choose(any)?;
            let bit = match e {
                0..=0x4F => 0x80,
                0x50..=0x9F => 0,
                _ => e % 40,
            };
            let next = g % 5;
            (number, [bit, if f < 0xE0 { any % 4 } else { f }, next])
        }
        _ => {
            let [a, b, c] = bytes.array()?;
            let first = match command {
                0x04 => a % 3,
                0x13 => a / 128,
                _ => a,
            };
            ([first, if command == 0x13 { b % 12 } else { b }, c, 0], [0; 3])
        }
    };
    Some([command, a, b, c, d, e, f, g])
}

fn request(data: &[u8]) -> Frame {
    Frame::new(CanId::new(REQUEST).unwrap(), data).unwrap()
}

/// The bytes of the answer, and the event.
fn apart(reaction: Option<Reaction>) -> Wanted {
    match reaction {
        Some(Reaction::Response(frame)) => {
            assert_eq!((frame.id().get(), frame.dlc()), (RESPONSE, 8));
            (frame.data().try_into().ok(), None)
        }
        Some(Reaction::Event(event)) => (None, Some(event)),
        None => (None, None),
    }
}
