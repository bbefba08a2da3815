//! The objects that NM170, NM172 and NM174 have in common (manual, chapter 4.4).

use object_dictionary::PdoMapping::{Receive, Transmit};
use object_dictionary::{Object, ObjectId, Unit};

use crate::cia301::{self, highest, mapped, number};
pub use crate::cia301::{
    ERROR_1, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_6, ERROR_7, ERROR_8, ERROR_COUNT,
};

/// Firmware version in hundredths, of both controllers.
pub const FIRMWARE: u16 = 105;

/// Spans of a PDO's COB-ID: 0x181 to 0x57F with bit 29 clear and bits 31 and 30 free.
const PDO_COB_IDS: &[(i64, i64)] =
    &[(0x4000_0181, 0x4000_057F), (0x8000_0181, 0x8000_057F), (0xC000_0181, 0xC000_057F)];

/// Transmission types besides 1 to 240: event timer, and on change.
const ACYCLIC: &[(i64, i64)] = &[(0xFE, 0xFF)];

/// Largest shown length, −99999 to 999999.
const LENGTH_MIN: i64 = -99_999;
const LENGTH_MAX: i64 = 999_999;

/// A communication parameter that 0x1010 saves.
const fn communication<T: object_dictionary::Value>(
    index: u16,
    sub: u8,
    name: &'static str,
) -> Object<T> {
    number(index, sub, name).read_write().stored_on_command()
}

/// A parameter that the application controller saves with every change.
const fn parameter<T: object_dictionary::Value>(
    index: u16,
    sub: u8,
    name: &'static str,
    min: i64,
    max: i64,
) -> Object<T> {
    number(index, sub, name).read_write().stored_at_once().within(min, max)
}

// Communication (CiA 301)

/// Absolute multiturn encoder by profile 406.
pub const DEVICE_TYPE: Object<u32> =
    number(0x1000, 0, "Device type").within(0x0002_0196, 0x0002_0196).default(0x0002_0196);
/// Bit 0 generic, 4 communication, 7 manufacturer specific.
pub const ERROR_REGISTER: Object<u8> = number(0x1001, 0, "Error register");
/// The status word 0x204E:01 again.
pub const STATUS_REGISTER: Object<u32> = number(0x1002, 0, "Manufacturer status register");
/// CAN-ID of SYNC; bit 31 is ignored, bits 30 and 29 can not be set.
pub const SYNC_COB_ID: Object<u32> = communication(0x1005, 0, "COB-ID SYNC")
    .within(1, 0x7FF)
    .or_within(&[(0x8000_0001, 0x8000_07FF)])
    .default(0x80);
/// Revision of the hardware.
pub const HARDWARE_VERSION: Object<[u8; 2]> =
    Object::new(0x1009, 0, "Manufacturer hardware version").default_text("/A");
/// Version of the firmware.
pub const SOFTWARE_VERSION: Object<[u8; 4]> =
    Object::new(0x100A, 0, "Manufacturer software version").default_text("1.05");
/// Signatures that save what 0x1000 to 0x1FFF keep.
pub const STORE: Object<u8> = highest(0x1010, "Store parameters - highest sub-index", 2);
/// Bit rate and node-ID are not included.
pub const STORE_ALL: Object<u32> = cia301::store(1, "Store parameters - Save all parameters");
/// The same as [`STORE_ALL`].
pub const STORE_COMMUNICATION: Object<u32> =
    cia301::store(2, "Store parameters - Save communication parameters");
/// Signatures that bring back the state at delivery.
pub const RESTORE: Object<u8> = highest(0x1011, "Restore parameters - highest sub-index", 2);
/// In force after a restart; bit rate and node-ID included.
pub const RESTORE_ALL: Object<u32> =
    cia301::restore(1, "Restore parameters - Restore all parameters");
/// The same as [`RESTORE_ALL`].
pub const RESTORE_COMMUNICATION: Object<u32> =
    cia301::restore(2, "Restore parameters - Restore communication parameters");
/// CAN-ID of emergencies; follows the node-ID until it is written.
pub const EMERGENCY_COB_ID: Object<u32> =
    communication(0x1014, 0, "COB-ID EMCY").within(0x81, 0xFF).default_node_id_plus(0x80);
/// Producers that are watched.
pub const CONSUMER_HEARTBEAT: Object<u8> =
    highest(0x1016, "Consumer heartbeat time - highest sub-index", 1);
/// Node-ID in bits 23 to 16, time in ms in bits 15 to 0; unused when one of them says nothing.
pub const CONSUMER_HEARTBEAT_TIME: Object<u32> =
    communication(0x1016, 1, "Consumer heartbeat time");
/// Period of the heartbeat; 0 is off.
pub const PRODUCER_HEARTBEAT_TIME: Object<u16> =
    communication(0x1017, 0, "Producer heartbeat time").unit(Unit::Millisecond);

