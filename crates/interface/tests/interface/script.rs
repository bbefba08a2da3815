//! A CAN interface controller on a table: a master on the bus, a partner on the link that has the
//! values of delivery, and a memory.

use std::fmt::Write as _;

use canopen::{BusState, CanId, Frame};
use expect_test::Expect;
use interface::{Boot, Event, Interface, NotSaved, Record};
use profiles::Product;
use profiles::nm172::PRODUCT;
use shared_proto::limits::SNAPSHOT_VALUES_MAX;
use shared_proto::{Hello, PROTOCOL, ProcessData, Receiver, ToApplication, ToInterface, encode};
use units::{Duration, Instant};

const CYCLE: Duration = Duration::from_millis(10);

/// The application controller as the link shows it: greets, has its values at their defaults,
/// acknowledges.
pub(crate) struct Partner {
    product: &'static Product,
    receiver: Receiver<ToApplication>,
    hello: Hello,
    pub(crate) process: ProcessData,
    pub(crate) answers: Vec<ToInterface>,
    pub(crate) connected: bool,
}

impl Partner {
    fn hear(&mut self, frame: &[u8]) -> Option<String> {
        let message = frame.iter().filter_map(|&byte| self.receiver.push(byte)).last()?;
        match message {
            ToApplication::Hello(hello) => {
                self.hello.heard = hello.nonce;
                self.hello.in_service = hello.heard == self.hello.nonce;
                self.answers.push(ToInterface::Hello(self.hello));
                None
            }
            ToApplication::Idle(_) => None,
            ToApplication::Write(_, write) => {
                self.process.acknowledged = write.sequence;
                Some(format!("write {:04x}:{} = {}", write.index, write.sub, write.value))
            }
            ToApplication::RequestSnapshot { from, .. } => {
                let rows = self.product.dictionary.rows().skip(from.into());
                let values = rows.take(SNAPSHOT_VALUES_MAX).map(|row| row.initial(127)).collect();
                self.answers.push(ToInterface::Snapshot { from, values });
                None
            }
            ToApplication::Urgent(_, urgent) => {
                self.process.urgent_acknowledged = urgent.number;
                Some(format!("urgent {:?}", urgent.urgency))
            }
        }
    }
}

pub(crate) struct Script {
    pub(crate) now: Instant,
    pub(crate) interface: Interface,
    pub(crate) partner: Partner,
    /// What the memory answers.
    pub(crate) memory: Result<(), NotSaved>,
    /// The set that was to be stored last.
    pub(crate) set: Vec<Record>,
    pub(crate) transcript: String,
}

impl Script {
    /// Just powered for the first time.
    pub(crate) fn new() -> Self {
        Self::powered(&PRODUCT, &[])
    }

    /// Just powered.
    pub(crate) fn powered(product: &'static Product, stored: &[(u32, u32)]) -> Self {
        let boot = Boot { serial_number: 0x4D52_F567, nonce: 1 };
        let hello = Hello {
            protocol: PROTOCOL,
            product: product.code,
            firmware: product.firmware,
            dictionary: product.fingerprint,
            nonce: 2,
            heard: 0,
            in_service: false,
        };
        Self {
            now: Instant::ZERO,
            interface: Interface::new(Instant::ZERO, product, boot, stored.iter().copied()),
            partner: Partner {
                product,
                receiver: Receiver::default(),
                hello,
                process: ProcessData { position_hundredths_mm: 500_000, ..Default::default() },
                answers: Vec::new(),
                connected: true,
            },
            memory: Ok(()),
            set: Vec::new(),
            transcript: String::new(),
        }
    }

    /// Booted, half a second ago.
    pub(crate) fn booted() -> Self {
        let mut script = Self::new();
        script.run(500);
        script.transcript.clear();
        script
    }

    /// Lets time pass. The partner speaks every 10 ms.
    pub(crate) fn run(&mut self, ms: u64) -> &mut Self {
        let end = self.now + Duration::from_millis(ms);
        let mut cycle_at = self.now + CYCLE;
        loop {
            let due = self.interface.poll_timeout().unwrap_or(end).max(self.now);
            let next = due.min(cycle_at).min(end);
            self.now = next;
            if due == next {
                self.interface.handle_timeout(self.now);
                self.drain();
            }
            if cycle_at == next {
                cycle_at = cycle_at + CYCLE;
                self.partner_speaks();
            }
            if next == end {
                return self;
            }
        }
    }

    fn partner_speaks(&mut self) {
        if !self.partner.connected {
            return;
        }
        let regular = if self.partner.hello.in_service {
            ToInterface::Process(self.partner.process)
        } else {
            ToInterface::Hello(self.partner.hello)
        };
        self.partner.answers.push(regular);
        while let Some(message) = self.partner.answers.pop() {
            self.interface.handle_link(self.now, &encode(&message));
            self.drain();
        }
    }

    /// A frame from a master: `id#data` in hexadecimal.
    pub(crate) fn send(&mut self, frame: &str) -> &mut Self {
        self.note("<-", frame);
        let (id, data) = frame.split_once('#').expect("id#data");
        let bytes: Vec<u8> = data
            .split_whitespace()
            .map(|byte| u8::from_str_radix(byte, 16).expect("two hex digits"))
            .collect();
        let id = CanId::new(u16::from_str_radix(id, 16).expect("hexadecimal")).expect("11 bits");
        self.interface.handle_frame(self.now, &Frame::new(id, &bytes).expect("up to 8 bytes"));
        self.drain();
        if self.interface.poll_timeout().is_some_and(|due_at| due_at <= self.now) {
            self.interface.handle_timeout(self.now);
            self.drain();
        }
        self
    }

    /// The partner says that the user touched the device during an offer.
    pub(crate) fn touch(&mut self, offer: u8) -> &mut Self {
        self.note("MSP", &format!("touched during offer {offer}"));
        self.interface.handle_link(self.now, &encode(&ToInterface::Touched { offer }));
        self.drain();
        self
    }

    pub(crate) fn bus(&mut self, state: BusState) -> &mut Self {
        self.note("bus", &format!("{state:?}"));
        self.interface.handle_bus(self.now, state);
        self.drain();
        self
    }

    pub(crate) fn drain(&mut self) {
        while let Some(frame) = self.interface.take_transmit() {
            let data: Vec<String> = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
            self.note("->", &format!("{:03X}#{}", frame.id().get(), data.join(" ")));
        }
        while let Some(frame) = self.interface.poll_link() {
            if self.partner.connected
                && let Some(order) = self.partner.hear(&frame)
            {
                self.note("MSP", &order);
            }
        }
        while let Some(event) = self.interface.poll_event() {
            self.note("do", &format!("{event:X?}"));
            match event {
                Event::StoreSet => self.set = self.interface.set_to_store().collect(),
                Event::Forget => self.set.clear(),
                Event::Confirm(number) => {
                    self.interface.handle_saved(self.now, number, self.memory);
                    self.drain();
                }
                Event::Store(_) | Event::FiltersChanged | Event::Restart => {}
            }
        }
    }

    fn note(&mut self, what: &str, detail: &str) {
        let ms = self.now.as_micros() / 1_000;
        writeln!(self.transcript, "{ms:<5} {what:3} {detail}").expect("a string takes everything");
    }

    #[track_caller]
    pub(crate) fn expect(&self, expected: Expect) {
        expected.assert_eq(&self.transcript);
    }
}
