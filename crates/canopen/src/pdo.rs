mod mapping;
mod tpdo;
mod transmission;

pub(crate) use tpdo::{TPDO_MAX, Tpdo};
pub(crate) use transmission::Transmission;
