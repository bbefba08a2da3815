//! The bench held to known answers: small images that do one thing each, and what must come out.
//! None of them knows anything of a product.
#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "what fails in a helper fails its test"
)]

use std::fmt::Write as _;
use std::sync::Arc;

use emulated::{Firmware, Fleet, Images, Options};
use expect_test::{Expect, expect};
use units::{Duration, Instant};
use world::ssi_encoder::Line;
use world::{Engine, Mcu, Surroundings};

const SEED: u64 = 1;

fn probe(bin: &str) -> Arc<Firmware> {
    Arc::new(emulated::build("firmware-probe", bin).unwrap())
}

fn options(nodes: usize) -> Options {
    Options { nodes, seed: SEED, flash: Vec::new() }
}

/// Devices with the same image on both controllers.
fn fleet(bin: &str, nodes: usize) -> Fleet {
    let image = probe(bin);
    let images = Images::pair(Arc::clone(&image), image);
    Fleet::new(&images, options(nodes)).unwrap()
}

fn run_ms(fleet: &mut Fleet, ms: u64) {
    fleet.run_until(fleet.now() + Duration::from_millis(ms)).unwrap();
}

/// What one controller logged since the last call, one line each.
fn log_of(fleet: &mut Fleet, mcu: Mcu) -> String {
    let mut text = String::new();
    for line in fleet.take_log(0).iter().filter(|line| line.mcu == mcu) {
        writeln!(text, "{}", line.text).unwrap();
    }
    text
}

#[track_caller]
fn check(found: &str, expected: Expect) {
    expected.assert_eq(found);
}

/// The number behind `key` in a line of `log`.
fn number(line: &str, key: &str) -> u64 {
    let rest = line.split_once(key).unwrap_or_else(|| panic!("no {key} in {line}")).1;
    let digits: String = rest.trim().chars().take_while(char::is_ascii_digit).collect();
    digits.parse().unwrap_or_else(|_| panic!("no number after {key} in {line}"))
}

#[test]
fn delays_of_1_ms_to_1_s_are_right_within_10_us() {
    let mut fleet = fleet("probe-time", 1);
    run_ms(&mut fleet, 2_500);
    let log = log_of(&mut fleet, Mcu::Msp);
    let took: Vec<&str> = log.lines().filter(|line| line.contains("took")).collect();
    assert_eq!(took.len(), 17, "{log}");
    for line in took {
        let asked_us = 1_000 * number(line, "");
        let late_us = number(line, "took").checked_sub(asked_us).expect("never early");
        assert!(late_us <= 10, "{line}");
    }
    assert!(log.ends_with("done\n"), "{log}");
}

#[test]
fn a_sleeping_core_takes_next_to_no_instructions() {
    let mut fleet = fleet("probe-time", 1);
    run_ms(&mut fleet, 3_000);
    let [_, before] = fleet.stats(0);
    run_ms(&mut fleet, 1_000);
    let [_, after] = fleet.stats(0);
    // The time base interrupts every 32.8 ms to count its half periods, and that is all.
    let instructions = after.instructions - before.instructions;
    assert!((100..5_000).contains(&instructions), "{instructions}");
    assert!(after.awake_fraction < 0.01, "{after:?}");
    assert!((64..16_384).contains(&after.stack_used), "{after:?}");
}

const FLASH_FIRST_RUN: &str = "\
    found 0xffffffff\n\
    erase true 400 ms, cell 0xffffffff\n\
    write true cell 0x1\n\
    and true true cell 0xff00f0f\n\
    locked: pgserr true cell 0xffffffff\n\
    done\n";

#[test]
fn flash_erases_programs_and_refuses_as_the_manual_says() {
    let mut fleet = fleet("probe-flash", 1);
    run_ms(&mut fleet, 500);
    assert_eq!(log_of(&mut fleet, Mcu::Stm), FLASH_FIRST_RUN);
    let [stm, _] = fleet.stats(0);
    assert_eq!((stm.sector_erases, stm.flash_ops), (1, 3));
}

#[test]
fn flash_survives_a_power_cycle_and_the_end_of_the_bench() {
    let mut first = fleet("probe-flash", 1);
    run_ms(&mut first, 500);
    first.take_log(0);
    first.set_power(0, false);
    run_ms(&mut first, 100);
    first.set_power(0, true);
    run_ms(&mut first, 500);
    let second_run = log_of(&mut first, Mcu::Msp);
    assert!(second_run.starts_with("found 0x1\n"), "{second_run}");

    let flash = vec![Mcu::BOTH.map(|mcu| Some(first.flash(0, mcu)))];
    drop(first);
    let image = probe("probe-flash");
    let images = Images::pair(Arc::clone(&image), image);
    let mut second = Fleet::new(&images, Options { flash, ..options(1) }).unwrap();
    run_ms(&mut second, 500);
    let third_run = log_of(&mut second, Mcu::Stm);
    assert!(third_run.starts_with("found 0x2\n"), "{third_run}");
}

