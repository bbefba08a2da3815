/// A position or length in hundredths of a millimetre: the display's last digit and the unit of
/// every position object on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Position(i32);

/// An angle of the shaft in sensor steps, counted over all turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Steps(i64);

/// The way one sensor step translates into length: 0x2004, ten-millionths of a hundredth of a
/// millimetre per step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scaling(u32);

impl Position {
    /// The zero of the measuring system.
    pub const ZERO: Self = Self(0);

    /// The position `value` hundredths of a millimetre from zero.
    #[must_use]
    pub const fn from_hundredths_mm(value: i32) -> Self {
        Self(value)
    }

    /// Hundredths of a millimetre from zero.
    #[must_use]
    pub const fn hundredths_mm(self) -> i32 {
        self.0
    }

    /// The sum; the ends of the `i32` range where it does not fit.
    #[must_use]
    pub const fn saturating_add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// The difference; the ends of the `i32` range where it does not fit.
    #[must_use]
    pub const fn saturating_sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl Steps {
    /// The middle of the measuring range.
    pub const ZERO: Self = Self(0);

    /// `count` steps from the middle of the measuring range.
    #[must_use]
    pub const fn new(count: i64) -> Self {
        Self(count)
    }

    /// Steps from the middle of the measuring range.
    #[must_use]
    pub const fn count(self) -> i64 {
        self.0
    }
}

impl core::ops::Add for Steps {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }
}

impl core::ops::Sub for Steps {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

impl core::ops::Neg for Steps {
    type Output = Self;

    fn neg(self) -> Self {
        Self(self.0.saturating_neg())
    }
}

impl Scaling {
    /// One step is one hundredth of a millimetre.
    pub const UNITY: Self = Self(10_000_000);

    /// The factor times ten million, as object 0x2004 holds it.
    #[must_use]
    pub const fn from_ten_millionths(value: u32) -> Self {
        Self(value)
    }

    /// The length of `steps`, rounded half away from zero. Beyond the `i32` range: its end.
    #[must_use]
    pub fn to_position(self, steps: Steps) -> Position {
        let product = i128::from(steps.0) * i128::from(self.0);
        let rounded = div_round_half_away(product, i128::from(Self::UNITY.0));
        Position(saturate(rounded))
    }

    /// The steps nearest to `position`. `None` for a scaling of zero, which maps every step to one
    /// place.
    #[must_use]
    pub fn to_steps(self, position: Position) -> Option<Steps> {
        if self.0 == 0 {
            return None;
        }
        let product = i128::from(position.0) * i128::from(Self::UNITY.0);
        let rounded = div_round_half_away(product, i128::from(self.0));
        i64::try_from(rounded).ok().map(Steps)
    }
}

/// `divisor` is positive.
fn div_round_half_away(dividend: i128, divisor: i128) -> i128 {
    let half = divisor / 2;
    (if dividend < 0 { dividend - half } else { dividend + half }) / divisor
}

fn saturate(value: i128) -> i32 {
    i32::try_from(value).unwrap_or(if value < 0 { i32::MIN } else { i32::MAX })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(scaling: u32, steps: i64) -> i32 {
        Scaling::from_ten_millionths(scaling).to_position(Steps::new(steps)).hundredths_mm()
    }

    /// NM17x POS-04, POS-05: pitch in hundredths of a millimetre over steps per turn; A-54 rounds
    /// half away from zero.
    #[test]
    fn one_turn_is_one_pitch() {
        for (scaling, steps, expected) in [
            (1_736_111, 2_304, 400),
            (976_563, 4_096, 400),
            (10_000_000, 12_345, 12_345),
            (5_000_000, 1, 1),
            (5_000_000, -1, -1),
            (4_999_999, 1, 0),
            (0, 9_437_184, 0),
            (99_999_999, 9_437_183, 94_371_829),
            (99_999_999, 9_000_000_000, i32::MAX),
            (99_999_999, -9_000_000_000, i32::MIN),
        ] {
            assert_eq!(length(scaling, steps), expected, "{steps} steps at {scaling}");
        }
    }

    /// NM17x POS-09: the preset offset is kept in steps, to the nearest step.
    #[test]
    fn a_position_is_some_whole_number_of_steps() {
        let steps = |scaling, position| {
            Scaling::from_ten_millionths(scaling)
                .to_steps(Position::from_hundredths_mm(position))
                .map(Steps::count)
        };
        assert_eq!(steps(1_736_111, 400), Some(2_304));
        assert_eq!(steps(1_736_111, -1), Some(-6));
        assert_eq!(steps(10_000_000, 999_999), Some(999_999));
        assert_eq!(steps(1, i32::MIN), Some(-21_474_836_480_000_000));
        assert_eq!(steps(0, 1), None);
    }
}
