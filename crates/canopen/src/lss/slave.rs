use units::Duration;

use super::bit_rate::BitRate;
use super::identity::{Identity, Part};
use super::request::{Bound, Fastscan, Request};
use super::settings::{Addressing, Identification, Selection, Settings, Unconfigured};
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

const CONFIGURE_NODE_ID: u8 = 0x11;
const CONFIGURE_BIT_TIMING: u8 = 0x13;
const STORE: u8 = 0x17;
const SELECTED: u8 = 0x44;
const IDENTIFIED: u8 = 0x4F;
const NON_CONFIGURED: u8 = 0x50;
const INQUIRE_IDENTITY: u8 = 0x5A;
const INQUIRE_NODE_ID: u8 = 0x5E;

const SUCCESS: u8 = 0;
const OUT_OF_RANGE: u8 = 1;

/// A slave of the layer setting services (CiA 305).
///
/// It acts on nothing itself: what a master configures is pending until the core above builds a
/// node with it, and stored when the core has stored it. It has no deadlines.
#[derive(Debug)]
pub struct Slave {
    settings: &'static Settings,
    identity: Identity,
    node_id: Option<NodeId>,
    pending_node_id: Option<NodeId>,
    pending_bit_rate: Option<BitRate>,
    state: State,
    /// What a switch selective said so far.
    selected: Selected,
    /// The identify frames that fitted so far, in their order.
    identified: u8,
    /// The part of the identity that a fastscan asks for next.
    scanned: Part,
    storing: Option<Storing>,
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

/// What a master waits for an answer to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Storing {
    Configuration,
    Offer,
}

#[derive(Clone, Copy, Debug)]
struct Selected {
    identity: Identity,
    /// Bit n is set when part n came.
    parts: u8,
}

/// What comes of an input.
#[must_use]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reaction {
    /// The answer to send.
    pub response: Option<Frame>,
    /// What the core above has to know.
    pub event: Option<Event>,
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

impl Reaction {
    const NONE: Self = Self { response: None, event: None };

    const fn answer(command: u8, [a, b, c, d]: [u8; 4]) -> Self {
        Self { response: Some(Frame::full(RESPONSE, [command, a, b, c, d, 0, 0, 0])), event: None }
    }

    const fn result(command: u8, code: u8) -> Self {
        Self::answer(command, [code, 0, 0, 0])
    }

    const fn event(event: Event) -> Self {
        Self { response: None, event: Some(event) }
    }
}

impl Selected {
    const NONE: Self = Self {
        identity: Identity { vendor_id: 0, product_code: 0, revision: 0, serial: 0 },
        parts: 0,
    };
    const ALL_PARTS: u8 = 0b1111;

    fn take(&mut self, part: Part, value: u32) {
        self.identity.set_part(part, value);
        self.parts |= 1 << part.number();
    }

    fn is(&self, identity: &Identity) -> bool {
        self.parts == Self::ALL_PARTS && self.identity == *identity
    }
}

impl Slave {
    /// A slave in waiting, of a device with this identity and, once it has one, node-ID.
    #[must_use]
    pub const fn new(
        settings: &'static Settings,
        identity: Identity,
        node_id: Option<NodeId>,
    ) -> Self {
        Self {
            settings,
            identity,
            node_id,
            pending_node_id: node_id,
            pending_bit_rate: None,
            state: State::Waiting,
            selected: Selected::NONE,
            identified: 0,
            scanned: Part::Vendor,
            storing: None,
        }
    }

