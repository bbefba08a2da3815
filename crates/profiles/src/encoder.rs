//! The absolute encoders: one set of objects, and modules for what sets the variants apart.

use object_dictionary::PdoMapping::Transmit;
use object_dictionary::{Object, Unit, product};

use crate::cia301::{self, COB_IDS, PDO_COB_IDS, highest, mapped, number};
pub use crate::cia301::{
    ERROR_1, ERROR_2, ERROR_3, ERROR_4, ERROR_5, ERROR_6, ERROR_7, ERROR_8, ERROR_COUNT,
};

/// Object 0x1000: profile 406, one turn.
const SINGLETURN: i64 = 0x0001_0196;

/// Object 0x1000: profile 406, many turns.
const MULTITURN: i64 = 0x0002_0196;

/// Four letters as the number whose bytes they are on the bus.
const fn letters(letters: [u8; 4]) -> i64 {
    u32::from_le_bytes(letters) as i64
}

// Communication (CiA 301)

/// Bit 0 generic, 4 communication, 7 manufacturer specific (B-27).
pub const ERROR_REGISTER: Object<u8> = number(0x1001, 0, "Error register");
/// CAN-ID of SYNC; bit 31 is ignored, bits 30 and 29 can not be set (B-64).
pub const SYNC_COB_ID: Object<u32> = number(0x1005, 0, "COB-ID SYNC")
    .read_write()
    .stored_on_command()
    .within(1, 0x7FF)
    .or_within(COB_IDS)
    .default(0x80);
/// `1.00`.
pub const HARDWARE_VERSION: Object<u32> =
    number(0x1009, 0, "Manufacturer hardware version").default(letters(*b"1.00"));
/// `1.09` (B-54).
pub const SOFTWARE_VERSION: Object<u32> =
    number(0x100A, 0, "Manufacturer software version").default(letters(*b"1.09"));
/// Period of node guarding.
pub const GUARD_TIME: Object<u16> =
    number(0x100C, 0, "Guard time").read_write().stored_on_command().unit(Unit::Millisecond);
/// Guard times without a request until the master counts as lost (B-06).
pub const LIFE_TIME_FACTOR: Object<u8> =
    number(0x100D, 0, "Life time factor").read_write().stored_on_command();

/// Signatures that save parameters.
pub const STORE: Object<u8> = highest(0x1010, "Store parameters - highest sub-index", 4);
/// All of them.
pub const STORE_ALL: Object<u32> = cia301::store(1, "Store parameters - all");
/// 0x1000 to 0x1FFF (B-56).
pub const STORE_COMMUNICATION: Object<u32> = cia301::store(2, "Store parameters - communication");
/// 0x6000 to 0x9FFF (B-56).
pub const STORE_APPLICATION: Object<u32> = cia301::store(3, "Store parameters - application");
/// 0x2000 to 0x5FFF (B-56).
pub const STORE_MANUFACTURER: Object<u32> =
    cia301::store(4, "Store parameters - manufacturer specific");

/// Signatures that bring back the state at delivery.
pub const RESTORE: Object<u8> =
    highest(0x1011, "Restore default parameters - highest sub-index", 4);
/// All of them.
pub const RESTORE_ALL: Object<u32> = cia301::restore(1, "Restore default parameters - all");
/// 0x1000 to 0x1FFF (B-56).
pub const RESTORE_COMMUNICATION: Object<u32> =
    cia301::restore(2, "Restore default parameters - communication");
/// 0x6000 to 0x9FFF (B-56).
pub const RESTORE_APPLICATION: Object<u32> =
    cia301::restore(3, "Restore default parameters - application");
/// 0x2000 to 0x5FFF (B-56).
pub const RESTORE_MANUFACTURER: Object<u32> =
    cia301::restore(4, "Restore default parameters - manufacturer specific");
/// CAN-ID of emergencies; bit 31 switches them off.
pub const EMERGENCY_COB_ID: Object<u32> = number(0x1014, 0, "COB-ID EMCY")
    .read_write()
    .stored_on_command()
    .within(1, 0x7FF)
    .or_within(COB_IDS)
    .default_node_id_plus(0x80);

