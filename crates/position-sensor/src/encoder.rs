//! The encoders: what their objects have to do with each other.

use canopen::lss::{self, BitRate, Selected, Unconfigured};
use canopen::{
    AbortCode, AbortCodes, AdditionalInformation, BusOff, BusRules, CanId, ErrorBehaviour,
    Expedited, Frame, Identifiers, PdoChanges, PdoRules, ReceiveErrors, RemoteRequests, Settings,
    Trigger,
};
use object_dictionary::{ObjectId, Values};
use profiles::OBJECTS_MAX;
use profiles::encoder::gxmm::{
    MEASURING_RANGE, MEASURING_RANGE_MAX, POSITION_VALUE, PRESET, UNITS_PER_TURN,
    UNITS_PER_TURN_MAX,
};
use profiles::encoder::{
    BIT_RATE, CYCLE_TIMER, MODULE_SERIAL_NUMBER, OFFSET, OPERATING_PARAMETERS, OPERATING_STATUS,
    OPTIONS, SERIAL_NUMBER, SYNC_COB_ID, TPDO1_EVENT_TIMER,
};

use crate::family::{Present, View};

/// Encoder EN-SDO-02 to EN-SDO-05, EN-PDO-02, B-11, B-15, B-21, B-28, B-32, B-33, B-69.
pub(crate) static SETTINGS: Settings = Settings {
    pdo: PdoRules {
        type_254: Trigger::Timer,
        remote_requests: RemoteRequests::RemoteTypes,
        changes: PdoChanges::AnyTime,
        ..Settings::CIA_301.pdo
    },
    identifiers: Identifiers::Any,
    expedited: Expedited::LongerToo,
    receive_errors: ReceiveErrors {
        too_short: None,
        too_long: None,
        value: None,
        overdue: None,
        sync_length: None,
    },
    bus: BusRules {
        warning: None,
        passive: None,
        recovered: None,
        overrun: None,
        overflow: None,
        off: BusOff::NoReason,
    },
    error_behaviour: ErrorBehaviour::InEveryState,
    additional_information: AdditionalInformation::None,
    abort_codes: AbortCodes {
        number_length: AbortCode::UNSUPPORTED_ACCESS,
        text_length: AbortCode::UNSUPPORTED_ACCESS,
        excess_bytes: None,
        above_maximum: AbortCode::VALUE_TOO_HIGH,
        below_minimum: AbortCode::VALUE_RANGE,
        value_range: AbortCode::VALUE_RANGE,
        not_stored: AbortCode::LOCAL_CONTROL,
    },
    lss: Some(&LAYER_SETTINGS),
};

/// Encoder EN-LSS-01 to EN-LSS-10, B-39.
static LAYER_SETTINGS: lss::Settings = lss::Settings {
    selected: Selected::Mode,
    unconfigured: Unconfigured::OutOfRange,
    ..lss::Settings::CIA_305
};

/// Bit of [`OPERATING_PARAMETERS`]: values rise when the shaft turns left.
const LEFT: u16 = 1 << 0;
/// Bit of [`OPERATING_PARAMETERS`]: the units that were set are used.
const SCALING: u16 = 1 << 2;

// Bits of OPTIONS (EN-OPT-01).
const INVERTED: u32 = 1 << 1;
const SCALING_LOCKED: u32 = 1 << 2;
const BUS_OFF_ENDS: u32 = 1 << 3;
const READ_WITH_SYNC: u32 = 1 << 6;
const READ_WITH_SYNC_ALONE: u32 = 1 << 7;
const TPDO1_DELAYED: u32 = 1 << 8;
const OFFSET_KEPT: u32 = 1 << 9;
const RESET_KEEPS_RUNNING: u32 = 1 << 10;
const OPTIONS_KNOWN: u32 = 0x7EE;

/// What TPDO1_DELAYED adds to the period (B-20).
const DELAY_MS: u16 = 2;

/// EN-CFG-01; the switches stand at 00 (B-41, B-43).
pub(crate) fn bit_rate(values: &Values<OBJECTS_MAX>) -> u32 {
    const KBIT_S: [u32; 9] = [10, 20, 50, 100, 125, 250, 500, 800, 1_000];
    KBIT_S.get(usize::from(values.get(&BIT_RATE))).map_or(50_000, |kbit_s| kbit_s * 1_000)
}

/// The number of a bit rate in [`BIT_RATE`] (EN-LSS-05).
pub(crate) const fn number_of(bit_rate: BitRate) -> u8 {
    8_u8.saturating_sub(bit_rate.index())
}

/// Whether bus-off ends by itself (EN-ERR-03).
pub(crate) fn recovers_from_bus_off(values: &Values<OBJECTS_MAX>) -> bool {
    values.get(&OPTIONS) & BUS_OFF_ENDS != 0
}

/// Whether the frame is a SYNC that the shaft is read for (EN-PDO-11).
pub(crate) fn reads_for(values: &Values<OBJECTS_MAX>, frame: &Frame) -> bool {
    values.get(&OPTIONS) & READ_WITH_SYNC != 0
        && frame.id() == CanId::from_low_bits(values.get(&SYNC_COB_ID))
        && !frame.is_remote()
}

