//! Whatever software writes and whatever is on the bus: no panic, and the registers stay consistent.

use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

use crate::rig::{ESR, FMR, IER, MCR, MSR, RF0R, RF1R, Rig, TI0R, TSR, btr, ext_frame, std_frame};
use world::can::Faults;

#[derive(Clone, Debug)]
enum Step {
    Write { node: usize, register: u64, value: u32 },
    Command { node: usize, register: u64, bit: u32 },
    Send { node: usize, mailbox: u64, id: u16, len: usize },
    Outside { id: u32, len: usize },
    Faults { error_rate: f64, no_ack: bool, stuck_dominant: bool },
    Restart { node: usize },
    Run { us: u64 },
}

/// Registers of the map, without the gaps in it.
fn registers() -> Vec<u64> {
    let control = (0..8).map(|n| 4 * n);
    let mailboxes = (0..20).map(|n| TI0R + 4 * n);
    let filters = [FMR, 0x204, 0x20C, 0x214, 0x21C];
    control.chain(mailboxes).chain(filters).chain((0..56).map(|n| 0x240 + 4 * n)).collect()
}

fn step() -> impl Strategy<Value = Step> {
    let node = 0..2usize;
    prop_oneof![
        3 => (node.clone(), prop::sample::select(registers()), any::<u32>())
            .prop_map(|(node, register, value)| Step::Write { node, register, value }),
        4 => (node.clone(), prop::sample::select(vec![MCR, MSR, TSR, RF0R, RF1R, IER, ESR]), 0..32u32)
            .prop_map(|(node, register, bit)| Step::Command { node, register, bit }),
        4 => (node.clone(), 0..3u64, 0..0x800u16, 0..=8usize)
            .prop_map(|(node, mailbox, id, len)| Step::Send { node, mailbox, id, len }),
        2 => (0..0x2000_0000u32, 0..=8usize).prop_map(|(id, len)| Step::Outside { id, len }),
        1 => (prop_oneof![Just(0.0), 0.0..1.0], any::<bool>(), prop::bool::weighted(0.2)).prop_map(
            |(error_rate, no_ack, stuck_dominant)| Step::Faults { error_rate, no_ack, stuck_dominant }
        ),
        1 => node.prop_map(|node| Step::Restart { node }),
        6 => (1..400u64).prop_map(|us| Step::Run { us }),
    ]
}

/// What holds at every moment.
fn consistent(rig: &mut Rig) {
    for node in 0..2 {
        let [msr, tsr, esr, ier] = [MSR, TSR, ESR, IER].map(|register| rig.read(node, register));
        assert_ne!(msr & 0b11, 0b11, "asleep and initialising");
        for mailbox in 0..3 {
            let waits = rig.read(node, TI0R + 0x10 * mailbox) & 1 == 1;
            let empty = tsr >> (26 + mailbox) & 1 == 1;
            assert_ne!(waits, empty, "TXRQ and TME of mailbox {mailbox}");
            let status = tsr >> (8 * mailbox);
            assert!(status & 0b11 != 0b10, "TXOK without RQCP");
            assert!(!(empty && status & 0x80 != 0), "an abort of nothing");
        }
        let (tec, rec) = (esr >> 16 & 0xFF, esr >> 24);
        assert_eq!(esr & 1 != 0, tec.max(rec) >= 96, "EWGF at {tec}, {rec}");
        assert_eq!(esr & 2 != 0, tec.max(rec) > 127, "EPVF at {tec}, {rec}");
        let [transmit, first, second, status] = rig.lines(node);
        let completed = tsr & 0x0001_0101 != 0;
        assert_eq!(transmit, ier & 1 != 0 && completed, "transmit interrupt");
        for (fifo, line) in [first, second].into_iter().enumerate() {
            let fifo_status = rig.read(node, RF0R + 4 * fifo as u64);
            assert_eq!(fifo_status & !0b1_1011, 0);
            let pending =
                [fifo_status & 0b11 != 0, fifo_status >> 3 & 1 == 1, fifo_status >> 4 & 1 == 1];
            let due = pending
                .into_iter()
                .enumerate()
                .any(|(n, pending)| pending && ier >> (1 + n + 3 * fifo) & 1 == 1);
            assert_eq!(line, due, "FIFO {fifo} interrupt");
        }
        let due = [(2, 15), (3, 16), (4, 17)]
            .into_iter()
            .any(|(flag, enable)| msr >> flag & 1 == 1 && ier >> enable & 1 == 1);
        assert_eq!(status, due, "status interrupt");
    }
}

fn run(steps: &[Step]) -> (Rig, u64) {
    let mut rig = Rig::running(2);
    let master = rig.attach(1_000_000);
    let mut refused = 0;
    for step in steps {
        match *step {
            Step::Write { node, register, value } => rig.write(node, register, value),
            Step::Command { node, register, bit } => {
                let held = rig.read(node, register);
                rig.write(node, register, held ^ 1 << bit);
            }
            Step::Send { node, mailbox, id, len } => {
                rig.send(node, mailbox, std_frame(id, &[0x5A; 8][..len]));
            }
            Step::Outside { id, len } => {
                refused +=
                    u64::from(rig.bus.send(master, ext_frame(id, &[0xA5; 8][..len])).is_err());
            }
            Step::Faults { error_rate, no_ack, stuck_dominant } => {
                rig.bus.set_faults(Faults { error_rate, no_ack, stuck_dominant });
            }
            Step::Restart { node } => rig.set_up(node, 1_000_000, 0),
            Step::Run { us } => rig.run_us(us),
        }
        consistent(&mut rig);
    }
    (rig, refused)
}

/// A failure prints its seed and keeps it in a file beside this one.
fn config() -> ProptestConfig {
    let beside = FileFailurePersistence::WithSource("regressions");
    ProptestConfig {
        cases: 200,
        failure_persistence: Some(Box::new(beside)),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn nothing_written_or_sent_confuses_the_controller(steps in prop::collection::vec(step(), 1..80)) {
        let (mut rig, _) = run(&steps);
        // However it was left, set up anew on a healthy bus it works.
        rig.bus.set_faults(Faults::default());
        for node in 0..2 {
            rig.reset(node);
            rig.write(node, MCR, 1);
            rig.write(node, 0x1C, btr(1_000_000));
            rig.set_up(node, 1_000_000, 0);
        }
        rig.run_us(50_000);
        rig.take_all(1, 0);
        rig.send(0, 0, std_frame(0x123, &[1, 2, 3]));
        rig.run_us(1_000);
        prop_assert!(rig.take_all(1, 0).contains(&std_frame(0x123, &[1, 2, 3])));
    }

    #[test]
    fn the_same_steps_give_the_same_run(steps in prop::collection::vec(step(), 1..40)) {
        let observe = || {
            let (rig, refused) = run(&steps);
            let log = rig.bus.log_since(Default::default()).0;
            (log, rig.bus.error_frames(), rig.bus.busy(), rig.interrupts(0), rig.interrupts(1), refused)
        };
        prop_assert_eq!(observe(), observe());
    }
}
