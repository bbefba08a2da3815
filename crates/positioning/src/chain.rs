//! The position chain (NM17x POS-01 to POS-13).
//!
//! ```text
//! raw steps ─ counting direction ─ + preset offset ─ scaling ─┬─ position value (0x6004)
//!                                                             └─ + correction ─ display
//! ```
//!
//! The preset offset is kept in steps (POS-09) and added before the scaling. That is the sum of
//! POS-06 with one rounding instead of two: the position grows with the steps without a flaw, and a
//! later change of the scaling scales the offset along (A-56).
//!
//! Setpoint and actual value are compared where the operator sees them, with the correction in
//! both: in the actual value as it is now, in the setpoint as it was when the setpoint was set
//! (A-53).

use units::{Position, Scaling, Steps};

/// What lies between steps and position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Params {
    /// Which way the position counts.
    pub direction: CountingDirection,
    /// Length of a step.
    pub scaling: Scaling,
    /// Steps added after the counting direction.
    pub preset_offset: Steps,
    /// What the display shows on top of the position.
    pub correction: Correction,
}

/// Which turn of the shaft, seen on its end, counts up (0x2000:02).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CountingDirection {
    /// Clockwise.
    #[default]
    ClockwiseUp,
    /// Counter-clockwise.
    ClockwiseDown,
}

/// The actual value correction (0x2010), and whether it is switched on (0x2000:06).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Correction {
    /// Whatever the correction is, it has no effect (POS-13).
    Off,
    /// Added to actual value and setpoint.
    On(Position),
}

/// A position at which the axis shall stand, with the correction of the moment it was set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setpoint {
    sent: Position,
    correction: Position,
}

/// Why a preset has no offset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetError {
    /// Every number of steps is the same position (A-54).
    ScalingIsZero,
    /// The offset does not fit into the 32 bits it is stored in. It takes a scaling below 0.0005
    /// hundredths of a millimetre per step.
    OffsetTooLarge,
}

impl Params {
    /// The position of the axis without the correction: object 0x6004 (POS-07, A-50). True beyond
    /// the displayable range too (A-58).
    #[must_use]
    pub fn position(&self, raw: Steps) -> Position {
        self.scaling.to_position(self.counted(raw) + self.preset_offset)
    }

    /// The actual value on the display, with the correction (POS-06).
    #[must_use]
    pub fn displayed(&self, raw: Steps) -> Position {
        self.position(raw).saturating_add(self.correction.length())
    }

    /// The preset offset with which the display shows `preset` while the sensor stands at `raw`,
    /// to half a step (POS-08, POS-09, A-51).
    ///
    /// # Errors
    /// When there is no such offset.
    pub fn preset(&self, raw: Steps, preset: Position) -> Result<Steps, PresetError> {
        let uncorrected = preset.saturating_sub(self.correction.length());
        let wanted = self.scaling.to_steps(uncorrected).ok_or(PresetError::ScalingIsZero)?;
        let offset = wanted - self.counted(raw);
        match i32::try_from(offset.count()) {
            Ok(_) => Ok(offset),
            Err(_) => Err(PresetError::OffsetTooLarge),
        }
    }

    fn counted(&self, raw: Steps) -> Steps {
        match self.direction {
            CountingDirection::ClockwiseUp => raw,
            CountingDirection::ClockwiseDown => -raw,
        }
    }
}

impl Correction {
    /// What is added: zero while it is off.
    #[must_use]
    pub const fn length(self) -> Position {
        match self {
            Self::Off => Position::ZERO,
            Self::On(length) => length,
        }
    }
}

impl Setpoint {
    /// A setpoint as sent, set under this correction (POS-11).
    #[must_use]
    pub const fn new(sent: Position, correction: Correction) -> Self {
        Self { sent, correction: correction.length() }
    }

    /// The setpoint without the correction, as it was sent.
    #[must_use]
    pub const fn sent(&self) -> Position {
        self.sent
    }

