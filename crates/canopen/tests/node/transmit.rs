use canopen::{CanId, Event, Frame, Node, TRANSMIT_MAX};
use object_dictionary::ObjectId;
use units::{Duration, Instant};

use crate::device::{DICTIONARY, Device, LEN, node};

fn set(node: &mut Node<LEN>, now: Instant, index: u16, value: u32) {
    let slot = DICTIONARY.find(ObjectId { index, sub: 0 }).unwrap();
    node.set_value(now, slot, value);
}

fn receive(node: &mut Node<LEN>, id: u16, data: &[u8]) {
    let frame = Frame::new(CanId::new(id).unwrap(), data).unwrap();
    node.handle_frame(Instant::ZERO, &frame, &mut Device::new());
}

fn waiting(node: &mut Node<LEN>) -> Vec<(u16, u8)> {
    core::iter::from_fn(|| node.take_transmit())
        .map(|frame| (frame.id().get(), frame.data()[0]))
        .collect()
}

/// NM17x BOOT-03, HB-01: before a bus that takes nothing, heartbeats and PDOs do not pile up, and
/// the boot-up message stays the first.
#[test]
fn a_silent_bus_leaves_only_what_is_new() {
    let mut node = node();
    set(&mut node, Instant::ZERO, 0x1017, 10);
    set(&mut node, Instant::ZERO, 0x1F80, 8);
    node.boot(Instant::ZERO);
    for ms in 0..1_000 {
        let now = Instant::ZERO + Duration::from_millis(ms);
        set(&mut node, now, 0x6004, u32::try_from(ms).unwrap());
        node.handle_timeout(now, &mut ());
    }
    let boot_up = node.take_transmit().unwrap();
    node.give_back(boot_up);
    let now = Instant::ZERO + Duration::from_millis(1_000);
    node.handle_timeout(now, &mut ());
    assert_eq!(waiting(&mut node), [(0x77F, 0x00), (0x2FF, 0xC0)]);
    node.handle_timeout(now + Duration::from_millis(50), &mut ());
    assert_eq!(waiting(&mut node), [(0x2FF, 0xE7), (0x77F, 0x05)]);
}

/// A mailbox that has to make room gives its frame back, ahead of younger ones.
#[test]
fn a_frame_that_comes_back_keeps_its_turn() {
    let mut node = node();
    node.boot(Instant::ZERO);
    node.take_transmit();
    receive(&mut node, 0x67F, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    receive(&mut node, 0x67F, &[0x40, 0xFF, 0x5F, 0, 0, 0, 0, 0]);
    let first = node.take_transmit().unwrap();
    node.give_back(first);
    assert_eq!(waiting(&mut node), [(0x5FF, 0x43), (0x5FF, 0x80)]);
}

/// A client that does not wait for answers loses some, and the device says so once, even if saying
/// so takes a place as well.
#[test]
fn an_overflow_is_reported_once() {
    let mut node = node();
    node.boot(Instant::ZERO);
    while node.poll_event().is_some() {}
    node.take_transmit();
    for round in 1..=2 {
        for _ in 0..TRANSMIT_MAX + 3 {
            receive(&mut node, 0x67F, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
        }
        let lost = if round == 1 { 3 } else { 7 };
        assert_eq!(node.poll_event(), Some(Event::TransmitOverflow { lost }));
        node.send_emergency(0x8110, [0; 5]);
        assert_eq!(node.poll_event(), None);
        let sent = waiting(&mut node);
        assert_eq!((sent.len(), sent[0]), (TRANSMIT_MAX, (0x0FF, 0x10)));
    }
}

/// NM17x NMT-04: PDOs that still wait when the node leaves Operational are not sent.
#[test]
fn waiting_pdos_end_with_operational() {
    let mut node = node();
    node.boot(Instant::ZERO);
    receive(&mut node, 0x000, &[0x01, 0x7F]);
    receive(&mut node, 0x67F, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    receive(&mut node, 0x000, &[0x80, 0x7F]);
    assert_eq!(waiting(&mut node), [(0x77F, 0x00), (0x5FF, 0x43)]);
}

/// NM17x PDO-03: a PDO that is served late does not make the next one late.
#[test]
fn the_event_timer_does_not_drift() {
    let mut node = node();
    let mut set_parameter = |sub, value| {
        let slot = DICTIONARY.find(ObjectId { index: 0x1801, sub }).unwrap();
        node.set_value(Instant::ZERO, slot, value);
    };
    for (sub, value) in [(2, 254), (3, 0), (5, 10)] {
        set_parameter(sub, value);
    }
    node.boot(Instant::ZERO);
    receive(&mut node, 0x000, &[0x01, 0x7F]);
    for (late_ms, next_ms) in [(13, 20), (20, 30), (39, 40), (75, 85)] {
        node.handle_timeout(Instant::ZERO + Duration::from_millis(late_ms), &mut ());
        let next_at = Instant::ZERO + Duration::from_millis(next_ms);
        assert_eq!(node.poll_timeout(), Some(next_at), "served at {late_ms} ms");
    }
}

/// Decision A-36: a stopped node sends nothing that was meant for before.
#[test]
fn a_stopped_node_keeps_its_error_control_only() {
    let mut node = node();
    set(&mut node, Instant::ZERO, 0x1017, 10);
    node.boot(Instant::ZERO);
    waiting(&mut node);
    receive(&mut node, 0x000, &[0x01, 0x7F]);
    receive(&mut node, 0x67F, &[0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
    node.send_emergency(0x8110, [0; 5]);
    node.handle_timeout(Instant::ZERO + Duration::from_millis(10), &mut ());
    receive(&mut node, 0x000, &[0x02, 0x7F]);
    node.send_emergency(0x8110, [0; 5]);
    assert_eq!(waiting(&mut node), [(0x77F, 0x05)]);
}
