//! One thread's place on a bus.

use std::fmt;
use std::path::PathBuf;
use std::sync::Once;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::NodeView;
use iceoryx2::prelude::{
    CallbackProgression, Config, LogLevel, MessagingPattern, Node, NodeBuilder, NodeName,
    NodeState, SignalHandlingMode, ipc, set_log_level,
};

use crate::lock::StartupLock;
use crate::owner::OwnerLock;
use crate::recover;
use crate::root::{Place, SHM};
use crate::{BusError, BusName};

/// iceoryx2's variant: shared memory between processes, without a mutex around every port.
pub(crate) type Ipc = ipc::Service;

/// How long a transient refusal may last before its cause counts as left behind by a killed process. Ours.
const TRANSIENT: Duration = Duration::from_millis(50);
/// How long non-real-time nodes wait for a peer that is being set up. Real-time nodes do not wait.
const PEER_WAIT: Duration = Duration::from_millis(100);
/// Free room in `/dev/shm` beyond the payloads: connections, service descriptions, growth of others. Ours.
const RESERVE_BYTES: u64 = 4 << 20;

/// Whether a thread has a deadline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// It has: sending and receiving never wait for a peer that is being set up, and never log.
    Yes,
    /// It has not.
    No,
}

/// Someone on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// The role it opened the bus with; empty if unknown.
    pub role: String,
    /// Its process id; 0 if unknown.
    pub pid: u32,
    /// False once it died and until someone [cleans up](Bus::clean_dead).
    pub alive: bool,
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (process {})", self.role, self.pid)
    }
}

/// One thread's place on a bus: opens ports, sees peers, cleans up after the dead.
///
/// Ports that were opened from it outlive it.
#[derive(Debug)]
pub struct Bus {
    pub(crate) place: Place,
    pub(crate) realtime: Realtime,
    pub(crate) node: Node<Ipc>,
    role: String,
}

impl Bus {
    /// Joins a bus, and makes it if this is the first process on it.
    ///
    /// `role` is what others see, for example `atasd` or `sensor-left`.
    ///
    /// # Errors
    /// When the bus's folder is not private, `/dev/shm` is full, another process hangs in its start-up, or iceoryx2
    /// refuses.
    pub fn open(name: &BusName, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        quiet();
        let place = Place::of(name)?;
        let mut config = place.config()?;
        config.global.creation_timeout = if realtime == Realtime::Yes {
            Duration::ZERO
        } else {
            PEER_WAIT
        };
        // Cleaning costs up to 21 ms per dead node: at start-up and in `clean_dead`, not whenever something is opened
        // or dropped.
        config.global.service.cleanup_dead_nodes_on_open = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        let _startup = StartupLock::take(&place, role)?;
        clear_if_deserted(&place, &config)?;
        require_space("the bus", 0)?;
        let node = create_node(&place, &config, role)?;
        Ok(Self {
            place,
            realtime,
            node,
            role: role.to_owned(),
        })
    }

    /// The bus's name.
    #[must_use]
    pub fn name(&self) -> &BusName {
        &self.place.bus
    }

    /// The bus's folder: `/run/atas/<bus>` as a service, else below `$XDG_RUNTIME_DIR` or `/tmp`.
    #[must_use]
    pub fn folder(&self) -> &std::path::Path {
        &self.place.root
    }

    /// Removes what dead processes left; returns how many were removed.
    ///
    /// Until someone does this, a killed peer keeps its place. Costs up to 21 ms per dead process: for supervisor
    /// threads, every 250 ms or so. Does nothing while another process starts up.
    pub fn clean_dead(&self) -> usize {
        match StartupLock::try_take(&self.place, &self.role) {
            Ok(Some(_startup)) => self.node.try_cleanup_dead_nodes().cleanups as usize,
            Ok(None) | Err(_) => 0,
        }
    }

    /// Everyone on the bus, this thread included. Reads files: not for real-time threads.
    ///
    /// # Errors
    /// [`BusError::Open`] if the folder of the bus cannot be read.
    pub fn peers(&self) -> Result<Vec<Peer>, BusError> {
        peers(&self.place, self.node.config())
    }

    /// Removes everything of a bus: its folder and its shared memory. Returns how many entries that were.
    ///
    /// # Errors
    /// [`BusError::Owned`] or [`BusError::InUse`] while anyone is on the bus.
    pub fn wipe(name: &BusName) -> Result<usize, BusError> {
        let place = Place::of(name)?;
        let _owner = OwnerLock::take_at(&place, "wipe")?;
        let _startup = StartupLock::take(&place, "wipe")?;
        let mut alive = peers(&place, &place.config()?)?;
        alive.retain(|peer| peer.alive);
        if !alive.is_empty() {
            let peers: Vec<String> = alive.iter().map(Peer::to_string).collect();
            return Err(BusError::InUse {
                bus: name.to_string(),
                peers: peers.join(", "),
            });
        }
        let removed = recover::clear(&place);
        std::fs::remove_dir_all(&place.root).map_err(BusError::io("remove", &place.root))?;
        Ok(removed)
    }

