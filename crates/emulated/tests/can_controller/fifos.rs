//! Receive FIFOs: RM0090, 32.7.3.

use crate::rig::{FilterBank, IER, MCR, RF0R, RF1R, RFLM, Rig, std_frame};

const FULL: u32 = 1 << 3;
const FOVR: u32 = 1 << 4;
const RFOM: u32 = 1 << 5;

/// A controller that takes 0x000..0x3FF into FIFO 0 and the others into FIFO 1, and the frames of
/// `ids` sent to it one after the other.
fn received(control: u32, ids: &[u16]) -> Rig {
    let mut rig = Rig::new(1);
    rig.set_up(0, 1_000_000, control);
    let mask = 0x400 << 21;
    let bank = FilterBank { bank: 0, fifo: 0, wide: true, list: false, values: [0, mask] };
    rig.filters(0, &[bank, FilterBank { bank: 1, fifo: 1, values: [mask, mask], ..bank }]);
    let master = rig.attach(1_000_000);
    for id in ids {
        rig.bus.send(master, std_frame(*id, &id.to_be_bytes())).unwrap();
    }
    rig.run_us(2000);
    rig
}

fn ids(rig: &mut Rig, fifo: u64) -> Vec<u32> {
    rig.take_all(0, fifo).iter().map(|frame| frame.id().value()).collect()
}

#[test]
fn a_fifo_counts_its_frames_and_gives_the_oldest_first() {
    let mut rig = received(0, &[0x101, 0x102]);
    assert_eq!(rig.read(0, RF0R), 2);
    rig.write(0, RF0R, RFOM);
    assert_eq!(rig.read(0, RF0R), 1);
    assert_eq!(ids(&mut rig, 0), [0x102]);
    rig.write(0, RF0R, RFOM);
    assert_eq!(rig.read(0, RF0R), 0, "releasing an empty FIFO does nothing");
}

#[test]
fn both_fifos_fill_on_their_own() {
    let mut rig = received(0, &[0x401, 0x001, 0x402, 0x002, 0x403]);
    assert_eq!(rig.read(0, RF0R), 2);
    assert_eq!(rig.read(0, RF1R), 3 | FULL);
    assert_eq!(ids(&mut rig, 1), [0x401, 0x402, 0x403]);
    assert_eq!(ids(&mut rig, 0), [0x001, 0x002]);
}

#[test]
fn three_frames_fill_a_fifo_and_the_flag_waits_to_be_cleared() {
    let mut rig = received(0, &[1, 2, 3]);
    assert_eq!(rig.read(0, RF0R), 3 | FULL);
    rig.write(0, RF0R, FULL);
    assert_eq!(rig.read(0, RF0R), 3);
}

#[test]
fn an_overrun_replaces_the_newest_frame() {
    let mut rig = received(0, &[1, 2, 3, 4, 5]);
    assert_eq!(rig.read(0, RF0R), 3 | FULL | FOVR);
    assert_eq!(ids(&mut rig, 0), [1, 2, 5]);
    rig.write(0, RF0R, FOVR | FULL);
    assert_eq!(rig.read(0, RF0R), 0);
}

#[test]
fn a_locked_fifo_drops_what_overruns_it() {
    let mut rig = received(RFLM, &[1, 2, 3, 4, 5]);
    assert_eq!(rig.read(0, MCR) & RFLM, RFLM);
    assert_eq!(rig.read(0, RF0R), 3 | FULL | FOVR);
    assert_eq!(ids(&mut rig, 0), [1, 2, 3]);
}

#[test]
fn each_condition_of_a_fifo_has_its_interrupt() {
    // Enable bit, frames, and the write that takes the line down again.
    for (enable, frames, release) in [(0, 1, RFOM), (1, 3, FULL), (2, 4, FOVR)] {
        for fifo in [0, 1] {
            let all: Vec<u16> = (1..=frames).map(|n| n + 0x400 * fifo).collect();
            let mut rig = received(0, &all);
            assert_eq!(rig.lines(0), [false; 4]);
            rig.write(0, IER, 1 << (1 + enable + 3 * fifo));
            let mut wanted = [false; 4];
            wanted[1 + usize::from(fifo)] = true;
            assert_eq!(rig.lines(0), wanted, "enable {enable} of FIFO {fifo}");
            rig.write(0, RF0R + 4 * u64::from(fifo), release);
            assert_eq!(rig.lines(0), [false; 4], "enable {enable} of FIFO {fifo} released");
            assert_eq!(rig.interrupts(0).receive[usize::from(fifo)], 1);
            assert_eq!(rig.interrupts(0).total(), 1);
        }
    }
}

#[test]
fn frames_nobody_wants_raise_no_interrupt() {
    let mut rig = Rig::running(1);
    let bank = FilterBank { bank: 0, fifo: 0, wide: true, list: true, values: [0x605 << 21; 2] };
    rig.filters(0, &[bank]);
    rig.write(0, IER, 0b111_1110);
    let master = rig.attach(1_000_000);
    for id in 0..100 {
        rig.bus.send(master, std_frame(id, &[0; 8])).unwrap();
    }
    rig.run_us(20_000);
    assert_eq!(rig.bus.status(master).unwrap().sent, 100);
    assert_eq!(rig.interrupts(0).total(), 0);
}
