//! AP04: position display without motor, its turn counter kept by a battery.

use object_dictionary::PdoMapping::{Receive, Transmit};
use object_dictionary::{Object, Unit, product};

use crate::cia301::{self, COB_IDS, PDO_COB_IDS, highest, mapped, number};
pub use crate::cia301::{
    ERROR_1, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_6, ERROR_7, ERROR_8, ERROR_COUNT,
};

/// Largest value of the byte that holds the LEDs.
const LEDS_MAX: i64 = 56;

/// Bit of that byte that has to be clear.
const LEDS_RESERVED: i64 = 1 << 2;

/// The picture turned upside down, in degrees.
const UPSIDE_DOWN: i64 = 180;

/// Each permitted value of the LEDs, upright and upside down.
const ORIENTATIONS_AND_LEDS: [(i64, i64); 58] = {
    let mut values = [(0, 0); 58];
    let mut left = values.as_mut_slice();
    let mut leds = 0;
    while let [upright, upside_down, rest @ ..] = left {
        let value = leds << 8;
        *upright = (value, value);
        *upside_down = (value | UPSIDE_DOWN, value | UPSIDE_DOWN);
        leds += 1;
        while leds & LEDS_RESERVED != 0 {
            leds += 1;
        }
        left = rest;
    }
    assert!(leds > LEDS_MAX, "a value is missing");
    values
};

// Communication (CiA 301)

/// Absolute encoder with a battery-backed turn counter, by profile 406.
pub const DEVICE_TYPE: Object<u32> = number(0x1000, 0, "Device type").default(0x0003_0196);
/// Bit 0 generic, 4 communication, 7 manufacturer specific.
pub const ERROR_REGISTER: Object<u8> = number(0x1001, 0, "Error register");
/// Receive error counter in byte 0, transmit error counter in byte 1.
pub const STATUS_REGISTER: Object<u32> = number(0x1002, 0, "Manufacturer status register");
/// CAN-ID of SYNC; bit 31 is ignored, bits 30 and 29 can not be set.
pub const SYNC_COB_ID: Object<u32> = number(0x1005, 0, "COB-ID SYNC")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .within(1, 0x7FF)
    .or_within(COB_IDS)
    .default(0x80);
/// Name of the device.
pub const DEVICE_NAME: Object<[u8; 4]> =
    number(0x1008, 0, "Manufacturer device name").default_text("AP04");
/// Version of the hardware.
pub const HARDWARE_VERSION: Object<[u8; 4]> =
    number(0x1009, 0, "Manufacturer hardware version").default_text("V100");
/// Version of the firmware.
pub const SOFTWARE_VERSION: Object<[u8; 4]> =
    number(0x100A, 0, "Manufacturer software version").default_text("H100");

/// Says how parameters are saved.
pub const STORE: Object<u8> = highest(0x1010, "Store parameters - highest sub-index", 1);
/// 2: saved without command, with every change.
pub const STORE_ALL: Object<u32> =
    number(0x1010, 1, "Store parameters - Save all parameters").default(2);

/// Signature that brings back the state at delivery.
pub const RESTORE: Object<u8> =
    highest(0x1011, "Restore default parameters - highest sub-index", 1);
/// All parameters but the bit rate and the zero value.
pub const RESTORE_ALL: Object<u32> = cia301::restore(1, "Restore default parameters - all");
/// CAN-ID of emergencies; bit 31 switches them off.
pub const EMERGENCY_COB_ID: Object<u32> = number(0x1014, 0, "COB-ID EMCY")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .within(1, 0x7FF)
    .or_within(COB_IDS)
    .default_node_id_plus(0x80);
/// Period of the heartbeat; 0 is off.
pub const PRODUCER_HEARTBEAT_TIME: Object<u16> = number(0x1017, 0, "Producer heartbeat time")
    .read_write()
    .stored_at_once()
    .within(10, 0xFFFF)
    .or_within(&[(0, 0)])
    .unit(Unit::Millisecond);

/// Identity object.
pub const IDENTITY: Object<u8> = highest(0x1018, "Identity object - highest sub-index", 2);
/// SIKO.
pub const VENDOR_ID: Object<u32> =
    number(0x1018, 1, "Identity - Vendor-ID").within(0x195, 0x195).default(0x195);
