//! The CAN interface controller: its core, and what the shell of the image does for it.

use canopen::BusState;
use interface::{Boot, Event, Interface};
use profiles::Product;
use units::Duration;
use world::can::{Delivery, Nanos, PortState};

use crate::board::Board;
use crate::can_port::{CanPort, Notice};
use crate::memory::Kept;
use crate::pair::Outgoing;

/// How soon to look again at an error state that has to recover: getting better is no interrupt.
const LOOK_AGAIN_AFTER: Duration = Duration::from_millis(5);

/// The controller while it has supply.
#[derive(Debug)]
pub(crate) struct Stm {
    interface: Box<Interface>,
    port: CanPort,
    bus: BusState,
    look_again_ns: Option<u64>,
}

impl Stm {
    /// Starts with what `board` has in its memory.
    pub(crate) fn new(
        now_ns: u64,
        product: &'static Product,
        serial_number: u32,
        board: &Board,
    ) -> Self {
        let boot = Boot { serial_number, nonce: board.nonce().get() };
        let now = board.time(now_ns);
        let interface = Box::new(Interface::new(now, product, boot, board.memory.numbers()));
        let mut stm =
            Self { interface, port: CanPort::new(), bus: BusState::Active, look_again_ns: None };
        stm.configure_bus(now_ns);
        stm
    }

    /// Takes in what the bus decided.
    pub(crate) fn deliver(&mut self, delivery: Delivery) {
        self.port.deliver(delivery);
    }

    /// What its CAN controller wants from the bus.
    pub(crate) fn port(&self) -> PortState {
        self.port.state()
    }

    /// Frames that passed the filters.
    pub(crate) fn frames_taken(&self) -> u64 {
        self.port.frames_taken()
    }

    /// When there is something to do, apart from the line.
    pub(crate) fn due_ns(&self, board: &Board) -> Option<u64> {
        let timeout = self.interface.poll_timeout().map(|at| board.nanos(at));
        let event = self.port.next_event().map(|at| at.0);
        [timeout, event, self.look_again_ns].into_iter().flatten().min()
    }

    /// Does what is due: frames, bytes, error state, time.
    pub(crate) fn run(&mut self, arrived: Option<&[u8]>, out: &mut Outgoing<'_>) -> Kept {
        let now = out.board.time(out.now_ns);
        let mut kept = Kept::Yes;
        while let Some(notice) = self.port.poll(Nanos(out.now_ns)) {
            match notice {
                Notice::Received(frame) => self.interface.handle_frame(now, &frame),
                Notice::Returned(frame) => self.interface.give_back(frame),
                Notice::Other => {}
            }
            kept = kept.and(self.drain(out));
        }
        if let Some(bytes) = arrived {
            self.interface.handle_link(now, bytes);
            kept = kept.and(self.drain(out));
        }
        let bus = self.port.bus_state();
        if bus != self.bus {
            self.bus = bus;
            self.interface.handle_bus(now, bus);
            kept = kept.and(self.drain(out));
        }
        if self.interface.poll_timeout().is_some_and(|due| due <= now) {
            self.interface.handle_timeout(now);
        }
        kept = kept.and(self.drain(out));
        let pending = self.look_again_ns.filter(|at| *at > out.now_ns);
        self.look_again_ns = match self.bus {
            BusState::Active => None,
            BusState::Warning | BusState::Passive | BusState::Off => {
                Some(pending.unwrap_or(out.now_ns + LOOK_AGAIN_AFTER.as_micros() * 1_000))
            }
        };
        kept
    }

    /// Hands on what the core brought about.
    fn drain(&mut self, out: &mut Outgoing<'_>) -> Kept {
        while let Some(frame) = self.interface.peek_transmit().copied() {
            let Ok(returned) = self.port.transmit(Nanos(out.now_ns), &frame) else { break };
            self.interface.take_transmit();
            if let Some(returned) = returned {
                self.interface.give_back(returned);
            }
        }
        while out.has_room()
            && let Some(frame) = self.interface.poll_link()
        {
            out.send(&frame);
        }
        let mut kept = Kept::Yes;
        while let Some(event) = self.interface.poll_event() {
            match event {
                Event::Store(record) => kept = kept.and(out.keep(record.key, record.value)),
                Event::StoreSet => {
                    let set = self.interface.set_to_store();
                    kept = kept.and(out.keep_set(set.map(|record| (record.key, record.value))));
                }
                Event::Forget => kept = kept.and(out.forget()),
                Event::Confirm(number) => {
                    let now = out.board.time(out.now_ns);
                    self.interface.handle_saved(now, number, Ok(()));
                }
                Event::FiltersChanged => self.configure_bus(out.now_ns),
                Event::Restart => out.restart(),
            }
        }
        kept
    }

    fn configure_bus(&mut self, now_ns: u64) {
        let Self { interface, port, .. } = self;
        port.configure(Nanos(now_ns), interface.bit_rate(), interface.accepts());
    }
}
