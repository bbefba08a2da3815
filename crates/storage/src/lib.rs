//! Parameter records on NOR flash that survive a loss of supply at any moment.
//!
//! The manual stores a parameter right after each write (NM17x STORE-02, STORE-07) and the
//! communication parameters together, on request (STORE-03, STORE-04). A [`Store`] does both: a
//! record of its own per parameter, and one set of records that is replaced as a whole.
//!
//! What a loss of supply may do is the worst a NOR flash can show: the operation under way changes
//! any subset of the bits it was about to change, and every later operation does not happen. Then
//! the next [`Store::open`] finds the old value or the new one, never a third, and every other
//! record as it was. `sequential-storage` keeps the records in a log over the pages and expects a
//! page whose erase was interrupted to look erased from its start; a real sector erases all its
//! cells at once, so the pages carry a stamp of their own that says whether their erase was finished.
//!
//! A record that decays later fails its checksum and counts as never written: its key falls back to
//! the value before, or to none. This leaves the same trace as a write that a loss of supply cut
//! short, so it cannot be reported apart from it; a memory that cannot be read at all is.
#![no_std]

mod pages;
mod store;
mod value;

pub use store::{Error, Opened, RECORD_KEY_MAX, SET_LEN_MAX, Store, Stored};
pub use value::{Record, VALUE_LEN_MAX, Value};
