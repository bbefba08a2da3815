//! The thread that owns the engine.
//!
//! Everything the outside wants comes as an [`Event`] through one bounded queue and is dealt with
//! between two slices of virtual time, one event after the other. Nothing else touches the engine,
//! so a run depends on the order of the events alone.

use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError};

use units::{Duration, Instant};
use world::can::LogCursor;

use crate::args::Clock;
use crate::control::{self, Answer, Desk, Request};
use crate::glance::Glance;
use crate::lines::Line;
use crate::pace::Pace;
use crate::slcan::Channel;
use crate::socketcand;
use crate::stage::Stage;
use crate::state::StateDir;

/// Events that may wait; who wants to add one more waits too.
pub const EVENTS_MAX: usize = 1024;

/// Chunks that may wait for a client to read them. What comes then stays on the bus.
pub const CHUNKS_MAX: usize = 1024;

/// Bytes of answers kept for a client that does not read; one more and it is hung up.
pub const UNREAD_MAX: usize = 16 << 20;

/// Virtual time between two looks at the outside.
pub const SLICE: Duration = Duration::from_millis(1);

/// The same for a while after somebody said something: an answer is on its way, and whoever waits for
/// it is not to wait longer than the bus takes.
const LIVELY_SLICE: Duration = Duration::from_micros(50);

/// How long that while is.
const LIVELY_FOR: Duration = Duration::from_millis(5);

/// Events dealt with between two slices, so that a flood does not stop virtual time.
const EVENTS_PER_SLICE: usize = 256;

/// Virtual time between two looks at the flash contents.
const STATE_EVERY: Duration = Duration::from_millis(1_000);

/// A client, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientId(pub u64);

/// What the outside wants.
pub enum Event {
    /// A client has connected.
    Joined(Newcomer),
    /// A client sent bytes.
    Said(ClientId, Vec<u8>),
    /// A client is gone.
    Left(ClientId),
    /// Somebody at the terminal did something to a device.
    Do(usize, Request),
    /// Somebody wants to look at a device.
    Look(Look),
    /// The run is over.
    Stop,
}

/// A client that has connected.
pub struct Newcomer {
    /// Its name.
    pub id: ClientId,
    /// What it speaks.
    pub speaks: Speaks,
    /// Where bytes for it go.
    pub out: SyncSender<Vec<u8>>,
    /// Its connection, to hang up.
    pub connection: Option<TcpStream>,
}

/// A look at a device.
pub struct Look {
    /// Which.
    pub node: usize,
    /// Frames after this place are wanted.
    pub since: LogCursor,
    /// Where the answer goes; it must have room for it.
    pub answer: SyncSender<Glance>,
}

/// What a client speaks.
#[derive(Debug)]
pub enum Speaks {
    /// SLCAN, on this channel.
    Slcan(Channel),
    /// The socketcand protocol.
    Socketcand,
    /// The control port's JSON lines.
    Control,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum End {
    /// Somebody stopped it.
    Stopped,
    /// It could not go on, for the reason in this sentence.
    Failed(String),
}

enum Session {
    Slcan(Channel),
    Socketcand(socketcand::Session),
    Control(Desk),
}

struct Client {
    id: ClientId,
    session: Session,
    out: SyncSender<Vec<u8>>,
    unread: Vec<u8>,
    connection: Option<TcpStream>,
}

/// Stops a run from any thread.
#[derive(Clone)]
pub struct Stopper {
    stopped: Arc<AtomicBool>,
    events: SyncSender<Event>,
}

impl Stopper {
    /// Stops the run whose queue is `events`.
    #[must_use]
    pub fn new(events: SyncSender<Event>) -> Self {
        Self { stopped: Arc::new(AtomicBool::new(false)), events }
    }

    /// Ends the run at the next slice.
    pub fn stop(&self) {
        self.stopped.store(true, Ordering::SeqCst);
        // When the queue is full the run is busy and sees the flag without being woken.
        let _ = self.events.try_send(Event::Stop);
    }

    /// Whether the run is over or about to be.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stopped.load(Ordering::SeqCst)
    }
}

/// A run.
pub struct Run {
    stage: Stage,
    clock: Clock,
    stopper: Stopper,
    events: Receiver<Event>,
    clients: Vec<Client>,
    state: Option<StateDir>,
    state_due: Instant,
    factor: f64,
}

