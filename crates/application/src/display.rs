//! The picture: data of the device for five seconds, then setpoint and actual value.

use lcd::{Arrows, Line, View};
use units::{Duration, Instant, Position};

use crate::guidance::Guidance;

/// Phases after power-on (NM17x BOOT-01).
const DESIGNATION_UNTIL: Duration = Duration::from_millis(2_500);
const NODE_ID_UNTIL: Duration = Duration::from_millis(5_000);
/// How long an error, then the normal content, is shown in turns (NM17x ERR-03, A-101).
const ERROR_HALF_PERIOD: Duration = Duration::from_millis(1_000);
/// A position must rest this long to be shown rounded (NM17x DISP-09).
const ROUNDED_AFTER: Duration = Duration::from_millis(3_000);
/// Digits of a node-ID at least (NM17x A-104).
const NODE_ID_DIGITS_MIN: usize = 2;
/// Digits behind the point of a version.
const VERSION_DECIMALS: usize = 2;

/// Settings of the display.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Settings {
    /// In what lengths are shown (0x2001).
    pub(crate) unit: LengthUnit,
    /// How the device is mounted (0x2000:05).
    pub(crate) mounting: Mounting,
    /// How many digits behind the point are shown (0x2005:03).
    pub(crate) last_digit: LastDigit,
    /// Whether a reached setpoint is shown in place of the actual value (0x2000:04).
    pub(crate) rounding: Rounding,
}

/// Object 0x2001.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LengthUnit {
    /// Hundredths of a millimetre.
    Millimetre,
    /// Thousandths of an inch.
    Inch,
}

/// Object 0x2000:05.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mounting {
    /// Display above, keys below.
    Normal,
    /// The other way round.
    Inverted,
}

/// Object 0x2005:03.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum LastDigit {
    /// On.
    Shown,
    /// Off, in both lines.
    Hidden,
}

/// Object 0x2000:04, without effect where the setpoint is never shown (NM17x DISP-10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rounding {
    /// The actual value is shown as it is.
    Off,
    /// In the window and at rest the setpoint is shown instead.
    On,
}

/// Since when the display could be showing the same: the actual value rests and no key is pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Rest {
    position: Option<Position>,
    since: Instant,
}

/// What a device tells of itself at power-on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Identity {
    /// Name of the type.
    pub(crate) designation: &'static str,
    /// Version of the CAN interface controller in hundredths, once it said so.
    pub(crate) firmware: Option<u16>,
    /// Node-ID, once the CAN interface controller said so.
    pub(crate) node_id: Option<u8>,
}

/// What a device in operation shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Operation {
    /// With the correction.
    pub(crate) setpoint: Position,
    /// With the correction; `None` while the sensor says nothing.
    pub(crate) actual: Option<Position>,
    /// Where to turn.
    pub(crate) guidance: Guidance,
    /// The gravest error.
    pub(crate) error: Option<&'static [u8]>,
    /// How long it has been at rest.
    pub(crate) rest: Rest,
    /// What else is to be shown.
    pub(crate) notice: Notice,
}

/// What the display shows besides, or instead.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Notice {
    /// Nothing.
    None,
    /// A node-ID on offer in the place of the setpoint (NM17x ADDR-08, DISP-15).
    Offer(u8),
    /// A text of the master's: upper and lower line (NM17x DISP-17).
    Message(Line, Line),
    /// The own node-ID in the lower line and nothing else (NM17x DISP-16).
    NodeId,
}

impl Settings {
    /// The view of a device that has been on since the start of the clock.
    pub(crate) fn view(&self, now: Instant, identity: &Identity, operation: &Operation) -> View {
        let on_since = now.since(Instant::ZERO);
        let view = if on_since < DESIGNATION_UNTIL {
            designation(identity)
        } else if on_since < NODE_ID_UNTIL {
            node_id(identity)
        } else {
            match operation.notice {
                Notice::None => self.operation(now, operation),
                Notice::Offer(offered) => View {
                    upper: node_id_line(offered),
                    arrows: Arrows::NONE,
                    ..self.operation(now, operation)
                },
                Notice::Message(upper, lower) => View { upper, lower, arrows: Arrows::NONE },
                Notice::NodeId => node_id(identity),
            }
        };
        self.mounted(view)
    }

