//! The NM172 on the bench: both images as they are flashed.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use tests_host::Scene;

mod scenarios;

/// What the devices of the scenarios are made of.
const ENGINE: &str = "image";

/// NM17x STORE-02: the supply fails in the middle of any flash operation of a write: afterwards
/// the old value is there, or the new one, and everything else as before.
#[test]
fn the_supply_fails_while_a_parameter_is_written() {
    let mut seen = BTreeSet::new();
    for operation in 1.. {
        let mut scene = Scene::booted("nm172", &["--seed", &operation.to_string()]);
        scene.request("23 20 20 01 40 9C 00 00");
        scene.run_ms(300).request("23 03 20 00 40 01 00 00");
        scene.run_ms(300).tell("power_cut", json!({ "mcu": "msp", "flash_op": operation }));
        scene.request("23 03 20 00 41 01 00 00");
        scene.run_ms(300);
        let still_on = scene.bench.tell("stats", json!({}));
        scene.tell("power", json!({ "on": false })).run_ms(100);
        scene.tell("power", json!({ "on": true })).run_ms(1_000);
        let window = scene.request("40 03 20 00 00 00 00 00");
        assert_eq!(scene.request("40 20 20 01 00 00 00 00"), "43 20 20 01 40 9C 00 00");
        assert!(
            ["43 03 20 00 40 01 00 00", "43 03 20 00 41 01 00 00"].contains(&window.as_str()),
            "operation {operation}: {window}"
        );
        seen.insert(window.clone());
        let operations = still_on["msp"]["flash_ops"].as_u64().unwrap_or_default();
        if operation > 4 && window.ends_with("41 01 00 00") || operation > 20 {
            assert!(operations > 0);
            break;
        }
    }
    assert_eq!(seen.len(), 2, "cuts before and behind the decisive word: {seen:?}");
}

/// The controller reports a frame four bits before the bus is free: at 1 Mbit/s a transmission that
/// is requested within 640 cycles leaves no gap. Nothing keeps the controller from a frame for longer
/// than 50 µs, of the 141 µs in which a FIFO may fill.
#[test]
fn answers_leave_without_a_gap() {
    let mut scene = booted_at_1_mbit_s();
    let mut reactions = Vec::new();
    for request in [
        "40 00 10 00 00 00 00 00",
        "40 4E 20 01 00 00 00 00",
        "40 FF 5F 00 00 00 00 00",
        "23 03 20 00 NN 01 00 00",
        "23 03 60 00 NN 01 00 00",
        "2F 01 21 00 NN 00 00 00",
        "23 14 10 00 00 NN 00 00",
        "2B 17 10 00 NN 01 00 00",
        "2F 01 18 02 NN 00 00 00",
        "2B 01 18 03 NN 01 00 00",
        "2B 01 18 05 NN 01 00 00",
        "23 01 18 01 NN 02 00 80",
        "40 08 10 00 00 00 00 00",
        "23 16 10 01 NN 00 04 00",
    ] {
        let cycles = reaction(&mut scene, |scene, number| {
            scene.request(&request.replace("NN", &format!("{number:02X}")));
        });
        reactions.push((request, cycles));
    }
    for prepared in [
        "2B 17 10 00 00 00 00 00",
        "2F 01 18 02 01 00 00 00",
        "2B 01 18 03 00 00 00 00",
        "2B 01 18 05 00 00 00 00",
        "23 01 18 01 FF 02 00 00",
    ] {
        scene.request(prepared);
    }
    scene.send("000#01 7F").run_ms(100).frames();
    let sync = reaction(&mut scene, |scene, _| {
        assert_eq!(scene.send("080#").run_ms(3).frames(), ["2FF#03 01 00 00 00 00 00 10"]);
    });
    reactions.push(("SYNC", sync));
    assert!(reactions.iter().all(|(_, cycles)| *cycles <= NO_GAP), "{reactions:?}");
    let blocked = ["can_wait_ns", "masked_ns"].map(|figure| (figure, cycles(&mut scene, figure)));
    assert!(blocked.iter().all(|(_, cycles)| *cycles <= 50 * CYCLES_PER_US), "{blocked:?}");
}