/// `CAN`, the variant with this bus.
pub const PRODUCT_CODE: Object<u32> = number(0x1018, 2, "Identity - Product code")
    .within(0x004E_4143, 0x004E_4143)
    .default(0x004E_4143);

/// CAN-IDs of the SDO server.
pub const SDO_SERVER: Object<u8> = highest(0x1200, "SDO server - highest sub-index", 2);
/// Requests.
pub const SDO_REQUEST_COB_ID: Object<u32> =
    number(0x1200, 1, "SDO server - COB-ID client to server").default_node_id_plus(0x600);
/// Answers.
pub const SDO_ANSWER_COB_ID: Object<u32> =
    number(0x1200, 2, "SDO server - COB-ID server to client").default_node_id_plus(0x580);

/// RxPDO1: target value and control byte.
pub const RPDO1: Object<u8> =
    highest(0x1400, "RxPDO1 communication parameter - highest sub-index", 2);
/// Bit 31 switches it off; bit 30 is always set.
pub const RPDO1_COB_ID: Object<u32> = number(0x1400, 1, "RxPDO1 COB-ID")
    .read_write()
    .stored_at_once()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x4000_0200);
/// Taken over when received.
pub const RPDO1_TRANSMISSION_TYPE: Object<u8> =
    number(0x1400, 2, "RxPDO1 transmission type").default(0xFF);

/// RxPDO2: target value and control byte.
pub const RPDO2: Object<u8> =
    highest(0x1401, "RxPDO2 communication parameter - highest sub-index", 2);
/// Bit 31 switches it off; bit 30 is always set.
pub const RPDO2_COB_ID: Object<u32> = number(0x1401, 1, "RxPDO2 COB-ID")
    .read_write()
    .stored_at_once()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x4000_0300);
/// Taken over when received.
pub const RPDO2_TRANSMISSION_TYPE: Object<u8> =
    number(0x1401, 2, "RxPDO2 transmission type").default(0xFF);

/// What RxPDO1 carries.
pub const RPDO1_MAPPING: Object<u8> = highest(0x1600, "RxPDO1 mapping - highest sub-index", 2);
/// Bytes 1 to 4.
pub const RPDO1_MAPPED_TARGET: Object<u32> =
    mapped(0x1600, 1, "RxPDO1 mapping - Target value", 0x5F16_0020);
/// Byte 5.
pub const RPDO1_MAPPED_CONTROL: Object<u32> =
    mapped(0x1600, 2, "RxPDO1 mapping - Control byte", 0x5F0C_0008);

/// What RxPDO2 carries.
pub const RPDO2_MAPPING: Object<u8> = highest(0x1601, "RxPDO2 mapping - highest sub-index", 2);
/// Bytes 1 to 4.
pub const RPDO2_MAPPED_TARGET: Object<u32> =
    mapped(0x1601, 1, "RxPDO2 mapping - Target value", 0x5F16_0020);
/// Byte 5.
pub const RPDO2_MAPPED_CONTROL: Object<u32> =
    mapped(0x1601, 2, "RxPDO2 mapping - Control byte", 0x5F0C_0008);

/// TxPDO1: by its event timer.
pub const TPDO1: Object<u8> =
    highest(0x1800, "TxPDO1 communication parameter - highest sub-index", 5);
/// Bit 31 switches it off; bit 30 is always set.
pub const TPDO1_COB_ID: Object<u32> = number(0x1800, 1, "TxPDO1 COB-ID")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x4000_0180);
/// Event timer.
pub const TPDO1_TRANSMISSION_TYPE: Object<u8> =
    number(0x1800, 2, "TxPDO1 transmission type").default(0xFE);
/// The variable of [`CYCLE_TIMER`]; 0 is off.
pub const TPDO1_EVENT_TIMER: Object<u16> = number(0x1800, 5, "TxPDO1 event timer")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .unit(Unit::Millisecond);

/// TxPDO2: by SYNC or on request.
pub const TPDO2: Object<u8> =
    highest(0x1801, "TxPDO2 communication parameter - highest sub-index", 5);
