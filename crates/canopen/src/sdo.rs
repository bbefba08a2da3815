mod abort;
mod objects;
mod request;
mod response;
mod server;

pub use abort::AbortCode;
pub(crate) use objects::Objects;
pub(crate) use request::Request;
pub(crate) use server::Server;