#[test]
fn a_power_cut_leaves_a_flash_operation_half_done() {
    let mut fleet = fleet("probe-flash", 1);
    run_ms(&mut fleet, 500);
    fleet.set_power(0, false);
    run_ms(&mut fleet, 1);
    fleet.set_power(0, true);
    fleet.cut_power_at_flash_operation(0, Mcu::Stm, 1);
    fleet.take_log(0);
    run_ms(&mut fleet, 600);
    let log = log_of(&mut fleet, Mcu::Stm);
    assert_eq!(log, "found 0x1\n", "cut while it erased");
    let bank_2 = 1 << 20;
    let sector = fleet.flash(0, Mcu::Stm)[bank_2..bank_2 + 8].to_vec();
    let msp = log_of(&mut fleet, Mcu::Msp);
    assert!(msp.is_empty(), "taken with the other's: {msp}");
    let again = fleet.flash(0, Mcu::Stm)[bank_2..bank_2 + 8].to_vec();
    assert_eq!(sector, again, "without supply nothing changes");
    fleet.set_power(0, true);
    run_ms(&mut fleet, 600);
    assert!(log_of(&mut fleet, Mcu::Stm).ends_with("done\n"));
}

/// Turning, keys, inputs, motor lines and display of one device.
fn transcript(fleet: &mut Fleet) -> String {
    let mut text = String::new();
    let mut act = |name: &str, act: &mut dyn FnMut(&mut Surroundings, u64)| {
        let now = fleet.now();
        act(&mut fleet.surroundings(0), now.as_micros() * 1_000);
        run_ms(fleet, 25);
        let now_ns = fleet.now().as_micros() * 1_000;
        let log = log_of(fleet, Mcu::Msp);
        let world = fleet.surroundings(0);
        writeln!(text, "{name}: motor {:?} at {}", world.motor, world.spindle.position(now_ns))
            .unwrap();
        let last = log.lines().rfind(|line| line.starts_with("ssi"));
        for line in log.lines().filter(|line| !line.starts_with("ssi")).chain(last) {
            writeln!(text, "    {line}").unwrap();
        }
    };
    act("start", &mut |_, _| {});
    act("turned by hand", &mut |world, _| world.spindle.turn(4_096));
    act("left key", &mut |world, _| world.panel.left_key = true);
    act("both keys", &mut |world, _| world.panel.right_key = true);
    act("inputs", &mut |world, _| {
        world.panel = world::Panel { input_f: true, input_g: true, ..world::Panel::default() };
    });
    act("motor fault", &mut |world, at_ns| {
        let model = world::spindle::MotorModel { fault: true, ..world.spindle.model() };
        world.spindle.set_model(at_ns, model);
    });
    act("line open", &mut |world, _| world.encoder.line = Line::Open);
    act("line stuck", &mut |world, _| world.encoder.line = Line::StuckLow);
    text
}

