//! A text of the master's on both lines (NM17x OD-2007-1, DISP-17 to DISP-19).

use lcd::{DIGITS, Glyph, Line};

const LEN: usize = 2 * DIGITS;
const PART_LEN: usize = 4;

/// The text, as far as it has come, and whether it is on the display.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Message {
    text: [u8; LEN],
    shown: Shown,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Shown {
    #[default]
    No,
    Yes,
}

impl Message {
    /// Takes four characters in, the first one in the lowest byte. The last part shows the text.
    pub(crate) fn take_part(&mut self, part: usize, characters: u32) {
        if let Some(place) = self.text.as_chunks_mut().0.get_mut(part) {
            *place = characters.to_le_bytes();
            self.shown = if (part + 1) * PART_LEN == LEN { Shown::Yes } else { Shown::No };
        }
    }

    /// Takes the text off the display.
    pub(crate) fn end(&mut self) {
        self.shown = Shown::No;
    }

    /// Upper and lower line, while the text is shown.
    pub(crate) fn lines(&self) -> Option<(Line, Line)> {
        let (upper, lower) = self.text.split_at(DIGITS);
        match self.shown {
            Shown::No => None,
            Shown::Yes => Some((line(upper), line(lower))),
        }
    }
}

/// A place for every character, the point included, which has none of its own and is blank.
fn line(text: &[u8]) -> Line {
    let mut line = Line::BLANK;
    for (glyph, character) in line.glyphs.iter_mut().zip(text) {
        *glyph = Glyph::of(*character);
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x DISP-17: six characters a line, shown when all have come.
    #[test]
    fn the_last_part_shows_the_text() {
        let part = |text: &[u8; 4]| u32::from_le_bytes(*text);
        let mut message = Message::default();
        message.take_part(0, part(b"STOP"));
        message.take_part(1, part(b"  12"));
        assert_eq!(message.lines(), None);
        message.take_part(2, part(b"34-_"));
        let expected = Some((Line::text(b"STOP"), Line::text(b"1234-_")));
        assert_eq!(message.lines(), expected);
        message.end();
        assert_eq!(message.lines(), None);
    }
}
