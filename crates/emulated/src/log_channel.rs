//! The log channel (SEGGER RTT) as a debug probe reads it: a control block in RAM, and up-channel
//! 0, a ring whose write offset the firmware moves and whose read offset the reader moves.
use std::ops::Range;

use rigless::emulator::Host;
use rigless::soc::Width;

use crate::firmware::{Firmware, Line};
use crate::memory_map::{SRAM_BASE, SRAM_LEN};

/// How often the channel is read. The ring must hold what is logged in this time.
pub(crate) const READ_EVERY_NS: u64 = 1_000_000;

/// What the control block starts with, once the firmware has set it up.
const ID: [u64; 2] = [u64::from_le_bytes(*b"SEGGER R"), u64::from_le_bytes(*b"TT\0\0\0\0\0\0")];

const RAM: Range<u64> = SRAM_BASE..SRAM_BASE + SRAM_LEN;

/// Fields of up-channel 0, as offsets from the control block.
const BUFFER: u64 = 28;
const SIZE: u64 = 32;
const WRITE_OFFSET: u64 = 36;
const READ_OFFSET: u64 = 40;

/// The reader's end.
#[derive(Debug, Default)]
pub(crate) struct LogChannel {
    /// The frame that had only begun at the last read.
    begun: Vec<u8>,
}

impl LogChannel {
    /// Reads what the firmware has logged since the last time.
    pub(crate) fn read(&mut self, firmware: &Firmware, host: &mut dyn Host) -> Vec<Line> {
        let waiting = firmware.log_block().and_then(|block| take_waiting(block, host));
        self.begun.extend(waiting.unwrap_or_default());
        let whole = self.begun.iter().rposition(|&byte| byte == 0).map_or(0, |last| last + 1);
        let frames: Vec<u8> = self.begun.drain(..whole).collect();
        if frames.is_empty() { Vec::new() } else { firmware.lines(&frames) }
    }

    /// The firmware restarted: what had begun will not go on.
    pub(crate) fn restart(&mut self) {
        self.begun.clear();
    }
}

fn take_waiting(block: u64, host: &mut dyn Host) -> Option<Vec<u8>> {
    let word = |host: &mut dyn Host, at| host.read(block + at, Width::W32).ok();
    let (write, read) = (word(host, WRITE_OFFSET)?, word(host, READ_OFFSET)?);
    if write == read {
        return None;
    }
    for (n, part) in (0..).zip(ID) {
        if host.read(block + 8 * n, Width::W64).ok()? != part {
            return None;
        }
    }
    let (buffer, size) = (word(host, BUFFER)?, word(host, SIZE)?);
    let usable = size > 0
        && write < size
        && read < size
        && RAM.contains(&buffer)
        && RAM.contains(&(buffer + size - 1));
    if !usable {
        return None;
    }
    let len = (write + size - read) % size;
    let bytes = (0..len)
        .map(|n| host.read(buffer + (read + n) % size, Width::W8).ok())
        .map(|byte| byte.and_then(|byte| u8::try_from(byte).ok()))
        .collect::<Option<Vec<u8>>>()?;
    host.write(block + READ_OFFSET, Width::W32, write).ok()?;
    Some(bytes)
}
