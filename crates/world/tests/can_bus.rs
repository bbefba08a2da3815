//! The bus between outside nodes, without any device.

use world::can::{
    BitTime, Bus, Confinement, Faults, Frame, Id, Nanos, QueueFull, RECEIVE_MAX, Rate, Role,
    SEND_MAX, Source, greatest_quantum,
};

const QUANTUM_NS: u64 = 40_000;

fn frame(id: u16) -> Frame {
    Frame::new(Id::Standard(id), &[1, 2]).expect("an identifier of 11 bits")
}

fn run_us(bus: &mut Bus, us: u64) {
    let end = bus.now().after(us * 1000);
    while bus.now() < end {
        bus.resolve(bus.now().after(QUANTUM_NS), &[]);
    }
}

#[test]
fn the_greatest_quantum_follows_the_bit_rate() {
    for (rate, ns) in [(1_000_000, 42_000), (800_000, 52_500), (125_000, 336_000)] {
        assert_eq!(greatest_quantum(BitTime::from_rate(rate)), ns);
    }
}

#[test]
fn a_frame_reaches_every_other_node_and_the_log() {
    let mut bus = Bus::new(0);
    let [a, b, c] = [0; 3].map(|_| bus.attach(Rate::Fixed(500_000), Role::Normal));
    bus.send(a, frame(0x100)).unwrap();
    run_us(&mut bus, 1000);
    assert_eq!(bus.receive(a), None);
    let received = bus.receive(b).unwrap();
    assert_eq!((received.1, bus.receive(c)), (frame(0x100), Some(received)));
    let (log, end) = bus.log_since(Default::default());
    assert_eq!((log.len(), log[0].source), (1, Source::Outside(a)));
    assert_eq!(log[0].end.since(received.0), 2_000, "valid one bit before its end");
    assert_eq!(bus.log_since(end).0, []);
    assert_eq!(bus.busy(), log[0].end.since(log[0].start) + 3 * 2_000);
}

#[test]
fn nothing_is_known_before_it_happened() {
    let mut bus = Bus::new(0);
    let [a, b] = [0; 2].map(|_| bus.attach(Rate::Fixed(10_000), Role::Normal));
    bus.send(a, frame(0x100)).unwrap();
    let mut seen = Vec::new();
    while bus.now() < Nanos(20_000_000) {
        run_us(&mut bus, 40);
        if let Some((at, _)) = bus.receive(b) {
            seen.push(bus.now().since(at));
        }
        assert!(bus.log_since(Default::default()).0.iter().all(|l| l.end <= bus.now()));
    }
    assert!(matches!(seen[..], [late] if late <= 2 * 100_000), "{seen:?}");
}

#[test]
fn queues_are_bounded() {
    let mut bus = Bus::new(0);
    let [a, b] = [0; 2].map(|_| bus.attach(Rate::Fixed(1_000_000), Role::Normal));
    for _ in 0..SEND_MAX {
        bus.send(a, frame(1)).unwrap();
    }
    assert_eq!(bus.send(a, frame(1)), Err(QueueFull));
    for _ in 0..=RECEIVE_MAX / SEND_MAX {
        run_us(&mut bus, 30_000);
        while bus.send(a, frame(1)).is_ok() {}
    }
    run_us(&mut bus, 30_000);
    let status = bus.status(b).unwrap();
    assert_eq!(status.dropped, bus.status(a).unwrap().sent - RECEIVE_MAX as u64);
}

#[test]
fn a_detached_node_is_gone() {
    let mut bus = Bus::new(0);
    let [a, b] = [0; 2].map(|_| bus.attach(Rate::Fixed(1_000_000), Role::Normal));
    bus.detach(b);
    bus.detach(b);
    assert!(bus.send(b, frame(1)).is_err() && bus.status(b).is_err());
    assert_eq!(bus.receive(b), None);
    bus.send(a, frame(1)).unwrap();
    run_us(&mut bus, 1000);
    assert_eq!(bus.status(a).unwrap().sent, 0, "nobody acknowledges");
}

#[test]
fn an_automatic_node_follows_the_devices() {
    use world::can::{PortState, Presence};
    let mut bus = Bus::new(0);
    let tool = bus.attach(Rate::Automatic, Role::Normal);
    let master = bus.attach(Rate::Fixed(250_000), Role::Normal);
    let device = PortState {
        presence: Presence::Normal,
        bit: BitTime::from_rate(250_000),
        ..PortState::OFF
    };
    bus.resolve(Nanos(QUANTUM_NS), std::slice::from_ref(&device));
    bus.send(tool, frame(0x10)).unwrap();
    for n in 2..50 {
        bus.resolve(Nanos(QUANTUM_NS * n), std::slice::from_ref(&device));
    }
    assert_eq!(bus.receive(master).map(|(_, f)| f), Some(frame(0x10)));
}

#[test]
fn an_outside_node_comes_back_from_bus_off() {
    let mut bus = Bus::new(3);
    let [a, b] = [0; 2].map(|_| bus.attach(Rate::Fixed(1_000_000), Role::Normal));
    bus.set_faults(Faults { error_rate: 1.0, ..Faults::default() });
    bus.send(a, frame(1)).unwrap();
    while bus.status(a).unwrap().counters.confinement() != Confinement::BusOff {
        run_us(&mut bus, 40);
    }
    bus.set_faults(Faults::default());
    run_us(&mut bus, 1_000);
    assert_eq!(bus.status(a).unwrap().sent, 0);
    run_us(&mut bus, 1_000);
    assert_eq!(bus.status(a).unwrap().sent, 1);
    assert_eq!(bus.receive(b).map(|(_, f)| f), Some(frame(1)));
}

#[test]
fn the_same_seed_disturbs_the_same_frames() {
    let run = |seed| {
        let mut bus = Bus::new(seed);
        let [a, _b] = [0; 2].map(|_| bus.attach(Rate::Fixed(1_000_000), Role::Normal));
        bus.set_faults(Faults { error_rate: 0.1, ..Faults::default() });
        for id in 0..200 {
            bus.send(a, frame(id)).unwrap();
        }
        run_us(&mut bus, 50_000);
        bus.log_since(Default::default()).0
    };
    assert_eq!(run(7), run(7));
    assert_ne!(run(7), run(8));
}

#[test]
fn a_full_bus_is_full() {
    let mut bus = Bus::new(0);
    let [a, _b] = [0; 2].map(|_| bus.attach(Rate::Fixed(1_000_000), Role::Normal));
    for id in 0..SEND_MAX {
        bus.send(a, frame(u16::try_from(id).unwrap())).unwrap();
    }
    let (start, before) = (bus.now(), bus.busy());
    run_us(&mut bus, 10_000);
    let load = bus.busy() - before;
    assert!(load + 100_000 >= bus.now().since(start), "{load} ns");
}

#[test]
fn an_engine_may_sleep_while_nothing_is_due() {
    let run = |sleepy: bool| {
        let mut bus = Bus::new(0);
        let [a, b] = [0; 2].map(|_| bus.attach(Rate::Fixed(125_000), Role::Normal));
        for id in 0..20 {
            bus.send(if id % 2 == 0 { a } else { b }, frame(id)).unwrap();
        }
        let end = Nanos(100_000_000);
        while bus.now() < end {
            let due = bus.next_activity(&[]).map_or(end, |at| at.max(bus.now()));
            let next = if sleepy { due.after(336_000) } else { bus.now().after(10_000) };
            bus.resolve(next.min(end), &[]);
        }
        bus.log_since(Default::default()).0
    };
    assert_eq!(run(true), run(false));
    assert_eq!(run(true).len(), 20);
}