/// Identity object.
pub const IDENTITY: Object<u8> = highest(0x1018, "Identity object - highest sub-index", 4);
/// Baumer.
pub const VENDOR_ID: Object<u32> =
    number(0x1018, 1, "Identity - Vendor-ID").within(0xEC, 0xEC).default(0xEC);
/// Major revision in the upper, minor in the lower word.
pub const REVISION_NUMBER: Object<u32> =
    number(0x1018, 3, "Identity - Revision number").default(0x0001_0001);
/// Differs from device to device; never 0 on a device.
pub const SERIAL_NUMBER: Object<u32> = number(0x1018, 4, "Identity - Serial number");

/// What follows from an error.
pub const ERROR_BEHAVIOUR: Object<u8> = highest(0x1029, "Error behaviour - highest sub-index", 2);
/// Heartbeat lost: 0 to Pre-operational, 1 no change, 2 to Stopped.
pub const ERROR_BEHAVIOUR_COMMUNICATION: Object<u8> =
    communication(0x1029, 1, "Error behaviour - Communication error").within(0, 2);
/// Coded as [`ERROR_BEHAVIOUR_COMMUNICATION`].
pub const ERROR_BEHAVIOUR_MANUFACTURER: Object<u8> =
    communication(0x1029, 2, "Error behaviour - Manufacturer specific error")
        .within(0, 2)
        .default(1);

/// RxPDO1: the broadcast.
pub const RPDO1: Object<u8> =
    highest(0x1400, "RxPDO1 communication parameter - highest sub-index", 2);
/// The same on all devices; does not follow the node-ID.
pub const RPDO1_COB_ID: Object<u32> = communication(0x1400, 1, "RxPDO1 COB-ID")
    .within(0x181, 0x57F)
    .or_within(PDO_COB_IDS)
    .default(0x4000_0201);
/// Executed at once, whatever it says.
pub const RPDO1_TRANSMISSION_TYPE: Object<u8> =
    communication(0x1400, 2, "RxPDO1 transmission type").within(0xFF, 0xFF).default(0xFF);

/// RxPDO2: setpoint, correction and control register.
pub const RPDO2: Object<u8> =
    highest(0x1401, "RxPDO2 communication parameter - highest sub-index", 2);
/// Follows the node-ID until it is written.
pub const RPDO2_COB_ID: Object<u32> = communication(0x1401, 1, "RxPDO2 COB-ID")
    .within(0x181, 0x57F)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x4000_0300);
/// Executed at once, whatever it says.
pub const RPDO2_TRANSMISSION_TYPE: Object<u8> =
    communication(0x1401, 2, "RxPDO2 transmission type").within(0xFF, 0xFF).default(0xFF);

/// What RxPDO1 carries.
pub const RPDO1_MAPPING: Object<u8> = highest(0x1600, "RxPDO1 mapping - highest sub-index", 4);
/// Byte 1.
pub const RPDO1_MAPPED_CONTROL: Object<u32> =
    mapped(0x1600, 1, "RxPDO1 mapping - Broadcast control", 0x2500_0108);
/// Bytes 2 and 3.
pub const RPDO1_MAPPED_OBJECT: Object<u32> =
    mapped(0x1600, 2, "RxPDO1 mapping - Broadcast object", 0x2500_0210);
/// Byte 4.
pub const RPDO1_MAPPED_SUB_INDEX: Object<u32> =
    mapped(0x1600, 3, "RxPDO1 mapping - Broadcast sub-index", 0x2500_0308);
/// Bytes 5 to 8.
pub const RPDO1_MAPPED_DATA: Object<u32> =
    mapped(0x1600, 4, "RxPDO1 mapping - Broadcast data", 0x2500_0420);

/// What RxPDO2 carries.
pub const RPDO2_MAPPING: Object<u8> = highest(0x1601, "RxPDO2 mapping - highest sub-index", 3);
/// Bytes 1 to 4.
pub const RPDO2_MAPPED_SETPOINT: Object<u32> =
    mapped(0x1601, 1, "RxPDO2 mapping - Setpoint", 0x2501_0120);
/// Bytes 5 and 6.
pub const RPDO2_MAPPED_CORRECTION: Object<u32> =
    mapped(0x1601, 2, "RxPDO2 mapping - Actual value correction", 0x2501_0210);
/// Bytes 7 and 8.
pub const RPDO2_MAPPED_CONTROL: Object<u32> =
    mapped(0x1601, 3, "RxPDO2 mapping - Control", 0x2501_0310);

/// TxPDO1: position, status, errors.
pub const TPDO1: Object<u8> = highest(0x1800, "TxPDO1 communication parameter", 5);
/// Off (bit 31) at delivery.
pub const TPDO1_COB_ID: Object<u32> = communication(0x1800, 1, "TxPDO1 COB-ID")
    .within(0x181, 0x57F)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0xC000_0180);
