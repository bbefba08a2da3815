//! Shell
#![no_std]
mod can;
mod core_task;

/// x
pub fn x(p: embassy_stm32::Peripherals) {
    let mut c = can::Port::new(can::Pins { can: p.CAN1, rx: p.PD0, tx: p.PD1 });
    c.configure(125000, &[0]);
    let _ = c.transmit(&canopen::Frame::full(canopen::CanId::MAX, [0; 8]));
    c.join();
    c.receive(can::Turn::Control);
    c.take_lost();
    c.poll_completed();
    c.listen_for_outcomes();
    c.error_state();
}
