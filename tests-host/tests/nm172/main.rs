//! The NM172 on the bench: both images as they are flashed.

use std::collections::BTreeSet;

use serde_json::json;
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