/// 1 to 240 every n-th SYNC, 254 event timer, 255 on change.
pub const TPDO1_TRANSMISSION_TYPE: Object<u8> =
    communication(0x1800, 2, "TxPDO1 transmission type")
        .within(1, 0xF0)
        .or_within(ACYCLIC)
        .default(0xFF);
/// In ms, unlike CiA 301.
pub const TPDO1_INHIBIT_TIME: Object<u16> =
    communication(0x1800, 3, "TxPDO1 inhibit time").default(80).unit(Unit::Millisecond);
/// Period of type 254; 0 is off.
pub const TPDO1_EVENT_TIMER: Object<u16> =
    communication(0x1800, 5, "TxPDO1 event timer").default(1_000).unit(Unit::Millisecond);

/// TxPDO2: position, correction, status.
pub const TPDO2: Object<u8> = highest(0x1801, "TxPDO2 communication parameter", 5);
/// On at delivery.
pub const TPDO2_COB_ID: Object<u32> = communication(0x1801, 1, "TxPDO2 COB-ID")
    .within(0x181, 0x57F)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x4000_0280);
/// 1 to 240 every n-th SYNC, 254 event timer, 255 on change.
pub const TPDO2_TRANSMISSION_TYPE: Object<u8> =
    communication(0x1801, 2, "TxPDO2 transmission type")
        .within(1, 0xF0)
        .or_within(ACYCLIC)
        .default(0xFF);
/// In ms, unlike CiA 301.
pub const TPDO2_INHIBIT_TIME: Object<u16> =
    communication(0x1801, 3, "TxPDO2 inhibit time").default(80).unit(Unit::Millisecond);
/// Period of type 254; 0 is off.
pub const TPDO2_EVENT_TIMER: Object<u16> =
    communication(0x1801, 5, "TxPDO2 event timer").default(1).unit(Unit::Millisecond);

/// What TxPDO1 carries.
pub const TPDO1_MAPPING: Object<u8> = highest(0x1A00, "TxPDO1 mapping", 3);
/// Bytes 1 to 4.
pub const TPDO1_MAPPED_POSITION: Object<u32> =
    mapped(0x1A00, 1, "TxPDO1 mapping - Position", 0x6004_0020);
/// Bytes 5 and 6.
pub const TPDO1_MAPPED_STATUS: Object<u32> =
    mapped(0x1A00, 2, "TxPDO1 mapping - Status", 0x204E_0110);
/// Bytes 7 and 8.
pub const TPDO1_MAPPED_ERRORS: Object<u32> =
    mapped(0x1A00, 3, "TxPDO1 mapping - Errors", 0x204E_0210);

/// What TxPDO2 carries.
pub const TPDO2_MAPPING: Object<u8> = highest(0x1A01, "TxPDO2 mapping", 3);
/// Bytes 1 to 4.
pub const TPDO2_MAPPED_POSITION: Object<u32> =
    mapped(0x1A01, 1, "TxPDO2 mapping - Position", 0x6004_0020);
/// Bytes 5 and 6.
pub const TPDO2_MAPPED_CORRECTION: Object<u32> =
    mapped(0x1A01, 2, "TxPDO2 mapping - Actual value correction", 0x2501_0410);
/// Bytes 7 and 8.
pub const TPDO2_MAPPED_STATUS: Object<u32> =
    mapped(0x1A01, 3, "TxPDO2 mapping - Status", 0x204E_0110);

/// 0 waits for the master, 8 goes to Operational by itself after a restart.
pub const NMT_STARTUP: Object<u32> =
    communication(0x1F80, 0, "NMT startup").within(0, 0).or_within(&[(8, 8)]);

// Settings of the application

/// General settings.
pub const GENERAL_SETTINGS: Object<u8> = highest(0x2000, "General settings", 8);
/// 0 up, 1 down: the side a target is reached from.
pub const POSITIONING_DIRECTION: Object<u32> = parameter(0x2000, 1, "Positioning direction", 0, 1);
/// 0: clockwise counts up; 1: down.
pub const COUNTING_DIRECTION: Object<u32> = parameter(0x2000, 2, "Counting direction", 0, 1);
/// 0 up, 1 down, 2 both, 3 off, 4 both with loop, 5 off with loop.
pub const ARROWS: Object<u32> = parameter(0x2000, 3, "Arrows", 0, 5);
/// 1: the display shows the setpoint while the actual value is in the window.
pub const ROUND_ACTUAL_VALUE: Object<u32> = parameter(0x2000, 4, "Round actual value", 0, 1);
/// 1: the picture is upside down.
pub const ROTATE_DISPLAY: Object<u32> = parameter(0x2000, 5, "Rotate display 180 degrees", 0, 1);
/// 1: the correction 0x2010 is in force.
pub const CORRECTION_ENABLED: Object<u32> =
    parameter(0x2000, 6, "Actual value correction off/on", 0, 1).default(1);
