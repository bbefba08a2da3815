//! The control port, on devices that do nothing but send.

use crate::senders::{Senders, Talk};
use bench::args::Clock;
use bench::run::End;
use bench::{Bench, Setup};
use expect_test::{Expect, expect};

/// The answers to `requests`, on a bench of two devices whose clock stands.
fn transcript(requests: &[&str]) -> String {
    let bench = Bench::start(Setup::new("nm172", Clock::Step), Senders::boxed(2)).unwrap();
    let mut talk = Talk::with(bench.control());
    let answers: String = requests.iter().map(|request| talk.ask(request) + "\n").collect();
    assert_eq!(bench.stop(), End::Stopped);
    answers
}

#[track_caller]
fn check(requests: &[&str], expected: &Expect) {
    expected.assert_eq(&transcript(requests));
}

#[test]
fn time_passes_only_when_asked() {
    check(
        &[
            r#"{"id":1,"do":"now"}"#,
            r#"{"id":2,"do":"advance","us":1500}"#,
            r#"{"id":3,"do":"advance","us":0}"#,
            r#"{"id":"four","do":"now"}"#,
        ],
        &expect![[r#"
            {"id":1,"ok":true,"us":0}
            {"id":2,"ok":true,"us":1500}
            {"id":3,"ok":true,"us":1500}
            {"id":"four","ok":true,"us":1500}
        "#]],
    );
}

#[test]
fn the_log_of_the_bus_tells_who_sent_what_and_each_frame_once() {
    check(
        &[
            r#"{"id":0,"do":"can_send","data":"0100"}"#,
            r#"{"id":2,"do":"advance","us":150000}"#,
            r#"{"id":3,"do":"can_log"}"#,
            r#"{"id":4,"do":"can_log"}"#,
            r#"{"id":5,"do":"log","node":1}"#,
            r#"{"id":6,"do":"log","node":1}"#,
        ],
        &expect![[r#"
            {"id":0,"ok":true}
            {"id":2,"ok":true,"us":150000}
            {"id":3,"ok":true,"frames":[{"data":"0100","dir":"in","extended":false,"id":0,"rtr":false,"us":520},{"data":"05","dir":"out","extended":false,"id":1793,"node":0,"rtr":false,"us":100440},{"data":"05","dir":"out","extended":false,"id":1794,"node":1,"rtr":false,"us":100904}]}
            {"id":4,"ok":true,"frames":[]}
            {"id":5,"ok":true,"lines":[{"level":"info","mcu":"stm","text":"sent","us":100904}]}
            {"id":6,"ok":true,"lines":[]}
        "#]],
    );
}

#[test]
fn the_surroundings_can_be_worked_and_seen() {
    check(
        &[
            r#"{"id":1,"do":"shaft","steps":-5}"#,
            r#"{"id":2,"do":"shaft","steps_per_s":4000}"#,
            r#"{"id":3,"do":"advance","us":1000}"#,
            r#"{"id":4,"do":"shaft","steps_per_s":0}"#,
            r#"{"id":5,"do":"shaft","steps":0,"node":1}"#,
            r#"{"id":6,"do":"motor"}"#,
            r#"{"id":7,"do":"key","name":"left","down":true}"#,
            r#"{"id":8,"do":"input","pin":"G","high":true}"#,
            r#"{"id":9,"do":"motor_model","slow":7,"fault":true}"#,
            r#"{"id":10,"do":"sensor","connected":false}"#,
            r#"{"id":11,"do":"link","cut":true}"#,
            r#"{"id":12,"do":"power_cut","mcu":"stm","flash_op":1}"#,
            r#"{"id":13,"do":"stats"}"#,
            r#"{"id":14,"do":"display"}"#,
        ],
        &expect![[r#"
            {"id":1,"ok":true,"raw":16777211}
            {"id":2,"ok":true,"raw":16777211}
            {"id":3,"ok":true,"us":1000}
            {"id":4,"ok":true,"raw":16777215}
            {"id":5,"ok":true,"raw":16777216}
            {"id":6,"ok":true,"in1":false,"in2":false,"in3":false,"in4":false,"steps_per_s":0}
            {"id":7,"ok":true}
            {"id":8,"ok":true}
            {"id":9,"ok":true}
            {"id":10,"ok":true}
            {"id":11,"ok":true}
            {"id":12,"ok":true}
            {"id":13,"ok":true,"stm":{"awake_fraction":0.0,"can_interrupts":0,"can_reaction_ns":0,"can_wait_ns":0,"flash_ops":0,"instructions":0,"masked_ns":0,"resets":[],"sector_erases":0,"stack_used":0},"msp":{"awake_fraction":0.0,"can_interrupts":0,"can_reaction_ns":0,"can_wait_ns":0,"flash_ops":0,"instructions":0,"masked_ns":0,"resets":[],"sector_erases":0,"stack_used":0}}
            {"id":14,"ok":true,"upper":"      ","lower":"      ","left_arrow":false,"right_arrow":false,"segments":"0000000000000000000000000000000000000000","ascii":"                          \n                          \n                          \n                          \n                          \n                          \n                          \n"}
        "#]],
    );
}

#[test]
fn faults_of_the_bus_show_in_its_log() {
    check(
        &[
            r#"{"id":1,"do":"can_fault","no_ack":true}"#,
            r#"{"id":2,"do":"advance","us":105000}"#,
            r#"{"id":3,"do":"can_log"}"#,
            r#"{"id":4,"do":"can_fault","no_ack":false}"#,
            r#"{"id":5,"do":"power","on":false}"#,
            r#"{"id":6,"do":"advance","us":20000}"#,
            r#"{"id":7,"do":"can_log"}"#,
        ],
        &expect![[r#"
            {"id":1,"ok":true}
            {"id":2,"ok":true,"us":105000}
            {"id":3,"ok":true,"frames":[]}
            {"id":4,"ok":true}
            {"id":5,"ok":true}
            {"id":6,"ok":true,"us":125000}
            {"id":7,"ok":true,"frames":[{"data":"05","dir":"out","extended":false,"id":1794,"node":1,"rtr":false,"us":105480}]}
        "#]],
    );
}

#[test]
fn what_can_not_be_done_is_refused_and_the_line_lives_on() {
    let long = "x".repeat(bench::control::LINE_MAX + 1);
    check(
        &[
            "what",
            "",
            "[1]",
            &long,
            r#"{"id":1,"do":"fly"}"#,
            r#"{"id":2,"do":"now","node":2}"#,
            r#"{"id":3,"do":"leds"}"#,
            r#"{"id":4,"do":"switches"}"#,
            r#"{"id":5,"do":"battery"}"#,
            r#"{"id":6,"do":"key","name":"chain","down":true}"#,
            r#"{"id":7,"do":"sensor","value":3}"#,
            r#"{"id":8,"do":"now"}"#,
        ],
        &expect![[r#"
            {"id":null,"ok":false,"error":"this is no JSON: expected value at line 1 column 1"}
            {"id":null,"ok":false,"error":"this is no JSON: EOF while parsing a value at line 1 column 0"}
            {"id":null,"ok":false,"error":"a request is a JSON object"}
            {"id":null,"ok":false,"error":"a line has at most 4096 bytes"}
            {"id":1,"ok":false,"error":"there is no verb \"fly\""}
            {"id":2,"ok":false,"error":"there is no node 2: there are 2, from 0"}
            {"id":3,"ok":false,"error":"nm172 has no LEDs"}
            {"id":4,"ok":false,"error":"nm172 has no switches for node-ID and bit rate"}
            {"id":5,"ok":false,"error":"nm172 has no battery"}
            {"id":6,"ok":false,"error":"nm172 has no key \"chain\": its keys are \"left\" and \"right\""}
            {"id":7,"ok":false,"error":"nm172 has no sensor whose word can be set: turn its shaft"}
            {"id":8,"ok":true,"us":0}
        "#]],
    );
}

#[test]
fn the_same_requests_give_the_same_answers() {
    let requests = [
        r#"{"id":1,"do":"can_fault","error_rate":0.3}"#,
        r#"{"do":"can_send","id":1,"data":"00"}"#,
        r#"{"id":3,"do":"advance","us":2000000}"#,
        r#"{"id":4,"do":"can_log"}"#,
        r#"{"id":5,"do":"stats"}"#,
    ];
    assert_eq!(transcript(&requests), transcript(&requests));
}

#[test]
fn requests_of_one_client_are_answered_in_order_and_clients_do_not_disturb_each_other() {
    let bench = Bench::start(Setup::new("nm172", Clock::Step), Senders::boxed(1)).unwrap();
    let mut one = Talk::with(bench.control());
    let mut other = Talk::with(bench.control());
    let all: String = (0..100).map(|n| format!("{{\"id\":{n},\"do\":\"now\"}}\n")).collect();
    one.say(&all);
    assert_eq!(other.ask(r#"{"id":"x","do":"now"}"#), r#"{"id":"x","ok":true,"us":0}"#);
    for n in 0..100 {
        assert_eq!(one.hear(b'\n'), format!("{{\"id\":{n},\"ok\":true,\"us\":0}}\n"));
    }
}

#[test]
fn with_the_real_clock_time_passes_by_itself_and_can_not_be_advanced() {
    let bench = Bench::start(Setup::new("nm172", Clock::Real), Senders::boxed(1)).unwrap();
    let mut talk = Talk::with(bench.control());
    let refused = talk.ask(r#"{"id":1,"do":"advance","us":1}"#);
    assert!(refused.starts_with(r#"{"id":1,"ok":false"#), "{refused}");
    let us = |answer: String| -> u64 {
        let answer: serde_json::Value = serde_json::from_str(&answer).unwrap();
        answer["us"].as_u64().unwrap()
    };
    let first = us(talk.ask(r#"{"do":"now"}"#));
    while us(talk.ask(r#"{"do":"now"}"#)) < first + 20_000 {}
    assert_eq!(bench.stop(), End::Stopped);
}

#[test]
fn an_engine_that_can_not_go_on_says_so_and_time_stands_still() {
    let bench = Bench::start(Setup::new("nm172", Clock::Step), Senders::boxed(1)).unwrap();
    let mut talk = Talk::with(bench.control());
    let sentence = r#""ok":false,"error":"nobody knows what comes after 10 s"}"#;
    assert_eq!(
        talk.ask(r#"{"id":1,"do":"advance","us":11000000}"#),
        r#"{"id":1,"#.to_owned() + sentence
    );
    assert_eq!(talk.ask(r#"{"id":2,"do":"now"}"#), r#"{"id":2,"ok":true,"us":10000000}"#);
    assert_eq!(talk.ask(r#"{"id":3,"do":"advance","us":1}"#), r#"{"id":3,"#.to_owned() + sentence);
    assert_eq!(bench.stop(), End::Failed("nobody knows what comes after 10 s".to_owned()));
}

#[test]
fn a_client_that_closes_its_direction_still_gets_its_answers() {
    let bench = Bench::start(Setup::new("nm172", Clock::Step), Senders::boxed(1)).unwrap();
    let mut talk = Talk::with(bench.control());
    talk.say("{\"id\":1,\"do\":\"now\"}\n{\"id\":2,\"do\":\"now\"}\n");
    talk.close_own_direction();
    assert_eq!(talk.hear(b'\n'), "{\"id\":1,\"ok\":true,\"us\":0}\n");
    assert_eq!(talk.hear(b'\n'), "{\"id\":2,\"ok\":true,\"us\":0}\n");
    assert_eq!(talk.hear(b'\n'), "");
}

#[test]
fn the_first_line_tells_where_everything_is() {
    let mut setup = Setup::new("nm172", Clock::Step);
    setup.socketcand = Some(([127, 0, 0, 1], 0).into());
    let bench = Bench::start(setup, Senders::boxed(2)).unwrap();
    let line: serde_json::Value = serde_json::from_str(&bench.ready_line()).unwrap();
    assert_eq!(line["ready"], true);
    assert_eq!(line["slcan"], bench.slcan().to_string());
    assert_eq!(line["socketcand"], bench.socketcand().unwrap().to_string());
    assert_eq!(line["control"], bench.control().to_string());
    assert_eq!(line["products"], serde_json::json!(["nm172", "nm172"]));
}
