use canopen::lss::{Event, Settings, Slave, StoreError};
use canopen::{CanId, Frame};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::{IDENTITY, NM17X, REQUEST, RESPONSE, frame, id, selection};

#[derive(Clone, Debug)]
enum Step {
    Receive(Frame),
    Take,
    Stored(Result<(), StoreError>),
}

fn step() -> impl Strategy<Value = Step> {
    let command = prop_oneof![
        4 => Just(0x04_u8), 4 => Just(0x11), 2 => Just(0x13), 2 => Just(0x15), 4 => Just(0x17),
        8 => 0x40..=0x5F_u8, 1 => any::<u8>(),
    ];
    let byte = || prop_oneof![Just(0), Just(1), Just(0xFF), any::<u8>()];
    let request = (command, vec(byte(), 7), 0..=8_usize).prop_map(|(command, rest, len)| {
        let mut data = vec![command];
        data.extend(rest);
        data.truncate(len);
        frame(REQUEST, &data)
    });
    let selecting = prop::sample::select(selection(&IDENTITY).to_vec())
        .prop_map(|request| frame(REQUEST, &request));
    let stored = prop_oneof![Just(Ok(())), Just(Err(StoreError::AccessFailed))];
    prop_oneof![
        12 => request.prop_map(Step::Receive),
        4 => selecting.prop_map(Step::Receive),
        1 => (0..=8_u8).prop_map(|len| {
            Step::Receive(Frame::new_remote(CanId::new(REQUEST).unwrap(), len).unwrap())
        }),
        1 => Just(Step::Receive(frame(RESPONSE, &[0x44, 0, 0, 0, 0, 0, 0, 0]))),
        2 => Just(Step::Take),
        4 => stored.prop_map(Step::Stored),
    ]
}

proptest! {
    /// NM17x LSS-01, LSS-09, ADDR-05: whatever arrives, each answer belongs to its request, and
    /// what is stored is answered at most once.
    #[test]
    fn no_sequence_of_requests_breaks_the_rules(
        settings in prop::sample::select(vec![&NM17X, &Settings::CIA_305]),
        node_id in prop::option::of(1..=127_u8),
        steps in vec(step(), 0..200),
    ) {
        let mut slave = Slave::new(settings, IDENTITY, node_id.map(id));
        let mut unanswered = 0_u32;
        for step in steps {
            let (asked, reaction) = match &step {
                Step::Receive(frame) => (frame.data().first().copied(), slave.handle_frame(frame)),
                Step::Take => (None, slave.take_offer()),
                Step::Stored(outcome) => (None, slave.handle_stored(*outcome)),
            };
            if let Some(response) = reaction.response {
                prop_assert_eq!((response.id().get(), response.dlc()), (RESPONSE, 8));
                let command = response.data().first().copied();
                let fits = match (command, asked) {
                    (Some(0x11 | 0x17), None) => true,
                    (Some(0x44), Some(0x43)) | (Some(0x50), Some(0x4C)) => true,
                    (Some(0x4F), Some(0x4B | 0x51)) => true,
                    (Some(0x11 | 0x13 | 0x5A..=0x5E), Some(_)) => command == asked,
                    _ => false,
                };
                prop_assert!(fits, "{response:02X?} to {step:02X?}");
            }
            match reaction.event {
                Some(Event::Store { .. } | Event::StoreNodeId { .. }) => {
                    prop_assert_eq!(unanswered, 0);
                    unanswered = 1;
                }
                Some(
                    Event::Configured { .. }
                    | Event::ActivateBitTiming { .. }
                    | Event::Offered { .. }
                    | Event::AddressingEnded,
                )
                | None => {}
            }
            if let Step::Stored(_) = step {
                prop_assert!(reaction.response.is_none() || unanswered == 1);
                unanswered = 0;
            }
        }
    }
}