/// 0: the setpoint vanishes when reached; 1: never; 2: it is never shown.
pub const HIDE_SETPOINT: Object<u32> = parameter(0x2000, 7, "Hide setpoint", 0, 2);
/// 0 as the keys, 1 slow, 2 middle, 3 fast.
pub const EXTERNAL_INPUTS: Object<u32> = parameter(0x2000, 8, "External inputs", 0, 3);

/// Display only: 0 mm, 1 inch.
pub const LENGTH_UNIT: Object<u32> = parameter(0x2001, 0, "Length unit mm/inch", 0, 1);
/// 0: no loop.
pub const LOOP_LENGTH: Object<u32> =
    parameter(0x2002, 0, "Loop length for backlash compensation", 0, 9_999)
        .default(100)
        .unit(Unit::HundredthMm);
/// Setpoint ± this value.
pub const TOLERANCE_WINDOW: Object<u32> =
    parameter(0x2003, 0, "Tolerance window", 0, 9_999).default(5).unit(Unit::HundredthMm);
/// Pitch in 1/100 mm over steps per turn, times ten million.
pub const SCALING: Object<u32> = parameter(0x2004, 0, "Scaling (spindle pitch)", 0, 99_999_999)
    .default(1_736_111)
    .unit(Unit::ScalingFactor);

/// Special parameters.
pub const SPECIAL_PARAMETERS: Object<u8> = highest(0x2005, "Special parameters", 3);
/// Largest plausible jump of the sensor.
pub const FILTER_WIDTH: Object<u32> =
    parameter(0x2005, 1, "Filter width", 0, 2_303).default(100).unit(Unit::SensorStep);
/// Jumps discarded in a row.
pub const FILTER_COUNT: Object<u32> = parameter(0x2005, 2, "Filter count", 0, 99).default(5);
/// 1: the last digit of both lines is blank.
pub const HIDE_LAST_DIGIT: Object<u32> = parameter(0x2005, 3, "Hide rightmost LCD digit", 0, 1);

/// Device data of the application controller.
pub const MSP_DATA: Object<u8> = highest(0x2006, "MSP controller device data", 2);
/// In hundredths: 105 is V1.05.
pub const MSP_FIRMWARE_VERSION: Object<u32> =
    number(0x2006, 1, "MSP firmware version").default(FIRMWARE as i64);

/// Text for the lower line, exactly 12 characters.
pub const DISPLAY_MESSAGE: Object<[u8; 12]> =
    Object::new(0x2007, 0, "Display message").read_write().default_text("1234567890AB");
/// 1: the lower line shows the node-ID.
pub const SHOW_NODE_ID: Object<u32> =
    number(0x2008, 0, "Show node-ID on display").write_only().within(0, 1);
/// Tool offset, in force while 0x2000:06 is 1.
pub const CORRECTION: Object<i32> =
    parameter(0x2010, 0, "Actual value correction (offset)", LENGTH_MIN, LENGTH_MAX)
        .unit(Unit::HundredthMm);
/// 1 parameters, 2 multiturn counter, 3 parameters and offsets, 4 correction, 5 restart, 6 preset.
pub const RESET_FUNCTION: Object<u32> =
    number(0x2015, 0, "SPA reset function").write_only().within(1, 6);

/// Setpoints.
pub const SETPOINT: Object<u8> = highest(0x2020, "Setpoint (target position)", 8);
/// The setpoint that is in force after power-up.
pub const STANDARD_SETPOINT: Object<i32> =
    parameter(0x2020, 1, "Standard setpoint (S)", LENGTH_MIN, LENGTH_MAX)
        .default(1_000)
        .unit(Unit::HundredthMm);

/// As [`STANDARD_SETPOINT`], and the move starts at once.
pub const START_STANDARD_SETPOINT: Object<i32> =
    parameter(0x2020, 2, "Standard setpoint with motor release (SF)", LENGTH_MIN, LENGTH_MAX)
        .default(1_000)
        .unit(Unit::HundredthMm);
/// Equals [`STANDARD_SETPOINT`] after power-up.
pub const DIMENSION_SETPOINT: Object<i32> = number(0x2020, 3, "Dimension setpoint (SD)")
    .read_write()
    .within(LENGTH_MIN, LENGTH_MAX)
    .unit(Unit::HundredthMm);
/// As [`DIMENSION_SETPOINT`], and the move starts at once.
pub const START_DIMENSION_SETPOINT: Object<i32> =
    number(0x2020, 4, "Dimension setpoint with motor release (SDF)")
        .read_write()
        .within(LENGTH_MIN, LENGTH_MAX)
        .unit(Unit::HundredthMm);
