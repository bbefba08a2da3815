use core::mem;
use core::ops::Deref;

use units::Duration;

use super::bit_rate::BitRate;
use super::settings::{
    Addressing, Identification, RequestLength, Selected, Selection, Settings, Unconfigured,
};
use crate::cob_id::NodeId;
use crate::frame::{CanId, Frame};

/// From the master to all slaves.
pub(crate) const REQUEST: CanId = CanId::from_low_bits(0x7E5);
/// From a slave to the master.
pub(crate) const RESPONSE: CanId = CanId::from_low_bits(0x7E4);

/// The node-ID of a device that has none.
const UNCONFIGURED: u8 = 0xFF;
/// In a switch selective: every device of the vendor.
const EVERY: u32 = u32::MAX;

const SWITCH_GLOBAL: u8 = 0x04;
const CONFIGURE_NODE_ID: u8 = 0x11;
const CONFIGURE_BIT_TIMING: u8 = 0x13;
const ACTIVATE_BIT_TIMING: u8 = 0x15;
const STORE: u8 = 0x17;
const SELECT_VENDOR: u8 = 0x40;
const SELECT_SERIAL: u8 = 0x43;
const SELECTED: u8 = 0x44;
const IDENTIFY_VENDOR: u8 = 0x46;
const IDENTIFY_SERIAL_MAX: u8 = 0x4B;
const IDENTIFY_NON_CONFIGURED: u8 = 0x4C;
const IDENTIFIED: u8 = 0x4F;
const NON_CONFIGURED: u8 = 0x50;
const FASTSCAN: u8 = 0x51;
const INQUIRE_VENDOR: u8 = 0x5A;
const INQUIRE_SERIAL: u8 = 0x5D;
const INQUIRE_NODE_ID: u8 = 0x5E;

/// The place of the serial number, the last part of an identity.
const SERIAL: u8 = 3;

const SUCCESS: u8 = 0;
const OUT_OF_RANGE: u8 = 1;

/// A slave of the layer setting services (CiA 305).
///
/// It acts on nothing itself: what a master configures is pending until the core above builds a
/// node with it, and stored when the core has stored it. It has no deadlines.
#[derive(Debug)]
pub struct Slave<S = &'static Settings> {
    settings: S,
    /// Its parts in the order of the identity object.
    identity: [u32; 4],
    node_id: Option<NodeId>,
    pending_node_id: Option<NodeId>,
    pending_bit_rate: Option<BitRate>,
    state: State,
    /// What of a switch selective was the own identity so far.
    own: Parts,
    /// What of a switch selective was the own vendor, and every product, revision and serial number.
    open: Parts,
    /// The identify frames that fitted so far, in their order.
    identified: u8,
    /// The part of the identity that a fastscan asks for next.
    scanned: u8,
    /// The command of the answer that a master gets when its configuration is stored.
    storing: Option<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Configuration,
    /// Everyone shows the offer; it is gone once taken.
    Addressing {
        offer: Option<NodeId>,
    },
}

/// A set of parts of the identity: bit n is part n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Parts(u8);

/// What tells one device from every other: the identity object (0x1018:01 to 04).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// The vendor-ID that CiA gave out.
    pub vendor_id: u32,
    /// The product code.
    pub product_code: u32,
    /// The revision number.
    pub revision: u32,
    /// The serial number, unique among devices of one product and revision.
    pub serial: u32,
}

/// What comes of an input, if anything does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// An answer to send.
    Response(Frame),
    /// Something that the core above has to know.
    Event(Event),
}

/// What the core above a slave has to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A device without a node-ID has one now: build a node with it and boot it.
    Configured {
        /// The node-ID to use.
        node_id: NodeId,
    },
    /// Store the configuration and report with [`Slave::handle_stored`].
    Store {
        /// The node-ID from the next start on; `None` for none.
        node_id: Option<NodeId>,
        /// The bit rate from the next start on; `None` leaves it as it is.
        bit_rate: Option<BitRate>,
    },
    /// All devices of the bus change their bit rate: be silent for `delay`, switch, be silent for
    /// `delay` again, and build a new node.
    ActivateBitTiming {
        /// The rate to switch to.
        bit_rate: BitRate,
        /// Both times of silence, 0 to 65535 ms.
        delay: Duration,
    },
    /// A node-ID is on offer: show it. [`Slave::take_offer`] takes it.
    Offered {
        /// The node-ID to show.
        node_id: NodeId,
    },
    /// The offer was taken: store the node-ID and report with [`Slave::handle_stored`].
    StoreNodeId {
        /// The node-ID from the next start on.
        node_id: NodeId,
    },
    /// Nothing is on offer any more: show what is usual.
    AddressingEnded,
}

/// Why a configuration is not stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// The device has no memory for it.
    NotSupported,
    /// The memory did not take it.
    AccessFailed,
}

impl Parts {
    const ALL: Self = Self(0b1111);

    fn note(&mut self, part: u8, fits: bool) {
        self.0 = self.0 & !(1 << part) | u8::from(fits) << part;
    }
}