#[test]
fn keys_inputs_encoder_motor_and_display_reach_each_other() {
    let mut fleet = fleet("probe-board", 1);
    let found = transcript(&mut fleet);
    check(
        &found,
        expect![[r#"
        start: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 0
            lcd true nobody true
            pins [true, true, false, false, false]
            ssi true 0xe0000000
        turned by hand: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 4096
            ssi true 0xe0060000
        left key: motor MotorOutputs { in1: true, in2: false, in3: true, in4: false } at 4070
            pins [false, true, false, false, false]
            ssi true 0xe0020780
        both keys: motor MotorOutputs { in1: true, in2: true, in3: true, in4: true } at 4065
            pins [false, false, false, false, false]
            ssi true 0xe0020440
        inputs: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 4065
            pins [true, true, true, true, false]
            ssi true 0xe0020440
        motor fault: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 4065
            pins [true, true, true, true, true]
            ssi true 0xe0020440
        line open: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 4065
            ssi true 0xffffffff
        line stuck: motor MotorOutputs { in1: false, in2: false, in3: false, in4: false } at 4065
            ssi true 0x00000000
    "#]],
    );
    let world = fleet.surroundings(0);
    check(
        &format!("[{}] [{}]", world.lcd.upper(), world.lcd.lower()),
        expect!["[8 8.8.8.8.] [8.8.8.8.8.8.]"],
    );
}

#[test]
fn the_same_seed_and_calls_give_the_same_run() {
    let run = || {
        let mut fleet = fleet("probe-board", 2);
        (transcript(&mut fleet), fleet.take_log(1), fleet.stats(0), fleet.stats(1))
    };
    assert_eq!(run(), run());
}

#[test]
fn bytes_cross_between_the_controllers_in_order_and_in_time() {
    let mut fleet = fleet("probe-link", 1);
    run_ms(&mut fleet, 45);
    let log: Vec<_> = fleet.take_log(0);
    let of = |mcu| log.iter().filter(move |line| line.mcu == mcu).map(|line| line.text.as_str());
    let sent_at =
        |mcu| of(mcu).find(|line| line.starts_with("sends")).map(|line| number(line, "at"));
    let got: Vec<&str> = of(Mcu::Stm).filter(|line| line.starts_with("got")).collect();
    assert_eq!(got.len(), 2, "{log:?}");
    let bytes = "[40, 41, 42, 43, 44, 45, 46, 47, 48, 49, 4a, 4b, 4c, 4d, 4e, 4f]";
    assert!(got[0].contains(bytes), "{got:?}");
    // Sixteen bytes of 21.7 µs, 100 µs on the way, one byte of silence, and the cores' own time.
    let took = number(got[0], "at ") - sent_at(Mcu::Msp).unwrap();
    assert!((16 * 22 + 100..16 * 22 + 100 + 100).contains(&took), "{took} us");
}

#[test]
fn a_cut_line_carries_nothing_and_a_noisy_one_not_everything() {
    let mut fleet = fleet("probe-link", 1);
    fleet.surroundings(0).link.cut = true;
    run_ms(&mut fleet, 100);
    let cut = log_of(&mut fleet, Mcu::Stm);
    assert!(!cut.contains("got"), "{cut}");
    fleet.surroundings(0).link = world::Link { cut: false, bit_error_rate: 0.0, drop_rate: 0.5 };
    run_ms(&mut fleet, 1_000);
    let bytes = log_of(&mut fleet, Mcu::Stm).matches('4').count();
    assert!((200..700).contains(&bytes), "{bytes} of 800");
}

#[test]
fn the_watchdog_resets_and_the_cause_is_told() {
    let mut fleet = fleet("probe-watchdog", 1);
    run_ms(&mut fleet, 500);
    let log = log_of(&mut fleet, Mcu::Stm);
    let [stm, _] = fleet.stats(0);
    let causes: Vec<&str> = stm.resets.iter().map(|reset| reset.cause.as_str()).collect();
    assert_eq!(causes, ["power-on", "watchdog", "software"], "{log}");
    let last_pet = number(log.lines().nth(1).unwrap(), "last pet at");
    let reset_at = stm.resets[1].at.as_micros();
    assert!((last_pet + 95_000..last_pet + 105_000).contains(&reset_at), "{reset_at} {log}");
    for (run, expected) in [
        (0, "power-on true watchdog false software false"),
        (2, "power-on false watchdog true software false"),
        (3, "power-on false watchdog false software true"),
    ] {
        assert_eq!(log.lines().nth(run), Some(expected), "{log}");
    }
}

/// The error a run ends with in which the CAN interface controller does forbidden thing `choice`.
fn refusal(choice: u8) -> String {
    let mut flash = vec![0xFF; 2 << 20];
    flash[1 << 20] = choice;
    let image = probe("probe-faults");
    let images = Images::pair(Arc::clone(&image), image);
    let options = Options { flash: vec![[Some(flash), None]], ..options(1) };
    let mut fleet = Fleet::new(&images, options).unwrap();
    let first =
        fleet.run_until(Instant::from_micros(20_000)).expect_err("nothing stands behind it");
    let again = fleet.run_until(Instant::from_micros(30_000)).expect_err("the run is over");
    assert_eq!(first, again);
    first.0
}

#[test]
fn an_access_to_nothing_ends_the_run() {
    let error = refusal(0);
    assert!(error.starts_with("stm of node 0: access to 0x40001000 at pc 0x08"), "{error}");
}

#[test]
fn a_dma_address_in_core_coupled_memory_ends_the_run() {
    let error = refusal(1);
    assert!(error.contains("0x400260ac is set to 0x10000100 at pc 0x08"), "{error}");
}

#[test]
fn an_access_to_an_unclocked_instance_ends_the_run() {
    let error = refusal(2);
    assert!(error.contains("access to 0x40013000 at pc 0x08"), "{error}");
    assert!(error.contains("gated by RCC.APB2ENR.SPI1EN"), "{error}");
}
