mod abort;
mod block;
mod message;
mod objects;
mod segments;
mod server;
mod transfer;

pub use abort::AbortCode;
pub(crate) use objects::{Effect, Objects};
pub(crate) use server::Server;
