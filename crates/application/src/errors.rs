//! Application errors, object 0x204E:02 (NM17x ERR-01).

use units::Position;

/// Largest and smallest position that the display has digits for. The end positions of an axis lie
/// within these (NM17x ERR-04, A-75).
const DISPLAYABLE_MAX: Position = Position::from_hundredths_mm(999_999);
const DISPLAYABLE_MIN: Position = Position::from_hundredths_mm(-99_999);

/// What is wrong, as the bits of the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Errors(u16);

impl Errors {
    const END_POSITION_MAX: Self = Self(1 << 0);
    const END_POSITION_MIN: Self = Self(1 << 1);

    /// The errors of an axis at `position`.
    pub(crate) fn at(position: Position) -> Self {
        if position > DISPLAYABLE_MAX {
            Self::END_POSITION_MAX
        } else if position < DISPLAYABLE_MIN {
            Self::END_POSITION_MIN
        } else {
            Self::default()
        }
    }

    /// The bits.
    pub(crate) fn bits(self) -> u16 {
        self.0
    }

    /// Whether anything is wrong.
    pub(crate) fn any(self) -> bool {
        self != Self::default()
    }

    /// What the display says: of several errors the gravest (NM17x ERR-02).
    pub(crate) fn text(self) -> Option<&'static [u8]> {
        const BY_PRIORITY: [(Errors, &[u8]); 2] =
            [(Errors::END_POSITION_MAX, b"ER 1"), (Errors::END_POSITION_MIN, b"ER 2")];
        BY_PRIORITY.iter().find(|(error, _)| self.0 & error.0 != 0).map(|(_, text)| *text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x ERR-01, ERR-04: Er 1 and Er 2 at the latest where the display ends.
    #[test]
    fn the_range_of_the_display_is_watched() {
        for (position, bits, text) in [
            (0, 0, None),
            (999_999, 0, None),
            (1_000_000, 1, Some(&b"ER 1"[..])),
            (-99_999, 0, None),
            (-100_000, 2, Some(b"ER 2")),
        ] {
            let errors = Errors::at(Position::from_hundredths_mm(position));
            assert_eq!((errors.bits(), errors.any(), errors.text()), (bits, bits != 0, text));
        }
    }
}