/// Producers that are watched.
pub const CONSUMER_HEARTBEAT: Object<u8> =
    highest(0x1016, "Consumer heartbeat time - highest sub-index", 1);
/// Node-ID in bits 23 to 16, time in ms in bits 15 to 0 (B-63).
pub const CONSUMER_HEARTBEAT_TIME: Object<u32> = number(0x1016, 1, "Consumer heartbeat time")
    .read_write()
    .stored_on_command()
    .within(0, 0x00FF_FFFF)
    .default(0x0001_0000);
/// Period of the heartbeat; 0 is off.
pub const PRODUCER_HEARTBEAT_TIME: Object<u16> = number(0x1017, 0, "Producer heartbeat time")
    .read_write()
    .stored_on_command()
    .unit(Unit::Millisecond);

/// Identity object.
pub const IDENTITY: Object<u8> = highest(0x1018, "Identity object - highest sub-index", 4);
/// Baumer.
pub const VENDOR_ID: Object<u32> =
    number(0x1018, 1, "Identity - Vendor-ID").within(0xEC, 0xEC).default(0xEC);
/// Version in the upper, running number in the lower word.
pub const REVISION_NUMBER: Object<u32> =
    number(0x1018, 3, "Identity - Revision number").default(0x0109_0001);
/// Differs from device to device.
pub const SERIAL_NUMBER: Object<u32> = number(0x1018, 4, "Identity - Serial number");

/// What follows from an error.
pub const ERROR_BEHAVIOUR: Object<u8> = highest(0x1029, "Error behaviour - highest sub-index", 1);
/// 0 to Pre-operational, 1 no change, 2 to Stopped, 3 restart (B-32).
pub const ERROR_BEHAVIOUR_COMMUNICATION: Object<u8> =
    number(0x1029, 1, "Error behaviour - Communication error")
        .read_write()
        .stored_on_command()
        .within(0, 3)
        .default(1);

/// TxPDO1: the position.
pub const TPDO1: Object<u8> =
    highest(0x1800, "TxPDO1 communication parameter - highest sub-index", 5);
/// Bit 31 switches it off; bit 30 has no effect (B-69).
pub const TPDO1_COB_ID: Object<u32> = number(0x1800, 1, "TxPDO1 COB-ID")
    .read_write()
    .stored_on_command()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x180);
/// 1 to 240 every n-th SYNC, 254 event timer (B-22).
pub const TPDO1_TRANSMISSION_TYPE: Object<u8> = number(0x1800, 2, "TxPDO1 transmission type")
    .read_write()
    .stored_on_command()
    .within(1, 240)
    .or_within(&[(254, 254)])
    .default(0xFE);
/// Period of type 254, the variable of [`CYCLE_TIMER`] (B-20); 0 is off.
pub const TPDO1_EVENT_TIMER: Object<u16> = number(0x1800, 5, "TxPDO1 event timer")
    .read_write()
    .stored_on_command()
    .default(0x0203)
    .unit(Unit::Millisecond);

/// TxPDO2: the position.
pub const TPDO2: Object<u8> =
    highest(0x1801, "TxPDO2 communication parameter - highest sub-index", 5);
/// Bit 31 switches it off; bit 30 has no effect (B-69).
pub const TPDO2_COB_ID: Object<u32> = number(0x1801, 1, "TxPDO2 COB-ID")
    .read_write()
    .stored_on_command()
    .within(1, 0x7FF)
    .or_within(PDO_COB_IDS)
    .default_node_id_plus(0x280);
/// 1 to 240 every n-th SYNC, 254 event timer (B-22).
pub const TPDO2_TRANSMISSION_TYPE: Object<u8> = number(0x1801, 2, "TxPDO2 transmission type")
    .read_write()
    .stored_on_command()
    .within(1, 240)
    .or_within(&[(254, 254)])
    .default(2);
/// Period of type 254, of its own (B-02); 0 is off.
pub const TPDO2_EVENT_TIMER: Object<u16> = number(0x1801, 5, "TxPDO2 event timer")
    .read_write()
    .stored_on_command()
    .default(0x0100)
    .unit(Unit::Millisecond);

