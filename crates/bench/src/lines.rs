//! Splits what a client sends into lines of bounded length.

/// Collects bytes until a terminator comes.
#[derive(Debug)]
pub struct Lines {
    terminator: u8,
    len_max: usize,
    partial: Vec<u8>,
    overlong: bool,
}

/// What lies between two terminators.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Line {
    /// The bytes, without the terminator.
    Whole(Vec<u8>),
    /// More than the bound; the bytes are gone.
    TooLong,
}

impl Lines {
    /// Lines ended by `terminator`, of at most `len_max` bytes without it.
    #[must_use]
    pub const fn new(terminator: u8, len_max: usize) -> Self {
        Self { terminator, len_max, partial: Vec::new(), overlong: false }
    }

    /// Takes `bytes` and returns the lines they complete, in order.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Line> {
        let mut lines = Vec::new();
        for &byte in bytes {
            if byte == self.terminator {
                let line = core::mem::take(&mut self.partial);
                lines.push(if core::mem::take(&mut self.overlong) {
                    Line::TooLong
                } else {
                    Line::Whole(line)
                });
            } else if self.partial.len() == self.len_max {
                self.overlong = true;
            } else {
                self.partial.push(byte);
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_whole_however_it_is_cut_and_too_long_only_beyond_the_bound() {
        let whole = |text: &str| Line::Whole(text.as_bytes().to_vec());
        for (chunks, expected) in [
            (&["abc\n"][..], vec![whole("abc")]),
            (&["a", "b", "c\nd"], vec![whole("abc")]),
            (&["a\n\nb\n"], vec![whole("a"), whole(""), whole("b")]),
            (&["abcd\n", "ok\n"], vec![whole("abcd"), whole("ok")]),
            (&["abcde\n", "ok\n"], vec![Line::TooLong, whole("ok")]),
            (&["abcdefgh", "ijkl\nok\n"], vec![Line::TooLong, whole("ok")]),
        ] {
            let mut lines = Lines::new(b'\n', 4);
            let found: Vec<Line> = chunks.iter().flat_map(|c| lines.push(c.as_bytes())).collect();
            assert_eq!(found, expected, "{chunks:?}");
        }
    }
}
