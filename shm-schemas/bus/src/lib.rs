//! The bus: typed, isolated shared-memory services between the processes of one robot.
//!
//! ```text
//!  BusName ─▶ Folder (private) ─▶ Place (random prefix in /dev/shm) ─▶ Bus (one node per thread)
//!                │                                                      ├─ publisher / subscriber    streams, newest wins
//!                │                                                      ├─ goal_server / goal_client one request, many updates
//!                │                                                      └─ control_server / _client  one request, one reply
//!                └─▶ stop: a socket of its own, beside all this
//! ```
//!
//! * **In:** a bus name (`--bus`, `ATAS_BUS`), a role, and whether the thread is real-time.
//!   **Out:** ports over the payloads of [`shm_schemas`], and errors that say what to do.
//! * **Invariants**
//!   * No other crate names iceoryx2. Every service is opened with the one line that [`STREAMS`] has for it.
//!   * Two buses share nothing: neither files nor shared-memory names (`tests/isolation.rs`).
//!   * Everything belongs to one user. Other users can neither attach, nor prepare a trap, nor open anything in the moment
//!     in which it is made (`folder.rs`, `place.rs`, `node.rs`, `tests/isolation.rs`).
//!   * Who only looks makes nothing: [`Bus::join`].
//!   * A stop gets through, whatever the bus is in ([`stop`], `tests/stop.rs`).
//!   * Whoever sets something up holds the bus's start-up lock, so what looks half-made under that lock was left by
//!     a killed process, and is removed (`remains.rs`, `tests/crash.rs`).
//!   * Cleaning up after the dead may itself be killed at any moment (`clean.rs`, `tests/crash.rs`).
//!   * What is short (memory, descriptors, inodes, stack) is refused by name, not met by a signal (`tests/shortage.rs`).
//!   * Sending and receiving never wait for a peer. A full buffer loses its oldest content.
//! * **Threads:** ports are not `Send`. Each thread opens its own [`Bus`]; the compiler holds it to that.
//! * **Cost:** [`Publisher::send`] allocates once (48 bytes, inside iceoryx2 0.10), receiving never
//!   (`tests/allocation.rs`). Neither makes a system call while the set of peers stays the same (measured, strace).
//! * **Absent on purpose:** wake-ups (readers poll on their own clock), iceoryx2's blackboard (a restarted writer
//!   cannot take it over) and its `dev_permissions` (they would open the bus to every user).
#![forbid(unsafe_code)]

mod bus;
mod clean;
mod client;
mod clock;
mod control;
mod error;
mod exchange;
mod folder;
mod fresh;
mod goal;
mod lock;
mod log;
mod member;
mod name;
mod node;
mod owner;
mod peer;
mod place;
mod publisher;
mod qos;
mod refusal;
mod remains;
mod server;
mod shortage;
mod startup;
pub mod stop;
mod stream;
mod subscriber;
mod traffic;
mod user;

pub use bus::Bus;
pub use clock::{now_ns, writer_epoch};
pub use control::{ControlCall, ControlClient, ControlServer};
pub use error::{BusError, Unseen};
pub use exchange::Exchange;
pub use fresh::FreshBus;
pub use goal::{ActiveGoal, GoalClient, GoalServer, PendingGoal};
pub use name::BusName;
pub use node::Realtime;
pub use owner::{Owner, OwnerLock};
pub use peer::Peer;
pub use publisher::Publisher;
pub use qos::{BORROWED, STREAMS, Stream};
pub use subscriber::Subscriber;
pub use traffic::Traffic;

/// Every exchange.
pub const EXCHANGES: [Exchange; 2] = [goal::EXCHANGE, control::EXCHANGE];
