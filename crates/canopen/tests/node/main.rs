//! The node as masters meet it.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::indexing_slicing,
    clippy::unwrap_used,
    reason = "a test that meets what it does not expect has to fail"
)]

mod bus;
mod cia_301;
mod configurable;
mod device;
mod emergency;
mod guarding;
mod idle;
mod mapping;
mod monitor;
mod nmt;
mod pdo;
mod receive;
mod script;
mod sdo;
mod sdo_access;
mod storage;
mod sync;
mod time;
mod transmission;
mod transmit;
mod vectors;

use expect_test::Expect;

/// Compares what the device with the settings of NM17x does in a script.
#[track_caller]
fn check(script: &str, expected: Expect) {
    expected.assert_eq(&script::transcript(device::node(), &mut device::Device::new(), script));
}