/// What TxPDO1 carries.
pub const TPDO1_MAPPING: Object<u8> = highest(0x1A00, "TxPDO1 mapping - highest sub-index", 1);
/// Bytes 1 to 4 (B-04).
pub const TPDO1_MAPPED_POSITION: Object<u32> =
    mapped(0x1A00, 1, "TxPDO1 mapping - Position value", 0x6004_0020);

/// What TxPDO2 carries.
pub const TPDO2_MAPPING: Object<u8> = highest(0x1A01, "TxPDO2 mapping - highest sub-index", 1);
/// Bytes 1 to 4 (B-04).
pub const TPDO2_MAPPED_POSITION: Object<u32> =
    mapped(0x1A01, 1, "TxPDO2 mapping - Position value", 0x6004_0020);

// Settings of the device

/// 0 to 8: 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s. In force when
/// the switches are 0 (B-70).
pub const BIT_RATE: Object<u8> = number(0x2100, 0, "CAN baud rate")
    .read_write()
    .stored_on_command()
    .held_by_interface()
    .within(0, 8)
    .default(2);
/// In force when the switches are 0 (B-41, B-70).
pub const NODE_ID: Object<u8> = number(0x2101, 0, "Node-ID")
    .read_write()
    .stored_on_command()
    .held_by_interface()
    .within(1, 127)
    .default(1);
/// Bits: encoder EN-OPT-01; others are ignored (B-71).
pub const OPTIONS: Object<u32> = number(0x2110, 0, "Manufacturer options")
    .read_write()
    .stored_on_command()
    .default(8)
    .not_in_eds();

/// Counters of the device's life (B-52).
pub const STATISTICS: Object<u8> = highest(0x2201, "Statistics - highest sub-index", 3);
/// Errors of the sensor.
pub const POSITION_ERRORS: Object<u32> =
    number(0x2201, 1, "Statistics - Number of position errors").stored_on_command();
/// Since the device was made.
pub const TOTAL_OPERATING_TIME: Object<u32> =
    number(0x2201, 2, "Statistics - Total operating time").stored_on_command().unit(Unit::Second);
/// Restarts by the watchdog.
pub const WATCHDOG_RESETS: Object<u32> =
    number(0x2201, 3, "Statistics - Number of watchdog timer resets").stored_on_command();

/// Memory for the customer (B-03).
pub const CUSTOMER_DATA: Object<u8> =
    highest(0x2300, "Customer EEPROM area - highest sub-index", 8);
/// Free to use.
pub const CUSTOMER_DATA_0: Object<u16> =
    number(0x2300, 1, "Customer EEPROM area - Data 0").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_1: Object<u16> =
    number(0x2300, 2, "Customer EEPROM area - Data 1").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_2: Object<u16> =
    number(0x2300, 3, "Customer EEPROM area - Data 2").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_3: Object<u16> =
    number(0x2300, 4, "Customer EEPROM area - Data 3").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_4: Object<u16> =
    number(0x2300, 5, "Customer EEPROM area - Data 4").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_5: Object<u16> =
    number(0x2300, 6, "Customer EEPROM area - Data 5").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_6: Object<u16> =
    number(0x2300, 7, "Customer EEPROM area - Data 6").read_write().stored_on_command();
/// Free to use.
pub const CUSTOMER_DATA_7: Object<u16> =
    number(0x2300, 8, "Customer EEPROM area - Data 7").read_write().stored_on_command();
/// How often a value is sent; 0 without end (B-17).
pub const PDO1_REPEATS: Object<u8> =
    number(0x2800, 0, "PDO1 event trigger").read_write().stored_on_command().held_by_interface();
/// How often a value is sent; 0 without end (B-17).
pub const PDO2_REPEATS: Object<u8> =
    number(0x2801, 0, "PDO2 event trigger").read_write().stored_on_command().held_by_interface();

// Device profile (CiA 406)

/// Bit 0 counting direction, bit 2 scaling on; others are ignored.
pub const OPERATING_PARAMETERS: Object<u16> =
    number(0x6000, 0, "Operating parameters").read_write().stored_on_command().default(4);
