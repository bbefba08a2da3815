use units::Duration;

use crate::lss;
use crate::sdo::AbortCode;

/// What products do differently, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// How PDOs are configured and sent.
    pub pdo: PdoRules,
    /// Which identifiers clients may choose.
    pub identifiers: Identifiers,
    /// Which lengths expedited transfers have.
    pub expedited: Expedited,
    /// The emergency messages about received frames.
    pub receive_errors: ReceiveErrors,
    /// What errors of the bus bring about.
    pub bus: BusRules,
    /// In which states the error behaviour (0x1029) acts.
    pub error_behaviour: ErrorBehaviour,
    /// What an entry of the pre-defined error field (0x1003) holds besides the error code.
    pub additional_information: AdditionalInformation,
    /// How layer setting services are served; `None` without.
    pub lss: Option<&'static lss::Settings>,
    /// The abort codes that products choose differently.
    pub abort_codes: AbortCodes,
}

/// Where a node has its settings from. A reference suits products that are chosen at run time. A type
/// without data that returns a constant suits a program for one product: it then has no code for
/// what only others do.
pub trait ProductSettings: Copy {
    /// The settings, always the same ones.
    fn settings(self) -> &'static Settings;
}

impl ProductSettings for &'static Settings {
    #[inline]
    fn settings(self) -> &'static Settings {
        self
    }
}

/// How PDOs are configured and sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PdoRules {
    /// One step of the inhibit times 0x1800:03 and following.
    pub inhibit_unit: Duration,
    /// What starts a PDO of transmission type 254.
    pub type_254: Trigger,
    /// What starts a PDO of transmission type 255.
    pub type_255: Trigger,
    /// What transmission types 1 to 240 count.
    pub sync_division: SyncDivision,
    /// Which transmit PDOs answer remote frames, if bit 30 of their COB-ID allows it.
    pub remote_requests: RemoteRequests,
    /// When clients may change identifier, inhibit time and SYNC start value; the identifier of
    /// emergency messages, too.
    pub changes: PdoChanges,
}

/// What transmission types 1 to 240 count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SyncDivision {
    /// The PDO goes out with every n-th SYNC.
    EveryNth,
    /// The PDO goes out with every SYNC, whatever the number.
    None,
}

/// Which transmit PDOs answer remote frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemoteRequests {
    /// Those of all transmission types.
    AllTypes,
    /// Those of transmission types 252 and 253.
    RemoteTypes,
}

/// When clients may change identifier, inhibit time and SYNC start value of a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PdoChanges {
    /// While it is switched off (bit 31 of its COB-ID).
    WhileOff,
    /// Always.
    AnyTime,
}

/// Which identifiers of eleven bits clients may choose for a PDO that is switched on, for SYNC and for
/// emergency messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identifiers {
    /// All but the restricted ones (CiA 301, section 7.3.5).
    Unrestricted,
    /// All that the row permits.
    Any,
}

/// What starts an event-driven PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trigger {
    /// A change of the mapped data.
    Change,
    /// The event timer.
    Timer,
    /// Both.
    ChangeOrTimer,
}

/// Which lengths expedited transfers have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expedited {
    /// That of the object, 1, 2 or 4 bytes.
    AnyLength,
    /// That of the object; the command that indicates three bytes is unknown.
    OneTwoOrFour,
    /// In a download that of the object or more; the bytes behind it do not count.
    LongerToo,
    /// Always four: a shorter number is widened both ways, and one that does not fit its object is
    /// above the maximum. There are no segments.
    FourOnly,
}

/// The emergency messages about received frames; `None` says nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReceiveErrors {
    /// A frame has fewer bytes than the mapped objects. It is dropped.
    pub too_short: Option<Emergency>,
    /// A frame has more bytes than the mapped objects. The first bytes are used.
    pub too_long: Option<Emergency>,
    /// One of the values is not permitted. The frame is dropped.
    pub value: Option<Emergency>,
    /// The next PDO is overdue (sub-index 5 of 0x1400 and following).
    pub overdue: Option<Emergency>,
    /// A SYNC has a counter where none is expected, or none where one is. It is dropped.
    pub sync_length: Option<Emergency>,
}

