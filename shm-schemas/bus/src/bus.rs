//! Connection of one thread to a bus.

use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use crate::clean;
use crate::clock::now_ns;
use crate::error::BusError;
use crate::folder::Folder;
use crate::leftovers;
use crate::location::Location;
use crate::lock::{FileLock, OWNER_LOCK};
use crate::log;
use crate::member::{Departure, Member};
use crate::name::BusName;
use crate::node::{self, Realtime};
use crate::opaque::Opaque;
use crate::owner_lock::OwnerLock;
use crate::peer::Peer;
use crate::presence;
use crate::shortage::{self, require_space, require_stack};
use crate::startup::StartupLock;
use crate::version;

/// Longest time between taking the ownership of a bus and joining it. Design choice: a daemon needs
/// about 20 ms.
const START_MAX: Duration = Duration::from_secs(2);

/// Connection of one thread to a bus: opens ports, lists peers, removes dead ones.
///
/// Its ports stay valid after it is dropped. It cannot leave its thread:
///
/// ```compile_fail,E0277
/// use shm_bus::{Bus, BusName, Realtime};
/// let bus = Bus::open(&BusName::fresh("doc"), "doc", Realtime::No).unwrap();
/// std::thread::spawn(move || bus.clean_dead());
/// ```
#[derive(Debug)]
pub struct Bus {
    pub(crate) member: Rc<Member>,
}

impl Bus {
    /// Joins a bus, and creates it if no process is on it.
    ///
    /// `role` identifies the process to others, for example `atasd` or `sensor-left`.
    ///
    /// # Errors
    /// The bus's folder is not private, `/dev/shm` is full, another process blocks the start-up,
    /// iceoryx2 fails, or processes of another ABI use the bus ([`BusError::OtherVersion`]).
    pub fn open(name: &BusName, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        require_stack("the bus")?;
        let folder = Folder::for_bus(name)?;
        folder.make()?;
        Self::attach(&folder, role, realtime)
    }

    /// Joins an existing bus, for clients and observers. A mistyped name creates nothing.
    ///
    /// # Errors
    /// [`BusError::OtherUser`] if only another user has a bus of this name; [`BusError::Absent`] if
    /// no bus is found; else as [`Bus::open`].
    pub fn join(name: &BusName, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        require_stack("the bus")?;
        let folder = Folder::for_bus(name)?;
        folder.find()?;
        Self::attach(&folder, role, realtime)
    }

    /// Checks that this user has such a bus. Creates and joins nothing.
    ///
    /// # Errors
    /// As [`Bus::join`] if the bus is absent, belongs to another user, or has a folder that is not
    /// private.
    pub fn find(name: &BusName) -> Result<(), BusError> {
        Folder::for_bus(name)?.find()
    }

    /// Not inlined: uses its stack after [`require_stack`].
    #[inline(never)]
    fn attach(folder: &Folder, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        log::install();
        require_space("the bus", 0)?;
        let _startup = StartupLock::take(folder, role)?;
        let place = prepare_location(folder)?;
        let config = node::config(&place, realtime)?;
        let refused = |why| shortage::refusal_error(&place, "the bus", why);
        let node = node::create(&place, &config, role).map_err(refused)?;
        clean::remove_dead_for_new_handle(&place, &node);
        Ok(Self {
            member: Rc::new(Member {
                _departure: Departure::new(place.clone()),
                location: place,
                realtime,
                node: Opaque::new(node),
                role: role.to_owned(),
            }),
        })
    }

    /// The bus's name.
    #[must_use]
    pub fn name(&self) -> &BusName {
        self.member.location.bus()
    }

