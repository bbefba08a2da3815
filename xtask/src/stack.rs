//! What the CANopen stack takes for each operation of DEV1, beside its bars.

use std::path::Path;

use crate::images::TARGET;
use crate::qemu;
use crate::run::{self, Failure};
use crate::tools::{self, Tool};

/// The most instructions that an operation may take on a Cortex-M4, in the order of the operations.
const BARS: [u64; 10] = [350, 350, 350, 300, 200, 300, 200, 300, 40, 60];

/// An operation and the instructions that one of it takes.
struct Count {
    operation: String,
    instructions: u64,
}

/// Counts on the emulated Cortex-M4 and prints a table.
pub(crate) fn perf() -> Result<(), Failure> {
    tools::require(&[Tool::ThumbTarget, Tool::Qemu])?;
    let counts = on_cortex_m4("dev1-spindle")?;
    println!("| instructions on a Cortex-M4 | Spindle | at most | |");
    println!("|---|---:|---:|---|");
    for (count, bar) in counts.iter().zip(BARS) {
        let Count { operation, instructions } = count;
        let verdict = if *instructions > bar { "over" } else { "" };
        println!("| {operation} | {instructions} | {bar} | {verdict} |");
    }
    Ok(())
}

fn on_cortex_m4(bin: &str) -> Result<Vec<Count>, Failure> {
    run::step(
        run::cargo(["build", "--release", "--package", "perf-dev1", "--bin", bin])
            .args(["--target", TARGET])
            // In place of the flags for the boards: another memory map, no log.
            .env("RUSTFLAGS", "-C link-arg=--nmagic"),
    )?;
    let image = run::target_dir().join(TARGET).join("release").join(bin);
    // One instruction is one nanosecond of the emulated clock.
    let text = qemu::run(&image, &["-icount", "shift=0"])?;
    parse(&image, &text)
}

fn parse(image: &Path, text: &str) -> Result<Vec<Count>, Failure> {
    let counts: Option<Vec<Count>> = text
        .lines()
        .map(|line| {
            let (instructions, operation) = line.split_once('\t')?;
            Some(Count {
                operation: operation.to_owned(),
                instructions: instructions.parse().ok()?,
            })
        })
        .collect();
    counts
        .filter(|counts| counts.len() == BARS.len())
        .ok_or_else(|| Failure::Step(format!("{} printed\n{text}", image.display())))
}
