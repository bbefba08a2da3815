//! Error counters, states and interrupts: RM0090, 32.7.6, and ISO 11898-1, fault confinement.

use crate::rig::{ABOM, ESR, IER, INRQ, MCR, MSR, NART, Rig, TSR, std_frame};
use world::can::{Faults, Rate, Role};

const EWGF: u32 = 1 << 0;
const EPVF: u32 = 1 << 1;
const BOFF: u32 = 1 << 2;
const EWGIE: u32 = 1 << 8;
const EPVIE: u32 = 1 << 9;
const BOFIE: u32 = 1 << 10;
const LECIE: u32 = 1 << 11;
const ERRIE: u32 = 1 << 15;
const ERRI: u32 = 1 << 2;

const ALWAYS: Faults = Faults { error_rate: 1.0, no_ack: false, stuck_dominant: false };

/// TEC, REC, LEC and the three flags.
fn esr(rig: &mut Rig, node: usize) -> (u32, u32, u32, u32) {
    let esr = rig.read(node, ESR);
    (esr >> 16 & 0xFF, esr >> 24, esr >> 4 & 7, esr & 7)
}

/// One frame of node 0 that fails, once.
fn fail_once(rig: &mut Rig) {
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR) & 1, 1, "RQCP");
}

/// Two nodes; node 0 sends without repetition, and all its frames fail.
fn failing() -> Rig {
    let mut rig = Rig::running(2);
    rig.write(0, MCR, NART);
    rig.bus.set_faults(ALWAYS);
    rig
}

#[test]
fn a_failed_frame_costs_the_sender_8_and_receivers_1() {
    let mut rig = failing();
    fail_once(&mut rig);
    let (tec, rec, lec, flags) = esr(&mut rig, 0);
    assert_eq!((tec, rec, flags), (8, 0, 0));
    assert!(lec == 4 || lec == 5, "a bit error, not {lec}");
    assert_eq!(esr(&mut rig, 1), (0, 1, 1, 0), "a stuff error");
    fail_once(&mut rig);
    assert_eq!((esr(&mut rig, 0).0, esr(&mut rig, 1).1), (16, 2));
}

#[test]
fn a_good_frame_takes_1_off() {
    let mut rig = failing();
    fail_once(&mut rig);
    rig.bus.set_faults(Faults::default());
    fail_once(&mut rig);
    assert_eq!(esr(&mut rig, 0), (7, 0, 0, 0));
    assert_eq!(esr(&mut rig, 1), (0, 0, 0, 0));
    for _ in 0..10 {
        fail_once(&mut rig);
    }
    assert_eq!((esr(&mut rig, 0).0, esr(&mut rig, 1).1), (0, 0), "never below 0");
}

#[test]
fn the_sender_goes_through_warning_and_passive_to_bus_off() {
    let mut rig = failing();
    rig.write(0, IER, ERRIE | EWGIE | EPVIE | BOFIE);
    let mut changes = vec![(0, 0)];
    for n in 1..=32 {
        fail_once(&mut rig);
        let flags = esr(&mut rig, 0).3;
        if changes.last().unwrap().1 != flags {
            changes.push((n, flags));
            assert_eq!(rig.lines(0), [false, false, false, true], "after {n} errors");
            rig.write(0, MSR, ERRI);
        }
        assert_eq!(rig.lines(0), [false; 4], "after {n} errors");
    }
    assert_eq!(changes, [(0, 0), (12, EWGF), (16, EWGF | EPVF), (32, EWGF | EPVF | BOFF)]);
    assert_eq!(rig.interrupts(0).status, 3);
    assert_eq!(esr(&mut rig, 0).0, 0xF8, "TEC as it is shown off the bus");
}

#[test]
fn receivers_become_passive_and_recover_to_120() {
    let mut rig = Rig::running(3);
    rig.write(0, MCR, NART | ABOM);
    rig.write(2, MCR, NART | ABOM);
    rig.bus.set_faults(ALWAYS);
    // Two senders in turn, each out of bus-off again in time.
    for n in 0..128 {
        let node = if n % 2 == 0 { 0 } else { 2 };
        rig.send(node, 0, std_frame(0x100, &[]));
        rig.run_us(3_000);
    }
    let (tec, rec, _, flags) = esr(&mut rig, 1);
    assert_eq!((tec, rec, flags), (0, 128, EWGF | EPVF));
    rig.bus.set_faults(Faults::default());
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(3_000);
    assert_eq!(esr(&mut rig, 1), (0, 120, 0, EWGF));
}

