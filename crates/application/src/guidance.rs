//! Which way the operator has to turn, and whether the setpoint is shown (NM17x DISP-04 to
//! DISP-07). Setpoint and actual value are those of the display, with the correction.

use lcd::Arrows;
use units::Position;

/// Object 0x2000:03.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ArrowMode {
    /// To the right while the actual value is too small.
    Up,
    /// To the left while the actual value is too small.
    Down,
    /// Both while the setpoint is not reached.
    Both,
    /// None.
    Off,
}

/// Object 0x2000:07.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HideSetpoint {
    /// Hidden when reached.
    WhenReached,
    /// Always shown.
    Never,
    /// Never shown, nor the arrows.
    Always,
}

/// What decides.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Params {
    /// Look of the arrows.
    pub(crate) arrow_mode: ArrowMode,
    /// When the setpoint is shown.
    pub(crate) hide_setpoint: HideSetpoint,
    /// Setpoint ± this much counts as reached (0x2003).
    pub(crate) tolerance: Position,
}

/// What the display has to show of the setpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Guidance {
    /// Whether the upper line shows the setpoint.
    pub(crate) setpoint_visible: bool,
    /// The arrows.
    pub(crate) arrows: Arrows,
    /// Whether the actual value lies in the tolerance window.
    pub(crate) reached: bool,
}

impl ArrowMode {
    /// The mode of a value of the object. Modes 4 and 5 differ from 2 and 3 by the loop only.
    pub(crate) fn from_raw(raw: u32) -> Self {
        match raw {
            1 => Self::Down,
            2 | 4 => Self::Both,
            3 | 5 => Self::Off,
            _ => Self::Up,
        }
    }
}

impl HideSetpoint {
    /// The mode of a value of the object.
    pub(crate) fn from_raw(raw: u32) -> Self {
        match raw {
            1 => Self::Never,
            2 => Self::Always,
            _ => Self::WhenReached,
        }
    }
}

/// The way from `actual` to `setpoint`.
pub(crate) fn guidance(setpoint: Position, actual: Position, params: &Params) -> Guidance {
    let lowest = setpoint.saturating_sub(params.tolerance);
    let highest = setpoint.saturating_add(params.tolerance);
    let reached = (lowest..=highest).contains(&actual);
    let (setpoint_visible, guided) = match params.hide_setpoint {
        HideSetpoint::WhenReached => (!reached, !reached),
        HideSetpoint::Never => (true, !reached),
        HideSetpoint::Always => (false, false),
    };
    let arrows = if guided { arrows(actual < setpoint, params.arrow_mode) } else { Arrows::NONE };
    Guidance { setpoint_visible, arrows, reached }
}

/// What to show while the actual value is not known: the setpoint, but no way to it.
pub(crate) fn astray(params: &Params) -> Guidance {
    let setpoint_visible = params.hide_setpoint != HideSetpoint::Always;
    Guidance { setpoint_visible, arrows: Arrows::NONE, reached: false }
}

fn arrows(too_small: bool, mode: ArrowMode) -> Arrows {
    match mode {
        ArrowMode::Up => Arrows { left: !too_small, right: too_small },
        ArrowMode::Down => Arrows { left: too_small, right: !too_small },
        ArrowMode::Both => Arrows { left: true, right: true },
        ArrowMode::Off => Arrows::NONE,
    }
}

#[cfg(test)]
mod tests {
    use std::string::String;

    use super::*;

    fn look(actual: i32, arrows: u32, hide: u32) -> String {
        let params = Params {
            arrow_mode: ArrowMode::from_raw(arrows),
            hide_setpoint: HideSetpoint::from_raw(hide),
            tolerance: Position::from_hundredths_mm(5),
        };
        let setpoint = Position::from_hundredths_mm(1_000);
        let guidance = guidance(setpoint, Position::from_hundredths_mm(actual), &params);
        let arrow = |on, arrow| if on { arrow } else { "" };
        String::from(if guidance.setpoint_visible { "10.00" } else { "" })
            + arrow(guidance.arrows.left, " <")
            + arrow(guidance.arrows.right, " >")
    }

    /// NM17x DISP-04, DISP-05, DISP-06, DISP-07, STAT-09 (the window).
    #[test]
    fn arrows_point_to_the_setpoint_until_it_is_reached() {
        for (actual, arrows, hide, expected) in [
            (0, 0, 0, "10.00 >"),
            (2_000, 0, 0, "10.00 <"),
            (994, 0, 0, "10.00 >"),
            (995, 0, 0, ""),
            (1_000, 0, 0, ""),
            (1_005, 0, 0, ""),
            (1_006, 0, 0, "10.00 <"),
            (0, 1, 0, "10.00 <"),
            (2_000, 1, 0, "10.00 >"),
            (0, 2, 0, "10.00 < >"),
            (2_000, 4, 0, "10.00 < >"),
            (0, 3, 0, "10.00"),
            (0, 5, 0, "10.00"),
            (0, 0, 1, "10.00 >"),
            (1_000, 0, 1, "10.00"),
            (1_000, 2, 1, "10.00"),
            (0, 0, 2, ""),
            (0, 2, 2, ""),
        ] {
            assert_eq!(
                look(actual, arrows, hide),
                expected,
                "{actual} arrows {arrows} hide {hide}"
            );
        }
    }
}