/// NM17x SDO-03, STORE-07: a sector of the flash is erased, and words are written, while a master
/// leaves no gap between its requests: each is answered, and nothing keeps the controller from a
/// frame for longer than 50 µs.
#[test]
fn an_erase_of_the_flash_loses_no_request() {
    const READ: &str = "67F#40 00 10 00 00 00 00 00";
    const WRITES: [&str; 2] = ["67F#2F 01 21 00 7E 00 00 00", "67F#2F 01 21 00 7F 00 00 00"];
    const ANSWERS: [&str; 2] = ["5FF#43 00 10 00", "5FF#60 01 21 00"];
    /// More than the bus carries in this time, with the answers.
    const REQUESTS: usize = 90;
    const ROUND_MS: u64 = 20;
    /// Several thousand numbers, of which a sector holds several hundred.
    const ROUNDS_MAX: u64 = 500;
    /// An erase takes up to half a second.
    const ROUNDS_OF_ERASE: u64 = 500 / ROUND_MS;
    let answers = |scene: &mut Scene| {
        let is_answer = |frame: &&String| ANSWERS.iter().any(|answer| frame.starts_with(answer));
        scene.frames().iter().filter(is_answer).count()
    };
    let mut scene = booted_at_1_mbit_s();
    let (mut asked, mut answered, mut rounds_left) = (0, 0, ROUNDS_MAX);
    let mut erased = false;
    while rounds_left > 0 {
        rounds_left -= 1;
        while asked < answered + REQUESTS {
            let [first, second] = WRITES;
            scene.send(match asked % 20 {
                0 => first,
                10 => second,
                _ => READ,
            });
            asked += 1;
        }
        answered += answers(scene.run_ms(ROUND_MS));
        assert!(answered < asked, "the master has to wait for the bus");
        if !erased && figure(&mut scene, "sector_erases") > 0 {
            (erased, rounds_left) = (true, ROUNDS_OF_ERASE);
        }
    }
    assert!(erased);
    answered += answers(scene.run_ms(ROUND_MS));
    assert_eq!(answered, asked);
    let blocked = ["can_wait_ns", "masked_ns"].map(|name| (name, cycles(&mut scene, name)));
    assert!(blocked.iter().all(|(_, cycles)| *cycles <= 50 * CYCLES_PER_US), "{blocked:?}");
}

fn booted_at_1_mbit_s() -> Scene {
    let mut scene = Scene::booted("nm172", &[]);
    scene.request("2F 00 21 00 08 00 00 00");
    scene.run_ms(500).tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000).frames();
    scene
}

/// Cycles from the interrupt of a frame to the transmit request of its answer, when no message of
/// the link comes at the same time: such a message is there in one of three phases at most. Each
/// phase has a number, so that a write can change something each time.
fn reaction(scene: &mut Scene, ask: impl Fn(&mut Scene, u8)) -> u64 {
    let asked = [(1, 0), (2, 3), (3, 3)].map(|(number, later_ms)| {
        ask(scene.run_ms(later_ms), number);
        cycles(scene, "can_reaction_ns")
    });
    asked.into_iter().min().unwrap_or(u64::MAX)
}

const CYCLES_PER_US: u64 = 160;
/// Cycles until a transmission is requested that leaves no gap at 1 Mbit/s.
const NO_GAP: u64 = 4 * CYCLES_PER_US;

/// A time among the figures of the CAN interface controller.
fn cycles(scene: &mut Scene, name: &str) -> u64 {
    figure(scene, name) * CYCLES_PER_US / 1_000
}

/// A figure of the CAN interface controller.
fn figure(scene: &mut Scene, name: &str) -> u64 {
    let stats = scene.bench.tell("stats", json!({}));
    stats.pointer(&format!("/stm/{name}")).and_then(Value::as_u64).expect("a whole number")
}
