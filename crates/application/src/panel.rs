//! Keys and inputs without the bouncing of their contacts.

use crate::application::STEP;
use units::Duration;

/// A contact counts as changed when it read the same for this long (NM17x A-82: 16 to 20 ms).
const DEBOUNCE_TIME: Duration = Duration::from_millis(18);
const DEBOUNCE_STEPS: u64 = DEBOUNCE_TIME.as_micros() / STEP.as_micros();

/// One contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Contact {
    active: bool,
    steps_different: u64,
}

impl Contact {
    /// Takes one reading in.
    pub(crate) fn step(self, reads_active: bool) -> Self {
        if reads_active == self.active {
            Self { steps_different: 0, ..self }
        } else if self.steps_different + 1 < DEBOUNCE_STEPS {
            Self { steps_different: self.steps_different + 1, ..self }
        } else {
            Self { active: reads_active, steps_different: 0 }
        }
    }

    /// Whether it has been pressed since `before`.
    pub(crate) fn is_pressed_since(self, before: Self) -> bool {
        self.active && !before.active
    }

    /// Whether it is pressed.
    pub(crate) fn active(self) -> bool {
        self.active
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x A-82: shorter than 16 ms is nothing, longer than 20 ms is a press.
    #[test]
    fn a_contact_is_active_after_it_rested() {
        for (pattern, active) in [
            (&[true; 8][..], false),
            (&[true; 9], true),
            (
                &[true, true, true, true, false, true, true, true, true, true, true, true, true],
                false,
            ),
            (&[false; 20], false),
        ] {
            let contact = pattern.iter().fold(Contact::default(), |c, reads| c.step(*reads));
            assert_eq!(contact.active(), active, "{pattern:?}");
        }
    }
}