    /// Takes a received frame in. Frames that are no requests change nothing.
    pub fn handle_frame(&mut self, frame: &Frame) -> Reaction {
        if frame.id() != REQUEST || frame.is_remote() {
            return Reaction::NONE;
        }
        let Some(request) = Request::parse(frame.data(), self.settings.request_length) else {
            return Reaction::NONE;
        };
        match request {
            Request::SwitchToWaiting => self.switch_to(State::Waiting),
            Request::SwitchToConfiguration => self.switch_to(State::Configuration),
            Request::Select { part, value } => self.select(part, value),
            Request::Identify { bound, value } => self.identify(bound, value),
            Request::IdentifyNonConfigured => self.identify_non_configured(),
            Request::Fastscan(question) => self.fastscan(question),
            Request::ConfigureNodeId { node_id } => self.configure_node_id(node_id),
            Request::ConfigureBitTiming { table, index } if self.configures() => {
                self.configure_bit_timing(table, index)
            }
            Request::ActivateBitTiming { delay_ms } if self.configures() => {
                self.activate_bit_timing(delay_ms)
            }
            Request::Store if self.configures() => self.store(),
            Request::Inquire(part) if self.configures() => {
                let value = self.identity.part(part).to_le_bytes();
                Reaction::answer(INQUIRE_IDENTITY + part.number(), value)
            }
            Request::InquireNodeId if self.configures() => {
                let node_id = self.node_id.map_or(UNCONFIGURED, NodeId::get);
                Reaction::result(INQUIRE_NODE_ID, node_id)
            }
            Request::ConfigureBitTiming { .. }
            | Request::ActivateBitTiming { .. }
            | Request::Store
            | Request::Inquire(_)
            | Request::InquireNodeId => Reaction::NONE,
        }
    }

    /// The user touched the device: takes the node-ID on offer, once per offer.
    pub fn take_offer(&mut self) -> Reaction {
        let State::Addressing { offer } = &mut self.state else { return Reaction::NONE };
        let Some(node_id) = offer.take_if(|_| self.storing.is_none()) else {
            return Reaction::NONE;
        };
        self.storing = Some(Storing::Offer);
        self.pending_node_id = Some(node_id);
        Reaction::event(Event::StoreNodeId { node_id })
    }

    /// The configuration of [`Event::Store`] or [`Event::StoreNodeId`] is stored, or is not. Nothing
    /// happens when none was to be. An offer that could not be stored stays unanswered: no device
    /// has it.
    pub fn handle_stored(&mut self, outcome: Result<(), StoreError>) -> Reaction {
        let code = match outcome {
            Ok(()) => SUCCESS,
            Err(StoreError::NotSupported) => 1,
            Err(StoreError::AccessFailed) => 2,
        };
        match self.storing.take() {
            Some(Storing::Configuration) => Reaction::result(STORE, code),
            Some(Storing::Offer) if outcome.is_ok() => Reaction::result(CONFIGURE_NODE_ID, SUCCESS),
            Some(Storing::Offer) => {
                self.pending_node_id = self.node_id;
                Reaction::NONE
            }
            None => Reaction::NONE,
        }
    }

    /// The node-ID to build a node with at the next reset of the communication. `None`: the device
    /// has none then.
    #[must_use]
    pub const fn pending_node_id(&self) -> Option<NodeId> {
        self.pending_node_id
    }
}

impl Slave {
    fn switch_to(&mut self, to: State) -> Reaction {
        let from = core::mem::replace(&mut self.state, to);
        match (from, to) {
            (State::Addressing { .. }, State::Waiting | State::Configuration) => {
                Reaction::event(Event::AddressingEnded)
            }
            (State::Configuration, State::Waiting) if self.node_id.is_none() => {
                self.node_id = self.pending_node_id;
                let event = self.node_id.map(|node_id| Event::Configured { node_id });
                Reaction { response: None, event }
            }
            (_, State::Waiting | State::Configuration | State::Addressing { .. }) => Reaction::NONE,
        }
    }

    /// The serial number decides; the other parts may come in any order before.
    fn select(&mut self, part: Part, value: u32) -> Reaction {
        match (self.state, self.settings.selection) {
            (State::Waiting, _) | (State::Configuration, Selection::WhileWaitingOrConfiguring) => {}
            (State::Configuration, Selection::WhileWaiting) | (State::Addressing { .. }, _) => {
                return Reaction::NONE;
            }
        }
        self.selected.take(part, value);
        if part != Part::Serial {
            return Reaction::NONE;
        }
        let selected = core::mem::replace(&mut self.selected, Selected::NONE);
        if selected.is(&self.identity) {
            let _ = self.switch_to(State::Configuration);
            Reaction::result(SELECTED, 0)
        } else if self.asks_for_addressing(&selected) {
            self.switch_to(State::Addressing { offer: None })
        } else {
            self.switch_to(State::Waiting)
        }
    }

    fn asks_for_addressing(&self, selected: &Selected) -> bool {
        let every = Identity {
            vendor_id: self.identity.vendor_id,
            product_code: EVERY,
            revision: EVERY,
            serial: EVERY,
        };
        match self.settings.addressing {
            Addressing::Configured => false,
            Addressing::ConfiguredOrOffered => selected.is(&every),
        }
    }

