//! One thread's place on a bus.

use std::fmt;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Once;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::{
    Config, LogLevel, MessagingPattern, Node, NodeBuilder, NodeName, SignalHandlingMode, ipc,
    set_log_level,
};

use crate::lock::StartupLock;
use crate::owner::OwnerLock;
use crate::root::{Place, SHM};
use crate::{BusError, BusName, Peer, clean, recover};

/// iceoryx2's variant: shared memory between processes, without a mutex around every port.
pub(crate) type Ipc = ipc::Service;

/// How long a transient refusal may last before its cause counts as left behind by a killed process. Ours.
const TRANSIENT: Duration = Duration::from_millis(50);
/// How long non-real-time nodes wait for a peer that is being set up. Real-time nodes do not wait. Ours.
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

/// One thread's place on a bus: opens ports, sees peers, cleans up after the dead.
///
/// Ports that were opened from it outlive it. Like its ports it stays in its thread:
///
/// ```compile_fail,E0277
/// let bus = shm_bus::Bus::open(&shm_bus::BusName::fresh("doc"), "doc", shm_bus::Realtime::No).unwrap();
/// std::thread::spawn(move || bus.clean_dead());
/// ```
#[derive(Debug)]
pub struct Bus {
    pub(crate) member: Rc<Member>,
}

/// What a bus and its clients share.
#[derive(Debug)]
pub(crate) struct Member {
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
        require_space("the bus", 0)?;
        let place = Place::of(name)?;
        let config = config(&place, realtime)?;
        let _startup = StartupLock::take(&place, role)?;
        place.check_shared_memory()?;
        clear_if_deserted(&place, &config)?;
        let node = create_node(&place, &config, role)?;
        place.close_shared_memory()?;
        clean::remove_dead(&place, &node);
        Ok(Self {
            member: Rc::new(Member {
                place,
                realtime,
                node,
                role: role.to_owned(),
            }),
        })
    }

    /// The bus's name.
    #[must_use]
    pub fn name(&self) -> &BusName {
        &self.member.place.bus
    }

    /// The bus's folder: `/run/atas/<bus>` as a service, else below `$XDG_RUNTIME_DIR` or in `/dev/shm`. For peers in other
    /// languages: it is iceoryx2's `global.root-path`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.member.place.root
    }

    /// What the bus's names in `/dev/shm` begin with. For peers in other languages: it is iceoryx2's `global.prefix`.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.member.place.prefix
    }

    /// Removes what dead processes left; returns how many were removed.
    ///
    /// Until someone does this, a killed peer keeps its place. Costs up to 21 ms per dead process: for supervisor
    /// threads, every 250 ms or so. Does nothing while another process starts up.
    pub fn clean_dead(&self) -> usize {
        self.member.clean_dead()
    }

    /// Everyone on the bus, this thread included. Reads files: not for real-time threads.
    ///
    /// # Errors
    /// [`BusError::Open`] if the folder of the bus cannot be read.
    pub fn peers(&self) -> Result<Vec<Peer>, BusError> {
        Peer::list(&self.member.place, self.member.node.config())
    }

    /// Removes everything of a bus: its folder and its shared memory. Returns how many entries that were.
    ///
    /// # Errors
    /// [`BusError::Owned`] or [`BusError::InUse`] while anyone is on the bus.
    pub fn wipe(name: &BusName) -> Result<usize, BusError> {
        let place = Place::of(name)?;
        let _owner = OwnerLock::take_at(&place, "wipe")?;
        let _startup = StartupLock::take(&place, "wipe")?;
        place.check_shared_memory()?;
        let mut alive = Peer::list(&place, &place.config()?)?;
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
}

impl Member {
    pub(crate) fn clean_dead(&self) -> usize {
        match StartupLock::try_take(&self.place, &self.role) {
            Ok(Some(_startup)) => clean::remove_dead(&self.place, &self.node),
            Ok(None) | Err(_) => 0,
        }
    }

    /// For setting something up, one process at a time.
    pub(crate) fn startup(&self) -> Result<StartupLock, BusError> {
        StartupLock::take(&self.place, &self.role)
    }

    pub(crate) fn refused(&self, what: &'static str, why: &impl fmt::Debug) -> BusError {
        BusError::Open {
            what,
            root: self.place.root.clone(),
            why: format!("{why:?}"),
        }
    }

    /// The error for a place that only one may have, and that this node has.
    pub(crate) fn taken_by(&self, service: &'static str, node: Option<UniqueNodeId>) -> BusError {
        let peer = node.and_then(|id| Peer::find(self.node.config(), id));
        let (role, pid) = peer.map_or(("another process".to_owned(), 0), |peer| {
            (peer.role, peer.pid)
        });
        BusError::Taken { service, role, pid }
    }

    /// Opens something under the start-up lock, in spite of what killed processes left.
    ///
    /// Places may belong to the dead: clean up, once. A refusal that is transient by its nature is retried for
    /// [`TRANSIENT`]; if it persists, a killed process left the service half-made or half-removed, and nobody can be
    /// using it: its description is removed, once.
    pub(crate) fn persist<T, E: Refusal>(
        &self,
        service: &'static str,
        pattern: MessagingPattern,
        open: impl Fn() -> Result<T, E>,
    ) -> Result<T, E> {
        let (mut begin, mut cleaned, mut forgotten) = (Instant::now(), false, false);
        loop {
            let refusal = match open() {
                Ok(opened) => return Ok(opened),
                Err(refusal) => refusal,
            };
            match refusal.cause() {
                Cause::NoPlace if !cleaned => {
                    clean::remove_dead(&self.place, &self.node);
                    cleaned = true;
                }
                Cause::Transient if begin.elapsed() < TRANSIENT => {
                    std::thread::sleep(Duration::from_millis(1))
                }
                Cause::Transient if !forgotten => {
                    tracing::warn!(bus = %self.place.bus, service, ?refusal, "removing a half-made service");
                    recover::forget_service(&self.place, service, pattern);
                    (begin, forgotten) = (Instant::now(), true);
                }
                _ => return Err(refusal),
            }
        }
    }
}

/// What lies behind a refusal of iceoryx2.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cause {
    /// It may pass when others finish what they are doing.
    Transient,
    /// All places are taken, some of them perhaps by the dead.
    NoPlace,
    /// It will not pass.
    Permanent,
}

/// An error of iceoryx2.
pub(crate) trait Refusal: fmt::Debug {
    fn cause(&self) -> Cause;
}

/// iceoryx2 logs through `tracing`; below warnings it is silent, so that nothing is formatted on a tick.
fn quiet() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| set_log_level(LogLevel::Warn));
}

fn config(place: &Place, realtime: Realtime) -> Result<Config, BusError> {
    let mut config = place.config()?;
    config.global.creation_timeout = if realtime == Realtime::Yes {
        Duration::ZERO
    } else {
        PEER_WAIT
    };
    // Cleaning up costs up to 21 ms per dead node and must survive being killed: only `clean` does it.
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    Ok(config)
}

fn clear_if_deserted(place: &Place, config: &Config) -> Result<(), BusError> {
    if Peer::list(place, config)?.iter().any(|peer| peer.alive) {
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
