//! The program as a user starts it: what is wrong is said in one sentence, with exit code 2.

use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Command, Output};

fn bench(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_bench"))
        .args(arguments)
        .env("SPINDLE_IMAGES", "/nonexistent/images")
        .output()
        .unwrap()
}

#[track_caller]
fn refused(arguments: &[&str], named: &str) {
    let output = bench(arguments);
    let sentence = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {sentence}");
    assert_eq!(sentence.lines().count(), 1, "{arguments:?}: {sentence}");
    assert!(sentence.contains(named), "{arguments:?}: {sentence}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
}

fn scratch(name: &str) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    if dir.exists() {
        std::fs::remove_dir_all(&dir).unwrap();
    }
    std::fs::create_dir_all(&dir).unwrap();
    dir
}

#[test]
fn what_is_wrong_is_named_in_one_sentence() {
    refused(&[], "bench up");
    refused(&["up"], "PRODUCT");
    refused(&["up", "nm172", "--fly"], "--fly");
    refused(&["up", "nm999"], "nm999");
    refused(&["up", "nm999", "--engine", "twin"], "gxmm");
    refused(&["up", "gxmm"], "--engine twin");
    refused(&["up", "dev1", "--engine", "twin"], "--engine image");
    refused(&["up", "dev1"], "/nonexistent/images/stm-dev1");
    refused(&["up", "nm172", "--clock", "sundial"], "sundial");
    refused(&["up", "nm172"], "/nonexistent/images/stm-nm172");
}

#[test]
fn a_state_directory_that_is_none_is_refused() {
    let dir = scratch("not-a-directory");
    let file = dir.join("file");
    std::fs::write(&file, "").unwrap();
    refused(&["up", "nm172", "--state", file.to_str().unwrap()], "file");
    std::fs::write(dir.join("node0-stm.flash"), "").unwrap();
    refused(&["up", "nm172", "--state", dir.to_str().unwrap()], "node0-stm.flash");
    std::fs::write(dir.join("product"), "ap04\n").unwrap();
    refused(&["up", "nm172", "--state", dir.to_str().unwrap()], "ap04");
}

#[test]
fn a_busy_port_is_refused() {
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap();
    let error = bench::Bench::start(
        bench::Setup { slcan: address, ..bench::Setup::new("nm172", bench::args::Clock::Step) },
        crate::senders::Senders::boxed(1),
    );
    let sentence = error.map(|_| ()).unwrap_err();
    assert!(sentence.contains(&address.to_string()), "{sentence}");
    assert_eq!(sentence.lines().count(), 1);
}

#[test]
fn help_goes_to_standard_output_with_exit_code_0() {
    for arguments in [&["--help"][..], &["up", "--help"], &["--version"]] {
        let output = bench(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}");
        assert_eq!(output.stderr, b"", "{arguments:?}");
        assert!(!output.stdout.is_empty(), "{arguments:?}");
    }
}