    /// The setpoint on the display (POS-12), without the correction while that is off (POS-13).
    #[must_use]
    pub const fn displayed(&self, correction: Correction) -> Position {
        match correction {
            Correction::Off => self.sent,
            Correction::On(_) => self.sent.saturating_add(self.correction),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const AS_DELIVERED: Params = Params {
        direction: CountingDirection::ClockwiseUp,
        scaling: Scaling::from_ten_millionths(1_736_111),
        preset_offset: Steps::ZERO,
        correction: Correction::On(Position::ZERO),
    };

    fn hmm(value: i32) -> Position {
        Position::from_hundredths_mm(value)
    }

    /// NM17x POS-01, POS-03, POS-04: direction and scaling, rounded once.
    #[test]
    fn steps_become_a_position() {
        for (direction, scaling, raw, expected) in [
            (CountingDirection::ClockwiseUp, 1_736_111, 2_304, 400),
            (CountingDirection::ClockwiseDown, 1_736_111, 2_304, -400),
            (CountingDirection::ClockwiseUp, 1_736_111, -23_040, -4_000),
            (CountingDirection::ClockwiseUp, 10_000_000, 123, 123),
            (CountingDirection::ClockwiseDown, 5_000_000, 1, -1),
            (CountingDirection::ClockwiseUp, 0, 9_437_183, 0),
            (CountingDirection::ClockwiseUp, 99_999_999, 9_437_183, 94_371_829),
        ] {
            let scaling = Scaling::from_ten_millionths(scaling);
            let params = Params { direction, scaling, ..AS_DELIVERED };
            assert_eq!(params.position(Steps::new(raw)), hmm(expected), "{params:?} {raw}");
        }
    }

    /// NM17x POS-06, POS-07, POS-10, POS-13: the display has the correction, 0x6004 has not.
    #[test]
    fn only_the_display_is_corrected() {
        for (correction, position, displayed) in [
            (Correction::Off, 400, 400),
            (Correction::On(hmm(0)), 400, 400),
            (Correction::On(hmm(-6_250)), 400, -5_850),
            (Correction::On(hmm(999_999)), 400, 1_000_399),
        ] {
            let params = Params { correction, ..AS_DELIVERED };
            let raw = Steps::new(2_304);
            assert_eq!(params.position(raw), hmm(position), "{correction:?}");
            assert_eq!(params.displayed(raw), hmm(displayed), "{correction:?}");
        }
    }

    /// NM17x POS-08, OD-6003-1: the display shows the preset, 0x6004 the preset less the correction.
    #[test]
    fn a_preset_includes_the_correction() {
        let params = Params { correction: Correction::On(hmm(-6_250)), ..AS_DELIVERED };
        let raw = Steps::new(98_765);
        let preset_offset = params.preset(raw, hmm(20_000)).unwrap();
        let params = Params { preset_offset, ..params };
        assert_eq!(params.displayed(raw), hmm(20_000));
        assert_eq!(params.position(raw), hmm(26_250));
    }

    /// NM17x POS-09: the offset is a number of unscaled steps. A-54: no preset without a scaling.
    #[test]
    fn the_offset_is_in_steps() {
        for (scaling, raw, preset, expected) in [
            (1_736_111, 0, 400, Ok(2_304)),
            (1_736_111, 2_304, 0, Ok(-2_304)),
            (10_000_000, 5, -99_999, Ok(-100_004)),
            (0, 0, 400, Err(PresetError::ScalingIsZero)),
            (1, 0, 999_999, Err(PresetError::OffsetTooLarge)),
        ] {
            let scaling = Scaling::from_ten_millionths(scaling);
            let offset = Params { scaling, ..AS_DELIVERED }.preset(Steps::new(raw), hmm(preset));
            assert_eq!(offset.map(Steps::count), expected, "{scaling:?} {raw} {preset}");
        }
    }

    /// NM17x POS-11, POS-12, POS-13: 262.50 with a correction of −62.50 is shown as 200.00, and
    /// stays there when the correction changes; the correction switched off is in nothing.
    #[test]
    fn a_setpoint_keeps_the_correction_it_was_set_with() {
        let on = |length| Correction::On(hmm(length));
        for (when_set, now, expected) in [
            (on(-6_250), on(-6_250), 20_000),
            (on(-6_250), on(1_000), 20_000),
            (on(-6_250), Correction::Off, 26_250),
            (Correction::Off, Correction::Off, 26_250),
            (Correction::Off, on(-6_250), 26_250),
        ] {
            let setpoint = Setpoint::new(hmm(26_250), when_set);
            assert_eq!(setpoint.displayed(now), hmm(expected), "set {when_set:?}, now {now:?}");
            assert_eq!(setpoint.sent(), hmm(26_250));
        }
    }

    fn any_params() -> impl Strategy<Value = Params> {
        (any::<bool>(), 0_u32..100_000_000, any::<i32>(), any::<Option<i32>>()).prop_map(
            |(up, scaling, offset, correction)| Params {
                direction: if up {
                    CountingDirection::ClockwiseUp
                } else {
                    CountingDirection::ClockwiseDown
                },
                scaling: Scaling::from_ten_millionths(scaling),
                preset_offset: Steps::new(offset.into()),
                correction: correction
                    .map_or(Correction::Off, |length| Correction::On(hmm(length))),
            },
        )
    }

    proptest! {
        /// NM17x POS-08, POS-09 with A-56: off by max(1, factor/2) at most, a half counting as a
        /// whole last digit.
        #[test]
        fn the_actual_value_equals_the_preset(
            params in any_params(),
            scaling in 6_000_u32..100_000_000,
            raw in -9_437_184_i64..9_437_184,
            preset in -99_999_i32..=999_999,
            correction in -99_999_i32..=999_999,
        ) {
            let params = Params {
                scaling: Scaling::from_ten_millionths(scaling),
                correction: Correction::On(hmm(correction)),
                ..params
            };
            let raw = Steps::new(raw);
            let preset_offset = params.preset(raw, hmm(preset)).unwrap();
            let shown = Params { preset_offset, ..params }.displayed(raw).hundredths_mm();
            let allowed = scaling.div_ceil(20_000_000).max(1);
            prop_assert!(shown.abs_diff(preset) <= allowed, "{} for {}", shown, preset);
        }

        /// NM17x POS-03: the position follows the counting direction and never turns back.
        #[test]
        fn the_position_is_monotonic(params in any_params(), raw: i32, further in 0_i32..10_000) {
            let from = params.position(Steps::new(raw.into()));
            let to = params.position(Steps::new(i64::from(raw) + i64::from(further)));
            let ordered = match params.direction {
                CountingDirection::ClockwiseUp => from <= to,
                CountingDirection::ClockwiseDown => to <= from,
            };
            prop_assert!(ordered);
        }

        #[test]
        fn no_number_is_too_large(params in any_params(), raw: i64, offset: i64, preset: i32) {
            let params = Params { preset_offset: Steps::new(offset), ..params };
            let raw = Steps::new(raw);
            let _ = (params.position(raw), params.displayed(raw), params.preset(raw, hmm(preset)));
        }
    }
}