/// On at delivery; bit 30 stays clear, so that it may be requested.
pub const TPDO2_COB_ID: Object<u32> = number(0x1801, 1, "TxPDO2 COB-ID")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x280);
/// 1 to 240 with SYNC, 253 on request.
pub const TPDO2_TRANSMISSION_TYPE: Object<u8> = number(0x1801, 2, "TxPDO2 transmission type")
    .read_write()
    .stored_at_once()
    .written_in_pre_operational()
    .within(1, 240)
    .or_within(&[(253, 253)])
    .default(1);

/// What TxPDO1 carries.
pub const TPDO1_MAPPING: Object<u8> = highest(0x1A00, "TxPDO1 mapping - highest sub-index", 2);
/// Bytes 1 to 4.
pub const TPDO1_MAPPED_POSITION: Object<u32> =
    mapped(0x1A00, 1, "TxPDO1 mapping - Position value", 0x6004_0020);
/// Byte 5.
pub const TPDO1_MAPPED_STATUS: Object<u32> =
    mapped(0x1A00, 2, "TxPDO1 mapping - Status byte", 0x5F19_0008);

/// What TxPDO2 carries.
pub const TPDO2_MAPPING: Object<u8> = highest(0x1A01, "TxPDO2 mapping - highest sub-index", 2);
/// Bytes 1 to 4.
pub const TPDO2_MAPPED_POSITION: Object<u32> =
    mapped(0x1A01, 1, "TxPDO2 mapping - Position value", 0x6004_0020);
/// Byte 5.
pub const TPDO2_MAPPED_STATUS: Object<u32> =
    mapped(0x1A01, 2, "TxPDO2 mapping - Status byte", 0x5F19_0008);

// Settings of the device

/// Added to the position.
pub const OFFSET: Object<i32> = number(0x2001, 0, "Manufacturer offset")
    .read_write()
    .stored_at_once()
    .within(-5_242_879, 5_242_778);
/// 1 makes the measured value zero; reads 1 once that was done.
pub const ZERO_POSITION: Object<u8> =
    number(0x2002, 0, "Zero encoder value").read_write().within(0, 1);
/// 1: the key may make the value zero.
pub const ZERO_KEY: Object<u8> = number(0x2003, 0, "Enable zeroing by key")
    .read_write()
    .stored_at_once()
    .within(0, 1)
    .default(1);
/// 1: the key may switch to the chain dimension.
pub const CHAIN_KEY: Object<u8> = number(0x2004, 0, "Enable chain dimension by key")
    .read_write()
    .stored_at_once()
    .within(0, 1)
    .default(1);
/// Longest silence of the master; 0 is off.
pub const HEARTBEAT_TIMER: Object<u16> = number(0x5F09, 0, "External heartbeat timer")
    .read_write()
    .stored_at_once()
    .held_by_interface()
    .default(300)
    .unit(Unit::Millisecond);
/// In force after a restart.
pub const NODE_ID: Object<u8> = number(0x5F0A, 0, "Node-ID")
    .read_write()
    .stored_at_once()
    .held_by_interface()
    .within(1, 127)
    .default(1);
/// 1: the display does not show the target value.
pub const HIDE_TARGET: Object<u8> =
    number(0x5F0B, 0, "Hide target value").read_write().stored_at_once().within(0, 1);
/// Bit 0 target valid, 1 blinking, 4 green, 5 red.
pub const CONTROL_BYTE: Object<u8> = number(0x5F0C, 0, "Control byte")
    .write_only()
    .not_written_with_sdo()
    .held_by_interface()
    .mappable(Receive);
/// Largest deviation from the target that is in position.
pub const TARGET_WINDOW: Object<u32> =
    number(0x5F10, 0, "Target window").read_write().stored_at_once().default(5);
/// Digits after the point on the display.
pub const DECIMAL_PLACES: Object<u8> =
    number(0x5F11, 0, "Decimal places").read_write().stored_at_once().within(0, 4);
