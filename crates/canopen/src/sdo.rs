mod abort;
mod block;
mod message;
mod objects;
mod server;

pub use abort::AbortCode;
pub(crate) use message::Message;
pub(crate) use objects::{Effect, Objects};
pub(crate) use server::Server;
