//! NM172: spindle position display with its own absolute measuring system and motor control.

use object_dictionary::Object;

use crate::nm17x::*;
use crate::{Equipment, Product};

/// The product.
pub static PRODUCT: Product = Product {
    slug: "nm172",
    designation: "172.A01",
    code: CODE,
    equipment: Equipment::KeysAndMotor,
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

product_with_motor! {}