/// The move starts at once and never makes a loop.
pub const START_DIRECT_SETPOINT: Object<i32> =
    number(0x2020, 5, "Direct setpoint, no loop, with motor release (SEF)")
        .read_write()
        .within(LENGTH_MIN, LENGTH_MAX)
        .unit(Unit::HundredthMm);
/// Approached at [`SAW_IN_SPEED`].
pub const SAW_IN_SETPOINT: Object<i32> = number(0x2020, 6, "Saw-in setpoint (SL)")
    .read_write()
    .within(LENGTH_MIN, LENGTH_MAX)
    .unit(Unit::HundredthMm);
/// As [`SAW_IN_SETPOINT`], and the move starts at once.
pub const START_SAW_IN_SETPOINT: Object<i32> =
    number(0x2020, 7, "Saw-in setpoint with motor release (SLF)")
        .read_write()
        .within(LENGTH_MIN, LENGTH_MAX)
        .unit(Unit::HundredthMm);
/// 0 slow, 1 middle, 2 fast.
pub const SAW_IN_SPEED: Object<u32> = parameter(0x2020, 8, "Saw-in speed", 0, 2);

/// Basic settings of the motor.
pub const MOTOR_SETTINGS: Object<u8> =
    highest(0x2040, "Motor basic settings - highest sub-index", 4);
/// 0: the left key counts down; 1: swapped.
pub const KEY_ASSIGNMENT: Object<u32> = parameter(0x2040, 1, "Key assignment", 0, 1);
/// 1 swaps the outputs for left and right.
pub const MOTOR_DIRECTION: Object<u32> = parameter(0x2040, 2, "Motor rotation direction", 0, 1);
/// 0 up, 1 down, 2 both, 3 off.
pub const JOG_ENABLE: Object<u32> = parameter(0x2040, 3, "Jog enable (micro step)", 0, 3);
/// Value n is group n + 1.
pub const GROUP: Object<u32> = parameter(0x2040, 4, "Group setting", 0, 7);

/// Extended settings of the motor.
pub const MOTOR_EXTENDED_SETTINGS: Object<u8> =
    highest(0x2041, "Motor extended settings - highest sub-index", 4);
/// 0: collisions are watched; 1: they are not.
pub const COLLISION_OFF: Object<u32> = parameter(0x2041, 1, "Collision on/off", 0, 1);
/// 1: the switch-off point follows the run-out.
pub const DYNAMIC_PRE_CUTOFF: Object<u32> = parameter(0x2041, 2, "Dynamic pre-cutoff", 0, 1);
/// 0 standard and oscillation, 1 clocked, 2 external positioning, 3 off.
pub const INPUT_MODE: Object<u32> = parameter(0x2041, 3, "Input mode", 0, 3);
/// 0 standard, 1 slow, 2 middle, 3 fast.
pub const KEY_MODE: Object<u32> = parameter(0x2041, 4, "Key mode", 0, 3);

/// Where the speed changes before the target.
pub const SPEED_POINTS: Object<u8> =
    highest(0x2042, "Speed switching points - highest sub-index", 3);
/// Not in force when it is not above [`CREEP_POINT`].
pub const SLOW_POINT: Object<u32> =
    parameter(0x2042, 1, "Slow-speed point", 0, 9_999).unit(Unit::HundredthMm);
/// Before the target.
pub const CREEP_POINT: Object<u32> =
    parameter(0x2042, 2, "Creep-speed point", 0, 9_999).default(150).unit(Unit::HundredthMm);
/// Negative: past the target.
pub const SWITCH_OFF_POINT: Object<i32> =
    parameter(0x2042, 3, "Switch-off point", -9_999, 9_999).unit(Unit::HundredthMm);

/// Span in which the motor moves.
pub const END_POSITIONS: Object<u8> = highest(0x2043, "End positions - highest sub-index", 2);
/// Lower end.
pub const END_POSITION_MIN: Object<i32> =
    parameter(0x2043, 1, "End position MIN", LENGTH_MIN, LENGTH_MAX - 1)
        .default(LENGTH_MIN)
        .unit(Unit::HundredthMm);
/// Upper end.
pub const END_POSITION_MAX: Object<i32> =
    parameter(0x2043, 2, "End position MAX", LENGTH_MIN + 1, LENGTH_MAX)
        .default(LENGTH_MAX)
        .unit(Unit::HundredthMm);

/// Span in which collisions are watched.
pub const COLLISION_LIMITS: Object<u8> = highest(0x2044, "Collision limits - highest sub-index", 2);
/// Lower end.
pub const COLLISION_LIMIT_MIN: Object<i32> =
    parameter(0x2044, 1, "Collision MIN", LENGTH_MIN, LENGTH_MAX - 1)
        .default(LENGTH_MIN)
        .unit(Unit::HundredthMm);
