mod abort;
mod block;
mod objects;
mod request;
mod response;
mod server;

pub use abort::AbortCode;
pub(crate) use objects::Objects;
pub(crate) use server::Server;
