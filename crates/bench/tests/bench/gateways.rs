//! The CAN gateways, on devices that do nothing but send.

use crate::senders::{Senders, Talk};
use bench::args::Clock;
use bench::{Bench, Setup};

/// A bench of one device, whose clock stands, with every gateway.
fn bench() -> Bench {
    let mut setup = Setup::new("nm172", Clock::Step);
    setup.socketcand = Some("127.0.0.1:0".parse().unwrap());
    Bench::start(setup, Senders::boxed(1)).unwrap()
}

/// An SLCAN client on an open channel.
fn slcan(bench: &Bench, commands: &str) -> Talk {
    let mut talk = Talk::with(bench.slcan());
    talk.say(commands);
    for _ in commands.split_terminator('\r') {
        assert_eq!(talk.hear_bytes(1), "\r", "{commands:?}");
    }
    talk
}

fn advance(control: &mut Talk, us: u64) {
    let answer = control.ask(&format!("{{\"do\":\"advance\",\"us\":{us}}}"));
    assert!(answer.contains("\"ok\":true"), "{answer}");
}

#[test]
fn slcan_clients_hear_the_devices_and_each_other() {
    let bench = bench();
    let mut control = Talk::with(bench.control());
    let mut one = slcan(&bench, "S4\rO\r");
    let mut other = slcan(&bench, "S4\rZ1\rO\r");
    one.say("t12320aFf\rT0000012310a\rr7015\r");
    assert_eq!(one.hear_bytes(6), "z\rZ\rz\r");
    advance(&mut control, 110_000);
    assert_eq!(other.hear(b'\r'), "t12320AFF0000\r");
    assert_eq!(other.hear(b'\r'), "T0000012310A0001\r");
    assert_eq!(other.hear(b'\r'), "r70150001\r");
    assert_eq!(other.hear(b'\r'), "t7011050064\r");
    assert_eq!(one.hear(b'\r'), "t701105\r");
}

#[test]
fn slcan_at_the_wrong_bit_rate_brings_errors_and_no_data() {
    let bench = bench();
    let mut control = Talk::with(bench.control());
    let mut wrong = slcan(&bench, "S6\rL\r");
    advance(&mut control, 210_000);
    assert_eq!(wrong.hear(b'\r'), "e1F\r");
    wrong.say("F\r");
    let flags = loop {
        match wrong.hear(b'\r') {
            line if line == "e1F\r" => {}
            line => break line,
        }
    };
    let flags = u8::from_str_radix(flags.trim_start_matches('F').trim_end(), 16).unwrap();
    assert_ne!(flags & 0x80, 0, "bus error");
}

#[test]
fn slcan_answers_every_line_in_every_state() {
    let bench = bench();
    for (lines, answers) in [
        ("O\r", "\x07"),
        ("t0000\r", "\x07"),
        ("F\r", "\x07"),
        ("C\r", "\x07"),
        ("\r\r\r", "\r\r\r"),
        ("V\rv\rN\r", "V0101\rv0101\rN0001\r"),
        ("S4\rO\rO\r", "\r\r\x07"),
        ("S4\rO\rS5\rZ1\r", "\r\r\x07\x07"),
        ("S4\rO\rC\rC\r", "\r\r\r\x07"),
        ("S4\rO\rF\r", "\r\rF00\r"),
        ("S4\rL\rt0000\r", "\r\r\x07"),
        ("S4\r\nO\r\n", "\r\r"),
        ("M00000000\rmFFFFFFFF\r", "\r\r"),
        ("nonsense\rV\r", "\x07V0101\r"),
        (
            "tttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttttt\rV\r",
            "\x07V0101\r",
        ),
    ] {
        let mut talk = Talk::with(bench.slcan());
        talk.say(lines);
        assert_eq!(talk.hear_bytes(answers.len()), answers, "{lines:?}");
    }
}

#[test]
fn a_client_that_leaves_is_off_the_bus() {
    let bench = bench();
    let mut control = Talk::with(bench.control());
    let mut listener = slcan(&bench, "S4\rL\r");
    drop(slcan(&bench, "S6\rO\r"));
    // The node at the wrong rate would destroy every frame.
    advance(&mut control, 110_000);
    let mut line = listener.hear(b'\r');
    while line == "e1F\r" {
        advance(&mut control, 100_000);
        line = listener.hear(b'\r');
    }
    assert_eq!(line, "t701105\r");
}

#[test]
fn socketcand_clients_hear_the_devices_and_are_heard() {
    let bench = bench();
    let mut control = Talk::with(bench.control());
    let mut listener = slcan(&bench, "S4\rO\r");
    let mut talk = Talk::with(bench.socketcand().unwrap());
    for (say, hear) in [
        ("", "< hi >"),
        ("< echo >", "< echo >"),
        ("< rawmode >", "< error not in this state >"),
        ("< open can1 >", "< error could not open bus >"),
        ("< open can0 >", "< ok >"),
        ("< open can0 >", "< error not in this state >"),
        ("< send 001 0 >", "< error not in this state >"),
        ("< rawmode >", "< ok >"),
        ("< send 001 1 >", "< error that is no CAN frame >"),
        ("< fly >", "< error unknown command >"),
    ] {
        talk.say(say);
        assert_eq!(talk.hear(b'>'), hear, "{say}");
    }
    talk.say("< send 123 2 a ff >< echo >");
    assert_eq!(talk.hear(b'>'), "< echo >");
    advance(&mut control, 110_000);
    assert_eq!(listener.hear(b'\r'), "t12320AFF\r");
    assert_eq!(talk.hear(b'>'), "< frame 701 0.100432 05 >");
}