/// Upper end.
pub const COLLISION_LIMIT_MAX: Object<i32> =
    parameter(0x2044, 2, "Collision MAX", LENGTH_MIN + 1, LENGTH_MAX)
        .default(LENGTH_MAX)
        .unit(Unit::HundredthMm);

/// Setpoints of the inputs.
pub const SPECIAL_SETPOINTS: Object<u8> =
    highest(0x2045, "Special setpoints D1/D2/D3 - highest sub-index", 3);
/// Lower turning point of the oscillation, or clocked target of input F.
pub const SETPOINT_D1: Object<i32> = number(0x2045, 1, "Setpoint D1")
    .read_write()
    .within(LENGTH_MIN, LENGTH_MAX)
    .default(LENGTH_MIN)
    .unit(Unit::HundredthMm);
/// Upper turning point of the oscillation, or clocked target of input G.
pub const SETPOINT_D2: Object<i32> = number(0x2045, 2, "Setpoint D2")
    .read_write()
    .within(LENGTH_MIN, LENGTH_MAX)
    .default(LENGTH_MAX)
    .unit(Unit::HundredthMm);
/// Target of the external positioning; locked after power-up until it is written.
pub const SETPOINT_D3: Object<i32> = number(0x2045, 3, "Setpoint D3")
    .read_write()
    .within(LENGTH_MIN, LENGTH_MAX)
    .unit(Unit::HundredthMm);

/// 0 is a step of 50.
pub const JOG_STEP: Object<u32> =
    parameter(0x2046, 0, "Jog step width", 0, 9_999).default(1).unit(Unit::HundredthMm);

/// Times of the motor.
pub const MOTOR_TIMES: Object<u8> = highest(0x2047, "Motor system times - highest sub-index", 3);
/// Rest at the turn of a loop.
pub const LOOP_DWELL_TIME: Object<u32> =
    parameter(0x2047, 1, "Loop dwell time", 1, 999).default(10).unit(Unit::TenthSecond);
/// Rest of the shaft under power that is an error.
pub const LAG_TIME: Object<u32> =
    parameter(0x2047, 2, "Lag error time", 1, 999).default(30).unit(Unit::TenthSecond);
/// 0 off, 1 to 799 clamp, from 800 holding torque.
pub const CLAMPING: Object<u32> = parameter(0x2047, 3, "Clamping", 0, 999).unit(Unit::TenthSecond);

/// Reads 0 without clamp, 1 open, 2 closed; writes 0 open, 1 close.
pub const CLAMP: Object<u8> = number(0x2048, 0, "Clamp open/close").read_write().within(0, 1);

/// Commands to the motor.
pub const DRIVE_COMMAND: Object<u8> = highest(0x204D, "Drive command - highest sub-index", 3);
/// 0 stop, 1 to 8 start of this group.
pub const POSITIONING_COMMAND: Object<u8> =
    number(0x204D, 1, "Positioning start/stop").read_write().within(0, 8);
/// 0 end, 1 start.
pub const OSCILLATION_COMMAND: Object<u8> =
    number(0x204D, 2, "Oscillation start/stop").read_write().within(0, 1);
/// 11 to 13 right, 21 to 23 left: slow, middle, fast. Reads 0 at rest.
pub const JOG_COMMAND: Object<u8> =
    number(0x204D, 3, "Jog run start").read_write().within(11, 13).or_within(&[(21, 23)]);

/// Status and errors of the application.
pub const STATUS_AND_ERRORS: Object<u8> = highest(0x204E, "SPA status and errors", 2);
/// Bits: NM17x STAT-01.
pub const STATUS: Object<u16> = number(0x204E, 1, "SPA status").mappable(Transmit);
/// Bits: NM17x ERR-01.
pub const ERRORS: Object<u16> = number(0x204E, 2, "SPA errors").mappable(Transmit);

/// The external sensor of the NM174.
pub const SENSOR: Object<u8> = highest(0x2060, "Sensor parameters - highest sub-index", 3);
/// Length of a frame.
pub const SSI_WIDTH: Object<u32> =
    parameter(0x2060, 1, "SSI data width", 12, 32).default(25).unit(Unit::Bit);
/// 0 binary, 1 Gray.
pub const SSI_CODE: Object<u32> = parameter(0x2060, 2, "SSI code", 0, 1).default(1);
/// 0 rotary, 1 linear, 2 angle left-aligned, 3 Dunker AEM65, 4 Turck Li200, 9 angle right-aligned.
pub const SENSOR_TYPE: Object<u32> = parameter(0x2060, 3, "Sensor type", 0, 4).or_within(&[(9, 9)]);

