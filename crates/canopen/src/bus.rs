use crate::settings::{BusRules, Emergency};

/// The CAN controller's standing on the bus (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BusState {
    /// Error active, no warning.
    Active,
    /// An error counter has reached 96.
    Warning,
    /// Error passive: an error counter has reached 128.
    Passive,
    /// Bus-off: the transmit error counter has reached 256.
    Off,
}

impl BusState {
    /// Whether the controller cannot tell its errors any more.
    pub(crate) const fn is_impaired(self) -> bool {
        match self {
            Self::Active | Self::Warning => false,
            Self::Passive | Self::Off => true,
        }
    }
}

impl BusRules {
    /// What is to be said about a change.
    pub(crate) const fn message(&self, from: BusState, to: BusState) -> Option<Emergency> {
        match (from, to) {
            (BusState::Off, BusState::Active | BusState::Warning | BusState::Passive) => {
                self.recovered
            }
            (BusState::Active, BusState::Warning) => self.warning,
            (BusState::Active | BusState::Warning | BusState::Passive, BusState::Passive) => {
                self.passive
            }
            (BusState::Warning | BusState::Passive, BusState::Active | BusState::Warning)
            | (BusState::Active, BusState::Active)
            | (_, BusState::Off) => None,
        }
    }
}
