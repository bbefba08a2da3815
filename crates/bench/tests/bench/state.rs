//! Flash contents kept between runs.

use std::path::PathBuf;

use crate::senders::{Senders, Talk};
use bench::args::Clock;
use bench::run::End;
use bench::state::StateDir;
use bench::{Bench, Setup};

fn scratch(name: &str) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    if dir.exists() {
        std::fs::remove_dir_all(&dir).unwrap();
    }
    dir
}

fn stm_of_first_device(state: &StateDir) -> Option<String> {
    let [stm, _] = state.load(1).unwrap().remove(0);
    stm.map(|bytes| String::from_utf8(bytes).unwrap())
}

#[test]
fn contents_are_written_while_running_and_at_the_end() {
    let dir = scratch("kept");
    let state = StateDir::open(&dir, "nm172").unwrap();
    assert_eq!(stm_of_first_device(&state), None);

    let setup = Setup { state: Some(state), ..Setup::new("nm172", Clock::Step) };
    let bench = Bench::start(setup, Senders::boxed(2)).unwrap();
    let mut control = Talk::with(bench.control());
    control.ask(r#"{"do":"advance","us":1050000}"#);
    let written = std::fs::read_to_string(dir.join("node0-stm.flash")).unwrap();
    assert!(written.starts_with("0 stm after "), "{written}");
    control.ask(r#"{"do":"advance","us":500000}"#);
    assert_eq!(std::fs::read_to_string(dir.join("node0-stm.flash")).unwrap(), written);
    assert_eq!(bench.stop(), End::Stopped);

    let state = StateDir::open(&dir, "nm172").unwrap();
    assert_eq!(stm_of_first_device(&state).as_deref(), Some("0 stm after 30"));
}

#[test]
fn a_directory_belongs_to_one_bench_and_one_product() {
    let dir = scratch("taken");
    let first = StateDir::open(&dir, "nm172").unwrap();
    assert!(StateDir::open(&dir, "nm172").unwrap_err().contains("another bench"));
    drop(first);
    assert!(StateDir::open(&dir, "ap04").unwrap_err().contains("nm172"));
}