    fn identify(&mut self, bound: Bound, value: u32) -> Reaction {
        let Identity { vendor_id, product_code, revision, serial } = self.identity;
        let (step, fits) = match bound {
            Bound::Vendor => (0, value == vendor_id),
            Bound::Product => (1, value == product_code),
            Bound::RevisionMin => (2, value <= revision),
            Bound::RevisionMax => (3, value >= revision),
            Bound::SerialMin => (4, value <= serial),
            Bound::SerialMax => (5, value >= serial),
        };
        let follows = step == 0 || step == self.identified;
        self.identified = if follows && fits { step + 1 } else { 0 };
        if self.identified == 6 && self.identifies() {
            Reaction::answer(IDENTIFIED, [0; 4])
        } else {
            Reaction::NONE
        }
    }

    fn identify_non_configured(&self) -> Reaction {
        if self.identifies() && self.is_without_node_id() {
            Reaction::answer(NON_CONFIGURED, [0; 4])
        } else {
            Reaction::NONE
        }
    }

    /// A binary search of the master for the identity of one device without a node-ID.
    fn fastscan(&mut self, question: Fastscan) -> Reaction {
        let takes_part = self.state == State::Waiting && self.is_without_node_id();
        if !takes_part || !self.identifies() {
            return Reaction::NONE;
        }
        match question {
            Fastscan::Begin => self.scanned = Part::Vendor,
            Fastscan::Compare { number, lowest_bit, part, next } => {
                let differing = (self.identity.part(part) ^ number) >> lowest_bit;
                if part != self.scanned || differing != 0 {
                    return Reaction::NONE;
                }
                self.scanned = next;
                if lowest_bit == 0 && next.number() < part.number() {
                    let _ = self.switch_to(State::Configuration);
                }
            }
        }
        Reaction::answer(IDENTIFIED, [0; 4])
    }

    fn configure_node_id(&mut self, node_id: u8) -> Reaction {
        match &mut self.state {
            State::Waiting => Reaction::NONE,
            State::Addressing { offer } => match NodeId::new(node_id) {
                Some(node_id) => {
                    *offer = Some(node_id);
                    Reaction::event(Event::Offered { node_id })
                }
                None => Reaction::NONE,
            },
            State::Configuration => {
                let unconfigures = node_id == UNCONFIGURED
                    && self.settings.unconfigured == Unconfigured::Permitted;
                let configured = NodeId::new(node_id);
                if configured.is_none() && !unconfigures {
                    return Reaction::result(CONFIGURE_NODE_ID, OUT_OF_RANGE);
                }
                self.pending_node_id = configured;
                Reaction::result(CONFIGURE_NODE_ID, SUCCESS)
            }
        }
    }

    fn configure_bit_timing(&mut self, table: u8, index: u8) -> Reaction {
        const STANDARD_TABLE: u8 = 0;
        let rate = BitRate::from_index(index)
            .filter(|rate| table == STANDARD_TABLE && self.settings.bit_rates.contains(rate));
        self.pending_bit_rate = rate.or(self.pending_bit_rate);
        Reaction::result(CONFIGURE_BIT_TIMING, if rate.is_some() { SUCCESS } else { OUT_OF_RANGE })
    }

    fn activate_bit_timing(&self, delay_ms: u16) -> Reaction {
        let delay = Duration::from_millis(u64::from(delay_ms));
        let event = |bit_rate| Event::ActivateBitTiming { bit_rate, delay };
        Reaction { response: None, event: self.pending_bit_rate.map(event) }
    }

    /// A master that does not wait for its answer gets one only.
    fn store(&mut self) -> Reaction {
        if self.storing.is_some() {
            return Reaction::NONE;
        }
        self.storing = Some(Storing::Configuration);
        let (node_id, bit_rate) = (self.pending_node_id, self.pending_bit_rate);
        Reaction::event(Event::Store { node_id, bit_rate })
    }

    fn configures(&self) -> bool {
        self.state == State::Configuration
    }

    fn identifies(&self) -> bool {
        self.settings.identification == Identification::Answered
    }

    const fn is_without_node_id(&self) -> bool {
        self.node_id.is_none() && self.pending_node_id.is_none()
    }
}
