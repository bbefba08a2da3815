//! The objects that NM170, NM172 and NM174 have in common (manual, chapter 4.4).

use object_dictionary::PdoMapping::Transmit;
use object_dictionary::{Object, Unit};

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

const fn number<T: object_dictionary::Value>(index: u16, sub: u8, name: &'static str) -> Object<T> {
    Object::new(index, sub, name)
}

const fn highest(index: u16, name: &'static str, sub: u8) -> Object<u8> {
    Object::highest_sub_index(index, name, sub)
}

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

const fn mapped(index: u16, sub: u8, name: &'static str, entry: i64) -> Object<u32> {
    number(index, sub, name).within(entry, entry).default(entry)
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

/// Tool offset, in force while 0x2000:06 is 1.
pub const CORRECTION: Object<i32> =
    parameter(0x2010, 0, "Actual value correction (offset)", LENGTH_MIN, LENGTH_MAX)
        .unit(Unit::HundredthMm);
/// 1 parameters, 2 multiturn counter, 3 parameters and offsets, 4 correction, 5 restart, 6 preset.
pub const RESET_FUNCTION: Object<u32> =
    number(0x2015, 0, "SPA reset function").write_only().within(1, 6);

/// Setpoints.
pub const SETPOINT: Object<u8> = highest(0x2020, "Setpoint (target position)", 1);
/// The setpoint that is in force after power-up.
pub const STANDARD_SETPOINT: Object<i32> =
    parameter(0x2020, 1, "Standard setpoint (S)", LENGTH_MIN, LENGTH_MAX)
        .default(1_000)
        .unit(Unit::HundredthMm);

/// Status and errors of the application.
pub const STATUS_AND_ERRORS: Object<u8> = highest(0x204E, "SPA status and errors", 2);
/// Bits: NM17x STAT-01.
pub const STATUS: Object<u16> = number(0x204E, 1, "SPA status").mappable(Transmit);
/// Bits: NM17x ERR-01.
pub const ERRORS: Object<u16> = number(0x204E, 2, "SPA errors").mappable(Transmit);

/// 0 to 8: 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s. In force after a restart.
pub const BIT_RATE: Object<u8> =
    parameter(0x2100, 0, "CAN baud rate", 0, 8).default(4).held_by_interface();
/// In force after a restart.
pub const NODE_ID: Object<u8> =
    parameter(0x2101, 0, "Node-ID", 1, 127).default(127).held_by_interface();

/// The last RxPDO2, and what TxPDO2 returns of it.
pub const PDO_SETPOINT: Object<u8> = highest(0x2501, "PDO setpoint", 4);
/// Bytes 1 to 4 of RxPDO2.
pub const PDO_SETPOINT_SETPOINT: Object<u32> =
    number(0x2501, 1, "PDO setpoint - setpoint").read_write().held_by_interface();
/// Bytes 5 and 6 of RxPDO2.
pub const PDO_SETPOINT_CORRECTION: Object<u16> =
    number(0x2501, 2, "PDO setpoint - actual value correction (RxPDO2)")
        .read_write()
        .held_by_interface();
/// Bytes 7 and 8 of RxPDO2.
pub const PDO_SETPOINT_CONTROL: Object<u16> =
    number(0x2501, 3, "PDO setpoint - control register").read_write().held_by_interface();
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
