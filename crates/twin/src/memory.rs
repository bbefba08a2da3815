//! The numbers a controller keeps without supply.

use std::collections::BTreeMap;

use world::{EngineError, FlashImage};

/// Says what an image is; the digit is the format.
const TAG: [u8; 8] = *b"TWIN 1\r\n";
const NUMBER_LEN: usize = 4;
const RECORD_LEN: usize = 2 * NUMBER_LEN;

/// What became of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kept {
    /// It is stored.
    Yes,
    /// The supply failed before it was.
    SupplyLost,
}

impl Kept {
    /// Both, if `other` happened as well.
    pub(crate) const fn and(self, other: Self) -> Self {
        match self {
            Self::Yes => other,
            Self::SupplyLost => Self::SupplyLost,
        }
    }
}

/// Numbers by their keys. One flash operation stores one of them, or a set.
#[derive(Debug, Default)]
pub(crate) struct Memory {
    numbers: BTreeMap<u32, u32>,
    operations: u64,
    operations_to_cut: Option<u32>,
}

impl Memory {
    /// The memory that [`Memory::image`] showed.
    ///
    /// # Errors
    /// When it is the image of something else.
    pub(crate) fn from_image(image: &[u8]) -> Result<Self, EngineError> {
        let other = || EngineError("the flash contents are not the twin engine's".to_owned());
        let records = image.strip_prefix(&TAG).ok_or_else(other)?;
        let (records, []) = records.as_chunks::<RECORD_LEN>() else { return Err(other()) };
        let numbers = records.iter().map(|[a, b, c, d, number @ ..]| {
            (u32::from_le_bytes([*a, *b, *c, *d]), u32::from_le_bytes(*number))
        });
        Ok(Self { numbers: numbers.collect(), ..Self::default() })
    }

    /// All of it, to be kept between runs.
    pub(crate) fn image(&self) -> FlashImage {
        let records = self.numbers.iter().flat_map(|(key, number)| [*key, *number]);
        TAG.into_iter().chain(records.flat_map(u32::to_le_bytes)).collect()
    }

    /// Everything stored: key, number.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = (u32, u32)> + Clone {
        self.numbers.iter().map(|(key, number)| (*key, *number))
    }

    /// Stores `number` under `key`, unless it is stored already.
    pub(crate) fn keep(&mut self, key: u32, number: u32) -> Kept {
        self.keep_set([(key, number)])
    }

    /// Stores all of `set`, or nothing when the supply fails. Nothing happens when all of it is
    /// stored already.
    pub(crate) fn keep_set(&mut self, set: impl IntoIterator<Item = (u32, u32)>) -> Kept {
        let mut numbers = self.numbers.clone();
        numbers.extend(set);
        self.replace(numbers)
    }

    /// Stores all of `set` in the place of everything whose key `goes`, or nothing when the supply
    /// fails.
    pub(crate) fn keep_instead(
        &mut self,
        goes: impl Fn(u32) -> bool,
        set: impl IntoIterator<Item = (u32, u32)>,
    ) -> Kept {
        let kept = self.numbers.iter().filter(|(key, _)| !goes(**key));
        let kept = kept.map(|(key, number)| (*key, *number));
        self.replace(kept.chain(set).collect())
    }

    /// Forgets everything, or nothing when the supply fails.
    pub(crate) fn forget(&mut self) -> Kept {
        self.replace(BTreeMap::new())
    }

    fn replace(&mut self, numbers: BTreeMap<u32, u32>) -> Kept {
        if numbers == self.numbers {
            return Kept::Yes;
        }
        self.operations += 1;
        self.operations_to_cut = self.operations_to_cut.map(|left| left.saturating_sub(1));
        if self.operations_to_cut.take_if(|left| *left == 0).is_some() {
            return Kept::SupplyLost;
        }
        self.numbers = numbers;
        Kept::Yes
    }

    /// Has the supply fail in the `operation`-th operation from now (1 is the next).
    pub(crate) fn cut_at(&mut self, operation: u32) {
        self.operations_to_cut = Some(operation.max(1));
    }

    /// Operations so far.
    pub(crate) fn operations(&self) -> u64 {
        self.operations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_brings_the_numbers_back() {
        let mut memory = Memory::default();
        assert_eq!(memory.keep(0x0020_0300, 320), Kept::Yes);
        assert_eq!(memory.keep(0x0120_0000, u32::MAX), Kept::Yes);
        let again = Memory::from_image(&memory.image()).expect("its own image");
        assert!(again.numbers().eq([(0x0020_0300, 320), (0x0120_0000, u32::MAX)]));
        assert_eq!(Memory::from_image(&Memory::default().image()).map(|m| m.operations()), Ok(0));
    }

    #[test]
    fn another_image_is_refused() {
        for image in [&[][..], &[0xFF; 64], b"TWIN 1\r\nabc", b"TWIN 2\r\n"] {
            assert!(Memory::from_image(image).is_err(), "{image:?}");
        }
    }

    /// NM17x STORE-02: the operation that is cut does not happen; the same number costs none.
    #[test]
    fn the_supply_fails_in_the_chosen_operation() {
        let mut memory = Memory::default();
        memory.cut_at(2);
        assert_eq!(memory.keep(1, 10), Kept::Yes);
        assert_eq!(memory.keep(1, 10), Kept::Yes);
        assert_eq!(memory.keep(1, 11), Kept::SupplyLost);
        assert!(memory.numbers().eq([(1, 10)]));
        assert_eq!(memory.keep(1, 12), Kept::Yes);
        assert_eq!(memory.operations(), 3);
        memory.cut_at(1);
        assert_eq!(memory.keep_set([(2, 20), (3, 30)]), Kept::SupplyLost);
        assert!(memory.numbers().eq([(1, 12)]));
        assert_eq!(memory.keep_set([(2, 20), (3, 30)]), Kept::Yes);
        assert_eq!(memory.numbers().count(), 3);
        assert_eq!(memory.forget(), Kept::Yes);
        assert_eq!((memory.numbers().count(), memory.operations()), (0, 6));
    }

    #[test]
    fn some_numbers_take_the_place_of_others() {
        let mut memory = Memory::default();
        assert_eq!(memory.keep_set([(1, 10), (2, 20), (3, 30)]), Kept::Yes);
        memory.cut_at(1);
        assert_eq!(memory.keep_instead(|key| key < 3, [(2, 21)]), Kept::SupplyLost);
        assert!(memory.numbers().eq([(1, 10), (2, 20), (3, 30)]));
        assert_eq!(memory.keep_instead(|key| key < 3, [(2, 21)]), Kept::Yes);
        assert!(memory.numbers().eq([(2, 21), (3, 30)]));
    }
}
