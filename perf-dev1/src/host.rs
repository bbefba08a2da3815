//! On the host, under a tool that counts the instructions of `operate`.

use crate::operations::{OPERATIONS, Operation};
use crate::{Memory, Stack};

/// Without arguments, checks all operations. With the place of an operation and a number, does it
/// that often.
///
/// # Panics
/// When a stack does not do what it should, or for other arguments.
pub fn main<S: Stack>() -> ! {
    run::<S>();
    std::process::exit(0)
}

fn run<S: Stack>() {
    let mut arguments = std::env::args().skip(1);
    let Some(place) = arguments.next() else {
        return OPERATIONS.iter().for_each(Operation::check::<S>);
    };
    let number = |text: Option<String>| text.and_then(|text| text.parse::<usize>().ok());
    let operation = number(Some(place)).and_then(|place| OPERATIONS.get(place));
    let operation = operation.expect("the place of an operation");
    let times = number(arguments.next()).expect("a number of times");
    let bus = Memory::default();
    let (mut stack, frames) = operation.prepare::<S>(&bus);
    for frame in frames.iter().cycle().take(times) {
        operation.run(&mut stack, frame, &bus);
    }
}