/// What errors of the bus bring about: emergency messages, where `None` says nothing, and the error
/// behaviour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusRules {
    /// An error counter has reached 96.
    pub warning: Option<Emergency>,
    /// The controller became error passive.
    pub passive: Option<Emergency>,
    /// The controller recovered from bus-off.
    pub recovered: Option<Emergency>,
    /// The controller lost received frames.
    pub overrun: Option<Emergency>,
    /// Frames were dropped because too many waited for a mailbox.
    pub overflow: Option<Emergency>,
    /// What bus-off is.
    pub off: BusOff,
}

/// What bus-off is to the error behaviour (0x1029).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusOff {
    /// A communication error.
    CommunicationError,
    /// No reason to leave the state.
    NoReason,
}

/// In which states the error behaviour (0x1029) acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorBehaviour {
    /// In Operational alone.
    InOperational,
    /// In every state: to Stopped and to a reset also from Pre-operational.
    InEveryState,
}

/// What an emergency message says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// The error code (CiA 301, table 26).
    pub code: u16,
    /// The maker's bytes.
    pub manufacturer: [u8; 5],
}

/// What an entry of the pre-defined error field holds in bits 31 to 16, besides the error code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdditionalInformation {
    /// Nothing.
    None,
    /// The first two of the maker's bytes.
    FirstTwoBytes,
    /// The last of the maker's bytes, in bits 23 to 16.
    LastByte,
    /// The error register and the first of the maker's bytes, as the message has them.
    RegisterAndFirstByte,
}

/// Whether clients may transfer values in blocks (CiA 301 leaves it to the product).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockTransfer {
    /// Both ways, with a checksum where the client asks for it.
    Served,
    /// The commands are unknown.
    Unknown,
}

/// The abort codes that products choose differently.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbortCodes {
    /// The indicated length is not that of the number.
    pub number_length: AbortCode,
    /// The length is not that of the text.
    pub text_length: AbortCode,
    /// Bytes beyond the number, sent without an indicated length, are not zero. `None` ignores
    /// them.
    pub excess_bytes: Option<AbortCode>,
    /// The number lies above its only span.
    pub above_maximum: AbortCode,
    /// The number lies below its only span.
    pub below_minimum: AbortCode,
    /// The number lies outside several spans, or the product does not take it.
    pub value_range: AbortCode,
    /// The non-volatile memory did not take the value.
    pub not_stored: AbortCode,
}

impl Settings {
    /// As CiA 301 has it.
    pub const CIA_301: Self = Self {
        pdo: PdoRules {
            inhibit_unit: Duration::from_micros(100),
            type_254: Trigger::ChangeOrTimer,
            type_255: Trigger::ChangeOrTimer,
            sync_division: SyncDivision::EveryNth,
            remote_requests: RemoteRequests::AllTypes,
            changes: PdoChanges::WhileOff,
        },
        identifiers: Identifiers::Unrestricted,
        expedited: Expedited::AnyLength,
        receive_errors: ReceiveErrors {
            too_short: Some(Emergency { code: 0x8210, manufacturer: [0; 5] }),
            too_long: Some(Emergency { code: 0x8220, manufacturer: [0; 5] }),
            value: None,
            overdue: Some(Emergency { code: 0x8250, manufacturer: [0; 5] }),
            sync_length: Some(Emergency { code: 0x8240, manufacturer: [0; 5] }),
        },
        bus: BusRules {
            warning: None,
            passive: Some(Emergency { code: 0x8120, manufacturer: [0; 5] }),
            recovered: Some(Emergency { code: 0x8140, manufacturer: [0; 5] }),
            overrun: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
            overflow: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
            off: BusOff::CommunicationError,
        },
        error_behaviour: ErrorBehaviour::InOperational,
        additional_information: AdditionalInformation::FirstTwoBytes,
        lss: None,
        abort_codes: AbortCodes {
            number_length: AbortCode::LENGTH_MISMATCH,
            text_length: AbortCode::LENGTH_MISMATCH,
            excess_bytes: None,
            above_maximum: AbortCode::VALUE_TOO_HIGH,
            below_minimum: AbortCode::VALUE_TOO_LOW,
            value_range: AbortCode::VALUE_RANGE,
            not_stored: AbortCode::HARDWARE_ERROR,
        },
    };
}

impl Default for Settings {
    fn default() -> Self {
        Self::CIA_301
    }
}
