//! The AP04: what its objects have to do with each other.

use canopen::{
    AbortCode, AbortCodes, AdditionalInformation, BusOff, BusRules, Emergency, Expedited,
    Identifiers, PdoChanges, PdoRules, ReceiveErrors, RemoteRequests, Settings, SyncDivision,
    Trigger,
};
use object_dictionary::{Object, ObjectId, Values};
use profiles::OBJECTS_MAX;
use profiles::ap04::{
    ALARMS, CYCLE_TIMER, LOOP_DIRECTION, MEASURING_RANGE, MODULE_OFFSET, OFFSET,
    OPERATING_PARAMETERS, OPERATING_STATUS, POSITION_MAX, POSITION_MIN, POSITION_VALUE, PRESET,
    RPDO1_COB_ID, RPDO2_COB_ID, TPDO1_COB_ID, TPDO1_EVENT_TIMER, TPDO2_COB_ID, UNITS_PER_TURN,
    ZERO_POSITION, ZERO_VALUE,
};

use crate::family::{Present, View};

/// Steps of the sensor in a turn (AP04 AP-GEN-01).
pub(crate) const STEPS_PER_TURN: u32 = 720;
const TURNS: u32 = 7_281;
/// Set by keys only (AP04 AP-GEN-04).
pub(crate) const BIT_RATE: u32 = 250_000;

/// AP04 AP-SDO-02, AP-SDO-06, AP-PDO-02, AP-PDO-05, AP-EMCY-03, A-32, A-33, A-35, A-42, A-45, A-72.
pub(crate) static SETTINGS: Settings = Settings {
    pdo: PdoRules {
        type_254: Trigger::Timer,
        sync_division: SyncDivision::None,
        remote_requests: RemoteRequests::RemoteTypes,
        changes: PdoChanges::AnyTime,
        ..Settings::CIA_301.pdo
    },
    identifiers: Identifiers::Any,
    expedited: Expedited::FourOnly,
    receive_errors: ReceiveErrors {
        too_short: None,
        too_long: None,
        value: None,
        overdue: None,
        sync_length: None,
    },
    bus: BusRules {
        warning: None,
        passive: Some(Emergency { code: 0x8120, manufacturer: [0; 5] }),
        recovered: Some(Emergency { code: 0x8140, manufacturer: [0; 5] }),
        overrun: None,
        overflow: None,
        off: BusOff::NoReason,
    },
    additional_information: AdditionalInformation::RegisterAndFirstByte,
    abort_codes: AbortCodes {
        number_length: AbortCode::LENGTH_MISMATCH,
        text_length: AbortCode::LENGTH_MISMATCH,
        excess_bytes: None,
        above_maximum: AbortCode::VALUE_RANGE,
        below_minimum: AbortCode::VALUE_RANGE,
        value_range: AbortCode::VALUE_RANGE,
        not_stored: AbortCode::NOT_STORED,
    },
    ..Settings::CIA_301
};

/// Bit of [`OPERATING_PARAMETERS`]: values rise when the shaft turns right.
const RIGHT: u16 = 1 << 0;
/// Bit of [`OPERATING_PARAMETERS`]: [`UNITS_PER_TURN`] may be written.
const SCALING: u16 = 1 << 2;
/// Bit of [`ALARMS`]: the position lies beyond what can be sent.
const POSITION_INVALID: u16 = 1 << 0;
/// Error code of the emergency message about that.
const POSITION_ERROR: u16 = 0x7320;
/// Bit of a COB-ID: no remote frames.
const NO_RTR: u32 = 1 << 30;
/// How [`LOOP_DIRECTION`] reads without a loop: `DIR`.
const DIRECT: u32 = 0x0052_4944;

pub(crate) fn present(values: &Values<OBJECTS_MAX>) -> Present {
    Present {
        units_are_open: values.get(&OPERATING_PARAMETERS) & SCALING != 0,
        preset_below: None,
        scale: (values.get(&UNITS_PER_TURN), values.get(&MEASURING_RANGE)),
    }
}

pub(crate) fn follow(view: &mut View<'_>, written: ObjectId, steps: i64) -> ObjectId {
    const FORCED: [Object<u32>; 3] = [RPDO1_COB_ID, RPDO2_COB_ID, TPDO1_COB_ID];
    if let Some(cob_id) = FORCED.iter().find(|cob_id| cob_id.id() == written) {
        view.set(cob_id, view.get(cob_id) | NO_RTR);
    } else if written == TPDO2_COB_ID.id() {
        view.set(&TPDO2_COB_ID, view.get(&TPDO2_COB_ID) & !NO_RTR);
    } else if written == OPERATING_PARAMETERS.id() {
        view.set(&OPERATING_PARAMETERS, view.get(&OPERATING_PARAMETERS) & (RIGHT | SCALING));
    } else if written == LOOP_DIRECTION.id() && view.get(&LOOP_DIRECTION) == 0 {
        view.set(&LOOP_DIRECTION, DIRECT);
    } else if written == CYCLE_TIMER.id() {
        view.set(&TPDO1_EVENT_TIMER, view.get(&CYCLE_TIMER));
        return TPDO1_EVENT_TIMER.id();
    } else if written == ZERO_POSITION.id() {
        view.set(&ZERO_VALUE, counted(view, steps));
        return ZERO_VALUE.id();
    }
    written
}

/// The steps in the direction in which values rise, within the turns that the counter tells apart:
/// half of them on either side of zero (AP-POS-07, AP-POS-11).
fn counted(view: &View<'_>, steps: i64) -> i32 {
    let all = i64::from(TURNS * STEPS_PER_TURN);
    let right = view.get(&OPERATING_PARAMETERS) & RIGHT != 0;
    let directed = if right { steps } else { -steps };
    let within = (directed + all / 2).rem_euclid(all) - all / 2;
    i32::try_from(within).unwrap_or(0)
}

pub(crate) fn derive(view: &mut View<'_>, steps: i64) {
    let units_per_turn = view.get(&UNITS_PER_TURN);
    view.set(&OPERATING_STATUS, view.get(&OPERATING_PARAMETERS));
    view.set(&MEASURING_RANGE, units_per_turn.saturating_mul(TURNS));
    view.set(&MODULE_OFFSET, view.get(&OFFSET));
    view.set(&CYCLE_TIMER, view.get(&TPDO1_EVENT_TIMER));
    // AP-POS-01 with the rounding of A-23, AP-POS-11 with the ends of A-22.
    let turned = i64::from(counted(view, steps)) - i64::from(view.get(&ZERO_VALUE));
    let measured =
        (i128::from(turned) * i128::from(units_per_turn)).div_euclid(i128::from(STEPS_PER_TURN));
    let position = measured + i128::from(view.get(&PRESET)) + i128::from(view.get(&OFFSET));
    let (min, max) = (view.get(&POSITION_MIN), view.get(&POSITION_MAX));
    let sent = i32::try_from(position.clamp(min.into(), max.into())).unwrap_or(max);
    let alarms = if i128::from(sent) == position { 0 } else { POSITION_INVALID };
    view.set(&POSITION_VALUE, sent);
    if view.get(&ALARMS) != alarms {
        view.set(&ALARMS, alarms);
        view.node.set_error_register(view.now, u8::from(alarms != 0));
        if alarms != 0 {
            // AP-EMCY-01: alarms and warnings are the maker's bytes.
            let [low, high] = alarms.to_le_bytes();
            view.node.send_emergency(POSITION_ERROR, [low, high, 0, 0, 0]);
        }
    }
}