impl RequestLength {
    /// The fewest bytes of a request with this command.
    const fn least(self, command: u8) -> u8 {
        match self {
            Self::Eight => 8,
            Self::AsNeeded => match command {
                SWITCH_GLOBAL..=CONFIGURE_NODE_ID => 2,
                CONFIGURE_BIT_TIMING..=ACTIVATE_BIT_TIMING => 3,
                SELECT_VENDOR..=IDENTIFY_SERIAL_MAX => 5,
                FASTSCAN => 8,
                _ => 1,
            },
        }
    }
}

impl<S: Deref<Target = Settings>> Slave<S> {
    /// A slave in waiting, of a device with this identity and, once it has one, node-ID.
    #[must_use]
    pub fn new(settings: S, identity: Identity, node_id: Option<NodeId>) -> Self {
        let Identity { vendor_id, product_code, revision, serial } = identity;
        Self {
            settings,
            identity: [vendor_id, product_code, revision, serial],
            node_id,
            pending_node_id: node_id,
            pending_bit_rate: None,
            state: State::Waiting,
            own: Parts(0),
            open: Parts(0),
            identified: 0,
            scanned: 0,
            storing: None,
        }
    }

    /// Takes a received frame in. Frames that are no requests change nothing.
    #[must_use]
    pub fn handle_frame(&mut self, frame: &Frame) -> Option<Reaction> {
        let [command, a, b, c, d, e, f, g] = frame.padded();
        let is_request = frame.id() == REQUEST && !frame.is_remote();
        if !is_request || frame.dlc() < self.settings.request_length.least(command) {
            return None;
        }
        let value = u32::from_le_bytes([a, b, c, d]);
        match command {
            SWITCH_GLOBAL => match a {
                0 => self.switch_to(State::Waiting),
                1 => self.switch_to(State::Configuration),
                _ => None,
            },
            SELECT_VENDOR..=SELECT_SERIAL => self.select(command - SELECT_VENDOR, value),
            IDENTIFY_VENDOR..=FASTSCAN if !self.identifies() => None,
            IDENTIFY_VENDOR..=IDENTIFY_SERIAL_MAX => {
                self.identify(command - IDENTIFY_VENDOR, value)
            }
            IDENTIFY_NON_CONFIGURED if self.is_without_node_id() => respond(NON_CONFIGURED, 0),
            FASTSCAN => self.fastscan(value, [e, f, g]),
            CONFIGURE_NODE_ID => self.configure_node_id(a),
            // All others are for a device in configuration.
            _ if self.state != State::Configuration => None,
            CONFIGURE_BIT_TIMING => self.configure_bit_timing(a, b),
            ACTIVATE_BIT_TIMING => self.activate_bit_timing(u16::from_le_bytes([a, b])),
            STORE => self.store(),
            INQUIRE_VENDOR..=INQUIRE_SERIAL => {
                respond(command, self.part(command - INQUIRE_VENDOR)?)
            }
            INQUIRE_NODE_ID => {
                respond(command, self.node_id.map_or(UNCONFIGURED, NodeId::get).into())
            }
            _ => None,
        }
    }

    /// The user touched the device: takes the node-ID on offer, once per offer.
    #[must_use]
    pub fn take_offer(&mut self) -> Option<Reaction> {
        let State::Addressing { offer } = &mut self.state else { return None };
        let node_id = offer.take_if(|_| self.storing.is_none())?;
        self.storing = Some(CONFIGURE_NODE_ID);
        self.pending_node_id = Some(node_id);
        Some(Reaction::Event(Event::StoreNodeId { node_id }))
    }

    /// The configuration of [`Event::Store`] or [`Event::StoreNodeId`] is stored, or is not. Nothing
    /// happens when none was to be. An offer that could not be stored stays unanswered: no device
    /// has it.
    #[must_use]
    pub fn handle_stored(&mut self, outcome: Result<(), StoreError>) -> Option<Reaction> {
        let code = match outcome {
            Ok(()) => SUCCESS,
            Err(StoreError::NotSupported) => 1,
            Err(StoreError::AccessFailed) => 2,
        };
        let command = self.storing.take()?;
        if command == CONFIGURE_NODE_ID && code != SUCCESS {
            self.pending_node_id = self.node_id;
            return None;
        }
        respond(command, code.into())
    }

    /// The node-ID to build a node with at the next reset of the communication. `None`: the device
    /// has none then.
    #[must_use]
    pub const fn pending_node_id(&self) -> Option<NodeId> {
        self.pending_node_id
    }
}

impl<S: Deref<Target = Settings>> Slave<S> {
    /// To waiting or to configuration.
    fn switch_to(&mut self, to: State) -> Option<Reaction> {
        let event = match (mem::replace(&mut self.state, to), to) {
            (State::Addressing { .. }, _) => Event::AddressingEnded,
            (State::Configuration, State::Waiting) if self.node_id.is_none() => {
                self.node_id = self.pending_node_id;
                Event::Configured { node_id: self.node_id? }
            }
            (State::Waiting | State::Configuration, _) => return None,
        };
        Some(Reaction::Event(event))
    }

