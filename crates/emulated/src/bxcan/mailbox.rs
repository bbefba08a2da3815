use world::can::{Frame, Id, Nanos, Request};

use super::filters::wide_pattern;
use super::registers::{dtr, ir, tsr};

/// Longest data of a frame; a larger length code means this many bytes.
const DATA_MAX: u32 = 8;

/// The four registers of a mailbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// TIxR, RIxR.
    Identifier,
    /// TDTxR, RDTxR.
    Length,
    /// TDLxR, RDLxR.
    Low,
    /// TDHxR, RDHxR.
    High,
}

/// What a received frame shows in its register.
pub(super) fn received(frame: &Frame, filter: u8, part: Part) -> u32 {
    let mut data = [0; DATA_MAX as usize];
    for (to, from) in data.iter_mut().zip(frame.data()) {
        *to = *from;
    }
    let [a, b, c, d, e, f, g, h] = data;
    match part {
        Part::Identifier => wide_pattern(frame),
        Part::Length => u32::from(frame.dlc()) | u32::from(filter) << dtr::FMI,
        Part::Low => u32::from_le_bytes([a, b, c, d]),
        Part::High => u32::from_le_bytes([e, f, g, h]),
    }
}

/// A transmit mailbox (RM0090, 32.7.1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mailbox {
    identifier: u32,
    length: u32,
    low: u32,
    high: u32,
    /// RQCP, TXOK, ALST, TERR.
    status: u32,
    requested_at: Option<Nanos>,
    withdrawn_at: Option<Nanos>,
}

impl Mailbox {
    pub(super) const fn read(&self, part: Part) -> u32 {
        match part {
            Part::Identifier => self.identifier,
            Part::Length => self.length,
            Part::Low => self.low,
            Part::High => self.high,
        }
    }

    /// Writes a register of an empty mailbox; one that waits to be sent is protected.
    pub(super) fn write(&mut self, part: Part, value: u32, now: Nanos) {
        if !self.is_empty() {
            return;
        }
        match part {
            Part::Identifier => {
                self.identifier = value;
                if value & ir::TXRQ != 0 {
                    self.requested_at = Some(now);
                    self.status = 0;
                }
            }
            Part::Length => self.length = value,
            Part::Low => self.low = value,
            Part::High => self.high = value,
        }
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.requested_at.is_none()
    }

    pub(super) const fn is_withdrawn(&self) -> bool {
        self.withdrawn_at.is_some()
    }

    /// The frame as it would be sent.
    pub(super) fn frame(&self) -> Frame {
        let id = if self.identifier & ir::IDE != 0 {
            Id::Extended(self.identifier >> ir::EXID)
        } else {
            Id::Standard(u16::try_from(self.identifier >> ir::STID).unwrap_or_default())
        };
        let dlc = (self.length & dtr::DLC_MASK).min(DATA_MAX);
        let frame = if self.identifier & ir::RTR != 0 {
            Frame::remote(id, u8::try_from(dlc).unwrap_or_default())
        } else {
            let words = [self.low.to_le_bytes(), self.high.to_le_bytes()];
            let data = words.as_flattened();
            Frame::new(id, data.get(..usize::try_from(dlc).unwrap_or_default()).unwrap_or(data))
        };
        // The registers have no room for an identifier or a length out of range.
        frame.expect("a mailbox always holds a frame")
    }

    pub(super) fn request(&self) -> Option<Request> {
        let at = self.requested_at?;
        Some(Request { at, withdrawn_at: self.withdrawn_at, frame: self.frame() })
    }

    /// This mailbox's byte of TSR.
    pub(super) const fn status(&self) -> u32 {
        self.status | if self.is_withdrawn() { tsr::ABRQ } else { 0 }
    }

    /// Clears bits of its byte of TSR; RQCP takes the others along.
    pub(super) const fn clear(&mut self, bits: u32) {
        let results = tsr::TXOK | tsr::ALST | tsr::TERR;
        let all = if bits & tsr::RQCP != 0 { tsr::RQCP | results } else { bits & results };
        self.status &= !all;
    }

    pub(super) const fn withdraw(&mut self, now: Nanos) {
        if self.requested_at.is_some() && self.withdrawn_at.is_none() {
            self.withdrawn_at = Some(now);
        }
    }

    /// An attempt failed and there will be another.
    pub(super) const fn failed(&mut self, result: u32) {
        self.status = result;
    }

    /// The request is done with; `result` is TXOK, ALST, TERR or 0.
    pub(super) const fn complete(&mut self, result: u32) {
        self.status = tsr::RQCP | result;
        self.requested_at = None;
        self.withdrawn_at = None;
        self.identifier &= !ir::TXRQ;
    }
}
