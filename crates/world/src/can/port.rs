use super::counters::ErrorCounters;
use super::frame::Frame;
use super::time::{BitTime, Nanos};

/// Transmit mailboxes of a controller.
pub const MAILBOXES: usize = 3;

/// What a device's CAN controller has put to the bus, as of a boundary between two quanta.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortState {
    /// How it takes part.
    pub presence: Presence,
    /// Its bit time.
    pub bit: BitTime,
    /// Since when it takes part: it saw 11 recessive bits before.
    pub since: Nanos,
    /// Its error counters.
    pub counters: ErrorCounters,
    /// Which of several mailboxes goes first.
    pub order: SendOrder,
    /// What it wants to send, by mailbox.
    pub requests: [Option<Request>; MAILBOXES],
    /// It needs the next boundary, soon: it wants to leave the bus or withdrew a frame, and only
    /// there learns whether one is under way.
    pub waits: bool,
}

impl PortState {
    /// A controller that is not on the bus: without supply, in reset, being set up, asleep, bus-off.
    pub const OFF: Self = Self {
        presence: Presence::Off,
        bit: BitTime::from_rate(1_000_000),
        since: Nanos::ZERO,
        counters: ErrorCounters::NONE,
        order: SendOrder::Identifier,
        requests: [None; MAILBOXES],
        waits: false,
    };
}

/// How a node takes part in the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// Not at all.
    Off,
    /// It hears, but drives nothing: no acknowledgement, no error flag, no frame.
    Silent,
    /// Fully.
    Normal,
    /// It sends, and neither hears nor needs an acknowledgement.
    LoopBack,
}

/// The order of the mailboxes of one controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SendOrder {
    /// The identifier that wins arbitration; of equals the lower mailbox.
    Identifier,
    /// The oldest request; of equals the lower mailbox.
    Request,
}

/// A frame waiting in a mailbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// When it was requested.
    pub at: Nanos,
    /// When it was withdrawn, if it was: it takes no part in an arbitration after that.
    pub withdrawn_at: Option<Nanos>,
    /// The frame.
    pub frame: Frame,
}

/// What a boundary brings a controller. The default brings nothing and need not be delivered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Delivery {
    /// What goes over the bus since the last boundary.
    pub activity: Option<Activity>,
    /// The mailbox whose frame is going out now; its outcome is among [`Delivery::outcomes`].
    pub sending: Option<usize>,
    /// What will happen, in the order of time, all of it after the boundary.
    pub outcomes: Vec<Outcome>,
    /// This is the boundary the controller waits for ([`PortState::waits`]).
    pub waited_for: bool,
}

/// A frame, or an attempt at one, on the bus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Activity {
    /// Its start of frame.
    pub start: Nanos,
    /// From when on the bus is recessive again: eleven bits later the next frame may start.
    pub quiet_from: Nanos,
    /// When the next frame may start.
    pub free_at: Nanos,
}

/// Something a controller notices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// When.
    pub at: Nanos,
    /// What.
    pub what: What,
    /// Its error counters from then on.
    pub counters: ErrorCounters,
}

/// What a controller can notice of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// A frame of another node is valid: all but the last bit of its end of frame have passed.
    Received(Frame),
    /// The frame in this mailbox went out and was acknowledged; end of frame has passed.
    Transmitted(usize),
    /// The frame in this mailbox had to give way.
    LostArbitration(usize),
    /// The frame in this mailbox failed.
    TransmitFailed(usize, WireError),
    /// A frame of another node failed.
    ReceiveFailed(WireError),
}

/// What was wrong with a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireError {
    /// Six equal bits where five are allowed.
    Stuff,
    /// A fixed bit had the wrong level.
    Form,
    /// Nobody acknowledged.
    Ack,
    /// Sent recessive, saw dominant.
    BitRecessive,
    /// Sent dominant, saw recessive.
    BitDominant,
    /// The check sequence was wrong.
    Crc,
}