#[test]
fn every_error_can_interrupt_with_its_code() {
    let mut rig = failing();
    rig.write(0, IER, ERRIE | LECIE);
    rig.write(0, ESR, 7 << 4);
    assert_eq!(esr(&mut rig, 0).2, 7, "set by software");
    fail_once(&mut rig);
    assert_eq!(rig.lines(0), [false, false, false, true]);
    assert_eq!(rig.read(0, MSR) & ERRI, ERRI);
    rig.write(0, MSR, ERRI);
    assert_eq!(rig.lines(0), [false; 4]);
    rig.bus.set_faults(Faults::default());
    fail_once(&mut rig);
    assert_eq!(esr(&mut rig, 0).2, 0, "a good frame clears it");
    assert_eq!(rig.lines(0), [false; 4]);
}

#[test]
fn errors_that_are_not_enabled_do_not_interrupt() {
    let mut rig = failing();
    rig.write(0, IER, ERRIE);
    for _ in 0..32 {
        fail_once(&mut rig);
    }
    assert_eq!(esr(&mut rig, 0).3, EWGF | EPVF | BOFF);
    assert_eq!(rig.interrupts(0).total(), 0);
    assert_eq!(rig.read(0, MSR) & ERRI, 0);
}

#[test]
fn a_lone_node_gets_no_acknowledgement_and_never_leaves_the_bus() {
    let mut rig = Rig::running(1);
    rig.send(0, 0, std_frame(0x701, &[0]));
    rig.run_us(20_000);
    assert_eq!(esr(&mut rig, 0), (128, 0, 3, EWGF | EPVF), "an acknowledgement error");
    assert_eq!(rig.read(0, TSR) & 1, 0, "still trying");
    let tries = rig.bus.error_frames();
    assert!(tries > 100, "{tries} tries");
    let (log, _) = rig.bus.log_since(Default::default());
    assert_eq!(log, [], "nobody saw a frame");
    let master = rig.attach(1_000_000);
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11, "sent as soon as somebody answers");
    assert_eq!(rig.bus.receive(master).map(|(_, frame)| frame), Some(std_frame(0x701, &[0])));
    assert_eq!(esr(&mut rig, 0), (127, 0, 0, EWGF));
}

#[test]
fn a_listener_does_not_acknowledge() {
    let mut rig = Rig::running(1);
    let listener = rig.bus.attach(Rate::Fixed(1_000_000), Role::ListenOnly);
    rig.send(0, 0, std_frame(0x701, &[0]));
    rig.run_us(500);
    assert!(rig.bus.receive(listener).is_none(), "an error-active sender destroys its frame");
    rig.run_us(5_000);
    assert_eq!(esr(&mut rig, 0).0, 128);
    assert!(rig.bus.receive(listener).is_some(), "an error-passive sender does not");
    assert_eq!(rig.read(0, TSR) & 1, 0);
}

#[test]
fn no_ack_as_a_fault_is_as_being_alone() {
    let mut rig = Rig::running(2);
    rig.bus.set_faults(Faults { no_ack: true, ..Faults::default() });
    rig.send(0, 0, std_frame(0x701, &[0]));
    rig.run_us(10_000);
    assert_eq!(esr(&mut rig, 0), (128, 0, 3, EWGF | EPVF));
    rig.bus.set_faults(Faults::default());
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11);
}

#[test]
fn error_passive_senders_pause_for_eight_bits() {
    let mut rig = Rig::running(1);
    rig.send(0, 0, std_frame(0x014, &[1]));
    rig.run_us(20_000);
    assert_eq!(esr(&mut rig, 0).0, 128);
    let failed = rig.bus.error_frames();
    let from = rig.now();
    rig.run_us(50_000);
    let each = (rig.now() - from) / (rig.bus.error_frames() - failed);
    // 55 bits as if it were good, 3 of intermission, 8 of pause.
    assert!((65_500..=66_500).contains(&each), "{each} ns");
}

#[test]
fn bus_off_lasts_until_the_software_asks_and_128_times_11_bits_have_passed() {
    let mut rig = failing();
    for _ in 0..32 {
        fail_once(&mut rig);
    }
    rig.bus.set_faults(Faults::default());
    rig.run_us(10_000);
    assert_eq!(esr(&mut rig, 0).3 & BOFF, BOFF, "by itself it stays off");
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(1_000);
    assert_eq!(rig.read(0, TSR) & 1, 0, "and sends nothing");
    rig.write(0, MCR, INRQ);
    assert_eq!(rig.read(0, MSR) & 1, 1);
    rig.write(0, MCR, 0);
    let asked = rig.now();
    let joined = rig.run_to(0, MSR, 1, 0);
    assert_eq!(joined - asked, 11_000);
    assert_eq!(esr(&mut rig, 0).3 & BOFF, BOFF);
    let back = rig.run_to(0, ESR, BOFF, 0);
    assert_eq!(back - joined, 128 * 11 * 1_000);
    assert_eq!(esr(&mut rig, 0).0, 0);
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11, "what waited goes out");
}

