//! What the CANopen stack takes beside others that run the same device, DEV1: instructions for
//! what a device does all day, flash and RAM of the smallest program.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::images::{self, Controller, TARGET};
use crate::qemu;
use crate::run::{self, Failure};
use crate::size;
use crate::tools::{self, Tool};

/// A stack with its program in `perf-dev1` and the one in `perf-footprint`.
struct Stack {
    name: &'static str,
    counted: &'static str,
    linked: &'static str,
}

/// What the bench calls the device.
pub(crate) const DEV1: &str = "dev1";

const SPINDLE: Stack =
    Stack { name: "Spindle", counted: "dev1-spindle", linked: "footprint-spindle" };
const PEERS: [Stack; 2] = [
    Stack { name: "zencan-node 0.0.5", counted: "dev1-zencan", linked: "footprint-zencan" },
    Stack { name: "canopen-rs 0.6.1", counted: "dev1-canopen-rs", linked: "footprint-canopen-rs" },
];

/// What is known of an operation without running anything: what CANopenNode v4 takes (measured once
/// with the same device, -O2), and the most that Spindle may take on a Cortex-M4.
struct Row {
    canopennode: Instructions,
    bar: u64,
}

/// Instructions of an operation.
#[derive(Clone, Copy)]
struct Instructions {
    cortex_m4: u64,
    host: u64,
}

/// In the order of the operations.
const ROWS: [Row; 10] = [
    Row { canopennode: Instructions { cortex_m4: 702, host: 762 }, bar: 350 },
    Row { canopennode: Instructions { cortex_m4: 695, host: 771 }, bar: 350 },
    Row { canopennode: Instructions { cortex_m4: 644, host: 699 }, bar: 350 },
    Row { canopennode: Instructions { cortex_m4: 517, host: 561 }, bar: 300 },
    Row { canopennode: Instructions { cortex_m4: 580, host: 671 }, bar: 200 },
    Row { canopennode: Instructions { cortex_m4: 962, host: 1_165 }, bar: 300 },
    Row { canopennode: Instructions { cortex_m4: 544, host: 633 }, bar: 200 },
    Row { canopennode: Instructions { cortex_m4: 976, host: 1_177 }, bar: 300 },
    Row { canopennode: Instructions { cortex_m4: 94, host: 93 }, bar: 40 },
    Row { canopennode: Instructions { cortex_m4: 548, host: 642 }, bar: 60 },
];

/// CANopenNode v4, -Os -flto, with block transfer: measured once. Flash and RAM in bytes.
const CANOPENNODE_FOOTPRINT: (u64, u64) = (17_668, 4_456);
/// The most that Spindle may take. Flash and RAM in bytes.
const FOOTPRINT_BAR: (u64, u64) = (17_600, 3_000);

/// In place of the flags for the boards: no log.
const FLAGS: (&str, &str) = ("RUSTFLAGS", "-C link-arg=--nmagic");

/// How often the host does an operation while it is counted.
const TIMES: u64 = 1_000;

/// An operation and the instructions that one of it takes.
struct Count {
    operation: String,
    instructions: u64,
}

/// Fails when Spindle takes more instructions, flash or RAM than it may; its image is built.
pub(crate) fn check() -> Result<(), Failure> {
    check_footprint()?;
    perf()
}

/// Counts Spindle on the emulated Cortex-M4, and fails when an operation takes more than it may.
pub(crate) fn perf() -> Result<(), Failure> {
    tools::require(&[Tool::ThumbTarget, Tool::Qemu])?;
    build_for_cortex_m4(&["--bin", SPINDLE.counted, "--features", "image"])?;
    let counts = on_cortex_m4(&SPINDLE)?;
    println!("| instructions on a Cortex-M4 | Spindle | at most |");
    println!("|---|---:|---:|");
    for (Count { operation, instructions }, row) in counts.iter().zip(ROWS) {
        println!("| {operation} | {instructions} | {} |", row.bar);
    }
    check_counts(&counts)
}

