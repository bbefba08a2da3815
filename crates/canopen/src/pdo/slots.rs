use object_dictionary::Slot;

/// A set of slots, where slots that are a multiple of 32 apart count as one. Two sets that do not
/// meet share no slot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slots(u32);

impl Slots {
    pub(super) const EMPTY: Self = Self(0);

    pub(super) const fn is_empty(self) -> bool {
        self.0 == 0
    }

    pub(super) const fn of(slot: Slot) -> Self {
        Self(1 << (slot.position() % 32))
    }

    pub(super) const fn join(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    pub(super) const fn meets(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}