/// 0 to 8: 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s. In force after a restart.
pub const BIT_RATE: Object<u8> =
    parameter(0x2100, 0, "CAN baud rate", 0, 8).default(4).held_by_interface();
/// In force after a restart.
pub const NODE_ID: Object<u8> =
    parameter(0x2101, 0, "Node-ID", 1, 127).default(127).held_by_interface();

/// The last RxPDO1. Writing it has no effect.
pub const BROADCAST: Object<u8> = highest(0x2500, "PDO broadcast - highest sub-index", 4);
/// As received.
pub const BROADCAST_CONTROL: Object<u8> = number(0x2500, 1, "Broadcast control register")
    .read_write()
    .held_by_interface()
    .mappable(Receive);
/// As received.
pub const BROADCAST_OBJECT: Object<u16> =
    number(0x2500, 2, "Broadcast object number").read_write().held_by_interface().mappable(Receive);
/// As received.
pub const BROADCAST_SUB_INDEX: Object<u8> =
    number(0x2500, 3, "Broadcast sub-index").read_write().held_by_interface().mappable(Receive);
/// As received.
pub const BROADCAST_DATA: Object<u32> =
    number(0x2500, 4, "Broadcast data").read_write().held_by_interface().mappable(Receive);

/// The last RxPDO2, and what TxPDO2 returns of it.
pub const PDO_SETPOINT: Object<u8> = highest(0x2501, "PDO setpoint", 4);
/// Bytes 1 to 4 of RxPDO2.
pub const PDO_SETPOINT_SETPOINT: Object<u32> =
    number(0x2501, 1, "PDO setpoint - setpoint").read_write().held_by_interface().mappable(Receive);
/// Bytes 5 and 6 of RxPDO2.
pub const PDO_SETPOINT_CORRECTION: Object<u16> =
    number(0x2501, 2, "PDO setpoint - actual value correction (RxPDO2)")
        .read_write()
        .held_by_interface()
        .mappable(Receive);
/// Bytes 7 and 8 of RxPDO2.
pub const PDO_SETPOINT_CONTROL: Object<u16> = number(0x2501, 3, "PDO setpoint - control register")
    .read_write()
    .held_by_interface()
    .mappable(Receive);
/// The correction TxPDO2 carries.
pub const PDO_SETPOINT_CORRECTION_SENT: Object<u16> =
    number(0x2501, 4, "PDO setpoint - actual value correction (TxPDO2)")
        .read_write()
        .held_by_interface()
        .mappable(Transmit);

// Device profile (CiA 406)

/// The actual value becomes this; reads the last one written.
pub const PRESET: Object<i32> =
    parameter(0x6003, 0, "Preset", LENGTH_MIN, LENGTH_MAX).unit(Unit::HundredthMm);
/// Actual value without the correction.
pub const POSITION_VALUE: Object<i32> =
    number(0x6004, 0, "Position value (actual value)").mappable(Transmit).unit(Unit::HundredthMm);

/// Objects that read a state of the device, whatever was written to them last.
pub const COMMANDS: [ObjectId; 4] =
    [CLAMP.id(), POSITIONING_COMMAND.id(), OSCILLATION_COMMAND.id(), JOG_COMMAND.id()];

/// What only the two controllers say to each other: entries beside the object that they are about.
pub mod between_controllers {
    use object_dictionary::ObjectId;

    use super::{DISPLAY_MESSAGE, NODE_ID};

    /// The text of [`DISPLAY_MESSAGE`], four characters each, the first one in the lowest byte. The
    /// last part shows it.
    pub const MESSAGE_PARTS: [ObjectId; 3] =
        [beside_message(1), beside_message(2), beside_message(3)];
    /// Whatever is written ends the text.
    pub const MESSAGE_END: ObjectId = beside_message(4);
    /// The node-ID that is on offer in bits 7 to 0, or 0 for none; the number of the offer in bits
    /// 15 to 8, or 0 when it is not to be taken any more.
    pub const OFFER: ObjectId = ObjectId { index: NODE_ID.id().index, sub: 1 };

    const fn beside_message(sub: u8) -> ObjectId {
        ObjectId { index: DISPLAY_MESSAGE.id().index, sub }
    }
}

