use crate::settings::{Settings, Trigger};

/// When a transmit PDO goes out (CiA 301, section 7.5.2.37, sub-index 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Transmission {
    /// With every n-th SYNC, 1 to 240.
    Synchronous { every: u8 },
    /// On an event.
    Event(Trigger),
    /// Never: a transmission type the stack does not know.
    Never,
}

impl Transmission {
    /// The meaning of a transmission type in this product.
    pub(super) fn new(transmission_type: u32, settings: &Settings) -> Self {
        match u8::try_from(transmission_type) {
            Ok(every @ 1..=240) => Self::Synchronous { every },
            Ok(254) => Self::Event(settings.type_254),
            Ok(255) => Self::Event(settings.type_255),
            Ok(0 | 241..=253) | Err(_) => Self::Never,
        }
    }

    /// Whether the stack knows the transmission type.
    pub(crate) const fn is_known(transmission_type: u32) -> bool {
        matches!(transmission_type, 1..=240 | 254 | 255)
    }

    /// Whether a change of the mapped data is an event.
    pub(super) const fn follows_changes(self) -> bool {
        match self {
            Self::Event(Trigger::Change | Trigger::ChangeOrTimer) => true,
            Self::Event(Trigger::Timer) | Self::Synchronous { .. } | Self::Never => false,
        }
    }

    /// Whether the event timer is an event.
    pub(super) const fn follows_timer(self) -> bool {
        match self {
            Self::Event(Trigger::Timer | Trigger::ChangeOrTimer) => true,
            Self::Event(Trigger::Change) | Self::Synchronous { .. } | Self::Never => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x PDO-02, PDO-03, PDO-04; decision A-11: a type is writable if and only if it means
    /// something.
    #[test]
    fn every_known_type_means_something() {
        for transmission_type in 0..=256 {
            let transmission = Transmission::new(transmission_type, &Settings::CIA_301);
            let known = Transmission::is_known(transmission_type);
            assert_eq!(known, transmission != Transmission::Never, "{transmission_type}");
        }
    }
}