/// Period of TxPDO1; 0 is off (B-20).
pub const CYCLE_TIMER: Object<u16> = number(0x6200, 0, "Cyclic timer")
    .read_write()
    .stored_on_command()
    .held_by_interface()
    .default(0x0203)
    .unit(Unit::Millisecond);
/// [`OPERATING_PARAMETERS`] as they are in force (B-45).
pub const OPERATING_STATUS: Object<u16> = number(0x6500, 0, "Operating status").default(4);
/// Bit 0 position error.
pub const ALARMS: Object<u16> = number(0x6503, 0, "Alarms");
/// Bits that [`ALARMS`] may have.
pub const SUPPORTED_ALARMS: Object<u16> = number(0x6504, 0, "Supported alarms").default(1);
/// Bit 2 restart by the watchdog, bit 4 battery low.
pub const WARNINGS: Object<u16> = number(0x6505, 0, "Warnings");
/// Profile 2.01, firmware 1.09 (B-54).
pub const PROFILE_AND_SOFTWARE_VERSION: Object<u32> =
    number(0x6507, 0, "Profile and software version").default(0x0109_0201);
/// Since the last restart.
pub const OPERATING_TIME: Object<u32> = number(0x6508, 0, "Operating time").unit(Unit::TenthHour);
/// Follows from the preset.
pub const OFFSET: Object<u32> = number(0x6509, 0, "Offset").stored_on_command();
/// [`SERIAL_NUMBER`] again.
pub const MODULE_SERIAL_NUMBER: Object<u32> =
    number(0x650B, 0, "Serial number").stored_on_command();

