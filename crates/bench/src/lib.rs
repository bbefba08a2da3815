//! The front of the virtual bench: one command line, the CAN gateways, the control port and the
//! terminal user interface, on top of whichever [`world::Engine`] runs the devices.
//!
//! One thread owns the engine and deals with one event after the other ([`run`]); the threads
//! around it only carry bytes ([`ports`], [`kernel`]). What a client says is understood by code
//! without threads and sockets: [`slcan`], [`socketcand`], [`control`].
//!
//! A program or a test may run a bench of its own:
//!
//! ```no_run
//! # fn start(engine: Box<dyn world::Engine>) -> Result<(), String> {
//! use bench::{Bench, Setup, args::Clock};
//!
//! let bench = Bench::start(Setup::new("nm172", Clock::Step), engine)?;
//! println!("masters attach to {}", bench.slcan());
//! bench.stop();
//! # Ok(())
//! # }
//! ```

pub mod args;
pub mod control;
pub mod glance;
mod hex;
pub mod images;
#[cfg(target_os = "linux")]
pub mod kernel;
pub mod lines;
pub mod node;
pub mod pace;
pub mod ports;
pub mod run;
pub mod slcan;
pub mod socketcand;
pub mod stage;
pub mod state;
pub mod tui;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::mpsc::{self, SyncSender};
use std::thread::{self, JoinHandle};

use world::Engine;

use crate::args::Clock;
use crate::ports::{Names, Port};
use crate::run::{EVENTS_MAX, End, Event, Run, Speaks, Stopper};
use crate::slcan::Channel;
use crate::stage::Stage;
use crate::state::StateDir;

/// Products that have images of two controllers; the twin engine has more.
pub const PAIRS: [&str; 1] = ["nm172"];

/// Products that have an image of one controller, which is on the CAN bus and nothing else.
pub const SINGLES: [&str; 1] = ["dev1"];

/// What a bench is started with, besides its engine.
pub struct Setup {
    /// The product of all devices.
    pub product: String,
    /// What moves virtual time.
    pub clock: Clock,
    /// Where SLCAN clients attach.
    pub slcan: SocketAddr,
    /// Where socketcand clients attach, if they may.
    pub socketcand: Option<SocketAddr>,
    /// A CAN interface of this computer, IFACE or IFACE@BITRATE.
    pub socketcan: Option<String>,
    /// Where the control port listens.
    pub control: SocketAddr,
    /// Where flash contents are kept.
    pub state: Option<StateDir>,
}

impl Setup {
    /// A bench that keeps nothing, on any free ports of this computer.
    #[must_use]
    pub fn new(product: &str, clock: Clock) -> Self {
        let any = SocketAddr::from((Ipv4Addr::LOCALHOST, 0));
        Self {
            product: product.to_owned(),
            clock,
            slcan: any,
            socketcand: None,
            socketcan: None,
            control: any,
            state: None,
        }
    }
}

/// A bench that is up.
pub struct Bench {
    product: String,
    nodes: usize,
    slcan: SocketAddr,
    socketcand: Option<SocketAddr>,
    control: SocketAddr,
    events: SyncSender<Event>,
    stopper: Stopper,
    run: JoinHandle<End>,
}

impl Bench {
    /// Opens the ports and starts the run.
    ///
    /// # Errors
    /// A sentence: an address or an interface can not be used.
    pub fn start(setup: Setup, engine: Box<dyn Engine>) -> Result<Self, String> {
        let slcan = Port::bind(setup.slcan, "SLCAN")?;
        let control = Port::bind(setup.control, "control")?;
        let socketcand =
            setup.socketcand.map(|address| Port::bind(address, "socketcand")).transpose()?;
        #[cfg(target_os = "linux")]
        let interface = setup.socketcan.as_deref().map(kernel::Interface::open).transpose()?;
        #[cfg(not(target_os = "linux"))]
        if setup.socketcan.is_some() {
            return Err("only Linux has SocketCAN: leave --socketcan out".to_owned());
        }

        let (events, queue) = mpsc::sync_channel(EVENTS_MAX);
        let stopper = Stopper::new(events.clone());
        let nodes = engine.node_count();
        let stage = Stage::new(&setup.product, engine);
        let run = Run::new(stage, setup.clock, setup.state, queue, stopper.clone());

        let bench = Self {
            product: setup.product,
            nodes,
            slcan: slcan.address(),
            socketcand: socketcand.as_ref().map(Port::address),
            control: control.address(),
            events: events.clone(),
            stopper: stopper.clone(),
            run: thread::spawn(move || run.go()),
        };
        let names = Names::default();
        let serve = |port: Port, speaks| {
            port.serve(speaks, names.clone(), events.clone(), stopper.clone());
        };
        serve(slcan, || Speaks::Slcan(Channel::default()));
        serve(control, || Speaks::Control);
        if let Some(socketcand) = socketcand {
            serve(socketcand, || Speaks::Socketcand);
        }
        #[cfg(target_os = "linux")]
        if let Some(interface) = interface {
            interface.join(names.next(), events, stopper);
        }
        Ok(bench)
    }

    /// Where SLCAN clients attach.
    #[must_use]
    pub const fn slcan(&self) -> SocketAddr {
        self.slcan
    }

    /// Where socketcand clients attach.
    #[must_use]
    pub const fn socketcand(&self) -> Option<SocketAddr> {
        self.socketcand
    }

    /// Where the control port listens.
    #[must_use]
    pub const fn control(&self) -> SocketAddr {
        self.control
    }

    /// How many devices are on the bus.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// Where events go, for a terminal.
    #[must_use]
    pub fn events(&self) -> SyncSender<Event> {
        self.events.clone()
    }

    /// Stops the run, from any thread.
    #[must_use]
    pub fn stopper(&self) -> Stopper {
        self.stopper.clone()
    }

    /// The line that tells where everything is: one JSON object, without newline.
    #[must_use]
    pub fn ready_line(&self) -> String {
        let socketcand = self
            .socketcand
            .map(|address| format!("\"socketcand\":\"{address}\","))
            .unwrap_or_default();
        let products = vec![format!("\"{}\"", self.product); self.nodes].join(",");
        format!(
            "{{\"ready\":true,\"slcan\":\"{}\",{socketcand}\"control\":\"{}\",\"products\":[{products}]}}",
            self.slcan, self.control
        )
    }

    /// Stops the run and tells how it ended.
    pub fn stop(self) -> End {
        self.stopper.stop();
        self.wait()
    }

    /// Waits for the run to end.
    pub fn wait(self) -> End {
        let end = self.run.join().unwrap_or_else(|_| {
            End::Failed("the engine has come to a state it should not reach".to_owned())
        });
        self.stopper.stop();
        [Some(self.slcan), self.socketcand, Some(self.control)]
            .into_iter()
            .flatten()
            .for_each(ports::wake);
        end
    }
}
