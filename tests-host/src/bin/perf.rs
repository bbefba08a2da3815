//! Measures the images on the bench and prints the figures as a table.

use std::process::ExitCode;
use std::time::Instant;

use serde_json::{Value, json};
use tests_host::Bench;

/// Virtual time over which the figures at rest are taken.
const REST_US: u64 = 5_000_000;

fn main() -> ExitCode {
    println!("| figure | value |");
    println!("|---|---:|");
    at_rest();
    ExitCode::SUCCESS
}

/// One NM172 in Pre-operational, nobody turns, nobody asks.
fn at_rest() {
    let mut bench = Bench::step("nm172", &[]);
    bench.advance_ms(6_000);
    let before = bench.tell("stats", json!({}));
    #[expect(
        clippy::disallowed_methods,
        reason = "the speed of the bench is a matter of real time"
    )]
    let started = Instant::now();
    bench.advance(REST_US);
    let wall_us = u64::try_from(started.elapsed().as_micros()).unwrap_or(u64::MAX);
    let after = bench.tell("stats", json!({}));
    let percent = REST_US * 100 / wall_us.max(1);
    row("bench speed, virtual per wall time", &format!("{}.{:02}", percent / 100, percent % 100));
    for mcu in ["stm", "msp"] {
        let figure = |stats: &Value, name: &str| {
            stats.pointer(&format!("/{mcu}/{name}")).cloned().unwrap_or_default()
        };
        let count = |stats| figure(stats, "instructions").as_u64().unwrap_or_default();
        let per_second = (count(&after) - count(&before)) * 1_000_000 / REST_US;
        row(&format!("{mcu}, instructions per second at rest"), &per_second.to_string());
        row(&format!("{mcu}, awake fraction"), &figure(&after, "awake_fraction").to_string());
        row(&format!("{mcu}, deepest stack in bytes"), &figure(&after, "stack_used").to_string());
    }
}

fn row(figure: &str, value: &str) {
    println!("| {figure} | {value} |");
}
