//! The twin engine on the bench: it shows what the images show, keeps what they keep, and carries
//! many devices.

use expect_test::{Expect, expect};
use serde_json::json;
use tests_host::Scene;

#[path = "../nm172/scenarios.rs"]
mod nm172;

/// What the devices of the scenarios are made of.
const ENGINE: &str = "twin";
const TWIN: [&str; 2] = ["--engine", ENGINE];

#[track_caller]
fn check(scene: &Scene, expected: Expect) {
    expected.assert_eq(scene.transcript());
}

/// NM17x STORE-02: the supply fails while a number is stored; the old one is there afterwards, and
/// the next write is kept.
#[test]
fn the_supply_fails_while_a_parameter_is_written() {
    let mut scene = Scene::booted("nm172", &TWIN);
    scene.sdo("23 03 20 00 40 01 00 00").run_ms(100);
    scene.tell("power_cut", json!({ "mcu": "msp", "flash_op": 1 }));
    scene.sdo("23 03 20 00 41 01 00 00").run_ms(100);
    scene.tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000);
    scene.sdo("40 03 20 00 00 00 00 00");
    scene.sdo("23 03 20 00 41 01 00 00").run_ms(100);
    scene.tell("power", json!({ "on": false })).run_ms(100);
    scene.tell("power", json!({ "on": true })).run_ms(1_000);
    scene.sdo("40 03 20 00 00 00 00 00");
    check(
        &scene,
        expect![[r#"
        1002   ms  23 03 20 00 40 01 00 00 -> 60 03 20 00 00 00 00 00
        1104   ms  23 03 20 00 41 01 00 00 -> 60 03 20 00 00 00 00 00
        2306   ms  40 03 20 00 00 00 00 00 -> 43 03 20 00 40 01 00 00
        2308   ms  23 03 20 00 41 01 00 00 -> 60 03 20 00 00 00 00 00
        3510   ms  40 03 20 00 00 00 00 00 -> 43 03 20 00 41 01 00 00
    "#]],
    );
}

/// NM17x GEN-05, ADDR-02, HB-01, PDO-05: 120 devices get a node-ID each, one after the other, and
/// then share a bus at 1 Mbit/s, each with a heartbeat and its position every 100 ms: none is missing.
#[test]
fn many_devices_share_a_bus() {
    const DEVICES: u16 = 120;
    let mut scene = Scene::powered("nm172", &[TWIN.as_slice(), &["--nodes", "120"]].concat());
    let power = |scene: &mut Scene, node: u16, on: bool| {
        scene.tell("power", json!({ "node": node - 1, "on": on }));
    };
    (1..=DEVICES).for_each(|node| power(&mut scene, node, false));
    for node in 1..=DEVICES {
        power(&mut scene, node, true);
        scene.run_ms(200).node_id(127).request("2F 00 21 00 08 00 00 00");
        scene.request(&format!("2F 01 21 00 {node:02X} 00 00 00"));
        scene.run_ms(20);
        power(&mut scene, node, false);
    }
    (1..=DEVICES).for_each(|node| power(&mut scene, node, true));
    scene.run_ms(500);
    for node in 1..=DEVICES {
        for request in
            ["2B 17 10 00 64 00 00 00", "2F 01 18 02 FE 00 00 00", "2B 01 18 05 64 00 00 00"]
        {
            scene.node_id(node).request(request);
        }
    }
    scene.send("000#01 00").run_ms(500).frames();
    let frames = scene.run_ms(1_000).frames();
    for node in 1..=DEVICES {
        let position = format!("{:03X}#00 00 00 00 00 00 00 10", 0x280 + node);
        for frame in [format!("{:03X}#05", 0x700 + node), position] {
            let sent = frames.iter().filter(|sent| **sent == frame).count();
            assert!((9..=11).contains(&sent), "{sent} times {frame} in a second");
        }
    }
}
