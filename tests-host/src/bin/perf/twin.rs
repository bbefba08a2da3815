//! The twin engine against the wall clock.

use std::time::Instant;

use serde_json::json;
use tests_host::{Bench, fleet};

use crate::row;

/// The wall clock.
#[expect(clippy::disallowed_methods, reason = "how fast the bench is, is a matter of real time")]
fn now() -> Instant {
    Instant::now()
}

/// Many devices on one bus, each with a heartbeat and a cyclic TPDO.
pub(crate) fn many_devices() {
    const DEVICES: u16 = 120;
    const PERIOD_MS: u16 = 100;
    const SPAN_S: u32 = 10;
    let mut scene = fleet(DEVICES, PERIOD_MS);
    let started = now();
    scene.run_ms(u64::from(SPAN_S) * 1_000);
    let wall = started.elapsed().as_secs_f64();
    row(
        &format!("twin: virtual seconds per wall second, {DEVICES} devices, {PERIOD_MS} ms"),
        &format!("{:.1}", f64::from(SPAN_S) / wall),
    );
}

/// Round trips of a master at the SLCAN port, one after the other, with the clock following the
/// wall clock.
pub(crate) fn round_trips() {
    const TRIPS: u32 = 4_000;
    const KBIT_1000: u8 = 8;
    let mut bench = Bench::real("nm172", &["--engine", "twin"]);
    let mut master = bench.slcan();
    master.open(4);
    while master.receive().id != 0x77F {}
    let mut ask = |request: [u8; 8]| {
        master.send(0x67F, &request);
        while master.receive().id != 0x5FF {}
    };
    ask([0x2F, 0x00, 0x21, 0x00, KBIT_1000, 0, 0, 0]);
    drop(master);
    bench.tell("power", json!({ "on": false }));
    let mut master = bench.slcan();
    master.open(KBIT_1000);
    bench.tell("power", json!({ "on": true }));
    while master.receive().id != 0x77F {}
    let started = now();
    for _ in 0..TRIPS {
        master.send(0x67F, &[0x40, 0x04, 0x60, 0, 0, 0, 0, 0]);
        while master.receive().id != 0x5FF {}
    }
    let rate = f64::from(TRIPS) / started.elapsed().as_secs_f64();
    row("twin: SDO round trips per second over SLCAN, 1 Mbit/s", &format!("{rate:.0}"));
}
