mod mapping;
mod rpdo;
mod tpdo;
mod transmission;

pub(crate) use rpdo::{RPDO_MAX, Received, Reception, Rpdo};
pub(crate) use tpdo::{TPDO_MAX, Tpdo};
pub(crate) use transmission::Transmission;