#[test]
fn bus_off_ends_by_itself_with_abom() {
    let mut rig = Rig::running(1);
    rig.write(0, MCR, ABOM);
    rig.bus.set_faults(ALWAYS);
    rig.send(0, 0, std_frame(0x100, &[]));
    let off = rig.run_to(0, ESR, BOFF, BOFF);
    rig.bus.set_faults(Faults::default());
    let back = rig.run_to(0, ESR, BOFF, 0);
    assert_eq!(back - off, (6 + 128 * 11) * 1_000, "behind its own error flag");
    assert_eq!(esr(&mut rig, 0), (0, 0, esr(&mut rig, 0).2, 0));
}

#[test]
fn on_a_busy_bus_every_frame_counts_once_towards_the_end_of_bus_off() {
    let mut rig = failing();
    for _ in 0..32 {
        fail_once(&mut rig);
    }
    rig.bus.set_faults(Faults::default());
    let master = rig.attach(1_000_000);
    rig.write(0, MCR, INRQ);
    rig.write(0, MCR, 0);
    let before = rig.bus.log_end();
    while esr(&mut rig, 0).3 & BOFF != 0 {
        while rig.bus.status(master).unwrap().waiting < 4 {
            rig.bus.send(master, std_frame(0x000, &[0; 8])).unwrap();
        }
        rig.run_us(10);
    }
    let frames = rig.bus.log_since(before).0.len();
    // The first frame starts within a quantum, which has room for three sequences.
    assert!((125..=128).contains(&frames), "{frames} frames");
}

#[test]
fn a_node_at_another_rate_sees_errors_and_no_data() {
    let mut rig = Rig::running(1);
    let master = rig.attach(125_000);
    rig.bus.send(master, std_frame(0x605, &[0x40, 0x00, 0x10, 0])).unwrap();
    rig.run_us(4_000);
    assert_eq!(rig.take_all(0, 0), []);
    assert!(esr(&mut rig, 0).1 > 0, "REC");
    let status = rig.bus.status(master).unwrap();
    assert_eq!(status.sent, 0);
    assert!(status.errors > 0 && status.counters.transmit() > 0);
}

#[test]
fn a_node_at_another_rate_destroys_frames_until_it_is_error_passive() {
    let mut rig = Rig::running(2);
    let master = rig.attach(500_000);
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(300);
    assert_eq!(rig.read(0, TSR) & 1, 0);
    assert!(rig.bus.error_frames() > 0);
    rig.run_us(20_000);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11);
    assert_eq!(rig.take_all(1, 0), [std_frame(0x100, &[])]);
    assert!(rig.bus.receive(master).is_none());
}

#[test]
fn on_a_bus_held_dominant_nothing_is_sent_and_errors_count() {
    let mut rig = Rig::running(2);
    rig.bus.set_faults(Faults { stuck_dominant: true, ..Faults::default() });
    rig.send(0, 0, std_frame(0x100, &[]));
    rig.run_us(5_000);
    assert_eq!(rig.read(0, TSR) & 1, 0);
    let (tec, rec, lec, flags) = esr(&mut rig, 0);
    assert_eq!((tec, lec, flags), (0, 1, EWGF | EPVF));
    assert!(rec > 127);
    rig.bus.set_faults(Faults::default());
    rig.run_us(200);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11);
}

#[test]
fn a_disturbed_frame_is_repeated_until_it_arrives() {
    let mut rig = Rig::running(2);
    rig.bus.set_faults(Faults { error_rate: 0.2, ..Faults::default() });
    let mut sent = 0;
    for n in 0..200u8 {
        rig.send(0, 0, std_frame(0x100, &[n]));
        rig.run_us(1_500);
        sent += rig.read(0, TSR) & 0b10;
        assert_eq!(rig.take_all(1, 0), [std_frame(0x100, &[n])]);
    }
    assert_eq!(sent, 400);
    let failed = rig.bus.error_frames();
    assert!((20..100).contains(&failed), "{failed} of about 250");
}
