//! The absolute multiturn kit encoder on the shaft.
//!
//! It counts more finely than the device is specified to (4096 instead of 2304 or 720 places per
//! turn) and never forgets the turns, so the position survives any time without supply. Its counter
//! cannot be set: where a device offers to set the turn counter, the difference is kept as
//! [`TurnOffset`] and added here.

use units::Steps;

/// A geometry of encoder and device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Encoder {
    /// Bits of the turn counter, above the angle in the word.
    pub turn_bits: u8,
    /// Bits of the angle.
    pub angle_bits: u8,
    /// Steps per turn of the device, at most two to the power of `angle_bits`.
    pub steps_per_turn: u16,
}

/// Turns to add to those of the encoder, modulo its number of turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TurnOffset(u32);

/// The encoder of NM170 and NM172: 25 bits, 2304 steps per turn (NM17x POS-02, A-57).
pub const NM17X: Encoder = Encoder { turn_bits: 13, angle_bits: 12, steps_per_turn: 2_304 };

impl TurnOffset {
    /// The offset that adds `turns`.
    #[must_use]
    pub const fn from_turns(turns: u32) -> Self {
        Self(turns)
    }

    /// Turns added.
    #[must_use]
    pub const fn turns(self) -> u32 {
        self.0
    }
}

impl Encoder {
    /// Bits of a word.
    #[must_use]
    pub const fn bits(&self) -> u8 {
        self.turn_bits + self.angle_bits
    }

    /// The steps of a word: `(MT − middle) · steps per turn + ST`, where the middle of the turn
    /// counter, 4096 of 8192, counts as turn 0. The angle is rounded down to a whole step, so the
    /// steps never go back while the shaft goes on and each turn has exactly its number of steps.
    #[must_use]
    pub fn steps(&self, word: u32, offset: TurnOffset) -> Steps {
        let places = 1_i64 << self.angle_bits;
        let turns_all = 1_i64 << self.turn_bits;
        let turns = i64::from(word >> self.angle_bits) + i64::from(offset.0);
        let angle = i64::from(word) & (places - 1);
        let steps_per_turn = i64::from(self.steps_per_turn);
        let turn = turns.rem_euclid(turns_all) - turns_all / 2;
        Steps::new(turn * steps_per_turn + angle * steps_per_turn / places)
    }

    /// The offset with which the turn counter reads its middle at this word: the shaft is then
    /// within the first turn from zero.
    #[must_use]
    pub const fn centred(&self, word: u32) -> TurnOffset {
        let turns_all = 1_u32 << self.turn_bits;
        let turns = word >> self.angle_bits & (turns_all - 1);
        TurnOffset((turns_all + turns_all / 2 - turns) % turns_all)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn steps(turns: u32, angle: u32) -> i64 {
        NM17X.steps(turns << 12 | angle, TurnOffset::default()).count()
    }

    /// NM17x POS-02: turn 4096 is zero, 2304 steps make a turn.
    #[test]
    fn the_middle_turn_is_zero() {
        for (turns, angle, expected) in [
            (4_096, 0, 0),
            (4_096, 1, 0),
            (4_096, 2, 1),
            (4_096, 4_095, 2_303),
            (4_097, 0, 2_304),
            (4_095, 4_095, -1),
            (4_095, 0, -2_304),
            (0, 0, -9_437_184),
            (8_191, 4_095, 9_437_183),
            (4_096, 2_048, 1_152),
            (4_096, 16, 9),
        ] {
            assert_eq!(steps(turns, angle), expected, "turn {turns}, angle {angle}");
        }
    }

    #[test]
    fn the_angle_is_spread_evenly() {
        let mut hits = [0; 2_304];
        for angle in 0..4_096 {
            hits[usize::try_from(steps(4_096, angle)).unwrap()] += 1;
        }
        assert!(hits.iter().all(|&places| places == 1 || places == 2));
    }

    /// NM17x OD-2015-2: the counter reads 4096 afterwards, the angle stays.
    #[test]
    fn a_centred_counter_is_in_turn_zero() {
        for turns in [0, 1, 4_095, 4_096, 4_097, 8_191] {
            let word = turns << 12 | 0x800;
            let offset = NM17X.centred(word);
            assert_eq!(NM17X.steps(word, offset).count(), 1_152, "turn {turns}");
            assert!(offset.turns() < 8_192);
        }
    }

    proptest! {
        #[test]
        fn steps_never_go_back(word in 0_u32..0x1FF_FFFF) {
            let (here, next) = (steps(0, word), steps(0, word + 1));
            prop_assert!(next == here || next == here + 1);
        }

        #[test]
        fn any_word_and_any_offset_stay_in_the_range(word: u32, turns: u32) {
            let steps = NM17X.steps(word, TurnOffset::from_turns(turns)).count();
            prop_assert!((-9_437_184..=9_437_183).contains(&steps));
        }
    }
}