/// Lists the objects of a product: those of every type, and its own, which lie between the setpoint
/// and the bit rate.
macro_rules! product {
    ($($own:path),* $(,)?) => {
        object_dictionary::product! {
            pub
            DEVICE_TYPE, ERROR_REGISTER, STATUS_REGISTER,
            ERROR_COUNT, ERROR_1, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_6, ERROR_7, ERROR_8,
            SYNC_COB_ID, DEVICE_NAME, HARDWARE_VERSION, SOFTWARE_VERSION,
            STORE, STORE_ALL, STORE_COMMUNICATION, RESTORE, RESTORE_ALL, RESTORE_COMMUNICATION,
            EMERGENCY_COB_ID, CONSUMER_HEARTBEAT, CONSUMER_HEARTBEAT_TIME, PRODUCER_HEARTBEAT_TIME,
            IDENTITY, VENDOR_ID, PRODUCT_CODE, REVISION_NUMBER, SERIAL_NUMBER,
            ERROR_BEHAVIOUR, ERROR_BEHAVIOUR_COMMUNICATION, ERROR_BEHAVIOUR_MANUFACTURER,
            RPDO1, RPDO1_COB_ID, RPDO1_TRANSMISSION_TYPE, RPDO2, RPDO2_COB_ID, RPDO2_TRANSMISSION_TYPE,
            RPDO1_MAPPING, RPDO1_MAPPED_CONTROL, RPDO1_MAPPED_OBJECT, RPDO1_MAPPED_SUB_INDEX,
            RPDO1_MAPPED_DATA,
            RPDO2_MAPPING, RPDO2_MAPPED_SETPOINT, RPDO2_MAPPED_CORRECTION, RPDO2_MAPPED_CONTROL,
            TPDO1, TPDO1_COB_ID, TPDO1_TRANSMISSION_TYPE, TPDO1_INHIBIT_TIME, TPDO1_EVENT_TIMER,
            TPDO2, TPDO2_COB_ID, TPDO2_TRANSMISSION_TYPE, TPDO2_INHIBIT_TIME, TPDO2_EVENT_TIMER,
            TPDO1_MAPPING, TPDO1_MAPPED_POSITION, TPDO1_MAPPED_STATUS, TPDO1_MAPPED_ERRORS,
            TPDO2_MAPPING, TPDO2_MAPPED_POSITION, TPDO2_MAPPED_CORRECTION, TPDO2_MAPPED_STATUS,
            NMT_STARTUP,
            GENERAL_SETTINGS, POSITIONING_DIRECTION, COUNTING_DIRECTION, ARROWS, ROUND_ACTUAL_VALUE,
            ROTATE_DISPLAY, CORRECTION_ENABLED, HIDE_SETPOINT, EXTERNAL_INPUTS,
            LENGTH_UNIT, LOOP_LENGTH, TOLERANCE_WINDOW, SCALING,
            SPECIAL_PARAMETERS, FILTER_WIDTH, FILTER_COUNT, HIDE_LAST_DIGIT,
            MSP_DATA, MSP_FIRMWARE_VERSION, DEVICE_TYPE_MSP,
            DISPLAY_MESSAGE, SHOW_NODE_ID, CORRECTION, RESET_FUNCTION,
            SETPOINT, STANDARD_SETPOINT,
            $($own,)*
            BIT_RATE, NODE_ID,
            BROADCAST, BROADCAST_CONTROL, BROADCAST_OBJECT, BROADCAST_SUB_INDEX, BROADCAST_DATA,
            PDO_SETPOINT, PDO_SETPOINT_SETPOINT, PDO_SETPOINT_CORRECTION, PDO_SETPOINT_CONTROL,
            PDO_SETPOINT_CORRECTION_SENT,
            PRESET, POSITION_VALUE
        }
    };
}
pub(crate) use product;

/// Lists the objects of a product with a motor, and those it has besides.
macro_rules! product_with_motor {
    ($($own:path),* $(,)?) => {
        $crate::nm17x::product! {
            START_STANDARD_SETPOINT, DIMENSION_SETPOINT, START_DIMENSION_SETPOINT, START_DIRECT_SETPOINT,
            SAW_IN_SETPOINT, START_SAW_IN_SETPOINT, SAW_IN_SPEED,
            MOTOR_SETTINGS, KEY_ASSIGNMENT, MOTOR_DIRECTION, JOG_ENABLE, GROUP,
            MOTOR_EXTENDED_SETTINGS, COLLISION_OFF, DYNAMIC_PRE_CUTOFF, INPUT_MODE, KEY_MODE,
            SPEED_POINTS, SLOW_POINT, CREEP_POINT, SWITCH_OFF_POINT,
            END_POSITIONS, END_POSITION_MIN, END_POSITION_MAX,
            COLLISION_LIMITS, COLLISION_LIMIT_MIN, COLLISION_LIMIT_MAX,
            SPECIAL_SETPOINTS, SETPOINT_D1, SETPOINT_D2, SETPOINT_D3, JOG_STEP,
            MOTOR_TIMES, LOOP_DWELL_TIME, LAG_TIME, CLAMPING, CLAMP,
            DRIVE_COMMAND, POSITIONING_COMMAND, OSCILLATION_COMMAND, JOG_COMMAND,
            STATUS_AND_ERRORS, STATUS, ERRORS,
            $($own),*
        }
    };
}
pub(crate) use product_with_motor;
