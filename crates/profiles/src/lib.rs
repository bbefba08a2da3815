//! The products: identity and object dictionary of each, written once. Everything that differs
//! from one product to the next and is data is here.
#![no_std]

pub mod ap04;
pub mod cia301;
pub mod encoder;
pub mod nm170;
pub mod nm172;
pub mod nm174;
pub mod nm17x;
mod sheets;

pub use sheets::{Lss, SHEETS, Sheet};

use object_dictionary::Dictionary;

/// Objects of the largest product. Images keep room for so many values.
pub const OBJECTS_MAX: usize = 256;

/// What makes a product.
#[derive(Debug)]
pub struct Product {
    /// Name on the command line and of the images.
    pub slug: &'static str,
    /// Designation on the display after power-on, without the letters a digit can not show.
    pub designation: &'static str,
    /// Object 0x1018:02.
    pub code: u16,
    /// What it has besides display and shaft.
    pub equipment: Equipment,
    /// Firmware version of both controllers in hundredths: 105 is V1.05.
    pub firmware: u16,
    /// All objects.
    pub dictionary: &'static Dictionary,
    /// Fingerprint of the dictionary.
    pub fingerprint: u32,
}

/// What a device has besides display and shaft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Equipment {
    /// Nothing: it is adjusted by hand.
    Nothing,
    /// Two keys, two inputs and a motor.
    KeysAndMotor,
}

const _: () = assert!(nm170::LEN <= OBJECTS_MAX);
const _: () = assert!(nm172::LEN <= OBJECTS_MAX);
const _: () = assert!(nm174::LEN <= OBJECTS_MAX);
const _: () = assert!(ap04::LEN <= OBJECTS_MAX);
const _: () = assert!(encoder::gxmm::LEN <= OBJECTS_MAX);
