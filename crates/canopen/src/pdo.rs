mod configuration;
mod entry;
mod mapping;
mod rpdo;
mod rpdos;
mod span;
mod target;
mod tpdo;
mod tpdos;
mod transmission;

pub(crate) use configuration::check;
pub use mapping::Mapped;
pub(crate) use rpdos::{RPDO_MAX, Rpdos};
pub(crate) use target::Target;
pub(crate) use tpdos::Tpdos;

/// Which way a PDO goes, as the device sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Direction {
    Receive,
    Transmit,
}
