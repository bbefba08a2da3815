//! Sleep, initialisation, normal, silent and loop back: RM0090, 32.4, 32.5.

use crate::rig::{AWUM, BTR, ESR, IER, INRQ, MCR, MSR, RF0R, Rig, SLEEP, TSR, btr, std_frame};

const INAK: u32 = 1 << 0;
const SLAK: u32 = 1 << 1;
const WKUI: u32 = 1 << 3;
const SLAKI: u32 = 1 << 4;
const TXM: u32 = 1 << 8;
const RXM: u32 = 1 << 9;
const WKUIE: u32 = 1 << 16;
const SLKIE: u32 = 1 << 17;
const LBKM: u32 = 1 << 30;
const SILM: u32 = 1 << 31;

fn acknowledged(rig: &mut Rig, node: usize) -> u32 {
    rig.read(node, MSR) & (INAK | SLAK)
}

#[test]
fn after_a_reset_the_controller_sleeps() {
    let mut rig = Rig::new(1);
    let values = [MCR, MSR, TSR, RF0R, IER, ESR].map(|register| rig.read(0, register));
    assert_eq!(values, [0x0001_0002, 0x0000_0C02, 0x1C00_0000, 0, 0, 0]);
}

#[test]
fn initialisation_is_entered_from_sleep_at_once() {
    let mut rig = Rig::new(1);
    rig.write(0, MCR, INRQ | SLEEP);
    assert_eq!(acknowledged(&mut rig, 0), SLAK, "still asked to sleep");
    rig.write(0, MCR, INRQ);
    assert_eq!(acknowledged(&mut rig, 0), INAK);
}

#[test]
fn sleep_is_left_after_eleven_bits() {
    let mut rig = Rig::new(1);
    rig.set_up(0, 1_000_000, SLEEP);
    assert_eq!(acknowledged(&mut rig, 0), SLAK);
    rig.run_us(77);
    rig.write(0, MCR, 0);
    let asked = rig.now();
    assert_eq!(acknowledged(&mut rig, 0), SLAK);
    assert_eq!(rig.run_to(0, MSR, INAK | SLAK, 0) - asked, 11_000);
}

#[test]
fn a_node_joins_between_frames() {
    let mut rig = Rig::new(2);
    rig.set_up(0, 1_000_000, INRQ);
    rig.set_up(1, 1_000_000, 0);
    let master = rig.attach(1_000_000);
    rig.run_us(100);
    rig.bus.send(master, std_frame(0x000, &[0; 8])).unwrap();
    rig.run_us(80);
    rig.write(0, MCR, 0);
    rig.run_us(20);
    assert_eq!(acknowledged(&mut rig, 0), INAK, "a frame is under way");
    rig.run_us(100);
    assert_eq!(acknowledged(&mut rig, 0), 0);
    assert_eq!(rig.take_all(0, 0), [], "that frame is not its own business");
    assert_eq!(rig.take_all(1, 0).len(), 1);
}

#[test]
fn initialisation_waits_for_the_frame_under_way() {
    let mut rig = Rig::running(2);
    rig.send(0, 0, std_frame(0x100, &[0; 8]));
    rig.run_us(60);
    assert_eq!(rig.read(0, MSR) & (TXM | RXM), TXM);
    assert_eq!(rig.read(1, MSR) & (TXM | RXM), RXM);
    rig.write(0, MCR, INRQ);
    rig.write(1, MCR, INRQ);
    rig.run_us(20);
    assert_eq!([acknowledged(&mut rig, 0), acknowledged(&mut rig, 1)], [0, 0]);
    rig.run_us(100);
    assert_eq!([acknowledged(&mut rig, 0), acknowledged(&mut rig, 1)], [INAK, INAK]);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11);
    assert_eq!(rig.take_all(1, 0).len(), 1);
}

#[test]
fn on_a_quiet_bus_initialisation_comes_within_a_quantum() {
    let mut rig = Rig::running(1);
    rig.run_us(13);
    rig.write(0, MCR, INRQ);
    let asked = rig.now();
    assert!(rig.run_to(0, MSR, INAK, INAK) - asked <= 40_000);
}

#[test]
fn an_initialising_node_neither_receives_nor_acknowledges() {
    let mut rig = Rig::running(1);
    rig.write(0, MCR, INRQ);
    rig.run_us(100);
    let master = rig.attach(1_000_000);
    rig.bus.send(master, std_frame(0x100, &[])).unwrap();
    rig.run_us(500);
    assert_eq!(rig.bus.status(master).unwrap().sent, 0);
    assert_eq!(rig.take_all(0, 0), []);
}

#[test]
fn going_to_sleep_can_interrupt() {
    let mut rig = Rig::running(1);
    rig.write(0, IER, SLKIE);
    rig.write(0, MCR, SLEEP);
    rig.run_us(100);
    assert_eq!(rig.read(0, MSR) & (SLAK | SLAKI), SLAK | SLAKI);
    assert_eq!(rig.lines(0), [false, false, false, true]);
    rig.write(0, MSR, SLAKI);
    assert_eq!(rig.lines(0), [false; 4]);
}

