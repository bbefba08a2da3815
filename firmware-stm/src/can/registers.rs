//! The registers of CAN1 that are not left to `bxcan`: reception, because its frames cannot hold a
//! data length code above 8, which the wire can carry; the transmit mailboxes, because an answer
//! must be in one 4 µs after its question was received; error states.
use canopen::{CanId, Frame};
use embassy_stm32::pac::CAN1;
use embassy_stm32::pac::can::regs::{Msr, Rfr, Tdhr, Tdlr, Tdtr, Tir, Tsr};
use embassy_stm32::pac::can::vals::Rtr;

/// Error state of the controller (ISO 11898-1), from harmless to cut off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum ErrorState {
    Active,
    Warning,
    Passive,
    BusOff,
}

pub(super) fn error_state() -> ErrorState {
    let errors = CAN1.esr().read();
    if errors.boff() {
        ErrorState::BusOff
    } else if errors.epvf() {
        ErrorState::Passive
    } else if errors.ewgf() {
        ErrorState::Warning
    } else {
        ErrorState::Active
    }
}

/// Lets changes of the error state interrupt. Single bit errors (LECIE) do not: a noisy bus would
/// keep the core busy with nothing to decide.
pub(super) fn report_error_states() {
    CAN1.ier().modify(|w| {
        w.set_ewgie(true);
        w.set_epvie(true);
        w.set_bofie(true);
        w.set_errie(true);
    });
}

/// Ends the interrupt raised by a change of the error state.
pub(super) fn acknowledge_error_state() {
    let mut flags = Msr(0);
    flags.set_erri(true);
    CAN1.msr().write_value(flags);
}

/// What became of a transmit request.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    Sent,
    Aborted,
}

/// Transmit requests that ended.
#[derive(Clone, Copy)]
pub(super) struct Ended(Tsr);

impl Ended {
    /// Takes all that ended since the last call.
    pub(super) fn take() -> Self {
        let ended = CAN1.tsr().read();
        // Clears TXOK, ALST and TERR of the same mailbox as well; the other bits ignore a zero.
        let mut clear = Tsr(0);
        for mailbox in 0..3 {
            clear.set_rqcp(mailbox, ended.rqcp(mailbox));
        }
        CAN1.tsr().write_value(clear);
        Self(ended)
    }

    /// What became of the request of `mailbox` (0..=2), if it ended.
    pub(super) fn outcome(self, mailbox: usize) -> Option<Outcome> {
        let outcome = if self.0.txok(mailbox) { Outcome::Sent } else { Outcome::Aborted };
        self.0.rqcp(mailbox).then_some(outcome)
    }
}

/// Puts `frame` into `mailbox` (0..=2), which is empty, and requests its transmission.
#[inline]
pub(super) fn request(mailbox: usize, frame: &Frame) {
    let place = CAN1.tx(mailbox);
    let [a, b, c, d, e, f, g, h] = frame.padded();
    let mut length = Tdtr(0);
    length.set_dlc(frame.dlc());
    place.tdtr().write_value(length);
    place.tdlr().write_value(Tdlr(u32::from_le_bytes([a, b, c, d])));
    place.tdhr().write_value(Tdhr(u32::from_le_bytes([e, f, g, h])));
    let mut head = Tir(0);
    head.set_stid(frame.id().get());
    head.set_rtr(if frame.is_remote() { Rtr::REMOTE } else { Rtr::DATA });
    head.set_txrq(true);
    place.tir().write_value(head);
}

/// Takes back the request of `mailbox` (0..=2). A frame that is on the wire is finished first: the
/// outcome tells which it was.
pub(super) fn abort(mailbox: usize) {
    let mut request = Tsr(0);
    request.set_abrq(mailbox, true);
    CAN1.tsr().write_value(request);
}

/// What a receive FIFO has to say.
pub(crate) enum Received {
    Frame(Frame),
    /// A frame was lost since the last call because the FIFO was full.
    Overrun,
}

/// The receive FIFOs.
#[derive(Clone, Copy)]
pub(crate) enum Fifo {
    Control = 0,
    Data = 1,
}

/// A data length code above 8 stands for eight bytes (ISO 11898-1).
const DLC_MAX: u8 = 8;

/// Takes the oldest frame out of `fifo`. The filters let 11-bit identifiers through only.
#[inline]
pub(super) fn receive(fifo: Fifo) -> Option<Received> {
    let state = CAN1.rfr(fifo as usize);
    let flags = state.read();
    if flags.fovr() {
        let mut clear = Rfr(0);
        clear.set_fovr(true);
        state.write_value(clear);
        return Some(Received::Overrun);
    }
    // While the frame taken last is still being released its registers show it once more. The
    // interrupt stays raised and comes again for what is behind it.
    if flags.fmp() == 0 || flags.rfom() {
        return None;
    }
    let mailbox = CAN1.rx(fifo as usize);
    let head = mailbox.rir().read();
    let len = mailbox.rdtr().read().dlc();
    let [a, b, c, d] = mailbox.rdlr().read().0.to_le_bytes();
    let [e, f, g, h] = mailbox.rdhr().read().0.to_le_bytes();
    let mut release = Rfr(0);
    release.set_rfom(true);
    state.write_value(release);
    let id = CanId::from_low_bits(u32::from(head.stid()));
    Some(Received::Frame(match head.rtr() {
        Rtr::DATA => Frame::prefix(id, [a, b, c, d, e, f, g, h], len),
        Rtr::REMOTE => remote_frame(id, len),
    }))
}

/// Rare, and kept out of the way of data frames.
#[cold]
fn remote_frame(id: CanId, len: u8) -> Frame {
    Frame::new_remote(id, len.min(DLC_MAX)).unwrap_or(Frame::full(id, [0; 8]))
}
