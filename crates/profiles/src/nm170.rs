//! NM170: spindle position display with its own absolute measuring system, without motor.

use object_dictionary::Object;

use crate::nm17x::*;
use crate::{Equipment, Product};

/// The product.
pub static PRODUCT: Product = Product {
    slug: "nm170",
    designation: "170.A01",
    code: CODE,
    equipment: Equipment::Nothing,
    firmware: FIRMWARE,
    dictionary: &DICTIONARY,
    fingerprint: FINGERPRINT,
};

/// Name of the device; segmented upload.
pub const DEVICE_NAME: Object<[u8; 14]> =
    Object::new(0x1008, 0, "Manufacturer device name").default_text("NM170 Standard");

/// Sets the type apart.
pub const PRODUCT_CODE: Object<u32> = Object::new(0x1018, 2, "Identity - Product code")
    .within(CODE as i64, CODE as i64)
    .default(CODE as i64);

const CODE: u16 = 0x70;

/// 0 up, 1 down, 2 both, 3 off.
pub const ARROWS: Object<u32> = crate::nm17x::ARROWS.within(0, 3);

/// Type of the application controller.
pub const DEVICE_TYPE_MSP: Object<u32> =
    Object::new(0x2006, 2, "MSP device type").within(0x8081, 0x8081).default(0x8081);

product! {}
