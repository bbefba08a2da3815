//! The shortest way through the whole device: sensor, both controllers, link, CAN, display.

use serde_json::{Value, json};
use tests_host::{Bench, Frame};

/// Node-ID at delivery.
const NODE_ID: u16 = 127;

/// Virtual time until the boot-up message, with new parameter memory, and some to spare.
const BOOT_MS: u64 = 200;

/// Frames that devices sent since the last call.
fn sent(bench: &mut Bench) -> Vec<Frame> {
    let log = bench.tell("can_log", json!({}));
    let frames = log.get("frames").and_then(Value::as_array).cloned().unwrap_or_default();
    frames
        .iter()
        .filter(|frame| frame["dir"] == "out")
        .map(|frame| {
            let hex = frame["data"].as_str().unwrap_or_default();
            let byte = |at| u8::from_str_radix(&hex[at..at + 2], 16).expect("two hex digits");
            let id = frame["id"].as_u64().and_then(|id| u16::try_from(id).ok());
            let data = (0..hex.len()).step_by(2).map(byte).collect();
            Frame { id: id.expect("an 11-bit identifier"), data }
        })
        .collect()
}

/// NM17x BOOT-03, OD-1000-1, GEN-05, SDO-10.
#[test]
fn a_master_reads_the_device_type_after_the_boot_up_message() {
    let mut bench = Bench::step("nm172", &[]);
    bench.advance_ms(BOOT_MS);
    assert_eq!(sent(&mut bench), [Frame { id: 0x700 + NODE_ID, data: vec![0] }]);

    let request = json!({"id": 0x600 + NODE_ID, "data": "4000100000000000"});
    bench.tell("can_send", request);
    bench.advance_ms(10);
    let answer = vec![0x43, 0x00, 0x10, 0x00, 0x96, 0x01, 0x02, 0x00];
    assert_eq!(sent(&mut bench), [Frame { id: 0x580 + NODE_ID, data: answer }]);
}

/// NM17x PDO-09, POS-05: one turn is 4.00 mm.
#[test]
fn a_turn_of_the_shaft_reaches_an_slcan_master() {
    let mut bench = Bench::step("nm172", &[]);
    bench.advance_ms(BOOT_MS);
    let mut master = bench.slcan();
    master.open(4);
    master.send(0, &[1, 0]);
    bench.advance_ms(100);
    bench.tell("shaft", json!({"steps": 4096}));
    bench.advance_ms(100);
    let position = loop {
        let Frame { id, data } = master.receive();
        if let (0x2FF, Some(position)) = (id, data.first_chunk()) {
            break i32::from_le_bytes(*position);
        }
    };
    assert_eq!(position % 400, 0, "{position}");
    assert!(bench.stop().0.success());
}
