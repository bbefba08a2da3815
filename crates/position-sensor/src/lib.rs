//! A position sensor with one controller, minus its pins: the AP04 and the encoders as a master
//! meets them on the bus.
//!
//! [`Sensor`] has all objects of its [`Model`], keeps those that survive without supply, and
//! measures. Display, keys, LEDs, battery, switches, positioning by target value, the external
//! heartbeat of the AP04 and the event triggers of the encoders are no part of it: their objects
//! hold what a master wrote.
//!
//! ```text
//! controller ── handle_frame ──→ ┌────────┐ ←── handle_steps ── shaft
//!            ←─ take_transmit ── │ Sensor │ ─── poll_event ───→ memory, restart
//! clock ─────── handle_timeout → └────────┘
//! ```
#![no_std]

mod ap04;
mod bit_timing;
mod encoder;
mod family;
mod model;
mod sensor;

pub use model::{MODELS, Model};
pub use sensor::{Event, Group, Record, Sensor};
