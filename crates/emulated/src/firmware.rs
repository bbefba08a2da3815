//! A firmware file: what is flashed, and what reads its log.
use std::fmt;
use std::path::Path;

use defmt_decoder::{DecodeError, Encoding, Table};
use rigless::cpu::armv7m::code_address;
use rigless::symbols::Symbols;
use world::EngineError;

use crate::memory_map::{BANK_2, FLASH_BASE, FLASH_LEN};

/// The control block of the log channel.
const LOG_BLOCK: &str = "_SEGGER_RTT";

/// An ELF file for the part, as flashed onto a board.
pub struct Firmware {
    name: String,
    /// Both banks as flashed.
    cells: Vec<u8>,
    log_block: Option<u64>,
    log_table: Option<Table>,
}

impl fmt::Debug for Firmware {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Firmware").field("name", &self.name).finish_non_exhaustive()
    }
}

/// One line of the log, not yet dated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Line {
    pub(crate) level: String,
    pub(crate) text: String,
}

/// What an instruction does to PRIMASK, which masks all interrupts (ARMv7-M, B5.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MaskingInstruction {
    Mask,
    Restore,
}

impl MaskingInstruction {
    fn decode(first: u16, second: u16) -> Option<Self> {
        match (first, second) {
            (0xB672, _) => Some(Self::Mask),
            (0xB662, _) | (0xF380..=0xF38F, 0x8810) => Some(Self::Restore),
            _ => None,
        }
    }
}

impl Firmware {
    /// Reads the ELF file at `path`.
    ///
    /// # Errors
    /// When the file cannot be read or is no ELF file for this part.
    pub fn read(path: &Path) -> Result<Self, EngineError> {
        let name = path.display().to_string();
        let elf = std::fs::read(path)
            .map_err(|error| EngineError(format!("{name} cannot be read: {error}")))?;
        Self::parse(&name, &elf)
    }

    /// Takes the bytes of an ELF file; `name` is what messages call it.
    ///
    /// # Errors
    /// When they are no ELF file for this part.
    pub fn parse(name: &str, elf: &[u8]) -> Result<Self, EngineError> {
        let refused = |why: &str| EngineError(format!("{name} {why}"));
        let cells = flash_cells(elf).map_err(refused)?;
        let symbols = Symbols::read(elf, code_address)
            .map_err(|error| refused(&format!("has unreadable symbols: {error}")))?;
        let log_table = Table::parse(elf)
            .map_err(|error| refused(&format!("has unreadable log strings: {error}")))?;
        if log_table.as_ref().is_some_and(|table| table.encoding() != Encoding::Rzcobs) {
            return Err(refused("logs in another encoding than rzCOBS"));
        }
        Ok(Self { name: name.to_owned(), cells, log_block: symbols.get(LOG_BLOCK).ok(), log_table })
    }

    /// What messages call it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Both banks of a controller it was flashed into; what `kept` (the flash of an earlier run)
    /// has in bank 2 stays.
    pub(crate) fn flashed(&self, kept: Option<&[u8]>) -> Vec<u8> {
        let mut cells = self.cells.clone();
        let bank_2 = usize::try_from(BANK_2 - FLASH_BASE).expect("inside the array");
        if let (Some(stored), Some(bank)) =
            (kept.and_then(|kept| kept.get(bank_2..FLASH_LEN)), cells.get_mut(bank_2..))
        {
            bank.copy_from_slice(stored);
        }
        cells
    }

    /// Where in flash an instruction looks like one that masks all interrupts or ends that. Data
    /// that looks the same is never executed.
    pub(crate) fn masking(&self) -> impl Iterator<Item = (u64, MaskingInstruction)> {
        let words = self.cells.windows(4).step_by(2);
        (FLASH_BASE..).step_by(2).zip(words).filter_map(|(at, bytes)| {
            MaskingInstruction::decode(half(bytes, 0)?, half(bytes, 2)?).map(|found| (at, found))
        })
    }

    /// That instruction at `address`, if it is one.
    pub(crate) fn masking_at(&self, address: u64) -> Option<MaskingInstruction> {
        let at = usize::try_from(address.checked_sub(FLASH_BASE)?).ok()?;
        MaskingInstruction::decode(half(&self.cells, at)?, half(&self.cells, at + 2)?)
    }

    /// Where the log channel's control block lies, if the firmware has one.
    pub(crate) const fn log_block(&self) -> Option<u64> {
        self.log_block
    }

    /// The lines in `bytes`, which end with a whole frame.
    pub(crate) fn lines(&self, bytes: &[u8]) -> Vec<Line> {
        let Some(table) = &self.log_table else {
            return Vec::new();
        };
        let mut decoder = table.new_stream_decoder();
        decoder.received(bytes);
        let mut lines = Vec::new();
        loop {
            match decoder.decode() {
                Ok(frame) => lines.push(Line {
                    level: frame.level().map_or("", |level| level.as_str()).to_owned(),
                    text: frame.display_message().to_string(),
                }),
                Err(DecodeError::UnexpectedEof) => return lines,
                Err(DecodeError::Malformed) => lines.push(Line {
                    level: String::new(),
                    text: "(a frame of the log that cannot be read)".to_owned(),
                }),
            }
        }
    }
}

const ELF_MAGIC: &[u8] = b"\x7FELF\x01\x01";
const MACHINE_ARM: u16 = 40;
const LOADED: u32 = 1;

/// Both banks with the loaded segments of `elf` in them, erased elsewhere.
fn flash_cells(elf: &[u8]) -> Result<Vec<u8>, &'static str> {
    const TORN: &str = "is an ELF file that ends early";
    if !elf.starts_with(ELF_MAGIC) || half(elf, 18) != Some(MACHINE_ARM) {
        return Err("is no 32-bit little-endian ELF file for Arm");
    }
    let table = offset(word(elf, 28).ok_or(TORN)?);
    let entry_len = usize::from(half(elf, 42).ok_or(TORN)?);
    let entries = usize::from(half(elf, 44).ok_or(TORN)?);
    let mut cells = vec![0xFF; FLASH_LEN];
    let mut loaded = false;
    for entry in (0..entries).map(|n| table + n * entry_len) {
        let field = |at| word(elf, entry + at).ok_or(TORN);
        let (kind, from, address, len) = (field(0)?, field(4)?, field(12)?, field(16)?);
        if kind != LOADED || len == 0 {
            continue;
        }
        let bytes = elf.get(offset(from)..offset(from) + offset(len)).ok_or(TORN)?;
        let start = u64::from(address)
            .checked_sub(FLASH_BASE)
            .and_then(|start| usize::try_from(start).ok());
        start
            .and_then(|start| cells.get_mut(start..start + bytes.len()))
            .ok_or("is loaded outside the flash memory")?
            .copy_from_slice(bytes);
        loaded = true;
    }
    if loaded { Ok(cells) } else { Err("has nothing to load") }
}

fn half(elf: &[u8], at: usize) -> Option<u16> {
    elf.get(at..at + 2)?.try_into().ok().map(u16::from_le_bytes)
}

fn word(elf: &[u8], at: usize) -> Option<u32> {
    elf.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes)
}

fn offset(value: u32) -> usize {
    usize::try_from(value).expect("the host has 32 bits or more")
}