/// Byte 0: 0 or 180 degrees; byte 1: the LEDs.
pub const ORIENTATION_AND_LEDS: Object<u32> = number(0x5F12, 0, "Display orientation and LED")
    .read_write()
    .stored_at_once()
    .within(0, 0)
    .or_within(ORIENTATIONS_AND_LEDS.split_at(1).1);
/// Power of ten the display divides by.
pub const DISPLAY_DIVISOR: Object<u8> =
    number(0x5F13, 0, "Display divisor").read_write().stored_at_once().within(0, 3);
/// 0: no loop.
pub const LOOP_WIDTH: Object<u32> = number(0x5F14, 0, "Loop width").read_write().stored_at_once();
/// 0 or `DIR` direct, `+`, `-`.
pub const LOOP_DIRECTION: Object<u32> = number(0x5F15, 0, "Loop direction")
    .read_write()
    .stored_at_once()
    .within(0, 0)
    .or_within(&[(0x2B, 0x2B), (0x2D, 0x2D), (0x0052_4944, 0x0052_4944)])
    .default(0x0052_4944);
/// Where to position.
pub const TARGET_VALUE: Object<i32> = number(0x5F16, 0, "Target value")
    .read_write()
    .not_written_with_sdo()
    .held_by_interface()
    .mappable(Receive);
/// What keeps [`HEARTBEAT_TIMER`] from ending: 0 a receive PDO, 1 SYNC.
pub const HEARTBEAT_SOURCE: Object<u8> = number(0x5F18, 0, "External heartbeat source")
    .read_write()
    .stored_at_once()
    .held_by_interface()
    .within(0, 1)
    .default(1);
/// Bits: AP04.
pub const STATUS_BYTE: Object<u8> =
    number(0x5F19, 0, "AP04 status byte").not_written_with_sdo().within(0, 0x7F).mappable(Transmit);
/// Turn back that is not yet a reversal.
pub const HYSTERESIS: Object<u32> =
    number(0x5F1A, 0, "Hysteresis for reversal detection").read_write().stored_at_once();

// Device profile (CiA 406)

/// Bit 0 counting direction, bit 2 scaling on; others are ignored.
pub const OPERATING_PARAMETERS: Object<u16> =
    number(0x6000, 0, "Operating parameters").read_write().stored_at_once();
/// Written only while the scaling is on.
pub const UNITS_PER_TURN: Object<u32> = number(0x6001, 0, "Measuring units per revolution")
    .read_write()
    .stored_at_once()
    .within(1, 0xFFFF_FFFF)
    .default(720);
/// 7281 times [`UNITS_PER_TURN`].
pub const MEASURING_RANGE: Object<u32> =
    number(0x6002, 0, "Total measuring range").within(7281, 0xFFFF_FFFF).default(5_242_320);
/// Part of the position at once.
pub const PRESET: Object<i32> = number(0x6003, 0, "Preset value").read_write().stored_at_once();
/// Actual value in measuring units.
pub const POSITION_VALUE: Object<i32> = number(0x6004, 0, "Position value").mappable(Transmit);
/// Period of TxPDO1; 0 is off.
pub const CYCLE_TIMER: Object<u16> = number(0x6200, 0, "Cyclic timer")
    .read_write()
    .stored_at_once()
    .held_by_interface()
    .unit(Unit::Millisecond);
/// [`OPERATING_PARAMETERS`] as they are in force.
pub const OPERATING_STATUS: Object<u16> = number(0x6500, 0, "Operating status");
/// Steps of the sensor in a turn.
pub const SINGLETURN_RESOLUTION: Object<u32> =
    number(0x6501, 0, "Single-turn resolution").default(720);
/// Turns the counter tells apart.
pub const TURNS: Object<u16> =
    number(0x6502, 0, "Number of distinguishable revolutions").default(7281);
/// Bit 0 position invalid, 12 battery low, 13 battery empty.
pub const ALARMS: Object<u16> = number(0x6503, 0, "Alarms");
/// Bits that [`ALARMS`] may have.
pub const SUPPORTED_ALARMS: Object<u16> = number(0x6504, 0, "Supported alarms").default(0x3001);
/// Bit 4 battery near its lower limit.
pub const WARNINGS: Object<u16> = number(0x6505, 0, "Warnings");
/// Bits that [`WARNINGS`] may have.
pub const SUPPORTED_WARNINGS: Object<u16> = number(0x6506, 0, "Supported warnings").default(0x0010);
/// Profile 3.01.
pub const PROFILE_AND_SOFTWARE_VERSION: Object<u32> =
    number(0x6507, 0, "Profile and software version").default(0x0065_0301);
