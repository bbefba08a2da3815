//! What an LSS slave has to do (CiA 305, and the NM17x manual, section 3.1.2), written to be read.

use canopen::NodeId;
use canopen::lss::{
    Addressing, BitRate, Event, Identification, Identity, RequestLength, Selection, Settings,
    StoreError, Unconfigured,
};
use units::Duration;

use super::Wanted;

const NOTHING: Wanted = (None, None);

/// A slave at the moment.
pub(super) struct Model {
    settings: &'static Settings,
    /// Vendor, product, revision, serial number.
    own: [u32; 4],
    node_id: Option<u8>,
    pending: Option<u8>,
    rate: Option<u8>,
    mode: Mode,
    /// What a switch selective said so far.
    heard: [Option<u32>; 4],
    /// How many identify frames fitted in a row.
    matched: u8,
    /// The part that a fastscan asks for.
    scanned: u8,
    /// What a master waits for: the command of the answer.
    storing: Option<u8>,
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Waiting,
    Configuring,
    Addressing { offer: Option<u8> },
}

impl Model {
    pub(super) fn new(settings: &'static Settings, own: Identity, node_id: Option<NodeId>) -> Self {
        let Identity { vendor_id, product_code, revision, serial } = own;
        let node_id = node_id.map(NodeId::get);
        Self {
            settings,
            own: [vendor_id, product_code, revision, serial],
            node_id,
            pending: node_id,
            rate: None,
            mode: Mode::Waiting,
            heard: [None; 4],
            matched: 0,
            scanned: 0,
            storing: None,
        }
    }

    pub(super) fn pending(&self) -> Option<NodeId> {
        self.pending.and_then(NodeId::new)
    }

    /// The user touches the device.
    pub(super) fn touch(&mut self) -> Wanted {
        let Mode::Addressing { offer: offer @ Some(_) } = self.mode else { return NOTHING };
        if self.storing.is_some() {
            return NOTHING;
        }
        self.mode = Mode::Addressing { offer: None };
        self.storing = Some(0x11);
        self.pending = offer;
        let node_id = offer.and_then(NodeId::new).unwrap();
        (None, Some(Event::StoreNodeId { node_id }))
    }

    pub(super) fn stored(&mut self, outcome: Result<(), StoreError>) -> Wanted {
        let code = match outcome {
            Ok(()) => 0,
            Err(StoreError::NotSupported) => 1,
            Err(StoreError::AccessFailed) => 2,
        };
        match self.storing.take() {
            Some(0x11) if code != 0 => {
                self.pending = self.node_id;
                NOTHING
            }
            Some(command) => says(&[command, code]),
            None => NOTHING,
        }
    }

    pub(super) fn ask(&mut self, data: &[u8]) -> Wanted {
        let mut frame = [0; 8];
        frame[..data.len()].copy_from_slice(data);
        let [command, a, b, ..] = frame;
        let value = u32::from_le_bytes([a, b, frame[3], frame[4]]);
        let needed = match command {
            0x04 | 0x11 => 2,
            0x13 | 0x15 => 3,
            0x40..=0x43 | 0x46..=0x4B => 5,
            0x51 => 8,
            _ => 1,
        };
        let is_heard = match self.settings.request_length {
            RequestLength::Eight => data.len() == 8,
            RequestLength::AsNeeded => data.len() >= needed,
        };
        let configuring = self.mode == Mode::Configuring;
        let identifies = self.settings.identification == Identification::Answered;
        let is_nameless = self.node_id.is_none() && self.pending.is_none();
        match command {
            _ if !is_heard => NOTHING,
            0x04 if a == 0 => self.switch(Mode::Waiting),
            0x04 if a == 1 => self.switch(Mode::Configuring),
            0x40..=0x43 => self.select(command - 0x40, value),
            0x46..=0x4B => {
                let part = [0, 1, 2, 2, 3, 3][usize::from(command - 0x46)];
                let own: u32 = self.own[part];
                let fits = match command {
                    0x46 | 0x47 => own == value,
                    0x48 | 0x4A => own >= value,
                    _ => own <= value,
                };
                let step = command - 0x46;
                let in_turn = step == 0 || step == self.matched;
                self.matched = if in_turn && fits { step + 1 } else { 0 };
                if self.matched == 6 && identifies { says(&[0x4F]) } else { NOTHING }
            }
            0x4C if identifies && is_nameless => says(&[0x50]),
            0x51 if identifies && is_nameless && self.mode == Mode::Waiting => {
                self.fastscan(value, [frame[5], frame[6], frame[7]])
            }
            0x11 => self.configure(a),
            0x13 if configuring => {
                let known = BitRate::from_index(b).filter(|_| a == 0);
                match known.filter(|rate| self.settings.bit_rates.contains(rate)) {
                    Some(_) => {
                        self.rate = Some(b);
                        says(&[0x13, 0])
                    }
                    None => says(&[0x13, 1]),
                }
            }
            0x15 if configuring => {
                let delay = Duration::from_millis(u64::from(u16::from_le_bytes([a, b])));
                let rate = self.rate.and_then(BitRate::from_index);
                (None, rate.map(|bit_rate| Event::ActivateBitTiming { bit_rate, delay }))
            }
            0x17 if configuring && self.storing.is_none() => {
                self.storing = Some(0x17);
                let bit_rate = self.rate.and_then(BitRate::from_index);
                (None, Some(Event::Store { node_id: self.pending(), bit_rate }))
            }
            0x5A..=0x5D if configuring => {
                let own = self.own[usize::from(command - 0x5A)].to_le_bytes();
                says(&[&[command], &own[..]].concat())
            }
            0x5E if configuring => says(&[0x5E, self.node_id.unwrap_or(0xFF)]),
            _ => NOTHING,
        }
    }

