//! What a receiver makes of a line that is not clean.

use proptest::prelude::*;
use shared_proto::{ProcessData, Receiver, ToApplication, ToInterface, encode};

fn process_data(cycle: u8) -> ToInterface {
    ToInterface::Process(ProcessData {
        cycle,
        position_hundredths_mm: -123_456,
        ..ProcessData::default()
    })
}

fn received(bytes: impl IntoIterator<Item = u8>) -> (Vec<ToInterface>, u32) {
    let mut receiver = Receiver::default();
    let messages = bytes.into_iter().filter_map(|byte| receiver.push(byte)).collect();
    (messages, receiver.damaged())
}

/// NM17x LINK-06: damage is noticed, and the next frame is whole again.
#[test]
fn a_receiver_finds_its_place_at_the_next_zero() {
    let (first, second) = (encode(&process_data(1)), encode(&process_data(2)));
    let whole = |frame: &[u8]| frame.to_vec();
    for (name, line, messages, damaged) in [
        ("clean", [whole(&first), whole(&second)].concat(), vec![1, 2], 0),
        ("begun in the middle", [first[4..].to_vec(), whole(&second)].concat(), vec![2], 1),
        ("cut short", [first[..6].to_vec(), vec![0], whole(&second)].concat(), vec![2], 1),
        ("zeros between", [vec![0, 0], whole(&first), vec![0, 0]].concat(), vec![1], 0),
        ("noise of any length", [vec![0x55; 500], vec![0], whole(&second)].concat(), vec![2], 1),
        ("lost zero", [first[..first.len() - 1].to_vec(), whole(&second)].concat(), vec![], 1),
    ] {
        let (got, dropped) = received(line);
        let expected: Vec<ToInterface> = messages.into_iter().map(process_data).collect();
        assert_eq!((got, dropped), (expected, damaged), "{name}");
    }
}

/// NM17x LINK-06: every error of one or two bits is found.
#[test]
fn no_frame_with_one_or_two_wrong_bits_is_used() {
    let frame = encode(&process_data(9));
    let bits = (frame.len() - 1) * 8;
    // An interpreter needs minutes for all of them.
    let stride = if cfg!(miri) { 17 } else { 1 };
    for a in (0..bits).step_by(stride) {
        for b in (a..bits).step_by(stride) {
            let mut wire = frame.to_vec();
            wire[a / 8] ^= 1 << (a % 8);
            if a != b {
                wire[b / 8] ^= 1 << (b % 8);
            }
            let (messages, _) = received(wire);
            assert_eq!(messages, [], "bits {a} and {b}");
        }
    }
}

proptest! {
    /// NM17x LINK-06: whatever comes, the receiver lives, and the frame behind the next zero is
    /// received. Proptest prints the seed of a failure.
    #[test]
    fn any_bytes_leave_a_receiver_that_works(noise in prop::collection::vec(any::<u8>(), 0..300)) {
        let mut to_interface = Receiver::<ToInterface>::default();
        let mut to_application = Receiver::<ToApplication>::default();
        for &byte in noise.iter().chain(&[0]) {
            to_interface.push(byte);
            to_application.push(byte);
        }
        let mut last = None;
        for byte in encode(&process_data(7)) {
            last = to_interface.push(byte);
        }
        prop_assert_eq!(last, Some(process_data(7)));
    }
}