fn check_counts(counts: &[Count]) -> Result<(), Failure> {
    let mut judged = counts.iter().zip(ROWS);
    judged.try_for_each(|(count, row)| check_bar(&count.operation, count.instructions, row.bar))
}

fn check_footprint() -> Result<(), Failure> {
    let (flash, ram) = size::flash_and_ram(&footprint_program(SPINDLE.linked))?;
    check_bar("flash of DEV1", flash, FOOTPRINT_BAR.0)?;
    check_bar("RAM of DEV1", ram, FOOTPRINT_BAR.1)
}

fn check_bar(what: &str, taken: u64, at_most: u64) -> Result<(), Failure> {
    if taken > at_most {
        return Err(Failure::Step(format!("{what}: {taken}, which is more than {at_most}")));
    }
    Ok(())
}

/// Counts all stacks on both machines, and fails as [`perf`] does.
pub(crate) fn perf_with_peers() -> Result<(), Failure> {
    tools::require(&[Tool::ThumbTarget, Tool::Qemu, Tool::Valgrind])?;
    build_for_cortex_m4(&["--bins", "--features", "image,peers"])?;
    let build = ["build", "--release", "--package", "perf-dev1", "--features", "peers"];
    run::step(&mut run::cargo(build))?;
    let spindle = on_cortex_m4(&SPINDLE)?;
    let operations: Vec<&str> = spindle.iter().map(|count| count.operation.as_str()).collect();
    let [zencan, canopen_rs] = &PEERS;
    let others = [on_cortex_m4(zencan)?, on_cortex_m4(canopen_rs)?].map(|counts| numbers(&counts));
    let bars = ROWS.map(|row| row.bar.to_string());
    print_table(
        "instructions on a Cortex-M4",
        &operations,
        &ROWS.map(|row| row.canopennode.cortex_m4.to_string()),
        &others,
        &numbers(&spindle),
        Some(&bars),
    );
    print_table(
        "instructions on this host",
        &operations,
        &ROWS.map(|row| row.canopennode.host.to_string()),
        &[on_host(zencan)?, on_host(canopen_rs)?],
        &on_host(&SPINDLE)?,
        None,
    );
    println!("\nCANopenNode was measured once and is printed as it was.");
    check_counts(&spindle)
}

/// Builds the smallest program that is DEV1 and puts it beside the images of the products.
pub(crate) fn build_image() -> Result<(), Failure> {
    build_footprint(&["--bin", SPINDLE.linked])?;
    let image = Controller::Stm.image(DEV1);
    fs::create_dir_all(images::directory())
        .and_then(|()| fs::copy(footprint_program(SPINDLE.linked), &image))
        .map_err(|e| Failure::Step(format!("{}: {e}", image.display())))?;
    Ok(())
}

/// Flash and RAM of the smallest programs. Fails when Spindle's takes more than it may.
pub(crate) fn footprint() -> Result<(), Failure> {
    build_footprint(&["--bins"])?;
    println!("| DEV1 on | flash (text + data) | RAM (data + bss) |");
    println!("|---|---:|---:|");
    println!("| CANopenNode v4 | {} | {} |", CANOPENNODE_FOOTPRINT.0, CANOPENNODE_FOOTPRINT.1);
    let without_blocks = ("Spindle without block transfer", "footprint-spindle-without-blocks");
    let linked = PEERS.iter().chain([&SPINDLE]).map(|stack| (stack.name, stack.linked));
    for (name, program) in linked.chain([without_blocks]) {
        let (flash, ram) = size::flash_and_ram(&footprint_program(program))?;
        println!("| {name} | {flash} | {ram} |");
    }
    println!("| at most | {} | {} |", FOOTPRINT_BAR.0, FOOTPRINT_BAR.1);
    check_footprint()
}

fn build_footprint(programs: &[&str]) -> Result<(), Failure> {
    tools::require(&[Tool::ThumbTarget])?;
    run::step(
        run::cargo(["build", "--profile", "footprint", "--package", "perf-footprint"])
            .args(programs)
            .args(["--features", "image", "--target", TARGET])
            .env(FLAGS.0, FLAGS.1),
    )
}

