//! Mailboxes, priorities, arbitration, abort: RM0090, 32.7.1, 32.7.2.

use crate::rig::{IER, INRQ, MCR, NART, Rig, TI0R, TSR, TXFP, ext_frame, std_frame};
use world::can::{Faults, Frame, Id, Source};

const RQCP: u32 = 1 << 0;
const TXOK: u32 = 1 << 1;
const ALST: u32 = 1 << 2;
const TERR: u32 = 1 << 3;
const ABRQ: u32 = 1 << 7;
const ALL_EMPTY: u32 = 0b111 << 26;

/// What went over the bus, in order.
fn wire(rig: &Rig) -> Vec<Frame> {
    rig.bus.log_since(Default::default()).0.into_iter().map(|logged| logged.frame).collect()
}

fn ids(rig: &Rig) -> Vec<u32> {
    wire(rig).iter().map(|frame| frame.id().value()).collect()
}

fn status(rig: &mut Rig, node: usize, mailbox: u32) -> u32 {
    rig.read(node, TSR) >> (8 * mailbox) & 0xFF
}

#[test]
fn a_frame_goes_out_and_its_mailbox_says_so() {
    let mut rig = Rig::running(2);
    rig.write(0, IER, 1);
    assert_eq!(rig.read(0, TSR), ALL_EMPTY, "reset value");
    rig.send(0, 0, std_frame(0x123, &[1, 2, 3]));
    assert_eq!(rig.read(0, TSR), 0b110 << 26 | 1 << 24, "mailbox 0 waits, 1 is the next free one");
    assert_eq!(rig.lines(0), [false; 4]);
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR), ALL_EMPTY | RQCP | TXOK);
    assert_eq!(rig.read(0, TI0R) & 1, 0, "TXRQ");
    assert_eq!(rig.lines(0), [true, false, false, false]);
    rig.write(0, TSR, RQCP);
    assert_eq!(rig.read(0, TSR), ALL_EMPTY);
    assert_eq!(rig.lines(0), [false; 4]);
    assert_eq!(rig.interrupts(0).transmit, 1);
    assert_eq!(rig.take_all(1, 0), [std_frame(0x123, &[1, 2, 3])]);
    assert_eq!(rig.take_all(0, 0), [], "no node receives its own frame");
}

#[test]
fn remote_and_extended_frames_arrive_as_sent() {
    let frames = [
        std_frame(0x7FF, &[]),
        ext_frame(0x1FFF_FFFF, &[1, 2, 3, 4, 5, 6, 7, 8]),
        ext_frame(0, &[0xFF]),
        Frame::remote(Id::Standard(0x701), 1).unwrap(),
        Frame::remote(Id::Extended(0x1234_5678), 8).unwrap(),
        Frame::remote(Id::Standard(0), 0).unwrap(),
    ];
    for frame in frames {
        let mut rig = Rig::running(2);
        rig.send(0, 2, frame);
        rig.run_us(300);
        assert_eq!(rig.take_all(1, 0), [frame]);
        assert_eq!(status(&mut rig, 0, 2), RQCP | TXOK);
    }
}

#[test]
fn a_length_code_above_eight_carries_eight_bytes() {
    let mut rig = Rig::running(2);
    rig.write(0, TI0R + 4, 15);
    rig.write(0, TI0R + 8, 0x0403_0201);
    rig.write(0, TI0R, 0x10 << 21 | 1);
    rig.run_us(300);
    assert_eq!(rig.take_all(1, 0), [std_frame(0x10, &[1, 2, 3, 4, 0, 0, 0, 0])]);
}

#[test]
fn mailboxes_go_out_by_identifier() {
    let mut rig = Rig::running(2);
    for (mailbox, id) in [(0, 0x300), (1, 0x100), (2, 0x200)] {
        rig.send(0, mailbox, std_frame(id, &[]));
    }
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x100, 0x200, 0x300]);
}

#[test]
fn of_equal_identifiers_the_lower_mailbox_goes_first() {
    let mut rig = Rig::running(2);
    for mailbox in [2, 0, 1] {
        rig.send(0, mailbox, std_frame(0x100, &[u8::try_from(mailbox).unwrap()]));
    }
    rig.run_us(400);
    let order: Vec<u8> = wire(&rig).iter().map(|frame| frame.data()[0]).collect();
    assert_eq!(order, [0, 1, 2]);
}

#[test]
fn by_request_order_mailboxes_go_out_as_they_were_filled() {
    let mut rig = Rig::running(2);
    rig.write(0, MCR, TXFP);
    for (mailbox, id) in [(2, 0x300), (0, 0x200), (1, 0x100)] {
        rig.send(0, mailbox, std_frame(id, &[]));
        rig.run_us(1);
    }
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x300, 0x200, 0x100]);
}

#[test]
fn a_more_important_frame_added_meanwhile_overtakes() {
    let mut rig = Rig::running(2);
    rig.send(0, 0, std_frame(0x300, &[]));
    rig.run_us(5);
    rig.send(0, 1, std_frame(0x200, &[]));
    rig.run_us(20);
    rig.send(0, 2, std_frame(0x100, &[]));
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x300, 0x100, 0x200]);
}

