//! From the bits of the sensor to the position that a device shows and reports.
//!
//! A read of the sensor passes, in this order, through [`ssi`] (bits of the line to a word),
//! [`encoder`] (word to steps of the shaft), [`filter`] (disturbed reads are dropped) and
//! [`chain`] (steps to a position). Every part is a function of what it is given: no clock, no
//! memory but the one that the caller holds.
#![no_std]

#[cfg(test)]
extern crate std;

pub mod chain;
pub mod encoder;
pub mod filter;
pub mod ssi;
