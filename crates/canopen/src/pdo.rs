mod communication;
mod configuration;
mod entry;
mod field;
mod mapping;
mod rpdo;
mod rpdos;
mod slots;
mod target;
mod tpdo;
mod tpdos;
mod transmission;

pub(crate) use configuration::check;
pub use mapping::Mapped;
pub(crate) use rpdos::Rpdos;
pub(crate) use target::Target;
pub(crate) use tpdos::Tpdos;

/// PDOs of a device in each direction.
pub(crate) const PDO_MAX: usize = 4;

/// The communication parameter of the first PDO of each direction, and how far behind it the
/// mapping lies (CiA 301, sections 7.5.2.35 to 7.5.2.38).
pub(crate) const RECEIVE: u16 = 0x1400;
pub(crate) const TRANSMIT: u16 = 0x1800;
const MAPPING: u16 = 0x200;

/// Which way a PDO goes, as the device sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}

impl Direction {
    /// That of the PDO with this object, one from 0x1400 to 0x1BFF.
    const fn of(index: u16) -> Self {
        if index < TRANSMIT { Self::Receive } else { Self::Transmit }
    }
}
