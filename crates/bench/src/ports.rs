//! The TCP ports: threads that carry bytes between clients and the run, and know nothing else.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::thread;

use crate::run::{CHUNKS_MAX, ClientId, Event, Newcomer, Speaks, Stopper};

/// Clients of one port at the same time; one more is hung up at once.
pub const CLIENTS_MAX: usize = 64;

/// Most bytes of a client passed on at once.
const CHUNK_MAX: usize = 4096;

/// Gives clients their names.
#[derive(Clone, Debug, Default)]
pub struct Names(Arc<AtomicU64>);

impl Names {
    /// A name nobody has.
    #[must_use]
    pub fn next(&self) -> ClientId {
        ClientId(self.0.fetch_add(1, Ordering::Relaxed))
    }
}

/// A port that is bound, and accepts nobody yet.
#[derive(Debug)]
pub struct Port {
    listener: TcpListener,
    address: SocketAddr,
}

impl Port {
    /// Binds `address`.
    ///
    /// # Errors
    /// A sentence: most of the time another program has it.
    pub fn bind(address: SocketAddr, purpose: &str) -> Result<Self, String> {
        let busy = |error| format!("the {purpose} address {address} can not be used: {error}");
        let listener = TcpListener::bind(address).map_err(busy)?;
        let address = listener.local_addr().map_err(busy)?;
        Ok(Self { listener, address })
    }

    /// The address in use.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Accepts clients from now on, each of which speaks what `speaks` makes.
    pub fn serve(
        self,
        speaks: fn() -> Speaks,
        names: Names,
        events: SyncSender<Event>,
        stopper: Stopper,
    ) {
        thread::spawn(move || {
            let connected = Arc::new(AtomicUsize::new(0));
            for stream in self.listener.incoming() {
                if stopper.stopped() {
                    return;
                }
                let Ok(stream) = stream else { continue };
                if connected.load(Ordering::SeqCst) >= CLIENTS_MAX {
                    continue;
                }
                connected.fetch_add(1, Ordering::SeqCst);
                let (id, events, connected) = (names.next(), events.clone(), connected.clone());
                thread::spawn(move || {
                    attend(&stream, id, speaks(), &events);
                    connected.fetch_sub(1, Ordering::SeqCst);
                });
            }
        });
    }
}

/// Wakes the thread that accepts clients at `address`, so that it sees that the run is over.
pub fn wake(address: SocketAddr) {
    // Nobody listens any more when it fails, which is as good.
    drop(TcpStream::connect(address));
}

/// Carries bytes of one client until it or the run is gone.
fn attend(stream: &TcpStream, id: ClientId, speaks: Speaks, events: &SyncSender<Event>) {
    let (Ok(writing), Ok(connection)) = (stream.try_clone(), stream.try_clone()) else { return };
    // Every answer goes out at once; without it they only come later.
    let _ = stream.set_nodelay(true);
    let (out, chunks) = mpsc::sync_channel(CHUNKS_MAX);
    thread::spawn(move || write(&writing, &chunks));
    let newcomer = Newcomer { id, speaks, out, connection: Some(connection) };
    if events.send(Event::Joined(newcomer)).is_err() {
        return;
    }
    let mut reading = stream;
    let mut buffer = [0; CHUNK_MAX];
    while let Ok(len) = reading.read(&mut buffer)
        && let Some(bytes) = buffer.get(..len).filter(|bytes| !bytes.is_empty())
    {
        if events.send(Event::Said(id, bytes.to_vec())).is_err() {
            return;
        }
    }
    // When the run is over there is nobody to tell.
    let _ = events.send(Event::Left(id));
}

fn write(mut stream: &TcpStream, chunks: &Receiver<Vec<u8>>) {
    while let Ok(chunk) = chunks.recv() {
        if stream.write_all(&chunk).is_err() {
            break;
        }
    }
    // The client may have closed the connection already.
    let _ = stream.shutdown(Shutdown::Both);
}
