//! One thread's place on a bus.

use std::path::Path;
use std::rc::Rc;

use crate::clean;
use crate::error::BusError;
use crate::folder::Folder;
use crate::log;
use crate::member::Member;
use crate::name::BusName;
use crate::node::{self, Realtime};
use crate::owner::OwnerLock;
use crate::peer::Peer;
use crate::place::Place;
use crate::remains;
use crate::shortage::{self, require_space, require_stack};
use crate::startup::StartupLock;

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

impl Bus {
    /// Joins a bus, and makes it if this is the first process on it.
    ///
    /// `role` is what others see, for example `atasd` or `sensor-left`.
    ///
    /// # Errors
    /// When the bus's folder is not private, `/dev/shm` is full, another process hangs in its start-up, or iceoryx2
    /// refuses.
    pub fn open(name: &BusName, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        require_stack("the bus")?;
        let folder = Folder::of(name)?;
        folder.make()?;
        Self::enter(&folder, role, realtime)
    }

    /// Joins a bus that others made: for those who look, ask or order. A mistyped name leaves nothing behind.
    ///
    /// # Errors
    /// [`BusError::OtherUser`], with its name, if this user has no such bus and another user has; [`BusError::Absent`] if nobody
    /// is seen to have it; else as [`Bus::open`].
    pub fn join(name: &BusName, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        require_stack("the bus")?;
        let folder = Folder::of(name)?;
        folder.find()?;
        Self::enter(&folder, role, realtime)
    }

    /// Whether this user has such a bus. Makes nothing, joins nothing.
    ///
    /// # Errors
    /// As [`Bus::join`] for a bus that is not there, is another user's, or has a folder that is not private.
    pub fn find(name: &BusName) -> Result<(), BusError> {
        Folder::of(name)?.find()
    }

    /// Not inlined, so that its stack is only taken after [`require_stack`].
    #[inline(never)]
    fn enter(folder: &Folder, role: &str, realtime: Realtime) -> Result<Self, BusError> {
        log::bridge();
        require_space("the bus", 0)?;
        let _startup = StartupLock::take(folder, role)?;
        let place = settle(folder)?;
        let config = node::config(&place, realtime)?;
        let refused = |why| shortage::explain(&place, "the bus", why);
        let node = node::create(&place, &config, role).map_err(refused)?;
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
        self.member.place.bus()
    }

    /// The bus's folder: `/run/atas/<bus>` as a service, else below `$XDG_RUNTIME_DIR` or in `/dev/shm`. For peers in other
    /// languages: it is iceoryx2's `global.root-path`.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.member.place.root()
    }

    /// What the bus's names in `/dev/shm` begin with, drawn anew for each life of the bus. For peers in other languages: it
    /// is iceoryx2's `global.prefix`, and stands in the file `prefix` of the folder.
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
        let folder = Folder::of(name)?;
        match folder.find() {
            Err(BusError::Absent { .. } | BusError::OtherUser { .. }) => return Ok(0),
            found => found?,
        }
        let _owner = OwnerLock::take_at(&folder, "wipe")?;
        let _startup = StartupLock::take(&folder, "wipe")?;
        let removed = match Place::read(&folder)? {
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
                remains::clear(&place)
            }
        };
        std::fs::remove_dir_all(&folder.path).map_err(BusError::io("remove", &folder.path))?;
        Ok(removed)
    }
}

/// The place in a folder: the one of those who are there, or a new one on clean ground. Call under the start-up lock.
fn settle(folder: &Folder) -> Result<Place, BusError> {
    let Some(place) = Place::read(folder)? else {
        return Place::draw(folder);
    };
    remains::sweep(&place);
    if Peer::list(&place, &place.config()?)?
        .iter()
        .any(|peer| peer.alive)
    {
        return Ok(place);
    }
    let removed = remains::clear(&place);
    if removed > 0 {
        tracing::info!(bus = %place.bus(), removed, "nobody was on the bus; removed what former processes left");
    }
    Place::draw(folder)
}
