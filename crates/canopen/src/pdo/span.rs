use object_dictionary::Slot;

/// Slots from a first to a last one. Two sets of objects whose spans do not meet share none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    first: Slot,
    last: Slot,
}

impl Span {
    /// No slot that a dictionary has.
    pub(super) const EMPTY: Self = Self { first: Slot::NOWHERE, last: Slot::NOWHERE };

    pub(super) const fn of(slot: Slot) -> Self {
        Self { first: slot, last: slot }
    }

    /// Both, and what lies between them.
    pub(super) fn join(self, other: Self) -> Self {
        if self == Self::EMPTY {
            other
        } else if other == Self::EMPTY {
            self
        } else {
            Self { first: self.first.min(other.first), last: self.last.max(other.last) }
        }
    }

    pub(super) fn meets(self, other: Self) -> bool {
        self.first <= other.last && other.first <= self.last
    }
}

impl Default for Span {
    fn default() -> Self {
        Self::EMPTY
    }
}