/// A variant: type, name, product code, steps per turn, steps in all, and the bits its warnings
/// may have.
macro_rules! variant {
    (
        $(#[$doc:meta])* $module:ident: $device_type:ident, $name:literal, code $code:literal,
        turn $turn:literal, range $range:literal, warnings $warnings:literal
    ) => {
        $(#[$doc])*
        pub mod $module {
            use super::*;

            /// Absolute encoder by profile 406.
            pub const DEVICE_TYPE: Object<u32> =
                number(0x1000, 0, "Device type").within($device_type, $device_type)
                    .default($device_type);
            /// Four letters in a number.
            pub const DEVICE_NAME: Object<u32> =
                number(0x1008, 0, "Manufacturer device name").default(letters(*$name));
            /// Sets the family and the type apart.
            pub const PRODUCT_CODE: Object<u32> = number(0x1018, 2, "Identity - Product code")
                .within($code, $code).default($code);
            /// A change clears the offset (B-47).
            pub const UNITS_PER_TURN: Object<u32> =
                number(0x6001, 0, "Measuring units per revolution").read_write()
                    .stored_on_command().within(1, $turn).default($turn);
            /// A change clears the offset (B-47, B-50).
            pub const MEASURING_RANGE: Object<u32> =
                number(0x6002, 0, "Total measuring range").read_write().stored_on_command()
                    .within(1, $range).default($range);
            /// The position becomes this at once. Its upper end is below [`MEASURING_RANGE`], or,
            /// with the scaling off, below [`MEASURING_RANGE_MAX`] (B-49).
            pub const PRESET: Object<u32> = number(0x6003, 0, "Preset value").read_write()
                .stored_on_command().within(0, $range - 1);
            /// Actual value, offset included (B-48).
            pub const POSITION_VALUE: Object<u32> = number(0x6004, 0, "Position value")
                .within(0, $range - 1).mappable(Transmit);
            /// Steps of the sensor in a turn.
            pub const UNITS_PER_TURN_MAX: Object<u32> =
                number(0x6501, 0, "Maximum single-turn resolution").default($turn);
            /// Steps of the sensor in all its turns (B-51).
            pub const MEASURING_RANGE_MAX: Object<u32> =
                number(0x6502, 0, "Maximum total measuring range").default($range);
            /// Bits that [`WARNINGS`] may have.
            pub const SUPPORTED_WARNINGS: Object<u16> =
                number(0x6506, 0, "Supported warnings").default($warnings);

            product! {
                pub
                DEVICE_TYPE, ERROR_REGISTER, ERROR_COUNT, ERROR_1, ERROR_2, ERROR_3, ERROR_4,
                ERROR_5, ERROR_6, ERROR_7, ERROR_8, SYNC_COB_ID, DEVICE_NAME, HARDWARE_VERSION,
                SOFTWARE_VERSION, GUARD_TIME, LIFE_TIME_FACTOR, STORE, STORE_ALL,
                STORE_COMMUNICATION, STORE_APPLICATION, STORE_MANUFACTURER, RESTORE, RESTORE_ALL,
                RESTORE_COMMUNICATION, RESTORE_APPLICATION, RESTORE_MANUFACTURER, EMERGENCY_COB_ID,
                CONSUMER_HEARTBEAT, CONSUMER_HEARTBEAT_TIME, PRODUCER_HEARTBEAT_TIME, IDENTITY,
                VENDOR_ID, PRODUCT_CODE, REVISION_NUMBER, SERIAL_NUMBER, ERROR_BEHAVIOUR,
                ERROR_BEHAVIOUR_COMMUNICATION, TPDO1, TPDO1_COB_ID, TPDO1_TRANSMISSION_TYPE,
                TPDO1_EVENT_TIMER, TPDO2, TPDO2_COB_ID, TPDO2_TRANSMISSION_TYPE, TPDO2_EVENT_TIMER,
                TPDO1_MAPPING, TPDO1_MAPPED_POSITION, TPDO2_MAPPING, TPDO2_MAPPED_POSITION,
                BIT_RATE, NODE_ID, OPTIONS, STATISTICS, POSITION_ERRORS, TOTAL_OPERATING_TIME,
                WATCHDOG_RESETS, CUSTOMER_DATA, CUSTOMER_DATA_0, CUSTOMER_DATA_1, CUSTOMER_DATA_2,
                CUSTOMER_DATA_3, CUSTOMER_DATA_4, CUSTOMER_DATA_5, CUSTOMER_DATA_6, CUSTOMER_DATA_7,
                PDO1_REPEATS, PDO2_REPEATS, OPERATING_PARAMETERS, UNITS_PER_TURN, MEASURING_RANGE,
                PRESET, POSITION_VALUE, CYCLE_TIMER, OPERATING_STATUS, UNITS_PER_TURN_MAX,
                MEASURING_RANGE_MAX, ALARMS, SUPPORTED_ALARMS, WARNINGS, SUPPORTED_WARNINGS,
                PROFILE_AND_SOFTWARE_VERSION, OPERATING_TIME, OFFSET, MODULE_SERIAL_NUMBER
            }
        }
    };
}

variant! {
    /// multivo, many turns.
    gxmm: MULTITURN, b"GXMM", code 0x0A,
    turn 0x2000, range 0x2000_0000, warnings 0x0014
}

variant! {
    /// multivo, one turn.
    gxam: SINGLETURN, b"GXAM", code 0x0B,
    turn 0x2000, range 0x2000, warnings 0x0004
}

variant! {
    /// magtivo, many turns (B-07).
    gcmm: MULTITURN, b"GCMM", code 0x0C,
    turn 0x1000, range 0x0400_0000, warnings 0x0014
}

variant! {
    /// magtivo, one turn.
    gcam: SINGLETURN, b"GCAM", code 0x0D,
    turn 0x1000, range 0x1000, warnings 0x0004
}

variant! {
    /// multivoPlus, many turns.
    gbmm: MULTITURN, b"GBMM", code 0x0E,
    turn 0x4_0000, range 0x8000_0000, warnings 0x0014
}

variant! {
    /// multivoPlus, one turn.
    gbam: SINGLETURN, b"GBAM", code 0x0F,
    turn 0x4_0000, range 0x4_0000, warnings 0x0004
}

variant! {
    /// activo, many turns (B-60).
    gdmm: MULTITURN, b"GDMM", code 0x0E,
    turn 0x4_0000, range 0x8000_0000, warnings 0x0014
}

variant! {
    /// activo, one turn (B-60).
    gdam: SINGLETURN, b"GDAM", code 0x0F,
    turn 0x4_0000, range 0x4_0000, warnings 0x0004
}
