//! Limits of connections: a bounded number before the handshake, and places for known clients.

use std::io;
use std::net::{IpAddr, Shutdown, SocketAddr, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Connections before their handshake. Design choice: a handshake takes milliseconds to one second.
const WAITING: usize = 32;
/// Commands of one client at the same time. Design choice: the same as at the gate for local users.
pub(crate) const PER_CLIENT: usize = 6;
/// Additional places, only for stops.
const STOPS: usize = 8;

/// Counters of the connections.
pub(crate) struct Admission {
    places: usize,
    state: Arc<Mutex<State>>,
}

#[derive(Default)]
struct State {
    next: u64,
    /// The oldest first.
    waiting: Vec<Waiting>,
    /// Names of the clients in a place.
    served: Vec<String>,
    stops: usize,
}

struct Waiting {
    number: u64,
    address: IpAddr,
    socket: TcpStream,
}

/// Connection before its handshake; leaves the list on drop.
pub(crate) struct Entry {
    number: u64,
    state: Arc<Mutex<State>>,
}

/// Place of a known client; becomes free on drop.
pub(crate) struct Place {
    name: Option<String>,
    state: Arc<Mutex<State>>,
}

impl Admission {
    pub(crate) fn new(places: usize) -> Self {
        Self {
            places,
            state: Arc::default(),
        }
    }

    /// Adds a connection. If the list is full, the oldest connection of the address with the most
    /// connections is closed: it is slower than a handshake takes.
    pub(crate) fn enter(&self, socket: &TcpStream, peer: SocketAddr) -> io::Result<Entry> {
        let socket = socket.try_clone()?;
        let mut state = lock(&self.state);
        if state.waiting.len() >= WAITING {
            let index = most_frequent(&state.waiting);
            let displaced = state.waiting.remove(index);
            // Its thread notices the closed socket and ends.
            let _ = displaced.socket.shutdown(Shutdown::Both);
            let address = displaced.address;
            tracing::warn!("closed a connection of {address}: {WAITING} wait for their handshake");
        }
        let number = state.next;
        state.next += 1;
        state.waiting.push(Waiting {
            number,
            address: peer.ip(),
            socket,
        });
        drop(state);
        Ok(Entry {
            number,
            state: Arc::clone(&self.state),
        })
    }

    /// Takes a place for a client; `None` if all are in use.
    pub(crate) fn place(&self, name: &str) -> Option<Place> {
        let mut state = lock(&self.state);
        let own = state.served.iter().filter(|served| *served == name).count();
        if own >= PER_CLIENT || state.served.len() >= self.places {
            return None;
        }
        state.served.push(name.to_owned());
        Some(self.taken(Some(name.to_owned())))
    }

    /// Takes one of the places for stops.
    pub(crate) fn stop_place(&self) -> Option<Place> {
        let mut state = lock(&self.state);
        if state.stops >= STOPS {
            return None;
        }
        state.stops += 1;
        Some(self.taken(None))
    }

    fn taken(&self, name: Option<String>) -> Place {
        Place {
            name,
            state: Arc::clone(&self.state),
        }
    }
}

impl Drop for Entry {
    fn drop(&mut self) {
        let mut state = lock(&self.state);
        state
            .waiting
            .retain(|waiting| waiting.number != self.number);
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut state = lock(&self.state);
        let Some(name) = &self.name else {
            state.stops = state.stops.saturating_sub(1);
            return;
        };
        if let Some(index) = state.served.iter().position(|served| served == name) {
            state.served.swap_remove(index);
        }
    }
}

fn lock(state: &Mutex<State>) -> MutexGuard<'_, State> {
    // No code panics while it holds the lock.
    state.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns the index of the oldest connection of the address with the most connections.
fn most_frequent(waiting: &[Waiting]) -> usize {
    let count = |address: IpAddr| waiting.iter().filter(|w| w.address == address).count();
    let most = waiting.iter().map(|w| count(w.address)).max();
    let oldest = waiting.iter().position(|w| Some(count(w.address)) == most);
    oldest.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    #[test]
    fn places_are_limited_per_client_and_in_total() {
        let admission = Admission::new(8);
        let mut alice: Vec<Place> = (0..PER_CLIENT)
            .map(|_| admission.place("alice").expect("free"))
            .collect();
        assert!(admission.place("alice").is_none());
        let bob: Vec<Place> = (0..2)
            .map(|_| admission.place("bob").expect("free"))
            .collect();
        assert!(admission.place("bob").is_none());
        let stops: Vec<Place> = (0..STOPS)
            .map(|_| admission.stop_place().expect("free"))
            .collect();
        assert!(admission.stop_place().is_none());
        drop((alice.pop(), stops, bob));
        assert!(admission.place("alice").is_some());
        assert!(admission.stop_place().is_some());
    }

    #[test]
    fn silent_connections_are_displaced_by_newer_ones() {
        let admission = Admission::new(1);
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let from = |ip: [u8; 4]| SocketAddr::from((ip, 1));
        let connect = || TcpStream::connect(address).expect("connected");
        let quiet = connect();
        let entry = admission
            .enter(&quiet, from([192, 0, 2, 1]))
            .expect("entered");
        let flood: Vec<(TcpStream, Entry)> = (0..3 * WAITING)
            .map(|_| {
                let socket = connect();
                let entry = admission
                    .enter(&socket, from([192, 0, 2, 2]))
                    .expect("entered");
                (socket, entry)
            })
            .collect();
        let waiting = || {
            lock(&admission.state)
                .waiting
                .iter()
                .map(|w| w.number)
                .collect::<Vec<_>>()
        };
        assert_eq!(waiting().len(), WAITING);
        assert!(
            waiting().contains(&entry.number),
            "the other address keeps its place"
        );
        drop((flood, entry));
        assert!(waiting().is_empty());
    }
}
