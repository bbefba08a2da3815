use core::num::NonZeroU32;

use crate::application::{ReadError, WriteError};
use crate::settings::AbortCodes;

/// The reason an SDO transfer ends without success (CiA 301, section 7.2.4.3.17).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AbortCode(NonZeroU32);

impl AbortCode {
    /// The toggle bit did not alternate.
    pub const TOGGLE: Self = Self::new(0x0503_0000);
    /// The client let the transfer wait too long.
    pub const TIMEOUT: Self = Self::new(0x0504_0000);
    /// The block size is not 1 to 127.
    pub const BLOCK_SIZE: Self = Self::new(0x0504_0002);
    /// The client has a segment that was not sent.
    pub const SEQUENCE_NUMBER: Self = Self::new(0x0504_0003);
    /// The checksum of a block transfer is wrong.
    pub const CRC: Self = Self::new(0x0504_0004);
    /// The command byte is unknown, or does not belong here.
    pub const UNKNOWN_COMMAND: Self = Self::new(0x0504_0001);
    /// The transfer does not fit the memory for it.
    pub const OUT_OF_MEMORY: Self = Self::new(0x0504_0005);
    /// The access to the object is not supported.
    pub const UNSUPPORTED_ACCESS: Self = Self::new(0x0601_0000);
    /// The object can only be written.
    pub const WRITE_ONLY: Self = Self::new(0x0601_0001);
    /// The object can only be read.
    pub const READ_ONLY: Self = Self::new(0x0601_0002);
    /// There is no such object.
    pub const NO_OBJECT: Self = Self::new(0x0602_0000);
    /// The object cannot be mapped to the PDO.
    pub const NOT_MAPPABLE: Self = Self::new(0x0604_0041);
    /// The mapped objects are more, or longer, than a PDO.
    pub const MAPPING_LENGTH: Self = Self::new(0x0604_0042);
    /// The value does not go with those of other objects.
    pub const INCOMPATIBLE: Self = Self::new(0x0604_0043);
    /// A fault of the hardware.
    pub const HARDWARE_ERROR: Self = Self::new(0x0606_0000);
    /// The length is not that of the object.
    pub const LENGTH_MISMATCH: Self = Self::new(0x0607_0010);
    /// The object exists, the sub-index does not.
    pub const NO_SUB_INDEX: Self = Self::new(0x0609_0011);
    /// The value is none of those permitted.
    pub const VALUE_RANGE: Self = Self::new(0x0609_0030);
    /// The value is too high.
    pub const VALUE_TOO_HIGH: Self = Self::new(0x0609_0031);
    /// The value is too low.
    pub const VALUE_TOO_LOW: Self = Self::new(0x0609_0032);
    /// A failure without a code of its own.
    pub const GENERAL: Self = Self::new(0x0800_0000);
    /// The data cannot be transferred or stored.
    pub const NOT_STORED: Self = Self::new(0x0800_0020);
    /// The data cannot be transferred or stored: the device itself is in control.
    pub const LOCAL_CONTROL: Self = Self::new(0x0800_0021);
    /// Not in the present state of the device.
    pub const DEVICE_STATE: Self = Self::new(0x0800_0022);
    /// There is no value now.
    pub const NO_DATA: Self = Self::new(0x0800_0024);

    /// For constants: does not compile with zero, which is no code.
    const fn new(code: u32) -> Self {
        match NonZeroU32::new(code) {
            Some(code) => Self(code),
            None => panic!("zero is no abort code"),
        }
    }

    /// The code as a number, which is not zero.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0.get()
    }

    pub(crate) const fn of_read(error: ReadError) -> Self {
        match error {
            ReadError::NoData => Self::NO_DATA,
            ReadError::Hardware => Self::HARDWARE_ERROR,
            ReadError::DeviceState => Self::DEVICE_STATE,
            ReadError::Failed => Self::GENERAL,
        }
    }

    pub(crate) const fn of_write(error: WriteError, codes: &AbortCodes) -> Self {
        match error {
            WriteError::ValueRange => codes.value_range,
            WriteError::NotStored => codes.not_stored,
            WriteError::Hardware => Self::HARDWARE_ERROR,
            WriteError::DeviceState => Self::DEVICE_STATE,
            WriteError::AboveMaximum => codes.above_maximum,
            WriteError::Failed => Self::GENERAL,
        }
    }
}
