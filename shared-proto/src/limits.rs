//! Every bound of the line, and how they hang together.

/// Bit rate of the line, 8N1.
pub const BIT_RATE: u32 = 460_800;
/// Longest frame on the wire, the closing zero included.
pub const FRAME_MAX: usize = 64;
/// Bytes of the check sum.
pub const CRC_LEN: usize = 2;
/// Longest postcard message: COBS adds one byte to a frame this short, the zero is another.
pub const MESSAGE_MAX: usize = FRAME_MAX - CRC_LEN - 2;
/// Values in one snapshot message.
pub const SNAPSHOT_VALUES_MAX: usize = 10;
/// Period of the process data, in milliseconds.
pub const CYCLE_MS: u64 = 10;
/// The application controller stops every automatic motion after this time without a valid frame.
pub const LOST_AFTER_MS: u64 = 100;
/// Longest frame in microseconds: ten bits for each byte.
pub const FRAME_US_MAX: u64 = FRAME_MAX as u64 * 10 * 1_000_000 / BIT_RATE as u64 + 1;

/// Bytes of a postcard number of up to 16 and up to 32 bits.
const VARINT16_MAX: usize = 3;
const VARINT32_MAX: usize = 5;

const _: () = {
    // Variant, first position, count, values.
    assert!(1 + VARINT16_MAX + 1 + SNAPSHOT_VALUES_MAX * VARINT32_MAX <= MESSAGE_MAX);
    // Hello, the longest message of a fixed shape: variant, numbers, flag.
    assert!(2 + 3 * VARINT16_MAX + 3 * VARINT32_MAX <= MESSAGE_MAX);
    // COBS adds one byte up to 254.
    assert!(MESSAGE_MAX + CRC_LEN <= 254);
    // Both frames of a cycle, process data and a snapshot, fit into it with room to spare.
    assert!(2 * FRAME_US_MAX < CYCLE_MS * 1_000 / 2);
};