/// Not counted.
pub const OPERATING_TIME: Object<u32> = number(0x6508, 0, "Operating time").default(0xFFFF_FFFF);
/// Follows from preset and offset.
pub const ZERO_VALUE: Object<i32> = number(0x6509, 0, "Encoder zero value").stored_at_once();

/// Offset and span of the position.
pub const MODULE_IDENTIFICATION: Object<u8> =
    highest(0x650A, "Module identification - highest sub-index", 3);
/// [`OFFSET`] again.
pub const MODULE_OFFSET: Object<i32> =
    number(0x650A, 1, "Module identification - Manufacturer offset");
/// Lower end of the position.
pub const POSITION_MIN: Object<i32> =
    number(0x650A, 2, "Module identification - Minimum position value").default(-5_242_880);
/// Upper end of the position.
pub const POSITION_MAX: Object<i32> =
    number(0x650A, 3, "Module identification - Maximum position value").default(5_242_880);
/// None.
pub const MODULE_SERIAL_NUMBER: Object<u32> =
    number(0x650B, 0, "Serial number").default(0xFFFF_FFFF);

product! {
    pub
    DEVICE_TYPE, ERROR_REGISTER, STATUS_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, ERROR_3, ERROR_4,
    ERROR_5, ERROR_6, ERROR_7, ERROR_8, SYNC_COB_ID, DEVICE_NAME, HARDWARE_VERSION,
    SOFTWARE_VERSION, STORE, STORE_ALL, RESTORE, RESTORE_ALL, EMERGENCY_COB_ID,
    PRODUCER_HEARTBEAT_TIME, IDENTITY, VENDOR_ID, PRODUCT_CODE, SDO_SERVER, SDO_REQUEST_COB_ID,
    SDO_ANSWER_COB_ID, RPDO1, RPDO1_COB_ID, RPDO1_TRANSMISSION_TYPE, RPDO2, RPDO2_COB_ID,
    RPDO2_TRANSMISSION_TYPE, RPDO1_MAPPING, RPDO1_MAPPED_TARGET, RPDO1_MAPPED_CONTROL,
    RPDO2_MAPPING, RPDO2_MAPPED_TARGET, RPDO2_MAPPED_CONTROL, TPDO1, TPDO1_COB_ID,
    TPDO1_TRANSMISSION_TYPE, TPDO1_EVENT_TIMER, TPDO2, TPDO2_COB_ID, TPDO2_TRANSMISSION_TYPE,
    TPDO1_MAPPING, TPDO1_MAPPED_POSITION, TPDO1_MAPPED_STATUS, TPDO2_MAPPING, TPDO2_MAPPED_POSITION,
    TPDO2_MAPPED_STATUS, OFFSET, ZERO_POSITION, ZERO_KEY, CHAIN_KEY, HEARTBEAT_TIMER, NODE_ID,
    HIDE_TARGET, CONTROL_BYTE, TARGET_WINDOW, DECIMAL_PLACES, ORIENTATION_AND_LEDS, DISPLAY_DIVISOR,
    LOOP_WIDTH, LOOP_DIRECTION, TARGET_VALUE, HEARTBEAT_SOURCE, STATUS_BYTE, HYSTERESIS,
    OPERATING_PARAMETERS, UNITS_PER_TURN, MEASURING_RANGE, PRESET, POSITION_VALUE, CYCLE_TIMER,
    OPERATING_STATUS, SINGLETURN_RESOLUTION, TURNS, ALARMS, SUPPORTED_ALARMS, WARNINGS,
    SUPPORTED_WARNINGS, PROFILE_AND_SOFTWARE_VERSION, OPERATING_TIME, ZERO_VALUE,
    MODULE_IDENTIFICATION, MODULE_OFFSET, POSITION_MIN, POSITION_MAX, MODULE_SERIAL_NUMBER
}
