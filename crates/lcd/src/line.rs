use crate::glyph::Glyph;

/// Digits of a line.
pub const DIGITS: usize = 6;

/// What six digits show, from left to right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Line {
    /// The digits with their points.
    pub glyphs: [Glyph; DIGITS],
}

impl Line {
    /// Nothing.
    pub const BLANK: Self = Self { glyphs: [Glyph::BLANK; DIGITS] };

    /// A number of which the last `decimals` digits, 0 to 5, stand behind the point (NM17x
    /// DISP-02, DISP-03, A-105). Leading zeros are left out, but one digit always stands before the
    /// point. Negative numbers have the minus sign in the leftmost place. A number with more digits
    /// than there are places shows its last ones, leading zeros included.
    #[must_use]
    pub fn number(value: i32, decimals: usize) -> Self {
        let places = if value < 0 { DIGITS - 1 } else { DIGITS };
        let mut line = Self::digits(value.unsigned_abs(), places, decimals + 1);
        if decimals > 0
            && let Some(glyph) = line.glyphs.iter_mut().rev().nth(decimals)
        {
            *glyph = glyph.with(Glyph::POINT);
        }
        if value < 0
            && let Some(leftmost) = line.glyphs.first_mut()
        {
            *leftmost = Glyph::of(b'-');
        }
        line
    }

    /// A whole number, right-aligned, with at least `digits_min` digits.
    #[must_use]
    pub fn whole(value: u32, digits_min: usize) -> Self {
        Self::digits(value, DIGITS, digits_min)
    }

    /// A text, left-aligned and cut off behind the last place. A point belongs to the character
    /// before it and takes no place; characters that cannot be shown are blank ([`Glyph::of`]).
    #[must_use]
    pub fn text(text: &[u8]) -> Self {
        let mut line = Self::BLANK;
        let mut left = text;
        for place in &mut line.glyphs {
            let Some((&character, rest)) = left.split_first() else { break };
            *place = Glyph::of(character);
            left = rest;
            if let Some((b'.', rest)) = left.split_first() {
                *place = place.with(Glyph::POINT);
                left = rest;
            }
        }
        line
    }

    /// The line with the rightmost digit, and a point that would be left without decimals, off
    /// (NM17x DISP-12).
    #[must_use]
    pub fn without_last_digit(self) -> Self {
        let [a, b, c, d, e, _] = self.glyphs;
        Self { glyphs: [a, b, c, d, e.without(Glyph::POINT), Glyph::BLANK] }
    }

    fn digits(value: u32, places: usize, digits_min: usize) -> Self {
        let overflow = value.checked_ilog10().is_some_and(|last| last as usize >= places);
        let digits_min = if overflow { places } else { digits_min };
        let mut line = Self::BLANK;
        let mut rest = value;
        for (n, glyph) in line.glyphs.iter_mut().rev().enumerate().take(places) {
            if n < digits_min || rest > 0 {
                *glyph = Glyph::digit((rest % 10).try_into().unwrap_or(0));
            }
            rest /= 10;
        }
        line
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;
    use crate::picture::readable;

    fn number(value: i32, decimals: usize) -> String {
        readable(&Line::number(value, decimals))
    }

    /// NM17x DISP-02, DISP-03, POS-15: six digits, or five and a minus sign in the sixth place from
    /// the right; beyond that the last digits with their leading zeros. A-105: leading zeros
    /// only then.
    #[test]
    fn numbers_fill_the_line_from_the_right() {
        for (value, decimals, expected) in [
            (0, 2, "   0.00"),
            (5, 2, "   0.05"),
            (-5, 2, "-  0.05"),
            (100, 2, "   1.00"),
            (1_000, 2, "  10.00"),
            (-1_000, 2, "- 10.00"),
            (20_000, 2, " 200.00"),
            (999_999, 2, "9999.99"),
            (1_000_000, 2, "0000.00"),
            (1_000_005, 2, "0000.05"),
            (1_234_567, 2, "2345.67"),
            (-99_999, 2, "-999.99"),
            (-100_000, 2, "-000.00"),
            (-100_001, 2, "-000.01"),
            (-1_234_567, 2, "-345.67"),
            (i32::MAX, 2, "4836.47"),
            (i32::MIN, 2, "-836.48"),
            (394, 3, "  0.394"),
            (-7, 3, "- 0.007"),
            (42, 0, "    42"),
            (0, 0, "     0"),
            (7, 5, "0.00007"),
        ] {
            assert_eq!(number(value, decimals), expected, "{value}, {decimals} decimals");
        }
    }

    /// NM17x A-104: a node-ID has at least two digits.
    #[test]
    fn whole_numbers_have_as_many_digits_as_asked_for() {
        for (value, digits_min, expected) in [
            (1, 2, "    01"),
            (127, 2, "   127"),
            (10, 2, "    10"),
            (0, 1, "     0"),
            (1_234_567, 2, "234567"),
        ] {
            assert_eq!(readable(&Line::whole(value, digits_min)), expected);
        }
    }

    /// NM17x DISP-18, A-98, A-99: what seven segments cannot show is blank, points take no place.
    #[test]
    fn texts_start_at_the_left() {
        for (text, expected) in [
            ("172.A01", "172.A01"),
            ("1.05", "1.05   "),
            ("ER 1", "ER 1  "),
            ("DEF9EB", "DEF9EB"),
            ("-_", "-_    "),
            ("KMVWXZ", "      "),
            ("abc?!.", "     . "),
            ("..5", " .5    "),
            ("ABCDEFGHIJ", "ABCDEF"),
            ("", "      "),
            ("1.2.3.4.5.6.7", "1.2.3.4.5.6."),
        ] {
            assert_eq!(readable(&Line::text(text.as_bytes())), expected, "{text:?}");
        }
    }

    /// NM17x DISP-12: tenths of a millimetre.
    #[test]
    fn the_rightmost_digit_can_be_off() {
        for (value, decimals, expected) in
            [(12_345, 2, " 123.4 "), (-5, 2, "-  0.0 "), (12_345, 1, " 1234 ")]
        {
            assert_eq!(readable(&Line::number(value, decimals).without_last_digit()), expected);
        }
    }

    proptest! {
        #[test]
        fn a_number_that_fits_reads_back(value in -99_999_i32..=999_999, decimals in 0_usize..=3) {
            let shown: String = number(value, decimals).chars().filter(|c| c.is_ascii_digit() || *c == '-').collect();
            prop_assert_eq!(shown.parse::<i32>().ok(), Some(value));
        }

        #[test]
        fn any_bytes_are_a_text(text: Vec<u8>) {
            let _ = Line::text(&text);
        }
    }
}
