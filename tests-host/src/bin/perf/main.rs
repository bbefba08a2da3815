//! Measures the images on the emulated controllers, and the twin, and prints the figures as a table.
//!
//! Everything but the speed of the engines is virtual time and repeats from run to run.

mod rig;
mod twin;

use std::process::ExitCode;

use rig::{BitRate, Rig};
use world::EngineError;
use world::can::{Frame, Id, Source};

/// Requests for the latency of the SDO server.
const REQUESTS: u64 = 100;
/// Turns of the shaft for the latencies of bus and display.
const TURNS: u64 = 50;
/// A time that shares no factor with the cycles of the device, so that every phase is met.
const ODD_PHASE_US: u64 = 137;

fn main() -> ExitCode {
    match measure() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure() -> Result<(), EngineError> {
    println!("| figure | value |");
    println!("|---|---:|");
    at_rest()?;
    let mut rig = Rig::new(BitRate::Kbit1000)?;
    sdo_latency(&mut rig)?;
    sync_latency(&mut rig)?;
    flood(&mut rig)?;
    foreign(&mut rig)?;
    cycle(&mut rig)?;
    shaft(&mut rig)?;
    blocked(&rig);
    twin::many_devices();
    twin::round_trips();
    Ok(())
}

fn row(figure: &str, value: &str) {
    println!("| {figure} | {value} |");
}

/// Smallest, middle and largest of some values in nanoseconds, as microseconds.
fn spread_us(mut values: Vec<u64>) -> String {
    values.sort_unstable();
    let at = |place: usize| values.get(place).copied().unwrap_or_default();
    let (last, middle) = (values.len().saturating_sub(1), values.len() / 2);
    format!("{} / {} / {} µs", us(at(0)), us(at(middle)), us(at(last)))
}

fn us(ns: u64) -> String {
    format!("{}.{}", ns / 1_000, ns / 100 % 10)
}

/// As [`spread_us`], in cycles of the controller's clock.
fn spread_cycles(mut values: Vec<u64>) -> String {
    const CYCLES_PER_US: u64 = 160;
    values.sort_unstable();
    let at = |place: usize| values.get(place).copied().unwrap_or_default() * CYCLES_PER_US / 1_000;
    let (last, middle) = (values.len().saturating_sub(1), values.len() / 2);
    format!("{} / {} / {}", at(0), at(middle), at(last))
}

/// Pre-operational at 125 kbit/s: nobody turns, nobody asks.
fn at_rest() -> Result<(), EngineError> {
    const REST_S: u32 = 10;
    let mut rig = Rig::new(BitRate::Kbit125)?;
    rig.run_ms(6_000)?;
    let before = rig.stats();
    #[expect(
        clippy::disallowed_methods,
        reason = "how fast the bench is, is a matter of real time"
    )]
    let started = std::time::Instant::now();
    rig.run_ms(u64::from(REST_S) * 1_000)?;
    let wall = started.elapsed().as_secs_f64();
    let after = rig.stats();
    row("virtual seconds per wall second, one device", &format!("{:.1}", f64::from(REST_S) / wall));
    for (name, (before, after)) in ["stm", "msp"].iter().zip(before.iter().zip(&after)) {
        let awake = (after.awake_us - before.awake_us) / (f64::from(REST_S) * 1e6);
        row(&format!("{name}: awake at rest"), &format!("{:.1} %", awake * 100.0));
        let instructions = (after.instructions - before.instructions) / u64::from(REST_S);
        row(&format!("{name}: instructions per second at rest"), &instructions.to_string());
        row(&format!("{name}: deepest stack"), &format!("{} bytes", after.stack_used));
    }
    Ok(())
}

/// An upload of 0x1000 on a quiet bus.
fn sdo_latency(rig: &mut Rig) -> Result<(), EngineError> {
    const WINDOW_MS: u64 = 10;
    let request = Frame::new(rig.sdo_request(), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).map_err(failed)?;
    let (mut latencies, mut reactions) = (Vec::new(), Vec::new());
    let (mut asked, mut idle) = (0, 0);
    for _ in 0..REQUESTS {
        let [start, _] = rig.stats();
        rig.run_ms(WINDOW_MS)?;
        let [middle, _] = rig.stats();
        rig.frames();
        rig.send(request)?;
        rig.run_ms(WINDOW_MS)?;
        let [end, _] = rig.stats();
        idle += middle.instructions - start.instructions;
        asked += end.instructions - middle.instructions;
        if let [question, answer] = rig.frames().as_slice() {
            latencies.push(answer.start.0.saturating_sub(question.end.0));
            reactions.push(end.can_reaction_ns);
        }
        rig.run_us(ODD_PHASE_US)?;
    }
    row("SDO upload at 1 Mbit/s: end of request to start of response", &spread_us(latencies));
    row("SDO upload: receive interrupt to transmit request, cycles", &spread_cycles(reactions));
    let instructions = asked.saturating_sub(idle) / REQUESTS;
    row("SDO upload: instructions, interrupts included", &instructions.to_string());
    Ok(())
}

/// A SYNC that one PDO goes with, on a quiet bus.
fn sync_latency(rig: &mut Rig) -> Result<(), EngineError> {
    const WINDOW_MS: u64 = 10;
    rig.write(&[0x2F, 0x01, 0x18, 0x02, 1, 0, 0, 0])?;
    rig.start()?;
    let sync = Frame::new(Id::Standard(0x080), &[]).map_err(failed)?;
    let (mut latencies, mut reactions) = (Vec::new(), Vec::new());
    for _ in 0..REQUESTS {
        rig.send(sync)?;
        rig.run_ms(WINDOW_MS)?;
        if let [sync, pdo] = rig.frames().as_slice() {
            latencies.push(pdo.start.0.saturating_sub(sync.end.0));
            reactions.push(rig.stats()[0].can_reaction_ns);
        }
        rig.run_us(ODD_PHASE_US)?;
    }
    row("SYNC at 1 Mbit/s: its end to the start of the first PDO", &spread_us(latencies));
    row("SYNC: receive interrupt to transmit request, cycles", &spread_cycles(reactions));
    rig.write(&[0x2F, 0x01, 0x18, 0x02, 0xFF, 0, 0, 0])
}

