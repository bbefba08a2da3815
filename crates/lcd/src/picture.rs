//! The glass as text, for tests, logs and documents.

use core::fmt;

use crate::glyph::Glyph;
use crate::view::View;

/// Characters of one digit: three of segments, one for the point.
const DIGIT_WIDTH: usize = 4;
const LINE_WIDTH: usize = crate::line::DIGITS * DIGIT_WIDTH;

/// The glass with its segments as bars, in a frame; the arrows stand below the lines.
impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "┌{:─<LINE_WIDTH$}┐", "")?;
        for line in [&self.upper, &self.lower] {
            for row in [TOP, MIDDLE, BOTTOM] {
                f.write_str("│")?;
                for glyph in line.glyphs {
                    for (segment, bar) in row {
                        f.write_str(if glyph.shows(segment) { bar } else { " " })?;
                    }
                }
                f.write_str("│\n")?;
            }
        }
        let left = if self.arrows.left { "◄" } else { " " };
        let right = if self.arrows.right { "►" } else { " " };
        writeln!(f, "│{left}{:width$}{right}│", "", width = LINE_WIDTH - 2)?;
        write!(f, "└{:─<LINE_WIDTH$}┘", "")
    }
}

/// What a row of a digit consists of: a segment and the way it looks when it is on.
type Row = [(Glyph, &'static str); DIGIT_WIDTH];

/// No segment is there: always the gap.
const GAP: (Glyph, &str) = (Glyph::BLANK, " ");
const TOP: Row = [GAP, (Glyph::A, "_"), GAP, GAP];
const MIDDLE: Row = [(Glyph::F, "|"), (Glyph::G, "_"), (Glyph::B, "|"), GAP];
const BOTTOM: Row = [(Glyph::E, "|"), (Glyph::D, "_"), (Glyph::C, "|"), (Glyph::POINT, ".")];

/// A line as characters. A 5 also stands for S.
#[cfg(test)]
pub(crate) fn readable(line: &crate::line::Line) -> std::string::String {
    let mut text = std::string::String::new();
    for glyph in line.glyphs {
        let known = b" 0123456789-_ABCDEFGHIJLNOPQRTUY";
        let plain = glyph.without(Glyph::POINT);
        text.extend(known.iter().find(|c| Glyph::of(**c) == plain).map(|c| char::from(*c)));
        text.extend(glyph.shows(Glyph::POINT).then_some('.'));
    }
    text
}
