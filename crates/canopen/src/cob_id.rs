use core::num::NonZeroU8;

use crate::frame::CanId;

/// A node-ID, 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(NonZeroU8);

impl NodeId {
    /// The node-ID `id`. `None` for 0 and above 127.
    #[must_use]
    pub const fn new(id: u8) -> Option<Self> {
        match NonZeroU8::new(id) {
            Some(id) if id.get() <= 127 => Some(Self(id)),
            Some(_) | None => None,
        }
    }

    /// The node-ID as a number, 1 to 127.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0.get()
    }
}

/// The broadcast object of the network management (CiA 301, section 7.2.8).
pub(crate) const NMT: CanId = CanId::from_low_bits(0);

/// The peer-to-peer objects of the pre-defined connection set (CiA 301, section 7.3.3): their
/// identifier is a function code plus the node-ID.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    Emergency,
    SdoResponse,
    SdoRequest,
    ErrorControl,
}

impl Service {
    /// Whether a node has this object with the identifier `id`.
    pub(crate) fn has(self, id: CanId) -> bool {
        const NODE_ID: u16 = 0x7F;
        id.get() & !NODE_ID == self.function_code() && id.get() & NODE_ID != 0
    }

    /// The identifier of this object at a node.
    pub(crate) const fn id(self, node_id: NodeId) -> CanId {
        CanId::from_low_bits(self.function_code() as u32 + node_id.get() as u32)
    }

    const fn function_code(self) -> u16 {
        match self {
            Self::Emergency => 0x080,
            Self::SdoResponse => 0x580,
            Self::SdoRequest => 0x600,
            Self::ErrorControl => 0x700,
        }
    }
}

/// The 32 bits of a COB-ID object: an identifier and three flags (CiA 301, sections 7.5.2.5 and
/// 7.5.2.37).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CobId(u32);

impl CobId {
    const INVALID: u32 = 1 << 31;
    const GENERATE: u32 = 1 << 30;
    const NO_REMOTE: u32 = 1 << 30;
    const CONSUME: u32 = 1 << 31;
    const EXTENDED: u32 = 1 << 29;

    pub(crate) const fn from_raw(raw: u32) -> Self {
        Self(raw)
    }

    pub(crate) const fn can_id(self) -> CanId {
        CanId::from_low_bits(self.0)
    }

    /// The identifier, unless bit 31 says that the PDO or the emergency message does not exist.
    pub(crate) const fn valid(self) -> Option<CanId> {
        if self.0 & Self::INVALID == 0 { Some(self.can_id()) } else { None }
    }

    /// Whether what exists with both would change its identifier.
    pub(crate) fn moves(self, before: Self) -> bool {
        self.valid().is_some() && before.valid().is_some() && self.can_id() != before.can_id()
    }

    /// Whether remote frames may ask for the PDO: bit 30 is not set.
    pub(crate) const fn allows_remote(self) -> bool {
        self.0 & Self::NO_REMOTE == 0
    }

    /// Whether it has no identifier of 29 bits.
    pub(crate) const fn has_eleven_bits(self) -> bool {
        self.0 & Self::EXTENDED == 0
    }

    /// Whether a PDO may have it: eleven bits, and not one of the restricted identifiers as long as
    /// the PDO exists.
    pub(crate) fn suits_pdo(self) -> bool {
        self.has_eleven_bits() && !self.valid().is_some_and(is_restricted)
    }

    /// Whether emergency messages may have it: eleven bits, and not one of the restricted
    /// identifiers (CiA 301, section 7.5.2.17).
    pub(crate) fn suits_emergency(self) -> bool {
        self.0 & (Self::EXTENDED | Self::GENERATE) == 0 && !is_restricted(self.can_id())
    }

    /// Whether the device produces it: SYNC or TIME.
    pub(crate) const fn generates(self) -> bool {
        self.0 & Self::GENERATE != 0
    }

    /// The identifier of TIME, if the device consumes it (bit 31); else none.
    pub(crate) const fn consumed(self) -> CanId {
        if self.0 & Self::CONSUME != 0 { self.can_id() } else { CanId::NONE }
    }

    /// Whether a TIME consumer may have it: one that SYNC may have, too, and not asked to produce.
    pub(crate) fn suits_consumer(self) -> bool {
        self.suits_sync() && !self.generates()
    }

    /// Whether SYNC may have it: eleven bits, and not one of the restricted identifiers.
    pub(crate) fn suits_sync(self) -> bool {
        self.has_eleven_bits() && !is_restricted(self.can_id())
    }
}

/// The identifiers no configurable object may use (CiA 301, section 7.3.5): 0x000 to 0x07F, 0x101 to
/// 0x180, 0x581 to 0x5FF, 0x601 to 0x67F, 0x6E0 to 0x6FF and 0x701 to 0x7FF, by function code.
fn is_restricted(id: CanId) -> bool {
    let node_id = id.get() & 0x7F;
    match id.get() >> 7 {
        0b0000 | 0b1111 => true,
        0b0010 | 0b1011 | 0b1100 | 0b1110 => node_id > 0,
        0b0011 => node_id == 0,
        0b1101 => node_id >= 0x60,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NM17x GEN-04.
    #[test]
    fn the_connection_set_follows_the_node_id() {
        let node_id = NodeId::new(127).unwrap();
        assert_eq!(Service::SdoResponse.id(node_id).get(), 0x5FF);
        assert_eq!(Service::SdoRequest.id(node_id).get(), 0x67F);
        assert_eq!(Service::ErrorControl.id(node_id).get(), 0x77F);
        assert_eq!((NodeId::new(0), NodeId::new(128)), (None, None));
    }

    /// Decisions.
    #[test]
    fn restricted_identifiers_and_wrong_flags_are_refused() {
        for (raw, pdo, sync) in [
            (0x0000_0080, true, true),
            (0x8000_0080, true, true),
            (0x4000_0181, true, true),
            (0xC000_057F, true, true),
            (0x2000_0181, false, false),
            (0x0000_0000, false, false),
            (0x8000_0000, true, false),
            (0x0000_0180, false, false),
            (0x0000_0581, false, false),
            (0x0000_0600, true, true),
            (0x0000_067F, false, false),
            (0x0000_0700, true, true),
            (0x0000_07E4, false, false),
        ] {
            let cob_id = CobId::from_raw(raw);
            assert_eq!((cob_id.suits_pdo(), cob_id.suits_sync()), (pdo, sync), "{raw:#x}");
        }
    }
}
