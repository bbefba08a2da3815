use crate::settings::{PdoRules, SyncDivision, Trigger};

/// When a transmit PDO goes out (CiA 301, section 7.5.2.37, sub-index 2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transmission {
    /// With a SYNC after an event: type 0.
    SyncAfterEvent,
    /// With every n-th SYNC: types 1 to 240.
    EverySync { nth: u8 },
    /// On a remote frame, as it was at the last SYNC: type 252.
    RemoteFromSync,
    /// On a remote frame: type 253.
    Remote,
    /// On an event: types 254 and 255.
    Event(Trigger),
    /// Never: a transmission type the stack does not know.
    Never,
}

impl Transmission {
    /// The meaning of a transmission type in this product.
    #[inline(never)]
    pub(super) fn new(transmission_type: u32, rules: &PdoRules) -> Self {
        match u8::try_from(transmission_type) {
            Ok(0) => Self::SyncAfterEvent,
            Ok(nth @ 1..=240) => Self::EverySync {
                nth: match rules.sync_division {
                    SyncDivision::EveryNth => nth,
                    SyncDivision::None => 1,
                },
            },
            Ok(252) => Self::RemoteFromSync,
            Ok(253) => Self::Remote,
            Ok(254) => Self::Event(rules.type_254),
            Ok(255) => Self::Event(rules.type_255),
            Ok(241..=251) | Err(_) => Self::Never,
        }
    }

    /// Whether the stack knows the transmission type.
    pub(super) const fn is_known(transmission_type: u32) -> bool {
        matches!(transmission_type, 0..=240 | 252..=255)
    }

    /// Whether it goes out with a SYNC.
    pub(super) const fn follows_sync(self) -> bool {
        match self {
            Self::SyncAfterEvent | Self::EverySync { .. } => true,
            Self::RemoteFromSync | Self::Remote | Self::Event(_) | Self::Never => false,
        }
    }

    /// Whether an event lets it go out, at once or with a SYNC.
    pub(super) const fn has_events(self) -> bool {
        match self {
            Self::SyncAfterEvent | Self::Event(_) => true,
            Self::EverySync { .. } | Self::RemoteFromSync | Self::Remote | Self::Never => false,
        }
    }

    /// Whether a change of the mapped data is an event.
    pub(super) const fn follows_changes(self) -> bool {
        match self {
            Self::SyncAfterEvent | Self::Event(Trigger::Change | Trigger::ChangeOrTimer) => true,
            Self::Event(Trigger::Timer)
            | Self::EverySync { .. }
            | Self::RemoteFromSync
            | Self::Remote
            | Self::Never => false,
        }
    }

    /// Whether the event timer is an event.
    pub(super) const fn follows_timer(self) -> bool {
        match self {
            Self::Event(Trigger::Timer | Trigger::ChangeOrTimer) => true,
            Self::Event(Trigger::Change)
            | Self::SyncAfterEvent
            | Self::EverySync { .. }
            | Self::RemoteFromSync
            | Self::Remote
            | Self::Never => false,
        }
    }

    /// Whether it goes out on remote frames alone.
    pub(super) const fn is_remote_only(self) -> bool {
        match self {
            Self::RemoteFromSync | Self::Remote => true,
            Self::SyncAfterEvent | Self::EverySync { .. } | Self::Event(_) | Self::Never => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    /// NM17x PDO-02, PDO-03, PDO-04: a type is writable if and only if it means something.
    #[test]
    fn every_known_type_means_something() {
        for transmission_type in 0..=256 {
            let transmission = Transmission::new(transmission_type, &Settings::CIA_301.pdo);
            let known = Transmission::is_known(transmission_type);
            assert_eq!(known, transmission != Transmission::Never, "{transmission_type}");
        }
    }
}
