//! Bus: typed, isolated shared-memory services between the processes of one robot.
//!
//! ```text
//!  BusName ─▶ Folder (private) ─▶ Location (random prefix in /dev/shm)
//!               │                   └─▶ Bus (one node per thread)
//!               │                        ├─ publisher / subscriber    streams, newest wins
//!               │                        ├─ goal_server / goal_client one request, many updates
//!               │                        └─ control_server / _client  one request, one reply
//!               └─▶ stop: a separate socket, independent of all this
//! ```
//!
//! **In:** a bus name (`--bus`, `ATAS_BUS`), a role, and whether the thread is real-time. **Out:**
//! ports for the payloads of [`shm_schemas`]; errors that name cause and remedy.
//!
//! Invariants:
//! * No other crate uses iceoryx2. The settings of every service come from its row in [`STREAMS`].
//! * Two buses share neither files nor shared-memory names (`tests/isolation.rs`).
//! * All files belong to one user. Other users cannot attach, cannot plant files that the bus would
//!   use, and cannot open a file while it is being created (`folder.rs`, `location.rs`, `node.rs`).
//! * [`Bus::join`] creates nothing if the bus does not exist.
//! * A process of another ABI does not join; the error names both versions (`version.rs`,
//!   `tests/versions.rs`).
//! * A stop request reaches the daemon in every state of the bus ([`stop`], `tests/stop.rs`).
//! * Set-up happens under the bus's start-up lock. An unfinished file found under the lock was left
//!   by a killed process and is removed (`leftovers.rs`, `tests/crash.rs`).
//! * The clean-up after dead processes can itself be killed at any moment (`clean.rs`).
//! * A lack of memory, descriptors, inodes or stack gives an error, not a signal
//!   (`tests/shortage.rs`).
//! * Sending and receiving never wait for a peer. A full buffer loses its oldest content.
//! * Ports are not `Send`. Each thread opens its own [`Bus`].
//!
//! Cost: [`Publisher::send`] allocates once (48 bytes, inside iceoryx2 0.10), receiving never
//! (`tests/allocation.rs`). Neither makes a system call while the set of peers is constant
//! (measured with strace).
//!
//! Not used: wake-ups (readers poll on their own clock), iceoryx2's blackboard (a restarted writer
//! cannot take it over) and its `dev_permissions` (they would open the bus to every user).
//!
//! ```
//! use shm_bus::{Bus, FreshBus, Realtime};
//! use shm_schemas::{JointState, service};
//!
//! let name = FreshBus::new("docs");
//! let bus = Bus::open(&name, "robot", Realtime::No)?;
//! let mut reader = bus.subscriber::<JointState>(service::JOINT_STATE)?;
//! let robot = bus.publisher::<JointState>(service::JOINT_STATE)?;
//! robot.send(&JointState { joint_count: 22, ..JointState::default() })?;
//!
//! let mut state = JointState::default();
//! assert!(reader.newest(&mut state)?);
//! assert_eq!(state.joint_count, 22);
//! # Ok::<(), shm_bus::BusError>(())
//! ```
#![forbid(unsafe_code)]

mod bus;
mod clean;
mod client;
mod clock;
mod control;
mod end;
mod error;
mod exchange;
mod folder;
mod fresh;
mod goal;
mod leftovers;
mod location;
mod lock;
mod log;
mod member;
mod name;
mod node;
mod opaque;
mod owner;
mod owner_lock;
mod payload;
mod peer;
mod port_count;
mod presence;
mod publisher;
mod qos;
mod refusal;
mod server;
mod shortage;
mod startup;
pub mod stop;
mod stream;
mod subscriber;
mod user;
mod version;

pub use bus::Bus;
pub use clock::{now_ns, writer_epoch};
pub use control::{ControlCall, ControlClient, ControlServer};
pub use end::End;
pub use error::{BusError, HiddenFolders};
pub use exchange::Exchange;
pub use fresh::FreshBus;
pub use goal::{ActiveGoal, GoalClient, GoalServer, PendingGoal};
pub use name::BusName;
pub use node::Realtime;
pub use owner::Owner;
pub use owner_lock::OwnerLock;
pub use payload::StreamPayload;
pub use peer::Peer;
pub use port_count::PortCount;
pub use publisher::Publisher;
pub use qos::{BORROWED_MAX, STREAMS, Stream};
pub use subscriber::Subscriber;
pub use version::{Abi, long_version};

/// All request-response services.
pub const EXCHANGES: [Exchange; 2] = [goal::EXCHANGE, control::EXCHANGE];

/// Tests of the programs in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
