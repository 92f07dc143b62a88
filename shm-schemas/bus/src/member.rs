//! State shared by a bus and its ports.

use std::fmt;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::{MessagingPattern, Node};

use crate::clean;
use crate::error::BusError;
use crate::leftovers;
use crate::location::{Location, PREFIX};
use crate::node::{Ipc, Realtime};
use crate::opaque::Opaque;
use crate::peer::Peer;
use crate::presence;
use crate::refusal::{Cause, Refusal};
use crate::shortage;
use crate::startup::StartupLock;

/// Time limit for the start-up lock when a process leaves. Design choice: other processes take some
/// milliseconds; the next process on the bus removes what remains.
const LEAVE_MAX: Duration = Duration::from_millis(100);
/// Time after which a transient error counts as left by a killed process. Design choice.
const TRANSIENT_MAX: Duration = Duration::from_millis(50);

#[derive(Debug)]
pub(crate) struct Member {
    pub(crate) location: Location,
    pub(crate) realtime: Realtime,
    pub(crate) node: Opaque<Node<Ipc>>,
    pub(crate) role: String,
    /// Declared after the node, which must be gone before.
    pub(crate) _departure: Departure,
}

/// Removes the files of a bus on drop if no process remains: iceoryx2 leaves one in `/dev/shm`.
#[derive(Debug)]
pub(crate) struct Departure {
    location: Location,
}

impl Departure {
    /// Counts the presence of this process on the bus. Call after its node exists.
    pub(crate) fn new(location: Location) -> Self {
        presence::enter(&location.prefix);
        Self { location }
    }
}

impl Drop for Departure {
    fn drop(&mut self) {
        let place = &self.location;
        if presence::leave(&place.prefix) {
            return;
        }
        // The bus may have been wiped, or have a new life.
        let is_current = || {
            let read = Location::read(&place.folder);
            read.is_ok_and(|now| now.is_some_and(|now| now.prefix == place.prefix))
        };
        if !is_current() {
            return;
        }
        let startup = StartupLock::take_within(&place.folder, "departure", LEAVE_MAX);
        let is_used = || {
            let config = place.config();
            config.and_then(|config| Peer::is_any_alive(place, &config))
        };
        if startup.is_ok() && is_current() && is_used().is_ok_and(|is_used| !is_used) {
            leftovers::remove_all(place);
            // Other programs wait for the next prefix; with this one, they would create shared
            // memory without the care of `node.rs`.
            leftovers::remove(&place.root().join(PREFIX));
        }
    }
}

impl Member {
    /// Removes dead nodes, unless another process is starting up.
    pub(crate) fn clean_dead(&self) -> usize {
        match StartupLock::try_take(&self.location.folder, &self.role) {
            Ok(Some(_startup)) => {
                leftovers::remove_unfinished(&self.location);
                clean::remove_dead(&self.location, &self.node)
            }
            Ok(None) | Err(_) => 0,
        }
    }

    /// Takes the start-up lock and removes unfinished files.
    pub(crate) fn startup(&self) -> Result<StartupLock, BusError> {
        let lock = StartupLock::take(&self.location.folder, &self.role)?;
        leftovers::remove_unfinished(&self.location);
        Ok(lock)
    }

    /// The error for a permanent refusal of iceoryx2.
    pub(crate) fn refused_error(&self, what: &'static str, why: &impl fmt::Debug) -> BusError {
        shortage::refusal_error(&self.location, what, format!("{why:?}"))
    }

    /// The error for a service whose only slot is held by `node`.
    pub(crate) fn taken_error(
        &self,
        service: &'static str,
        node: Option<UniqueNodeId>,
    ) -> BusError {
        let peer = node.and_then(|id| Peer::find(self.node.config(), id));
        let (role, pid) = peer.map_or(("another process".to_owned(), 0), |peer| {
            (peer.role, peer.pid)
        });
        BusError::Taken { service, role, pid }
    }

    /// Opens a service or port under the start-up lock, and repairs leftovers of killed processes.
    ///
    /// * No slot: removes dead nodes, once.
    /// * Transient error: retries for [`TRANSIENT_MAX`]. If it persists, a killed process left the
    ///   service unfinished; no process can use it, and its description is removed, once. Not if
    ///   this process lacks a resource: the service may then be in use.
    pub(crate) fn open_with_recovery<T, E: Refusal>(
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
                Cause::NoSlot if !cleaned => {
                    clean::remove_dead(&self.location, &self.node);
                    cleaned = true;
                }
                Cause::Transient if begin.elapsed() < TRANSIENT_MAX => {
                    std::thread::sleep(Duration::from_millis(1))
                }
                Cause::Transient
                    if !forgotten && shortage::find_shortage(&self.location).is_none() =>
                {
                    tracing::warn!(bus = %self.location.bus(), service, ?refusal, "removing an unfinished service");
                    leftovers::remove_service(&self.location, service, pattern);
                    (begin, forgotten) = (Instant::now(), true);
                }
                _ => return Err(refusal),
            }
        }
    }
}