    fn switch(&mut self, to: Mode) -> Wanted {
        let from = std::mem::replace(&mut self.mode, to);
        let mut event = None;
        if let Mode::Addressing { .. } = from {
            event = Some(Event::AddressingEnded);
        } else if from == Mode::Configuring && to == Mode::Waiting && self.node_id.is_none() {
            self.node_id = self.pending;
            event = self.pending().map(|node_id| Event::Configured { node_id });
        }
        (None, event)
    }

    fn select(&mut self, part: u8, value: u32) -> Wanted {
        let is_meant = match self.mode {
            Mode::Waiting => true,
            Mode::Configuring => self.settings.selection == Selection::WhileWaitingOrConfiguring,
            Mode::Addressing { .. } => false,
        };
        if !is_meant {
            return NOTHING;
        }
        self.heard[usize::from(part)] = Some(value);
        if part < 3 {
            return NOTHING;
        }
        let heard = std::mem::take(&mut self.heard);
        let everyone = [self.own[0], u32::MAX, u32::MAX, u32::MAX];
        if heard == self.own.map(Some) {
            self.mode = Mode::Configuring;
            says(&[0x44])
        } else if self.settings.addressing == Addressing::ConfiguredOrOffered
            && heard == everyone.map(Some)
        {
            self.switch(Mode::Addressing { offer: None })
        } else {
            self.switch(Mode::Waiting)
        }
    }

    fn fastscan(&mut self, number: u32, [bit, part, next]: [u8; 3]) -> Wanted {
        if bit == 0x80 {
            self.scanned = 0;
            return says(&[0x4F]);
        }
        if bit > 31 || part > 3 || next > 3 || part != self.scanned {
            return NOTHING;
        }
        if self.own[usize::from(part)] >> bit != number >> bit {
            return NOTHING;
        }
        self.scanned = next;
        if bit == 0 && next < part {
            self.mode = Mode::Configuring;
        }
        says(&[0x4F])
    }

    fn configure(&mut self, node_id: u8) -> Wanted {
        match self.mode {
            Mode::Waiting => NOTHING,
            Mode::Addressing { .. } => {
                let offer = NodeId::new(node_id);
                if offer.is_some() {
                    self.mode = Mode::Addressing { offer: offer.map(NodeId::get) };
                }
                (None, offer.map(|node_id| Event::Offered { node_id }))
            }
            Mode::Configuring => {
                let is_name = (1..=127).contains(&node_id);
                let is_none =
                    node_id == 0xFF && self.settings.unconfigured == Unconfigured::Permitted;
                if !is_name && !is_none {
                    return says(&[0x11, 1]);
                }
                self.pending = is_name.then_some(node_id);
                says(&[0x11, 0])
            }
        }
    }
}

fn says(answer: &[u8]) -> Wanted {
    let mut frame = [0; 8];
    frame[..answer.len()].copy_from_slice(answer);
    (Some(frame), None)
}