/// Whether it is read for other reasons, too (EN-PDO-11, B-46).
pub(crate) fn reads_cyclically(values: &Values<OBJECTS_MAX>) -> bool {
    const ALONE: u32 = READ_WITH_SYNC | READ_WITH_SYNC_ALONE;
    values.get(&OPTIONS) & ALONE != ALONE
}

/// Whether Reset Node restarts the device and not its communication alone (EN-NMT-04, B-24).
pub(crate) fn restarts_on_reset_node(values: &Values<OBJECTS_MAX>) -> bool {
    values.get(&OPTIONS) & RESET_KEEPS_RUNNING == 0
}

/// Whether the units that were set are used (B-45).
fn scales(parameters: u16, options: u32) -> bool {
    parameters & SCALING != 0 && options & SCALING_LOCKED == 0
}

/// Units per turn of the sensor and those in force: in a turn and in all (B-48, B-49).
#[derive(Clone, Copy, Debug)]
struct Scale {
    steps_per_turn: u64,
    steps: u64,
    units_per_turn: u64,
    units: u64,
}

impl Scale {
    fn of(values: &Values<OBJECTS_MAX>) -> Self {
        let steps_per_turn = values.get(&UNITS_PER_TURN_MAX);
        let steps = values.get(&MEASURING_RANGE_MAX);
        let (units_per_turn, units) =
            if scales(values.get(&OPERATING_PARAMETERS), values.get(&OPTIONS)) {
                (values.get(&UNITS_PER_TURN), values.get(&MEASURING_RANGE))
            } else {
                (steps_per_turn, steps)
            };
        Self {
            steps_per_turn: steps_per_turn.max(1).into(),
            steps: steps.max(1).into(),
            units_per_turn: units_per_turn.into(),
            units: units.max(1).into(),
        }
    }

    /// The position without offset.
    fn position(self, steps: i64, left: bool) -> u64 {
        let directed = if left { -i128::from(steps) } else { i128::from(steps) };
        let turned = directed.rem_euclid(self.steps.into());
        let position = turned * i128::from(self.units_per_turn) / i128::from(self.steps_per_turn);
        u64::try_from(position).unwrap_or(0) % self.units
    }
}

pub(crate) fn present(values: &Values<OBJECTS_MAX>) -> Present {
    Present {
        units_are_open: true,
        preset_below: u32::try_from(Scale::of(values).units).ok(),
        scale: (values.get(&UNITS_PER_TURN), values.get(&MEASURING_RANGE)),
    }
}

pub(crate) fn follow(
    view: &mut View<'_>,
    written: ObjectId,
    before: &Present,
    steps: i64,
) -> ObjectId {
    if written == OPTIONS.id() {
        view.set(&OPTIONS, view.get(&OPTIONS) & OPTIONS_KNOWN);
    } else if written == OPERATING_PARAMETERS.id() {
        view.set(&OPERATING_PARAMETERS, view.get(&OPERATING_PARAMETERS) & (LEFT | SCALING));
    } else if written == TPDO1_EVENT_TIMER.id() {
        view.set(&CYCLE_TIMER, view.get(&TPDO1_EVENT_TIMER).saturating_sub(delay_ms(view)));
    } else if written == PRESET.id() {
        let scale = Scale::of(view.node.values());
        let preset = u64::from(view.get(&PRESET)) + scale.units;
        let offset = (preset - scale.position(steps, counts_left(view))) % scale.units;
        view.set(&OFFSET, u32::try_from(offset).unwrap_or(0));
    }
    let scale = (view.get(&UNITS_PER_TURN), view.get(&MEASURING_RANGE));
    if scale != before.scale && view.get(&OPTIONS) & OFFSET_KEPT == 0 {
        view.set(&OFFSET, 0);
    }
    written
}

fn delay_ms(view: &View<'_>) -> u16 {
    if view.get(&OPTIONS) & TPDO1_DELAYED == 0 { 0 } else { DELAY_MS }
}

fn counts_left(view: &View<'_>) -> bool {
    let left = view.get(&OPERATING_PARAMETERS) & LEFT != 0;
    left != (view.get(&OPTIONS) & INVERTED != 0)
}

pub(crate) fn derive(view: &mut View<'_>, steps: i64) {
    let parameters = view.get(&OPERATING_PARAMETERS);
    let in_force =
        if scales(parameters, view.get(&OPTIONS)) { parameters } else { parameters & !SCALING };
    view.set(&OPERATING_STATUS, in_force);
    view.set(&MODULE_SERIAL_NUMBER, view.get(&SERIAL_NUMBER));
    let period = match view.get(&CYCLE_TIMER) {
        0 => 0,
        ms => ms.saturating_add(delay_ms(view)),
    };
    view.set(&TPDO1_EVENT_TIMER, period);
    let scale = Scale::of(view.node.values());
    let position = scale.position(steps, counts_left(view)) + u64::from(view.get(&OFFSET));
    view.set(&POSITION_VALUE, u32::try_from(position % scale.units).unwrap_or(0));
}
