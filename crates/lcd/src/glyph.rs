/// The segments of one digit that are on: `a` (top) clockwise to `f`, `g` (middle), and the point
/// to the lower right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Glyph(u8);

impl Glyph {
    /// Nothing on.
    pub const BLANK: Self = Self(0);
    /// Segment a, the top bar.
    pub const A: Self = Self(1 << 0);
    /// Segment b, upper right.
    pub const B: Self = Self(1 << 1);
    /// Segment c, lower right.
    pub const C: Self = Self(1 << 2);
    /// Segment d, the bottom bar.
    pub const D: Self = Self(1 << 3);
    /// Segment e, lower left.
    pub const E: Self = Self(1 << 4);
    /// Segment f, upper left.
    pub const F: Self = Self(1 << 5);
    /// Segment g, the middle bar; the minus sign.
    pub const G: Self = Self(1 << 6);
    /// The point, lower right of the digit.
    pub const POINT: Self = Self(1 << 7);

    /// The glyph of a character: 0 to 9, minus, underscore and the upper-case letters that seven
    /// segments can show (NM17x DISP-18, A-98). Every other character is blank.
    #[must_use]
    pub const fn of(character: u8) -> Self {
        Self(match character {
            b'0' => 0b011_1111,
            b'1' => 0b000_0110,
            b'2' => 0b101_1011,
            b'3' => 0b100_1111,
            b'4' => 0b110_0110,
            b'5' | b'S' => 0b110_1101,
            b'6' => 0b111_1101,
            b'7' => 0b000_0111,
            b'8' => 0b111_1111,
            b'9' => 0b110_1111,
            b'-' => 0b100_0000,
            b'_' => 0b000_1000,
            b'A' => 0b111_0111,
            b'B' => 0b111_1100,
            b'C' => 0b011_1001,
            b'D' => 0b101_1110,
            b'E' => 0b111_1001,
            b'F' => 0b111_0001,
            b'G' => 0b011_1101,
            b'H' => 0b111_0110,
            b'I' => 0b011_0000,
            b'J' => 0b001_1110,
            b'L' => 0b011_1000,
            b'N' => 0b101_0100,
            b'O' => 0b101_1100,
            b'P' => 0b111_0011,
            b'Q' => 0b110_0111,
            b'R' => 0b101_0000,
            b'T' => 0b111_1000,
            b'U' => 0b011_1110,
            b'Y' => 0b110_1110,
            _ => 0,
        })
    }

    /// The glyph of a decimal digit; blank above 9.
    #[must_use]
    pub const fn digit(digit: u8) -> Self {
        if digit <= 9 { Self::of(b'0' + digit) } else { Self::BLANK }
    }

    /// Whether all segments of `other` are on.
    #[must_use]
    pub const fn shows(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// The segments of both.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// These segments without those of `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// The segments upside down. The point has no counterpart and goes.
    #[must_use]
    pub(crate) fn upside_down(self) -> Self {
        let mirrored = [
            (Self::A, Self::D),
            (Self::B, Self::E),
            (Self::C, Self::F),
            (Self::D, Self::A),
            (Self::E, Self::B),
            (Self::F, Self::C),
            (Self::G, Self::G),
        ];
        mirrored
            .iter()
            .filter(|(from, _)| self.shows(*from))
            .fold(Self::BLANK, |turned, (_, to)| turned.with(*to))
    }
}
