//! Time on the wire: ISO 11898-1, at the bit rates of CiA 301.

use crate::rig::{BTR, MCR, MSR, RATES, RF0R, Rig, TSR, std_frame};

/// Bits of the frame 0x014 with the byte 0x01: 42 up to the check sequence 0x7753, 3 stuff bits,
/// 10 bits behind it.
const FRAME_BITS: u64 = 55;

#[test]
fn a_frame_takes_its_time_to_the_nanosecond_at_every_bit_rate() {
    for (rate, ..) in RATES {
        let bit_ns = 1_000_000_000 / u64::from(rate);
        let mut rig = Rig::new(2);
        rig.set_up(0, rate, 0);
        rig.set_up(1, rate, 0);
        rig.run_us(5_000);
        let requested = rig.now();
        rig.send(0, 0, std_frame(0x014, &[1]));
        let valid = rig.run_to(1, RF0R, 0b11, 1);
        assert_eq!(valid - requested, (FRAME_BITS - 1) * bit_ns, "{rate} bit/s, received");
        let sent = rig.run_to(0, TSR, 1, 1);
        assert_eq!(sent - requested, FRAME_BITS * bit_ns, "{rate} bit/s, sent");
        let (log, _) = {
            rig.run_us(1_000);
            rig.bus.log_since(Default::default())
        };
        assert_eq!((log[0].start.0, log[0].end.0), (requested, sent), "{rate} bit/s");
    }
}

#[test]
fn frames_follow_each_other_after_three_bits() {
    for (rate, ..) in RATES {
        let bit_ns = 1_000_000_000 / u64::from(rate);
        let mut rig = Rig::new(2);
        rig.set_up(0, rate, 0);
        rig.set_up(1, rate, 0);
        rig.run_us(5_000);
        for mailbox in 0..3 {
            rig.send(0, mailbox, std_frame(0x014, &[1]));
        }
        let started = rig.now();
        rig.run_us(200 * bit_ns / 1000 + 1_000);
        let (log, _) = rig.bus.log_since(Default::default());
        let starts: Vec<u64> = log.iter().map(|l| (l.start.0 - started) / bit_ns).collect();
        assert_eq!(starts, [0, FRAME_BITS + 3, 2 * (FRAME_BITS + 3)], "{rate} bit/s");
    }
}

#[test]
fn joining_takes_eleven_recessive_bits_at_every_bit_rate() {
    for (rate, ..) in RATES {
        let bit_ns = 1_000_000_000 / u64::from(rate);
        let mut rig = Rig::new(1);
        rig.set_up(0, rate, 0);
        let asked = rig.now();
        let joined = rig.run_to(0, MSR, 1, 0);
        assert_eq!(joined - asked, 11 * bit_ns, "{rate} bit/s");
    }
}

#[test]
fn bit_timing_changes_only_during_initialisation() {
    let mut rig = Rig::new(1);
    assert_eq!(rig.read(0, BTR), 0x0123_0000, "reset value");
    rig.write(0, BTR, 0x0014_0001);
    assert_eq!(rig.read(0, BTR), 0x0123_0000, "asleep");
    rig.write(0, MCR, 1);
    rig.write(0, BTR, 0x0014_0001);
    assert_eq!(rig.read(0, BTR), 0x0014_0001);
    rig.write(0, MCR, 0);
    rig.run_us(100);
    rig.write(0, BTR, 0);
    assert_eq!(rig.read(0, BTR), 0x0014_0001, "in normal mode");
}

#[test]
fn the_length_of_the_quanta_does_not_show() {
    let observe = |quantum_ns| {
        let mut rig = Rig::running(3).with_quantum(quantum_ns);
        let mut received = Vec::new();
        for n in 0..300u16 {
            let node = usize::from(n % 3);
            rig.send(node, u64::from(n / 3 % 3), std_frame(n * 37 % 0x7FF, &n.to_be_bytes()));
            // Never on a boundary: what is written there comes after it.
            rig.run_until(rig.now() / 1000 * 1000 + u64::from(n * 7 % 61) * 1000 + 500);
            for node in 0..3 {
                received.extend(rig.take_all(node, 0).into_iter().map(|frame| (node, frame)));
            }
        }
        rig.run_us(1_000);
        (rig.bus.log_since(Default::default()).0, received, rig.bus.busy())
    };
    let wanted = observe(40_000);
    assert!(wanted.0.len() > 100, "{} frames", wanted.0.len());
    for quantum_ns in [1_000, 7_777, 13_000, 33_333] {
        let seen = observe(quantum_ns);
        let first = wanted.0.iter().zip(&seen.0).position(|(wanted, seen)| wanted != seen);
        if let Some(n) = first {
            for l in [&wanted.0, &seen.0] {
                for f in &l[n - 2..n + 3] {
                    println!(
                        "{} {} {:x} {:?} {:?}",
                        f.start.0,
                        f.end.0,
                        f.frame.id().value(),
                        f.frame.data(),
                        f.source
                    );
                }
                println!();
            }
        }
        assert_eq!((first, seen.0.len()), (None, wanted.0.len()), "frames at {quantum_ns} ns");
        let first = wanted.1.iter().zip(&seen.1).position(|(wanted, seen)| wanted != seen);
        assert_eq!((first, seen.1.len()), (None, wanted.1.len()), "received at {quantum_ns} ns");
        assert_eq!(seen.2, wanted.2, "busy at {quantum_ns} ns");
    }
}