    /// Sets something up, one process at a time.
    pub(crate) fn startup(&self) -> Result<StartupLock, BusError> {
        StartupLock::take(&self.place, &self.role)
    }

    /// The error for a place that one process has and only one may have.
    pub(crate) fn taken_by(&self, service: &'static str, node: Option<UniqueNodeId>) -> BusError {
        let state =
            node.and_then(|id| Node::<Ipc>::state_of(self.node.config(), id).ok().flatten());
        let peer = state.map(|state| peer_of(&state));
        let (role, pid) = peer.map_or(("another process".to_owned(), 0), |peer| {
            (peer.role, peer.pid)
        });
        BusError::Taken { service, role, pid }
    }

    /// Opens a service under the start-up lock, in spite of what killed processes left.
    ///
    /// A refusal that is transient by its nature is retried for [`TRANSIENT`]; if it persists, a killed process left
    /// the service half-made or half-removed. Nobody can be using it then, so its description is removed, once.
    pub(crate) fn persist<T, E: Refusal>(
        &self,
        service: &'static str,
        pattern: MessagingPattern,
        open: impl Fn() -> Result<T, E>,
    ) -> Result<T, BusError> {
        let (mut begin, mut recovered) = (Instant::now(), false);
        loop {
            let refusal = match open() {
                Ok(service) => return Ok(service),
                Err(refusal) => refusal,
            };
            if refusal.is_crowded() && !recovered {
                self.node.try_cleanup_dead_nodes();
                recovered = true;
            } else if refusal.is_transient() && begin.elapsed() < TRANSIENT {
                std::thread::sleep(Duration::from_millis(1));
            } else if refusal.is_transient() && !recovered {
                tracing::warn!(bus = %self.place.bus, service, ?refusal, "removing a service that a killed process left half-made");
                recover::forget_service(&self.place, service, pattern);
                (begin, recovered) = (Instant::now(), true);
            } else {
                let (root, why) = (self.place.root.clone(), format!("{refusal:?}"));
                return Err(BusError::Open {
                    what: service,
                    root,
                    why,
                });
            }
        }
    }
}

/// How iceoryx2's refusals are told apart.
pub(crate) trait Refusal: fmt::Debug {
    /// It may pass when others finish what they are doing.
    fn is_transient(&self) -> bool;
    /// Too many nodes, some of them perhaps dead.
    fn is_crowded(&self) -> bool;
}

/// iceoryx2 logs through `tracing`; below warnings it is silent, so that nothing is formatted on a tick.
fn quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| set_log_level(LogLevel::Warn));
}

fn clear_if_deserted(place: &Place, config: &Config) -> Result<(), BusError> {
    if peers(place, config)?.iter().any(|peer| peer.alive) {
        return Ok(());
    }
    let removed = recover::clear(place);
    if removed > 0 {
        tracing::info!(bus = %place.bus, removed, "nobody was on the bus; removed what former processes left");
    }
    Ok(())
}

fn create_node(place: &Place, config: &Config, role: &str) -> Result<Node<Ipc>, BusError> {
    let refused = |why: String| BusError::Open {
        what: "the bus",
        root: place.root.clone(),
        why,
    };
    let name = NodeName::new(role).map_err(|e| refused(format!("the role {role:?}: {e:?}")))?;
    let builder = NodeBuilder::new()
        .name(&name)
        .config(config)
        .signal_handling_mode(SignalHandlingMode::Disabled);
    builder
        .create::<Ipc>()
        .map_err(|e| refused(format!("{e:?}")))
}

fn peers(place: &Place, config: &Config) -> Result<Vec<Peer>, BusError> {
    let mut peers = Vec::new();
    Node::<Ipc>::list(config, |state| {
        peers.push(peer_of(&state));
        CallbackProgression::Continue
    })
    .map_err(|e| BusError::Open {
        what: "the list of peers",
        root: place.root.clone(),
        why: format!("{e:?}"),
    })?;
    Ok(peers)
}

fn peer_of(state: &NodeState<Ipc>) -> Peer {
    let (details, alive) = match state {
        NodeState::Alive(view) => (view.details().as_ref(), true),
        NodeState::Dead(view) => (view.details().as_ref(), false),
        // Cannot be examined, so it may be alive.
        NodeState::Inaccessible(_) => (None, true),
        NodeState::Undefined(_) => (None, false),
    };
    let role = details
        .map(|d| d.name().as_str().to_owned())
        .unwrap_or_default();
    let pid = details.map_or(0, |d| d.process_id().value() as u32);
    Peer { role, pid, alive }
}

/// Refuses when `/dev/shm` has no room for so many bytes and the reserve.
pub(crate) fn require_space(what: &'static str, bytes: usize) -> Result<(), BusError> {
    let needed = bytes as u64 + RESERVE_BYTES;
    let shm = PathBuf::from(SHM);
    let stat = rustix::fs::statvfs(&shm).map_err(|e| BusError::io("examine", &shm)(e.into()))?;
    let free = stat.f_bavail.saturating_mul(stat.f_frsize);
    if free >= needed {
        return Ok(());
    }
    Err(BusError::NoSpace {
        what,
        free_kib: free / 1024,
        needed_kib: needed.div_ceil(1024),
    })
}