    /// The view of a pair of controllers whose images do not belong together. Fixed, because
    /// nothing the other one says can be trusted.
    pub(crate) fn mismatch(&self) -> View {
        let view =
            View { upper: Line::text(b"ERROR"), lower: Line::text(b"PAIR"), arrows: Arrows::NONE };
        self.mounted(view)
    }

    fn operation(&self, now: Instant, operation: &Operation) -> View {
        let setpoint = self.length(operation.setpoint);
        let normal = if operation.guidance.setpoint_visible { setpoint } else { Line::BLANK };
        let upper = match operation.error {
            Some(text) if shows_error(now) => Line::text(text),
            Some(_) | None => normal,
        };
        let lower = match operation.actual {
            Some(_) if self.rounds(now, operation) => setpoint,
            Some(actual) => self.length(actual),
            None => Line::text(b"------"),
        };
        View { upper, lower, arrows: operation.guidance.arrows }
    }

    fn rounds(&self, now: Instant, operation: &Operation) -> bool {
        match self.rounding {
            Rounding::Off => false,
            Rounding::On => operation.guidance.reached && operation.rest.lasted(now, ROUNDED_AFTER),
        }
    }

    fn length(&self, length: Position) -> Line {
        let line = match self.unit {
            LengthUnit::Millimetre => Line::number(length.hundredths_mm(), 2),
            LengthUnit::Inch => Line::number(thousandths_inch(length), 3),
        };
        match self.last_digit {
            LastDigit::Shown => line,
            LastDigit::Hidden => line.without_last_digit(),
        }
    }

    fn mounted(&self, view: View) -> View {
        match self.mounting {
            Mounting::Normal => view,
            Mounting::Inverted => view.upside_down(),
        }
    }
}

impl Rest {
    /// Takes in the actual value; `disturbed` by a key starts the time anew.
    pub(crate) fn step(self, now: Instant, position: Option<Position>, disturbed: bool) -> Self {
        if disturbed || position != self.position { Self { position, since: now } } else { self }
    }

    fn lasted(&self, now: Instant, time: Duration) -> bool {
        now.since(self.since) >= time
    }
}

fn designation(identity: &Identity) -> View {
    let version = |firmware: u16| Line::number(firmware.into(), VERSION_DECIMALS);
    View {
        upper: Line::text(identity.designation.as_bytes()),
        lower: identity.firmware.map_or(Line::BLANK, version),
        arrows: Arrows::NONE,
    }
}

fn node_id(identity: &Identity) -> View {
    View {
        upper: Line::BLANK,
        lower: identity.node_id.map_or(Line::BLANK, node_id_line),
        arrows: Arrows::NONE,
    }
}

fn node_id_line(node_id: u8) -> Line {
    Line::whole(node_id.into(), NODE_ID_DIGITS_MIN)
}

fn shows_error(now: Instant) -> bool {
    (now.as_micros() / ERROR_HALF_PERIOD.as_micros()).is_multiple_of(2)
}

/// Hundredths of a millimetre over 2.54, rounded half away from zero (NM17x A-100).
fn thousandths_inch(length: Position) -> i32 {
    let dividend = i64::from(length.hundredths_mm()) * 100;
    let half = if dividend < 0 { -127 } else { 127 };
    i32::try_from((dividend + half) / 254).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x DISP-13, A-100.
    #[test]
    fn lengths_in_inch_have_three_decimals() {
        for (hundredths_mm, expected) in [
            (254, 100),
            (2_540, 1_000),
            (-2_540, -1_000),
            (1, 0),
            (2, 1),
            (-2, -1),
            (127, 50),
            (381, 150),
            (999_999, 393_700),
            (-99_999, -39_370),
            (i32::MAX, 845_466_003),
            (i32::MIN, -845_466_003),
        ] {
            let length = Position::from_hundredths_mm(hundredths_mm);
            assert_eq!(thousandths_inch(length), expected, "{hundredths_mm}");
        }
    }
}