    /// The serial number decides; the other parts may come in any order before.
    fn select(&mut self, part: u8, value: u32) -> Option<Reaction> {
        match (self.state, self.settings.selection) {
            (State::Waiting, _) | (State::Configuration, Selection::WhileWaitingOrConfiguring) => {}
            (State::Configuration, Selection::WhileWaiting) | (State::Addressing { .. }, _) => {
                return None;
            }
        }
        let is_own = self.part(part) == Some(value);
        self.own.note(part, is_own);
        self.open.note(part, if part == 0 { is_own } else { value == EVERY });
        if part != SERIAL {
            return None;
        }
        let (own, open) = (mem::take(&mut self.own), mem::take(&mut self.open));
        if own == Parts::ALL {
            self.state = State::Configuration;
            respond(SELECTED, u32::from(self.settings.selected == Selected::Mode))
        } else if open == Parts::ALL && self.settings.addressing == Addressing::ConfiguredOrOffered
        {
            self.state = State::Addressing { offer: None };
            None
        } else {
            self.switch_to(State::Waiting)
        }
    }

    /// Vendor, product, both ends of a range of revisions and both of serial numbers, in this order.
    fn identify(&mut self, step: u8, value: u32) -> Option<Reaction> {
        let own = self.part(if step < 2 { step } else { step / 2 + 1 })?;
        let fits = match step {
            0 | 1 => value == own,
            2 | 4 => value <= own,
            _ => value >= own,
        };
        let follows = step == 0 || step == self.identified;
        self.identified = if follows && fits { step + 1 } else { 0 };
        if self.identified == 6 { respond(IDENTIFIED, 0) } else { None }
    }

    /// A binary search of the master for the identity of one device without a node-ID: whose `part`
    /// equals `number` in bit 31 to bit `lowest_bit`? `next` is asked for afterwards.
    fn fastscan(&mut self, number: u32, question: [u8; 3]) -> Option<Reaction> {
        const BEGIN: u8 = 0x80;
        let [lowest_bit, part, next] = question;
        if self.state != State::Waiting || !self.is_without_node_id() {
            return None;
        }
        if lowest_bit == BEGIN {
            self.scanned = 0;
        } else {
            let differing = (self.part(part)? ^ number).checked_shr(lowest_bit.into())?;
            if part != self.scanned || next > SERIAL || differing != 0 {
                return None;
            }
            self.scanned = next;
            if lowest_bit == 0 && next < part {
                self.state = State::Configuration;
            }
        }
        respond(IDENTIFIED, 0)
    }

    fn configure_node_id(&mut self, node_id: u8) -> Option<Reaction> {
        let configured = NodeId::new(node_id);
        match &mut self.state {
            State::Waiting => None,
            State::Addressing { offer } => {
                let node_id = configured?;
                *offer = configured;
                Some(Reaction::Event(Event::Offered { node_id }))
            }
            State::Configuration => {
                let unconfigures = node_id == UNCONFIGURED
                    && self.settings.unconfigured == Unconfigured::Permitted;
                if configured.is_none() && !unconfigures {
                    return respond(CONFIGURE_NODE_ID, OUT_OF_RANGE.into());
                }
                self.pending_node_id = configured;
                respond(CONFIGURE_NODE_ID, SUCCESS.into())
            }
        }
    }

    fn configure_bit_timing(&mut self, table: u8, index: u8) -> Option<Reaction> {
        const STANDARD_TABLE: u8 = 0;
        let is_meant = |rate: &&BitRate| table == STANDARD_TABLE && rate.index() == index;
        let code = match self.settings.bit_rates.iter().find(is_meant) {
            Some(&rate) => {
                self.pending_bit_rate = Some(rate);
                SUCCESS
            }
            None => OUT_OF_RANGE,
        };
        respond(CONFIGURE_BIT_TIMING, code.into())
    }

    fn activate_bit_timing(&self, delay_ms: u16) -> Option<Reaction> {
        let bit_rate = self.pending_bit_rate?;
        let delay = Duration::from_millis(delay_ms.into());
        Some(Reaction::Event(Event::ActivateBitTiming { bit_rate, delay }))
    }

    /// A master that does not wait for its answer gets one only.
    fn store(&mut self) -> Option<Reaction> {
        if self.storing.is_some() {
            return None;
        }
        self.storing = Some(STORE);
        let (node_id, bit_rate) = (self.pending_node_id, self.pending_bit_rate);
        Some(Reaction::Event(Event::Store { node_id, bit_rate }))
    }

    fn part(&self, part: u8) -> Option<u32> {
        self.identity.get(usize::from(part)).copied()
    }

    fn identifies(&self) -> bool {
        self.settings.identification == Identification::Answered
    }

    const fn is_without_node_id(&self) -> bool {
        self.node_id.is_none() && self.pending_node_id.is_none()
    }
}

#[inline(never)]
fn respond(command: u8, value: u32) -> Option<Reaction> {
    let [a, b, c, d] = value.to_le_bytes();
    Some(Reaction::Response(Frame::full(RESPONSE, [command, a, b, c, d, 0, 0, 0])))
}