fn footprint_program(name: &str) -> PathBuf {
    run::target_dir().join(TARGET).join("footprint").join(name)
}

fn numbers(counts: &[Count]) -> Vec<String> {
    counts.iter().map(|count| shown(count.instructions)).collect()
}

/// Nothing but a return: the stack does not have the operation.
fn shown(instructions: u64) -> String {
    if instructions <= 1 { "–".to_owned() } else { instructions.to_string() }
}

fn print_table(
    title: &str,
    operations: &[&str],
    canopennode: &[String],
    peers: &[Vec<String>; 2],
    spindle: &[String],
    bars: Option<&[String]>,
) {
    let [zencan, canopen_rs] = PEERS.map(|peer| peer.name);
    let (bar_title, bar_line) = bars.map_or(("", ""), |_| (" at most |", "---:|"));
    println!("\n| {title} | CANopenNode v4 | {zencan} | {canopen_rs} | Spindle |{bar_title}");
    println!("|---|---:|---:|---:|---:|{bar_line}");
    for (place, operation) in operations.iter().enumerate() {
        let [zencan, canopen_rs] = peers;
        let columns = [canopennode, zencan, canopen_rs, spindle].into_iter().chain(bars);
        let cells = columns.filter_map(|column| column.get(place)).map(|cell| format!(" {cell} |"));
        println!("| {operation} |{}", cells.collect::<String>());
    }
}

fn build_for_cortex_m4(what: &[&str]) -> Result<(), Failure> {
    run::step(
        run::cargo(["build", "--release", "--package", "perf-dev1", "--target", TARGET])
            .args(what)
            .env(FLAGS.0, FLAGS.1),
    )
}

fn on_cortex_m4(stack: &Stack) -> Result<Vec<Count>, Failure> {
    let image = run::target_dir().join(TARGET).join("release").join(stack.counted);
    // One instruction is one nanosecond of the emulated clock.
    let text = qemu::run(&image, &["-icount", "shift=0"])?;
    parse(&image, &text)
}

fn parse(image: &Path, text: &str) -> Result<Vec<Count>, Failure> {
    let counts: Option<Vec<Count>> = text
        .lines()
        .map(|line| {
            let (instructions, operation) = line.split_once('\t')?;
            let instructions = instructions.parse().ok()?;
            Some(Count { operation: operation.to_owned(), instructions })
        })
        .collect();
    counts
        .filter(|counts| counts.len() == ROWS.len())
        .ok_or_else(|| Failure::Step(format!("{} printed\n{text}", image.display())))
}

/// What the operations take on the host. What is done before them counts the same with none of
/// them, and is subtracted.
fn on_host(stack: &Stack) -> Result<Vec<String>, Failure> {
    let program = run::target_dir().join("release").join(stack.counted);
    eprintln!("\n--- valgrind --tool=callgrind {}", program.display());
    let each = |operation| -> Result<String, Failure> {
        let all = collected(&program, operation, TIMES)?;
        Ok(shown((all - collected(&program, operation, 0)?) / TIMES))
    };
    (0..ROWS.len()).map(each).collect()
}

fn collected(program: &PathBuf, operation: usize, times: u64) -> Result<u64, Failure> {
    let failed = |why: String| Failure::Step(format!("{}: {why}", program.display()));
    let counts = program.with_extension("callgrind");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--toggle-collect=perf_dev1::operations::operate*"])
        .arg(format!("--callgrind-out-file={}", counts.display()))
        .arg(program)
        .args([operation.to_string(), times.to_string()])
        .output()
        .map_err(|e| failed(e.to_string()))?;
    if !output.status.success() {
        return Err(failed(String::from_utf8_lossy(&output.stderr).into_owned()));
    }
    let text = fs::read_to_string(&counts).map_err(|e| failed(e.to_string()))?;
    let total = text.lines().find_map(|line| line.strip_prefix("totals: ")?.trim().parse().ok());
    total.ok_or_else(|| failed("nothing was counted".to_owned()))
}