/// What kept the firmware from a received frame, in all that was measured before.
fn blocked(rig: &Rig) {
    let [stm, _] = rig.stats();
    row("stm: longest wait of a received frame", &format!("{} µs", us(stm.can_wait_ns)));
    row("stm: interrupts masked, the longest", &format!("{} µs", us(stm.masked_ns)));
}

/// As many SDO requests and SYNCs as the bus carries: each has its answer.
fn flood(rig: &mut Rig) -> Result<(), EngineError> {
    const FLOOD_MS: u64 = 1_000;
    let upload = Frame::new(rig.sdo_request(), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).map_err(failed)?;
    let download = [0x23, 0x05, 0x10, 0, 0x80, 0, 0, 0];
    let download = Frame::new(rig.sdo_request(), &download).map_err(failed)?;
    for (name, request) in [("SDO uploads", upload), ("SDO downloads", download)] {
        let (sent, answered, load) = rig.saturate(&[request], 0x5FF, FLOOD_MS)?;
        row(
            &format!("{name} at {load} % bus load: requests lost"),
            &format!("{} of {sent}", sent - answered),
        );
    }
    // A SYNC behind the PDO in priority, so that the PDO's way to the bus is open.
    let sync_id = 0x57F;
    rig.write(&[0x23, 0x05, 0x10, 0, 0x7F, 0x05, 0, 0])?;
    rig.write(&[0x2F, 0x01, 0x18, 0x02, 1, 0, 0, 0])?;
    rig.start()?;
    let sync = Frame::new(Id::Standard(sync_id), &[]).map_err(failed)?;
    let (sent, answered, load) = rig.saturate(&[sync], 0x2FF, FLOOD_MS)?;
    row(
        &format!("SYNC with a PDO each at {load} % bus load: PDOs missing"),
        &format!("{} of {sent}", sent - answered),
    );
    rig.write(&[0x2F, 0x01, 0x18, 0x02, 0xFF, 0, 0, 0])?;
    rig.write(&[0x23, 0x05, 0x10, 0, 0x80, 0, 0, 0])
}

/// Frames that are none of this node's, as fast as the bus carries them.
fn foreign(rig: &mut Rig) -> Result<(), EngineError> {
    let own = [0x000, 0x080, 0x67F];
    let frames: Result<Vec<Frame>, _> = (0..0x800)
        .filter(|id| !own.contains(id))
        .step_by(5)
        .map(|id| Frame::new(Id::Standard(id), &[0x55; 8]))
        .collect();
    let [before, _] = rig.stats();
    let (sent, _, load) = rig.saturate(&frames.map_err(failed)?, 0xFFFF, 1_000)?;
    let [after, _] = rig.stats();
    row(
        &format!("{sent} foreign frames at {load} % bus load: CAN interrupts"),
        &(after.can_interrupts - before.can_interrupts).to_string(),
    );
    Ok(())
}

/// A shaft that turns all the time changes the position in every cycle; TxPDO2 without inhibit
/// time then shows the cycle on the bus, for longer than anything in the device takes to come round.
fn cycle(rig: &mut Rig) -> Result<(), EngineError> {
    const CYCLES: u64 = 2_500;
    rig.write(&[0x2B, 0x01, 0x18, 0x03, 0, 0, 0, 0])?;
    rig.start()?;
    rig.turn_steadily(4_096);
    rig.run_ms(100)?;
    rig.frames();
    rig.run_ms(10 * CYCLES)?;
    let sent: Vec<u64> = rig
        .frames()
        .iter()
        .filter(|logged| matches!(logged.source, Source::Device(_)))
        .map(|logged| logged.start.0)
        .collect();
    let intervals = sent.windows(2).map(|pair| match pair {
        [first, second] => second - first,
        _ => 0,
    });
    row("10 ms cycle as TxPDO2 shows it: interval", &spread_us(intervals.collect()));
    rig.turn_steadily(0);
    rig.run_ms(100)
}

/// A 64th of a turn at once, at every phase of the cycles: less than the filter takes for a jump.
fn shaft(rig: &mut Rig) -> Result<(), EngineError> {
    const LATENCY_US_MAX: u64 = 100_000;
    const GLANCE_US: u64 = 50;
    let (mut to_bus, mut to_glass) = (Vec::new(), Vec::new());
    for turn in 0..TURNS {
        rig.run_us(20_000 + turn * ODD_PHASE_US)?;
        rig.frames();
        let (from_ns, shown) = (rig.now_ns(), rig.lower_line());
        rig.turn(64);
        let mut seen_at = None;
        for _ in 0..LATENCY_US_MAX / GLANCE_US {
            rig.run_us(GLANCE_US)?;
            if rig.lower_line() != shown {
                seen_at = Some(rig.now_ns());
                break;
            }
        }
        rig.run_us(20_000)?;
        to_glass.extend(seen_at.map(|at| at - from_ns));
        to_bus.extend(rig.frames().first().map(|logged| logged.start.0 - from_ns));
    }
    row("shaft to TxPDO2, start of frame", &spread_us(to_bus));
    row("shaft to display", &spread_us(to_glass));
    Ok(())
}

fn failed(error: impl std::fmt::Display) -> EngineError {
    EngineError(error.to_string())
}
