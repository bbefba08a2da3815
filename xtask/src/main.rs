//! `cargo xtask`: the one entry point to everything that is more than a single cargo call.

use std::process::ExitCode;

mod codegen;
mod flash;
mod fuzz;
mod images;
mod miri;
mod panics;
mod python;
mod qemu;
mod run;
mod size;
mod stack;
mod test;
mod tools;
mod trace;
mod up;

use run::Failure;

const HELP: &str = "\
cargo xtask VERB

  up PRODUCT [OPTIONS]     build the images and the bench, then start the bench with these options
  test                     everything that has to pass: style, lints, documentation, all tests
  ci                       the same as test
  codegen                  write the files that are made from the dictionaries
  size                     flash and RAM of the images, and the crates that take most of it
  size --stack             flash and RAM of the smallest CANopen device, beside other stacks
  perf                     count the instructions of the CANopen stack and of others, measure the
                           images on the bench
  perf --stack             count the instructions of the CANopen stack, in seconds
  perf --peers             count those of other stacks too
  panics                   look in the images for ways from the logic to a panic
  fuzz [TARGET] [--minutes N]
                           look for inputs that break a rule, 10 minutes for each target
  miri                     run the tests of what takes bytes from outside under Miri
  trace                    which requirement is shown by which test
  flash PRODUCT --stm PROBE --msp PROBE
                           build the images and write them to two boards

Products with images: nm172. The bench also has dev1, the device that stacks are judged by, and with
--engine twin all products (docs/bench.md).";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments.as_slice() {
        ["up", rest @ ..] => up::up(rest),
        ["test" | "ci"] => test::test(),
        ["codegen"] => codegen::write(),
        ["size"] => size::size().and_then(|()| stack::footprint()),
        ["size", "--stack"] => stack::footprint(),
        ["perf"] => stack::perf_with_peers().and_then(|()| up::perf()),
        ["perf", "--stack"] => stack::perf(),
        ["perf", "--peers"] => stack::perf_with_peers(),
        ["panics"] => panics::panics(),
        ["fuzz", rest @ ..] => fuzz::fuzz(rest),
        ["miri"] => miri::miri(),
        ["trace"] => trace::trace(),
        ["flash", rest @ ..] => flash::flash(rest),
        ["help" | "--help" | "-h"] => {
            println!("{HELP}");
            Ok(())
        }
        [] => Err(Failure::Usage(format!("a verb is missing\n\n{HELP}"))),
        [
            verb @ ("test" | "ci" | "codegen" | "size" | "perf" | "panics" | "miri" | "trace"),
            extra,
            ..,
        ] => Err(Failure::Usage(format!("`cargo xtask {verb}` takes no `{extra}`"))),
        [verb, ..] => Err(Failure::Usage(format!("there is no verb `{verb}`\n\n{HELP}"))),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
