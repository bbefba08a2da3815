//! The serial number (NM17x OD-1018-1: unique per device).
use embassy_stm32::uid::uid;

const FNV_OFFSET: u32 = 0x811C_9DC5;
const FNV_PRIME: u32 = 0x0100_0193;

/// The 96 bits of the microcontroller's unique ID (RM0090 section 39.1) folded to 32 by FNV-1a.
///
/// Never zero, because zero reads as "no serial number" on the bus.
#[must_use]
pub fn serial_number() -> u32 {
    let folded = uid()
        .iter()
        .fold(FNV_OFFSET, |hash, byte| (hash ^ u32::from(*byte)).wrapping_mul(FNV_PRIME));
    if folded == 0 { FNV_OFFSET } else { folded }
}