    /// The bus's folder: `/run/atas/<bus>` as a service, else below `$XDG_RUNTIME_DIR` or in
    /// `/dev/shm`. Peers in other languages use it as iceoryx2's `global.root-path`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.member.location.root()
    }

    /// Prefix of the bus's names in `/dev/shm`, random for each life of the bus. Peers in other
    /// languages read it from the file `prefix` of the folder and use it as iceoryx2's
    /// `global.prefix`.
    #[must_use]
    pub fn prefix(&self) -> &str {
        &self.member.location.prefix
    }

    /// Removes dead nodes and returns their number.
    ///
    /// A killed peer keeps its slots until then. Takes up to 21 ms per dead process: call it in
    /// supervisor threads, about every 250 ms. Does nothing while another process starts up.
    pub fn clean_dead(&self) -> usize {
        self.member.clean_dead()
    }

    /// All peers on the bus, this thread included. Reads files: not for real-time threads.
    pub fn peers(&self) -> Result<Vec<Peer>, BusError> {
        Peer::list(&self.member.location, self.member.node.config())
    }

    /// Removes the bus's folder and shared memory. Returns the number of removed entries.
    ///
    /// # Errors
    /// [`BusError::Owned`] or [`BusError::InUse`] while a process is on the bus.
    pub fn wipe(name: &BusName) -> Result<usize, BusError> {
        let folder = Folder::for_bus(name)?;
        match folder.find() {
            Err(BusError::Absent { .. } | BusError::OtherUser { .. }) => return Ok(0),
            found => found?,
        }
        let _owner = OwnerLock::lock(&folder, "wipe")?;
        let _startup = StartupLock::take(&folder, "wipe")?;
        let removed = match Location::read(&folder)? {
            None => 0,
            Some(place) => {
                let mut alive = Peer::list(&place, &place.config()?)?;
                alive.retain(|peer| peer.alive);
                if !alive.is_empty() {
                    let peers: Vec<String> = alive.iter().map(Peer::to_string).collect();
                    return Err(BusError::InUse {
                        bus: name.to_string(),
                        peers: peers.join(", "),
                    });
                }
                leftovers::remove_all(&place)
            }
        };
        std::fs::remove_dir_all(&folder.path).map_err(BusError::io("remove", &folder.path))?;
        Ok(removed)
    }
}

/// The location of a bus in use, or a new one after removing leftovers. Call under the start-up
/// lock.
fn prepare_location(folder: &Folder) -> Result<Location, BusError> {
    let Some(place) = Location::read(folder)? else {
        return create_location(folder);
    };
    let other = version::other_version(folder)?;
    leftovers::remove_unfinished(&place);
    let config = place.config()?;
    let Some(creator) = other else {
        let is_used = presence::is_present(&place.prefix) || Peer::is_any_alive(&place, &config)?;
        return match is_used {
            false => renew(folder, &place),
            true => Ok(place),
        };
    };
    let mut peers = Peer::list(&place, &config)?;
    peers.retain(|peer| peer.alive);
    let mut users: Vec<String> = peers.iter().map(Peer::to_string).collect();
    // Another release of iceoryx2 may not list the nodes of the daemon.
    users.extend(daemon(folder).filter(|_| peers.is_empty()));
    if users.is_empty() {
        return renew(folder, &place);
    }
    Err(BusError::OtherVersion {
        bus: folder.bus.to_string(),
        creator,
        peers: users.join(", "),
        program: version::bus_version(),
    })
}

/// A new location after removing the files of former processes.
fn renew(folder: &Folder, place: &Location) -> Result<Location, BusError> {
    let removed = leftovers::remove_all(place);
    if removed > 0 {
        tracing::info!(bus = %place.bus(), removed, "no process was on the bus; removed the files \
            of former processes");
    }
    create_location(folder)
}

/// Stores the version before the prefix: a bus with a prefix has a version, even after a kill.
fn create_location(folder: &Folder) -> Result<Location, BusError> {
    version::store(folder)?;
    Location::create(folder)
}

/// Another process that has owned the bus for longer than a start-up takes. A younger owner may not
/// have joined yet: the version in the folder then belongs to former processes.
fn daemon(folder: &Folder) -> Option<String> {
    let owner = FileLock::holder(folder, OWNER_LOCK)?;
    let owned = Duration::from_nanos(now_ns().saturating_sub(owner.since_ns));
    let is_other = owner.pid != std::process::id() && owned > START_MAX;
    is_other.then(|| format!("{} (process {})", owner.role, owner.pid))
}
