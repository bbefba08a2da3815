//! The status word, object 0x204E:01 (NM17x STAT-01).

/// Bit 5.
const LEFT_KEY: u16 = 1 << 5;
/// Bit 6.
const RIGHT_KEY: u16 = 1 << 6;
/// Bit 12.
const ARROWS: u16 = 1 << 12;
/// Bit 14.
const ERROR: u16 = 1 << 14;

/// What the word says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Status {
    /// The left key is pressed.
    pub(crate) left_key: bool,
    /// The right key is pressed.
    pub(crate) right_key: bool,
    /// Arrows are visible, steady or blinking.
    pub(crate) arrows: bool,
    /// 0x204E:02 is not zero.
    pub(crate) error: bool,
}

impl Status {
    /// The word.
    pub(crate) fn bits(self) -> u16 {
        [
            (self.left_key, LEFT_KEY),
            (self.right_key, RIGHT_KEY),
            (self.arrows, ARROWS),
            (self.error, ERROR),
        ]
        .iter()
        .filter(|(set, _)| *set)
        .fold(0, |word, (_, bit)| word | bit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x STAT-01.
    #[test]
    fn every_state_has_its_bit() {
        let none = Status::default();
        for (status, word) in [
            (none, 0),
            (Status { left_key: true, ..none }, 0x0020),
            (Status { right_key: true, ..none }, 0x0040),
            (Status { arrows: true, ..none }, 0x1000),
            (Status { error: true, ..none }, 0x4000),
        ] {
            assert_eq!(status.bits(), word, "{status:?}");
        }
    }
}