#[test]
fn the_lower_identifier_wins_between_nodes() {
    let mut rig = Rig::running(3);
    rig.send(0, 0, std_frame(0x101, &[]));
    rig.send(1, 0, std_frame(0x100, &[]));
    rig.send(2, 0, std_frame(0x180, &[]));
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x100, 0x101, 0x180]);
    assert_eq!(rig.bus.error_frames(), 0);
    assert_eq!(rig.take_all(0, 0).len(), 2, "the loser receives what it lost to");
    assert_eq!(status(&mut rig, 0, 0), RQCP | TXOK);
}

#[test]
fn standard_beats_extended_and_data_beats_remote() {
    let base = 0x155;
    let frames = [
        std_frame(base, &[7]),
        Frame::remote(Id::Standard(base), 1).unwrap(),
        ext_frame(u32::from(base) << 18, &[7]),
        Frame::remote(Id::Extended(u32::from(base) << 18), 1).unwrap(),
        ext_frame(u32::from(base) << 18 | 1, &[7]),
    ];
    let mut rig = Rig::running(frames.len());
    for (node, frame) in frames.iter().enumerate().rev() {
        rig.send(node, 0, *frame);
    }
    rig.run_us(1000);
    assert_eq!(wire(&rig), frames);
}

#[test]
fn outside_nodes_take_part_in_the_same_arbitration() {
    let mut rig = Rig::running(2);
    let master = rig.attach(1_000_000);
    let tool = rig.attach(1_000_000);
    // The bus is kept busy while all three ask.
    rig.send(1, 0, std_frame(0x7FF, &[0; 8]));
    rig.run_us(50);
    rig.bus.send(master, std_frame(0x080, &[])).unwrap();
    rig.bus.send(tool, std_frame(0x000, &[1, 0])).unwrap();
    rig.send(0, 0, std_frame(0x081, &[]));
    rig.send(0, 1, std_frame(0x07F, &[]));
    rig.run_us(600);
    assert_eq!(ids(&rig), [0x7FF, 0x000, 0x07F, 0x080, 0x081]);
    let (log, _) = rig.bus.log_since(Default::default());
    let sources: Vec<Source> = log.iter().map(|logged| logged.source).collect();
    let [m, t] = [master, tool].map(Source::Outside);
    assert_eq!(sources, [Source::Device(1), t, Source::Device(0), m, Source::Device(0)]);
    let seen: Vec<u32> =
        std::iter::from_fn(|| rig.bus.receive(master)).map(|(_, f)| f.id().value()).collect();
    assert_eq!(seen, [0x7FF, 0x000, 0x07F, 0x081], "all but its own");
}

#[test]
fn losing_arbitration_ends_a_single_shot() {
    let mut rig = Rig::running(2);
    rig.write(0, MCR, NART);
    rig.send(0, 0, std_frame(0x101, &[]));
    rig.send(1, 0, std_frame(0x100, &[]));
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x100]);
    assert_eq!(status(&mut rig, 0, 0), RQCP | ALST);
}

#[test]
fn a_single_shot_is_not_repeated_after_an_error() {
    let mut rig = Rig::running(1);
    rig.write(0, MCR, NART);
    rig.send(0, 1, std_frame(0x101, &[]));
    rig.run_us(400);
    assert_eq!(status(&mut rig, 0, 1), RQCP | TERR);
    assert_eq!(rig.bus.error_frames(), 1);
}

#[test]
fn equal_frames_of_two_nodes_are_one_frame() {
    let mut rig = Rig::running(3);
    rig.send(0, 0, std_frame(0x080, &[]));
    rig.send(1, 0, std_frame(0x080, &[]));
    rig.run_us(200);
    assert_eq!(ids(&rig), [0x080]);
    assert_eq!([status(&mut rig, 0, 0), status(&mut rig, 1, 0)], [RQCP | TXOK; 2]);
    assert_eq!(rig.take_all(2, 0).len(), 1);
}

#[test]
fn equal_identifiers_with_different_data_collide() {
    let mut rig = Rig::running(3);
    rig.write(0, MCR, NART);
    rig.write(1, MCR, NART);
    rig.send(0, 0, std_frame(0x701, &[0x00]));
    rig.send(1, 0, std_frame(0x701, &[0x7F]));
    rig.run_us(200);
    assert_eq!(wire(&rig), []);
    assert_eq!(rig.bus.error_frames(), 1);
    assert_eq!([status(&mut rig, 0, 0), status(&mut rig, 1, 0)], [RQCP | TERR; 2]);
}

#[test]
fn colliding_nodes_sort_it_out_once_they_are_error_passive() {
    let mut rig = Rig::running(3);
    rig.send(0, 0, std_frame(0x701, &[0x00]));
    rig.send(1, 0, std_frame(0x701, &[0x7F]));
    rig.run_us(10_000);
    assert_eq!(wire(&rig), [std_frame(0x701, &[0x00]), std_frame(0x701, &[0x7F])]);
    assert_eq!(rig.bus.error_frames(), 16, "8 a time up to 128");
}