impl Run {
    /// A run that has not begun.
    #[must_use]
    pub fn new(
        stage: Stage,
        clock: Clock,
        state: Option<StateDir>,
        events: Receiver<Event>,
        stopper: Stopper,
    ) -> Self {
        let state_due = stage.engine.now() + STATE_EVERY;
        Self { stage, clock, stopper, events, clients: Vec::new(), state, state_due, factor: 1.0 }
    }

    /// Runs until stopped, or until the engine can not go on. With the clock standing a failed
    /// engine ends nothing: clients are still told why.
    pub fn go(mut self) -> End {
        match self.clock {
            Clock::Step => self.go_by_step(),
            Clock::Real => self.go_by_wall_clock(),
        }
        let failure = self.stage.failure().map(ToString::to_string);
        let engine = self.stage.engine.as_ref();
        let unsaved = self.state.as_mut().and_then(|state| state.save_all(engine).err());
        match failure.or(unsaved) {
            Some(sentence) => End::Failed(sentence),
            None => End::Stopped,
        }
    }

    fn go_by_step(&mut self) {
        while !self.stopper.stopped() {
            match self.events.recv() {
                Ok(event) => self.handle(event),
                Err(_) => return,
            }
            self.serve();
        }
    }

    fn go_by_wall_clock(&mut self) {
        let mut pace = Pace::new(wall_us(), self.stage.engine.now());
        let mut lively_until = self.stage.engine.now();
        while !self.stopper.stopped() && self.stage.failure().is_none() {
            for _ in 0..EVENTS_PER_SLICE {
                match self.events.try_recv() {
                    Ok(event) => {
                        self.handle(event);
                        lively_until = self.stage.engine.now() + LIVELY_FOR;
                    }
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => return,
                }
            }
            let now = self.stage.engine.now();
            let due = pace.due(wall_us(), now);
            self.factor = pace.factor();
            let slice = if now < lively_until { LIVELY_SLICE } else { SLICE };
            if due >= now + slice {
                self.slice(due.min(now + SLICE));
            } else {
                self.serve();
                let wait = slice.as_micros() - due.since(now).as_micros();
                match self.events.recv_timeout(std::time::Duration::from_micros(wait)) {
                    Ok(event) => {
                        self.handle(event);
                        lively_until = now + LIVELY_FOR;
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
        }
    }

    fn slice(&mut self, until: Instant) {
        // A failure stays in the stage; whoever let time pass asks for it there.
        let _ = self.stage.run_until(until);
        self.serve();
        if self.stage.engine.now() >= self.state_due {
            self.state_due = self.stage.engine.now() + STATE_EVERY;
            if let Some(state) = &mut self.state {
                // Tried again later, and at the end, where a failure is told.
                let _ = state.save_changed(self.stage.engine.as_ref());
            }
        }
    }

    fn handle(&mut self, event: Event) {
        match event {
            Event::Joined(newcomer) => self.welcome(newcomer),
            Event::Said(id, bytes) => self.hear(id, &bytes),
            Event::Left(id) => self.part(id),
            Event::Do(node, request) => {
                // What the terminal offers can not be refused, and it shows what came of it.
                let _ = control::perform(&mut self.stage, node, &request);
            }
            Event::Look(Look { node, since, answer }) => {
                // Whoever asked may be gone.
                let _ = answer.try_send(Glance::take(&self.stage, node, since, self.factor));
            }
            Event::Stop => {}
        }
    }

    fn welcome(&mut self, newcomer: Newcomer) {
        let Newcomer { id, speaks, out, connection } = newcomer;
        let (session, unread) = match speaks {
            Speaks::Slcan(channel) => (Session::Slcan(channel), Vec::new()),
            Speaks::Socketcand => {
                let session = socketcand::Session::default();
                (Session::Socketcand(session), socketcand::GREETING.to_vec())
            }
            Speaks::Control => (Session::Control(Desk::new(&self.stage)), Vec::new()),
        };
        self.clients.push(Client { id, session, out, unread, connection });
    }

    fn hear(&mut self, id: ClientId, bytes: &[u8]) {
        // Its place is taken while it is served: time may pass, and others be served, meanwhile.
        let Some(place) = self.clients.iter().position(|client| client.id == id) else { return };
        let mut client = self.clients.remove(place);
        match &mut client.session {
            Session::Slcan(channel) => {
                client.unread.extend(channel.handle(&mut self.stage.engine.bus(), bytes));
            }
            Session::Socketcand(session) => {
                client.unread.extend(session.handle(&mut self.stage.engine.bus(), bytes));
            }
            Session::Control(desk) => {
                for line in desk.lines.push(bytes) {
                    let asked = match line {
                        Line::Whole(line) => control::parse(&line),
                        Line::TooLong => control::unreadable(&format!(
                            "a line has at most {} bytes",
                            control::LINE_MAX
                        )),
                    };
                    let answer = self.answer(desk, &asked);
                    client.unread.extend(control::write(&asked.id, &answer).into_bytes());
                }
            }
        }
        self.clients.insert(place.min(self.clients.len()), client);
    }

    fn answer(&mut self, desk: &mut Desk, asked: &control::Asked) -> Answer {
        let request = asked.request.as_ref().map_err(Clone::clone)?;
        let nodes = self.stage.engine.node_count();
        if asked.node >= nodes {
            return Err(format!("there is no node {}: there are {nodes}, from 0", asked.node));
        }
        if let Request::Advance(span) = request {
            self.advance(*span)
        } else {
            desk.perform(&mut self.stage, asked.node, request)
        }
    }

    fn advance(&mut self, span: Duration) -> Answer {
        match self.clock {
            Clock::Real => return Err("the wall clock advances this bench".to_owned()),
            Clock::Step => {}
        }
        let until = self.stage.engine.now() + span;
        while self.stage.engine.now() < until && !self.stopper.stopped() {
            self.slice((self.stage.engine.now() + SLICE).min(until));
            if let Some(failure) = self.stage.failure() {
                return Err(failure.to_string());
            }
        }
        Ok(vec![("us", self.stage.engine.now().as_micros().into())])
    }

    /// Hands over what the bus has for the clients, and hangs up on those that do not read.
    fn serve(&mut self) {
        let mut bus = self.stage.engine.bus();
        let mut deaf = Vec::new();
        for client in &mut self.clients {
            client.poll(&mut bus);
            if !client.flush() {
                client.hang_up();
                deaf.push(client.id);
            }
        }
        drop(bus);
        for id in deaf {
            self.part(id);
        }
    }

    fn part(&mut self, id: ClientId) {
        let Some(place) = self.clients.iter().position(|client| client.id == id) else { return };
        let mut client = self.clients.remove(place);
        // The last answers still go out: a client may have closed only its own direction.
        client.flush();
        let bus = &mut self.stage.engine.bus();
        match client.session {
            Session::Slcan(mut channel) => channel.leave(bus),
            Session::Socketcand(mut session) => session.leave(bus),
            Session::Control(desk) => desk.leave(bus),
        }
    }
}

impl Client {
    /// Fetches what the bus has, unless the client has not read the last of it.
    fn poll(&mut self, bus: &mut world::can::Bus) {
        match &mut self.session {
            Session::Control(desk) => desk.poll(bus),
            Session::Slcan(channel) if self.unread.is_empty() => self.unread = channel.poll(bus),
            Session::Socketcand(session) if self.unread.is_empty() => {
                self.unread = session.poll(bus);
            }
            Session::Slcan(_) | Session::Socketcand(_) => {}
        }
    }

    fn hang_up(&self) {
        if let Some(connection) = &self.connection {
            // It may be closed from the other end already.
            let _ = connection.shutdown(Shutdown::Both);
        }
    }

    /// Passes on what is unread. False when the client is beyond hope.
    fn flush(&mut self) -> bool {
        if self.unread.is_empty() {
            return true;
        }
        match self.out.try_send(std::mem::take(&mut self.unread)) {
            Ok(()) => true,
            Err(TrySendError::Full(unread)) => {
                self.unread = unread;
                self.unread.len() <= UNREAD_MAX
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

/// The wall clock, in microseconds from the first call.
fn wall_us() -> u64 {
    static START: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    #[expect(clippy::disallowed_methods, reason = "the real clock: virtual time follows it")]
    let now = std::time::Instant::now();
    u64::try_from(now.duration_since(*START.get_or_init(|| now)).as_micros()).unwrap_or(u64::MAX)
}
