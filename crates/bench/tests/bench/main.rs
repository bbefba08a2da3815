//! The bench as its clients and users meet it, on devices that do nothing but send.

#[cfg(test)]
mod any_bytes;
#[cfg(test)]
mod command_line;
#[cfg(test)]
mod control;
#[cfg(test)]
mod gateways;
#[cfg(test)]
mod senders;
#[cfg(test)]
mod state;
