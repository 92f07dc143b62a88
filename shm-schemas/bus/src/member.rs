//! State shared by a bus and its ports.

use std::fmt;
use std::time::{Duration, Instant};

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::prelude::{MessagingPattern, Node};

use crate::clean;
use crate::error::BusError;
use crate::node::{Ipc, Realtime};
use crate::peer::Peer;
use crate::place::Place;
use crate::refusal::{Cause, Refusal};
use crate::remains;
use crate::shortage;
use crate::startup::StartupLock;

/// Time after which a transient error counts as left by a killed process. Design choice.
const TRANSIENT: Duration = Duration::from_millis(50);

#[derive(Debug)]
pub(crate) struct Member {
    pub(crate) place: Place,
    pub(crate) realtime: Realtime,
    pub(crate) node: Node<Ipc>,
    pub(crate) role: String,
}

impl Member {
    /// Removes dead nodes, unless another process is starting up.
    pub(crate) fn clean_dead(&self) -> usize {
        match StartupLock::try_take(&self.place.folder, &self.role) {
            Ok(Some(_startup)) => {
                remains::sweep(&self.place);
                clean::remove_dead(&self.place, &self.node)
            }
            Ok(None) | Err(_) => 0,
        }
    }

    /// Takes the start-up lock and removes unfinished files.
    pub(crate) fn startup(&self) -> Result<StartupLock, BusError> {
        let lock = StartupLock::take(&self.place.folder, &self.role)?;
        remains::sweep(&self.place);
        Ok(lock)
    }

    /// The error for a permanent refusal of iceoryx2.
    pub(crate) fn refused(&self, what: &'static str, why: &impl fmt::Debug) -> BusError {
        shortage::explain(&self.place, what, format!("{why:?}"))
    }

    /// The error for a service whose only slot is held by `node`.
    pub(crate) fn taken_by(&self, service: &'static str, node: Option<UniqueNodeId>) -> BusError {
        let peer = node.and_then(|id| Peer::find(self.node.config(), id));
        let (role, pid) = peer.map_or(("another process".to_owned(), 0), |peer| {
            (peer.role, peer.pid)
        });
        BusError::Taken { service, role, pid }
    }

    /// Opens a service or port under the start-up lock, and repairs leftovers of killed processes.
    ///
    /// * No slot: removes dead nodes, once.
    /// * Transient error: retries for [`TRANSIENT`]. If it persists, a killed process left the
    ///   service unfinished; no process can use it, and its description is removed, once. Not if
    ///   this process lacks a resource: the service may then be in use.
    pub(crate) fn open_despite_remains<T, E: Refusal>(
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
                Cause::Transient if !forgotten && shortage::find(&self.place).is_none() => {
                    tracing::warn!(bus = %self.place.bus(), service, ?refusal, "removing a half-made service");
                    remains::forget_service(&self.place, service, pattern);
                    (begin, forgotten) = (Instant::now(), true);
                }
                _ => return Err(refusal),
            }
        }
    }
}
