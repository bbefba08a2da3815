//! Records on a simulated NOR flash: what is kept, what it costs, and what a loss of supply does.
#![expect(
    clippy::cast_possible_truncation,
    reason = "the simulated flash is smaller than every integer type used for it"
)]
#![expect(
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a test fails by panicking, in its helpers, too"
)]

mod nor;
mod power;
mod records;
