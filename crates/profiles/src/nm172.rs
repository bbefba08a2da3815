//! NM172: spindle position display with its own absolute measuring system and motor control.

use object_dictionary::{Object, product};

use crate::Product;
use crate::nm17x::*;

/// The product.
pub static PRODUCT: Product = Product {
    slug: "nm172",
    designation: "172.A01",
    code: CODE,
    firmware: FIRMWARE,
    dictionary: &DICTIONARY,
    fingerprint: FINGERPRINT,
};

/// Name of the device; segmented upload.
pub const DEVICE_NAME: Object<[u8; 14]> =
    Object::new(0x1008, 0, "Manufacturer device name").default_text("NM172 Standard");

/// Sets the type apart.
pub const PRODUCT_CODE: Object<u32> = Object::new(0x1018, 2, "Identity - Product code")
    .within(CODE as i64, CODE as i64)
    .default(CODE as i64);

const CODE: u16 = 0x71;

/// Type of the application controller.
pub const DEVICE_TYPE_MSP: Object<u32> =
    Object::new(0x2006, 2, "MSP device type").within(0x8281, 0x8281).default(0x8281);

/// The first setpoint alone.
pub const SETPOINT: Object<u8> = Object::highest_sub_index(0x2020, "Setpoint (target position)", 1);

product! {
    pub
    DEVICE_TYPE, ERROR_REGISTER, STATUS_REGISTER, SYNC_COB_ID,
    DEVICE_NAME, HARDWARE_VERSION, SOFTWARE_VERSION,
    PRODUCER_HEARTBEAT_TIME,
    IDENTITY, VENDOR_ID, PRODUCT_CODE, REVISION_NUMBER, SERIAL_NUMBER,
    TPDO1, TPDO1_COB_ID, TPDO1_TRANSMISSION_TYPE, TPDO1_INHIBIT_TIME, TPDO1_EVENT_TIMER,
    TPDO2, TPDO2_COB_ID, TPDO2_TRANSMISSION_TYPE, TPDO2_INHIBIT_TIME, TPDO2_EVENT_TIMER,
    TPDO1_MAPPING, TPDO1_MAPPED_POSITION, TPDO1_MAPPED_STATUS, TPDO1_MAPPED_ERRORS,
    TPDO2_MAPPING, TPDO2_MAPPED_POSITION, TPDO2_MAPPED_CORRECTION, TPDO2_MAPPED_STATUS,
    GENERAL_SETTINGS, POSITIONING_DIRECTION, COUNTING_DIRECTION, ARROWS, ROUND_ACTUAL_VALUE,
    ROTATE_DISPLAY, CORRECTION_ENABLED, HIDE_SETPOINT, EXTERNAL_INPUTS,
    LENGTH_UNIT, LOOP_LENGTH, TOLERANCE_WINDOW, SCALING,
    SPECIAL_PARAMETERS, FILTER_WIDTH, FILTER_COUNT, HIDE_LAST_DIGIT,
    MSP_DATA, MSP_FIRMWARE_VERSION, DEVICE_TYPE_MSP,
    CORRECTION, RESET_FUNCTION,
    SETPOINT, STANDARD_SETPOINT,
    STATUS_AND_ERRORS, STATUS, ERRORS,
    BIT_RATE, NODE_ID,
    PDO_SETPOINT, PDO_SETPOINT_SETPOINT, PDO_SETPOINT_CORRECTION, PDO_SETPOINT_CONTROL,
    PDO_SETPOINT_CORRECTION_SENT,
    PRESET, POSITION_VALUE
}
