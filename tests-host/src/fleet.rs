use serde_json::json;

use crate::Scene;

/// NM172 on the twin engine and one bus at 1 Mbit/s, with the node-IDs 1 to `devices`, all
/// Operational: each sends its heartbeat and its position every `period_ms`.
#[must_use]
pub fn fleet(devices: u16, period_ms: u16) -> Scene {
    let options = ["--engine", "twin", "--nodes", &devices.to_string()];
    let mut scene = Scene::powered("nm172", &options);
    let power = |scene: &mut Scene, node: u16, on: bool| {
        scene.tell("power", json!({ "node": node - 1, "on": on }));
    };
    (1..=devices).for_each(|node| power(&mut scene, node, false));
    // One after the other is alone, and gets its node-ID and its bit rate.
    for node in 1..=devices {
        power(&mut scene, node, true);
        scene.run_ms(200).node_id(127).request("2F 00 21 00 08 00 00 00");
        scene.request(&format!("2F 01 21 00 {node:02X} 00 00 00"));
        scene.run_ms(20);
        power(&mut scene, node, false);
    }
    (1..=devices).for_each(|node| power(&mut scene, node, true));
    scene.run_ms(500);
    let [low, high] = period_ms.to_le_bytes();
    let period = format!("{low:02X} {high:02X} 00 00");
    for node in 1..=devices {
        scene.node_id(node).request(&format!("2B 17 10 00 {period}"));
        scene.request("2F 01 18 02 FE 00 00 00");
        scene.request(&format!("2B 01 18 05 {period}"));
    }
    scene.send("000#01 00").run_ms(500).frames();
    scene
}
