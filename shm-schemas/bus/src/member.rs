//! What a bus and the ports opened from it share.

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

/// How long a transient refusal may last before its cause counts as left behind by a killed process. Ours.
const TRANSIENT: Duration = Duration::from_millis(50);

/// One thread's node on a bus.
#[derive(Debug)]
pub(crate) struct Member {
    pub(crate) place: Place,
    pub(crate) realtime: Realtime,
    pub(crate) node: Node<Ipc>,
    pub(crate) role: String,
}

impl Member {
    /// Removes what dead processes left, unless another process sets something up just now.
    pub(crate) fn clean_dead(&self) -> usize {
        match StartupLock::try_take(&self.place.folder, &self.role) {
            Ok(Some(_startup)) => {
                remains::sweep(&self.place);
                clean::remove_dead(&self.place, &self.node)
            }
            Ok(None) | Err(_) => 0,
        }
    }

    /// For setting something up, one process at a time, on ground that killed processes left clean.
    pub(crate) fn startup(&self) -> Result<StartupLock, BusError> {
        let lock = StartupLock::take(&self.place.folder, &self.role)?;
        remains::sweep(&self.place);
        Ok(lock)
    }

    /// The error for a refusal of iceoryx2 that will not pass.
    pub(crate) fn refused(&self, what: &'static str, why: &impl fmt::Debug) -> BusError {
        shortage::explain(&self.place, what, format!("{why:?}"))
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
    /// using it: its description is removed, once. Not so when this process itself is short of something: then the
    /// service may be whole and in use.
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