#[test]
fn a_full_set_of_mailboxes_names_the_least_important() {
    let mut rig = Rig::new(1);
    rig.set_up(0, 1_000_000, INRQ);
    rig.send(0, 0, std_frame(0x100, &[]));
    assert_eq!(rig.read(0, TSR) >> 24, 0b0001_1001, "LOW needs two");
    rig.send(0, 1, std_frame(0x300, &[]));
    assert_eq!(rig.read(0, TSR) >> 24, 0b0101_0010);
    rig.send(0, 2, std_frame(0x200, &[]));
    assert_eq!(rig.read(0, TSR) >> 24, 0b0100_0001);
}

#[test]
fn a_waiting_mailbox_is_protected() {
    let mut rig = Rig::new(2);
    rig.set_up(0, 1_000_000, INRQ);
    rig.set_up(1, 1_000_000, 0);
    rig.send(0, 0, std_frame(0x100, &[1]));
    rig.write(0, TI0R + 8, 0xFF);
    rig.write(0, TI0R, 0x7FF << 21 | 1);
    assert_eq!(rig.read(0, TI0R), 0x100 << 21 | 1);
    rig.write(0, MCR, 0);
    rig.run_us(300);
    assert_eq!(rig.take_all(1, 0), [std_frame(0x100, &[1])]);
}

#[test]
fn a_frame_aborted_before_its_start_is_never_sent() {
    let mut rig = Rig::running(2);
    rig.send(1, 0, std_frame(0x000, &[0; 8]));
    rig.run_us(50);
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(10);
    rig.write(0, TSR, ABRQ);
    assert_eq!(status(&mut rig, 0, 0), RQCP, "at once: the bus is known to be busy");
    rig.run_us(400);
    assert_eq!(ids(&rig), [0x000]);
}

#[test]
fn a_frame_aborted_off_the_bus_is_gone_at_once() {
    let mut rig = Rig::new(1);
    rig.set_up(0, 1_000_000, INRQ);
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.write(0, TSR, ABRQ);
    assert_eq!(rig.read(0, TSR), ALL_EMPTY | RQCP);
    rig.write(0, TSR, ABRQ << 8);
    assert_eq!(rig.read(0, TSR), ALL_EMPTY | RQCP, "aborting an empty mailbox does nothing");
}

#[test]
fn a_frame_aborted_on_the_wire_goes_through() {
    for after_us in [1, 10, 45] {
        let mut rig = Rig::running(2);
        rig.send(0, 0, std_frame(0x100, &[]));
        rig.run_us(after_us);
        rig.write(0, TSR, ABRQ);
        assert_eq!(status(&mut rig, 0, 0), ABRQ, "{after_us} us: the attempt is under way");
        rig.run_us(200);
        assert_eq!(status(&mut rig, 0, 0), RQCP | TXOK, "{after_us} us");
        assert_eq!(ids(&rig), [0x100]);
    }
}

#[test]
fn an_abort_ends_the_repetitions_of_a_failing_frame() {
    let mut rig = Rig::running(1);
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(1000);
    assert_eq!(status(&mut rig, 0, 0), TERR, "it goes on trying");
    rig.write(0, TSR, ABRQ);
    rig.run_us(100);
    assert_eq!(status(&mut rig, 0, 0), RQCP | TERR);
    let failed = rig.bus.error_frames();
    rig.run_us(1000);
    assert_eq!(rig.bus.error_frames(), failed);
}

#[test]
fn a_request_made_during_a_frame_waits_for_its_end() {
    let mut rig = Rig::running(2);
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(3);
    rig.send(1, 0, std_frame(0x000, &[]));
    rig.run_us(200);
    let (log, _) = rig.bus.log_since(Default::default());
    assert_eq!(ids(&rig), [0x100, 0x000]);
    assert_eq!(log[1].start.since(log[0].end), 3_000, "three bits of intermission");
}

#[test]
fn without_errors_every_frame_of_a_full_bus_arrives() {
    let mut rig = Rig::running(2);
    rig.bus.set_faults(Faults::default());
    let master = rig.attach(1_000_000);
    let mut received = 0;
    for n in 0..2000u16 {
        while rig.bus.status(master).unwrap().waiting > 2 {
            rig.run_us(50);
            received += rig.take_all(1, 0).len();
        }
        rig.bus.send(master, std_frame(n % 0x700, &n.to_be_bytes())).unwrap();
    }
    for _ in 0..10 {
        rig.run_us(50);
        received += rig.take_all(1, 0).len();
    }
    assert_eq!(received, 2000);
    let (log, _) = rig.bus.log_since(Default::default());
    let pauses = log.windows(2).filter(|pair| pair[1].start.since(pair[0].end) > 3_000).count();
    assert_eq!(pauses, 0, "one frame right behind the other");
}
