//! Whatever a client sends: no panic, and one answer for each line.

use bench::slcan::Channel;
use bench::{control, slcan, socketcand};
use proptest::prelude::*;
use world::can::Bus;

/// Bytes that are often nearly right.
fn noise(letters: &'static str) -> impl Strategy<Value = Vec<u8>> {
    let likely = prop::sample::select(letters.as_bytes());
    prop::collection::vec(prop_oneof![9 => likely, 1 => any::<u8>()], 0..400)
}

fn count(bytes: &[u8], wanted: u8) -> usize {
    bytes.iter().filter(|&&byte| byte == wanted).count()
}

proptest! {
    #[test]
    fn slcan_answers_each_line_once(bytes in noise("\r\r\rtTrRSOLCFZVvNM0148fF"), cut in 0usize..400) {
        let mut bus = Bus::new(0);
        let mut channel = Channel::default();
        let (one, two) = bytes.split_at(cut.min(bytes.len()));
        let mut answers = channel.handle(&mut bus, one);
        answers.extend(channel.handle(&mut bus, two));
        let ends = count(&answers, b'\r') + count(&answers, b'\x07');
        prop_assert_eq!(ends, count(&bytes, b'\r'));
        channel.leave(&mut bus);
    }

    #[test]
    fn slcan_commands_survive_any_line(line in prop::collection::vec(any::<u8>(), 0..40)) {
        let _ = slcan::Command::parse(&line);
    }

    #[test]
    fn socketcand_answers_with_whole_messages(bytes in noise("<> opencan0 rawmode send 123 1 FF echo")) {
        let mut bus = Bus::new(0);
        let mut session = socketcand::Session::default();
        let answers = session.handle(&mut bus, b"< open can0 >< rawmode >");
        prop_assert_eq!(answers, b"< ok >< ok >".to_vec());
        let answers = session.handle(&mut bus, &bytes);
        prop_assert_eq!(count(&answers, b'<'), count(&answers, b'>'));
        prop_assert!(count(&answers, b'>') <= count(&bytes, b'>') + bytes.len() / socketcand::MESSAGE_MAX + 1);
        session.leave(&mut bus);
    }

    #[test]
    fn control_answers_any_line_with_one_line_of_json(bytes in noise("{}\":,id do now us advance 1234567890 nul true")) {
        let asked = control::parse(&bytes);
        let answer = control::write(&asked.id, &asked.request.map(|_| Vec::new()));
        prop_assert_eq!(count(answer.as_bytes(), b'\n'), 1);
        let json: serde_json::Value = serde_json::from_str(&answer).unwrap();
        prop_assert!(json["ok"].is_boolean());
    }

    #[test]
    fn control_survives_any_value_in_any_field(
        verb in prop::sample::select(&[
            "now", "advance", "shaft", "key", "input", "motor", "motor_model", "sensor", "display",
            "leds", "switches", "battery", "power", "power_cut", "link", "can_send", "can_log",
            "can_fault", "log", "stats", "fly",
        ][..]),
        field in prop::sample::select(&[
            "us", "steps", "steps_per_s", "name", "down", "pin", "high", "slow", "connected", "on",
            "mcu", "flash_op", "cut", "drop_rate", "data", "rtr", "error_rate", "node", "can_id",
        ][..]),
        value in prop::sample::select(&[
            "null", "true", "-1", "0", "1", "1.5", "1e300", "18446744073709551616", "\"\"",
            "\"left\"", "\"stm\"", "\"0g\"", "\"00\"", "[]", "{}", "[[1]]",
        ][..]),
    ) {
        let line = format!("{{\"id\":1,\"do\":\"{verb}\",\"{field}\":{value}}}");
        let asked = control::parse(line.as_bytes());
        prop_assert_eq!(asked.id, serde_json::json!(1));
        if let Err(sentence) = asked.request {
            prop_assert_eq!(sentence.lines().count(), 1);
        }
    }
}
