//! The ways of the NM17x on the bus.

use canopen::lss::{
    self, Addressing, BitRate, Identification, RequestLength, Selected, Selection, Unconfigured,
};
use canopen::{
    AbortCode, AbortCodes, AdditionalInformation, BusOff, BusRules, Emergency, ErrorBehaviour,
    Expedited, Identifiers, PdoChanges, PdoRules, ProductSettings, ReceiveErrors, Settings,
    Trigger,
};
use units::Duration;

/// What NM17x devices do differently from CiA 301 (A-10, A-12, A-19, A-20,
///
static SETTINGS: Settings = Settings {
    pdo: PdoRules {
        inhibit_unit: Duration::from_millis(1),
        type_254: Trigger::Timer,
        type_255: Trigger::Change,
        changes: PdoChanges::AnyTime,
        ..Settings::CIA_301.pdo
    },
    identifiers: Identifiers::Unrestricted,
    expedited: Expedited::OneTwoOrFour,
    receive_errors: ReceiveErrors {
        too_short: Some(Emergency { code: 0x8210, manufacturer: [0, 0, 0, 0, 1] }),
        too_long: None,
        value: Some(Emergency { code: 0x8220, manufacturer: [0, 0, 0, 0, 3] }),
        overdue: None,
        sync_length: None,
    },
    bus: BusRules {
        warning: Some(Emergency { code: 0x8100, manufacturer: [0; 5] }),
        passive: Some(Emergency { code: 0x8120, manufacturer: [0; 5] }),
        recovered: Some(Emergency { code: 0x8140, manufacturer: [0; 5] }),
        overrun: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
        overflow: Some(Emergency { code: 0x8110, manufacturer: [0; 5] }),
        off: BusOff::NoReason,
    },
    error_behaviour: ErrorBehaviour::InOperational,
    additional_information: AdditionalInformation::LastByte,
    lss: Some(&LAYER_SETTINGS),
    abort_codes: AbortCodes {
        number_length: AbortCode::UNSUPPORTED_ACCESS,
        text_length: AbortCode::VALUE_RANGE,
        excess_bytes: Some(AbortCode::VALUE_TOO_HIGH),
        above_maximum: AbortCode::VALUE_RANGE,
        below_minimum: AbortCode::VALUE_RANGE,
        value_range: AbortCode::VALUE_RANGE,
        not_stored: AbortCode::LOCAL_CONTROL,
    },
};

/// [`SETTINGS`], known to the compiler wherever they are used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nm17x;

impl ProductSettings for Nm17x {
    #[inline]
    fn settings(self) -> &'static Settings {
        &SETTINGS
    }
}

/// What NM17x devices do differently from CiA 305.
static LAYER_SETTINGS: lss::Settings = lss::Settings {
    request_length: RequestLength::AsNeeded,
    selection: Selection::WhileWaitingOrConfiguring,
    selected: Selected::Confirmed,
    addressing: Addressing::ConfiguredOrOffered,
    identification: Identification::Ignored,
    unconfigured: Unconfigured::OutOfRange,
    bit_rates: BitRate::ALL,
};