#[test]
fn traffic_wakes_a_sleeping_node_by_itself_only_if_asked() {
    for (control, awake) in [(0, false), (AWUM, true)] {
        let mut rig = Rig::running(2);
        rig.write(0, IER, WKUIE);
        rig.write(0, MCR, SLEEP | control);
        rig.run_us(100);
        rig.send(1, 0, std_frame(0x000, &[]));
        let master = rig.attach(1_000_000);
        rig.run_us(300);
        assert_eq!(rig.read(0, MSR) & (SLAK | WKUI), if awake { WKUI } else { WKUI | SLAK });
        assert_eq!(rig.lines(0), [false, false, false, true]);
        rig.write(0, MSR, WKUI);
        assert_eq!(rig.lines(0), [false; 4]);
        assert_eq!(rig.take_all(0, 0), [], "the frame that woke it is lost");
        rig.bus.send(master, std_frame(0x001, &[])).unwrap();
        rig.run_us(300);
        assert_eq!(rig.take_all(0, 0).len(), usize::from(awake));
    }
}

/// One controller in a test mode, with a master on the bus.
fn in_test_mode(bits: u32) -> (Rig, world::can::Outside) {
    let mut rig = Rig::new(1);
    rig.write(0, MCR, INRQ);
    rig.write(0, BTR, btr(1_000_000) | bits);
    rig.accept_everything(0);
    rig.write(0, MCR, 0);
    rig.run_us(100);
    let master = rig.attach(1_000_000);
    (rig, master)
}

#[test]
fn a_silent_node_listens_without_a_trace() {
    let (mut rig, master) = in_test_mode(SILM);
    let other = rig.attach(1_000_000);
    rig.bus.send(master, std_frame(0x100, &[])).unwrap();
    rig.run_us(100);
    assert_eq!(rig.take_all(0, 0), [std_frame(0x100, &[])]);
    rig.bus.detach(other);
    rig.bus.send(master, std_frame(0x101, &[])).unwrap();
    rig.run_us(300);
    assert_eq!(rig.bus.status(master).unwrap().sent, 1, "it does not acknowledge");
    rig.bus.detach(master);
    rig.send(0, 0, std_frame(0x102, &[]));
    rig.run_us(1_000);
    assert_eq!(rig.read(0, TSR) & 1, 0, "it does not send");
}

#[test]
fn a_looped_back_node_hears_itself_alone_and_needs_no_acknowledgement() {
    let (mut rig, master) = in_test_mode(LBKM);
    rig.bus.detach(master);
    rig.send(0, 0, std_frame(0x100, &[1]));
    rig.run_us(100);
    assert_eq!(rig.read(0, TSR) & 0b11, 0b11);
    assert_eq!(rig.take_all(0, 0), [std_frame(0x100, &[1])]);
    let master = rig.attach(1_000_000);
    rig.send(0, 0, std_frame(0x101, &[1]));
    rig.run_us(200);
    assert_eq!(rig.bus.receive(master).map(|(_, f)| f), Some(std_frame(0x101, &[1])));
    rig.take_all(0, 0);
    rig.bus.send(master, std_frame(0x200, &[])).unwrap();
    rig.run_us(300);
    assert_eq!(rig.take_all(0, 0), [], "it does not hear others");
    assert_eq!(rig.bus.status(master).unwrap().sent, 0, "nor acknowledge them");
}

#[test]
fn looped_back_and_silent_nothing_reaches_the_wire() {
    let (mut rig, master) = in_test_mode(LBKM | SILM);
    let asked = rig.now();
    rig.send(0, 0, std_frame(0x014, &[1]));
    let sent = rig.run_to(0, TSR, 0b11, 0b11);
    assert_eq!(sent - asked, 55_000, "it takes the time of the frame");
    assert_eq!(rig.take_all(0, 0), [std_frame(0x014, &[1])]);
    rig.run_us(100);
    assert!(rig.bus.receive(master).is_none());
    assert_eq!(rig.bus.busy(), 0);
}

#[test]
fn a_master_reset_by_software_puts_it_to_sleep() {
    let mut rig = Rig::running(2);
    rig.send(1, 0, std_frame(0x100, &[]));
    rig.run_us(100);
    rig.write(0, MCR, 1 << 15);
    assert_eq!(rig.read(0, MCR), 0x0001_0002);
    assert_eq!((acknowledged(&mut rig, 0), rig.read(0, RF0R)), (SLAK, 0));
}

#[test]
fn a_reset_in_the_middle_of_a_frame_leaves_nothing_behind() {
    let mut rig = Rig::running(2);
    rig.write(1, IER, 0b10);
    rig.send(0, 0, std_frame(0x100, &[0; 8]));
    rig.run_us(60);
    rig.reset(1);
    rig.run_us(200);
    assert_eq!(rig.read(1, MSR), 0x0000_0C02);
    assert_eq!(rig.read(1, RF0R), 0);
    assert_eq!(rig.lines(1), [false; 4]);
    rig.set_up(1, 1_000_000, 0);
    rig.run_us(200);
}
