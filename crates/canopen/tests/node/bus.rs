use expect_test::expect;

use crate::check;
use crate::cia_301;
use crate::script::transcript;

/// NM17x EMCY-05, OD-1029-2; decisions A-30, A-31: what the controller says is an event, a message
/// and, while it is passive or off, the communication bit; no state ends.
#[test]
fn the_standing_on_the_bus_is_told() {
    check(
        "
        0 boot
        1 < 000 01 00
        2 bus warning
        3 bus warning
        4 bus passive
        5 < 67F 40 01 10 00 00 00 00 00
        6 bus warning
        7 bus passive
        8 bus off
        9 bus active
        10 bus off
        11 bus passive
        12 bus active
        13 overrun
        14 < 67F 40 03 10 01 00 00 00 00
        ",
        expect![[r#"
            0000 * Initialising to PreOperational
            0000 > 77F [1] 00
            0001 < 000 [2] 01 00
            0001 * PreOperational to Operational
            0001 > 2FF [8] 00 00 00 00 00 00 00 00
            0002 * BusStateChanged { from: Active, to: Warning }
            0002 > 0FF [8] 00 81 00 00 00 00 00 00
            0004 * BusStateChanged { from: Warning, to: Passive }
            0004 > 0FF [8] 20 81 11 00 00 00 00 00
            0005 < 67F [8] 40 01 10 00 00 00 00 00
            0005 > 5FF [8] 4F 01 10 00 11 00 00 00
            0006 * BusStateChanged { from: Passive, to: Warning }
            0006 > 0FF [8] 00 00 00 00 00 00 00 00
            0007 * BusStateChanged { from: Warning, to: Passive }
            0007 > 0FF [8] 20 81 11 00 00 00 00 00
            0008 * BusStateChanged { from: Passive, to: Off }
            0009 * BusStateChanged { from: Off, to: Active }
            0009 > 0FF [8] 40 81 11 00 00 00 00 00
            0009 > 0FF [8] 00 00 00 00 00 00 00 00
            0010 * BusStateChanged { from: Active, to: Off }
            0011 * BusStateChanged { from: Off, to: Passive }
            0011 > 0FF [8] 40 81 11 00 00 00 00 00
            0012 * BusStateChanged { from: Passive, to: Active }
            0012 > 0FF [8] 00 00 00 00 00 00 00 00
            0013 > 0FF [8] 10 81 00 00 00 00 00 00
            0014 < 67F [8] 40 03 10 01 00 00 00 00
            0014 > 5FF [8] 43 03 10 01 10 81 00 00
        "#]],
    );
}

/// CiA 301, section 7.5.2.32 and table 26: bus-off is a communication error, here one that stops
/// the node; what else is missing keeps the bit.
#[test]
fn bus_off_is_a_communication_error() {
    let script = "
        0 boot
        1 < 605 2F 29 10 01 02 00 00 00
        1 < 605 23 16 10 01 64 00 06 00
        2 < 000 01 00
        3 < 706 05
        20 bus passive
        21 bus off
        22 bus active
        200 < 000 80 00
        201 < 605 40 01 10 00 00 00 00 00
        202 < 706 05
        ";
    expect![[r#"
        0000 * Initialising to PreOperational
        0000 > 705 [1] 00
        0001 < 605 [8] 2F 29 10 01 02 00 00 00
        0001 > 585 [8] 60 29 10 01 00 00 00 00
        0001 < 605 [8] 23 16 10 01 64 00 06 00
        0001 > 585 [8] 60 16 10 01 00 00 00 00
        0001 * FiltersChanged
        0002 < 000 [2] 01 00
        0002 * PreOperational to Operational
        0003 < 706 [1] 05
        0020 * BusStateChanged { from: Active, to: Passive }
        0020 > 085 [8] 20 81 11 00 00 00 00 00
        0021 * BusStateChanged { from: Passive, to: Off }
        0021 * Operational to Stopped
        0022 * BusStateChanged { from: Off, to: Active }
        0103 * HeartbeatLost { producer: NodeId(6) }
        0200 < 000 [2] 80 00
        0200 * Stopped to PreOperational
        0201 < 605 [8] 40 01 10 00 00 00 00 00
        0201 > 585 [8] 4F 01 10 00 11 00 00 00
        0202 < 706 [1] 05
        0202 * HeartbeatRecovered { producer: NodeId(6) }
        0202 > 085 [8] 00 00 00 00 00 00 00 00
    "#]]
    .assert_eq(&transcript(cia_301::node(), &mut (), script));
}

/// A bus that comes and goes before anything can be sent is told once, with its last word last.
#[test]
fn emergencies_that_say_the_same_do_not_pile_up() {
    use units::{Duration, Instant};

    let mut node = crate::device::node();
    let at = |ms| Instant::ZERO + Duration::from_millis(ms);
    node.boot(at(0));
    assert_eq!(node.take_transmit().map(|frame| frame.id().get()), Some(0x77F));
    for ms in 0..1_000 {
        let state = [canopen::BusState::Passive, canopen::BusState::Active];
        node.handle_bus(at(ms), state[usize::try_from(ms % 2).unwrap()]);
        while node.poll_event().is_some() {}
    }
    let sent: Vec<_> = core::iter::from_fn(|| node.take_transmit()).collect();
    let codes: Vec<_> = sent.iter().map(|frame| frame.data()[..3].to_vec()).collect();
    assert_eq!(codes, [[0x20, 0x81, 0x11], [0x00, 0x00, 0x00]]);
}

/// Frames that find no place are an event and, with CiA 301, a message, once.
#[test]
fn an_overflow_is_told_once() {
    use canopen::{CanId, Event, Frame};
    use units::Instant;

    let mut node = cia_301::node();
    let now = Instant::ZERO;
    node.boot(now);
    let request = Frame::new(CanId::new(0x605).unwrap(), &[0x40, 0, 0x10, 0, 0, 0, 0, 0]).unwrap();
    let mut lost = Vec::new();
    for _ in 0..40 {
        node.handle_frame(now, &request, &mut ());
        while let Some(event) = node.poll_event() {
            if let Event::TransmitOverflow { lost: frames } = event {
                lost.push(frames);
            }
        }
    }
    assert_eq!(lost, [1]);
    let sent: Vec<_> = core::iter::from_fn(|| node.take_transmit()).collect();
    assert_eq!(sent.len(), canopen::TRANSMIT_MAX);
    assert_eq!(sent[1].data()[..2], [0x10, 0x81]);
}
