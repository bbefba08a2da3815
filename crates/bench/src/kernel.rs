//! A CAN interface of this computer (SocketCAN), joined to the virtual bus.
//!
//! Every frame on either side is sent on the other. To the run the interface is one more SLCAN
//! client: two threads translate between lines and the kernel's frames.

use std::sync::Arc;
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;
use std::time::Duration;

use socketcan::{CanFrame, CanSocket, EmbeddedFrame as _, ExtendedId, Socket as _, StandardId};
use world::can::{Frame, Id, Nanos, Rate};

use crate::lines::{Line, Lines};
use crate::run::{CHUNKS_MAX, ClientId, Event, Newcomer, Speaks, Stopper};
use crate::slcan::{self, Channel, Command, Stamps};

/// How long the reader waits for a frame before it looks whether the run is over.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// An interface that is open, and not joined yet.
pub struct Interface {
    socket: CanSocket,
    rate: Rate,
}

impl Interface {
    /// Opens `name`, which is IFACE or IFACE@BITRATE: the bit rate the interface has on the virtual
    /// bus, the one of the devices unless given.
    ///
    /// # Errors
    /// A sentence: the kernel has no CAN, there is no such interface, or it may not be used.
    pub fn open(name: &str) -> Result<Self, String> {
        let (name, rate) = match name.split_once('@') {
            None => (name, Rate::Automatic),
            Some((name, rate)) => {
                let wrong = || format!("{rate:?} is no bit rate: try {name}@125000");
                let rate = rate.parse().ok().filter(|&rate| rate > 0).ok_or_else(wrong)?;
                (name, Rate::Fixed(rate))
            }
        };
        let unusable =
            |error| format!("the CAN interface {name} can not be used (SocketCAN says: {error})");
        let socket = CanSocket::open(name).map_err(unusable)?;
        socket.set_read_timeout(LOOK_EVERY).map_err(unusable)?;
        Ok(Self { socket, rate })
    }

    /// Joins the virtual bus as client `id`.
    pub fn join(self, id: ClientId, events: SyncSender<Event>, stopper: Stopper) {
        let (out, chunks) = mpsc::sync_channel(CHUNKS_MAX);
        let speaks = Speaks::Slcan(Channel::at(self.rate));
        let socket = Arc::new(self.socket);
        let writing = socket.clone();
        thread::spawn(move || write(&writing, &chunks));
        thread::spawn(move || {
            let joined = [
                Event::Joined(Newcomer { id, speaks, out, connection: None }),
                Event::Said(id, b"O\r".to_vec()),
            ];
            if joined.into_iter().all(|event| events.send(event).is_ok()) {
                read(&socket, id, &events, &stopper);
            }
        });
    }
}

fn read(socket: &CanSocket, id: ClientId, events: &SyncSender<Event>, stopper: &Stopper) {
    while !stopper.stopped() {
        // A wait that ran out is an error like any other; none of them lasts.
        let Some(frame) = socket.read_frame().ok().as_ref().and_then(from_kernel) else { continue };
        let line = slcan::write(Nanos::ZERO, &frame, Stamps::Off);
        if events.send(Event::Said(id, line.into_bytes())).is_err() {
            return;
        }
    }
}

fn write(socket: &CanSocket, chunks: &Receiver<Vec<u8>>) {
    let mut lines = Lines::new(b'\r', slcan::LINE_MAX);
    while let Ok(chunk) = chunks.recv() {
        for line in lines.push(&chunk) {
            if let Line::Whole(line) = line
                && let Ok(Command::Transmit(frame)) = Command::parse(&line)
                && let Some(frame) = to_kernel(&frame)
            {
                // An interface that is down or full loses the frame, as a real one does.
                let _ = socket.write_frame(&frame);
            }
        }
    }
}

/// None for the kernel's error frames.
fn from_kernel(frame: &CanFrame) -> Option<Frame> {
    let id = match frame.id() {
        socketcan::Id::Standard(id) => Id::Standard(id.as_raw()),
        socketcan::Id::Extended(id) => Id::Extended(id.as_raw()),
    };
    match frame {
        CanFrame::Data(_) => Frame::new(id, frame.data()).ok(),
        CanFrame::Remote(_) => Frame::remote(id, u8::try_from(frame.dlc()).ok()?).ok(),
        CanFrame::Error(_) => None,
    }
}

fn to_kernel(frame: &Frame) -> Option<CanFrame> {
    let id = match frame.id() {
        Id::Standard(id) => socketcan::Id::Standard(StandardId::new(id)?),
        Id::Extended(id) => socketcan::Id::Extended(ExtendedId::new(id)?),
    };
    if frame.is_remote() {
        CanFrame::new_remote(id, usize::from(frame.dlc()))
    } else {
        CanFrame::new(id, frame.data())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_the_same_on_both_sides() {
        for frame in [
            Frame::new(Id::Standard(0x7FF), &[1, 2, 3, 4, 5, 6, 7, 8]).unwrap(),
            Frame::new(Id::Standard(0), &[]).unwrap(),
            Frame::new(Id::Extended(0x1FFF_FFFF), &[0xFF]).unwrap(),
            Frame::remote(Id::Standard(0x701), 1).unwrap(),
            Frame::remote(Id::Extended(0x701), 8).unwrap(),
        ] {
            assert_eq!(to_kernel(&frame).as_ref().and_then(from_kernel), Some(frame));
        }
    }

    #[test]
    fn an_interface_that_does_not_exist_is_refused_by_name() {
        for (name, named) in [("nosuchcan7", "nosuchcan7"), ("can0@fast", "fast")] {
            let sentence = Interface::open(name).map(|_| ()).unwrap_err();
            assert!(sentence.contains(named), "{sentence}");
        }
    }
}
