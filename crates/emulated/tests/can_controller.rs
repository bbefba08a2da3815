//! The bench held to known answers: the CAN controller, by its registers, against the bus.
//!
//! No processor and no firmware: the tests write and read registers as RM0090, chapter 32 describes
//! them. [`rig::Rig`] is the one place that knows the model's interface.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "the helpers of a test fail it by panicking"
)]

#[path = "can_controller/errors.rs"]
mod errors;
#[path = "can_controller/fifos.rs"]
mod fifos;
#[path = "can_controller/filters.rs"]
mod filters;
#[path = "can_controller/modes.rs"]
mod modes;
#[path = "can_controller/properties.rs"]
mod properties;
#[path = "can_controller/rig.rs"]
mod rig;
#[path = "can_controller/timing.rs"]
mod timing;
#[path = "can_controller/transmission.rs"]
mod transmission;
