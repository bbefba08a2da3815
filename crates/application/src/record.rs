//! Numbers that are no object but must outlive the supply.

/// Keys of objects are index and sub-index, 24 bits. Records without an object lie above.
const FIRST_KEY: u32 = 1 << 24;

/// Which number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum RecordKey {
    /// The preset offset in sensor steps, two's complement (NM17x POS-08, POS-09).
    PresetOffset = FIRST_KEY,
    /// Turns added to those of the encoder (NM17x OD-2015-2).
    TurnOffset = FIRST_KEY + 1,
}

/// A number, and whether the storage has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Record {
    key: RecordKey,
    value: u32,
    stored: bool,
}

impl Record {
    /// Zero, as on a device whose storage is empty.
    pub(crate) const fn new(key: RecordKey) -> Self {
        Self { key, value: 0, stored: true }
    }

    /// Takes over what the storage has, if this is the record of that key.
    pub(crate) fn restore(&mut self, key: u32, value: u32) {
        if key == self.key as u32 {
            self.value = value;
        }
    }

    /// The number.
    pub(crate) fn value(&self) -> u32 {
        self.value
    }

    /// Changes the number; one that is the same already is not stored again (NM17x A-44).
    pub(crate) fn set(&mut self, value: u32) {
        self.stored &= value == self.value;
        self.value = value;
    }

    /// Key and number, once after each change.
    pub(crate) fn poll_store(&mut self) -> Option<(u32, u32)> {
        let due = !self.stored;
        self.stored = true;
        due.then_some((self.key as u32, self.value))
    }
}
