//! Peers on a bus.

use std::fmt;

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::node::{NodeListFailure, NodeView};
use iceoryx2::prelude::{CallbackProgression, Config, Node, NodeState};

use crate::error::BusError;
use crate::location::Location;
use crate::node::Ipc;
use crate::shortage;

/// Process or thread on the bus.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// Role it opened the bus with; empty if unknown.
    pub role: String,
    /// Process id; 0 if unknown.
    pub pid: u32,
    /// False between its death and the next [clean-up](crate::Bus::clean_dead).
    pub alive: bool,
}

impl fmt::Display for Peer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (process {})", self.role, self.pid)
    }
}

impl Peer {
    pub(crate) fn list(place: &Location, config: &Config) -> Result<Vec<Self>, BusError> {
        let mut peers = Vec::new();
        let listed = Node::<Ipc>::list(config, |state| {
            peers.push(Self::from_state(&state));
            CallbackProgression::Continue
        });
        match listed {
            Ok(()) => Ok(peers),
            Err(e) => Err(list_error(place, e)),
        }
    }

    /// Returns true if a process is on the bus. Ends the search at the first one.
    pub(crate) fn is_any_alive(place: &Location, config: &Config) -> Result<bool, BusError> {
        let mut is_found = false;
        let searched = Node::<Ipc>::list(config, |state| {
            is_found = Self::from_state(&state).alive;
            if is_found {
                CallbackProgression::Stop
            } else {
                CallbackProgression::Continue
            }
        });
        match searched {
            Ok(()) => Ok(is_found),
            Err(e) => Err(list_error(place, e)),
        }
    }

    /// The peer with this id, if it exists.
    pub(crate) fn find(config: &Config, id: UniqueNodeId) -> Option<Self> {
        Node::<Ipc>::state_of(config, id)
            .ok()
            .flatten()
            .map(|state| Self::from_state(&state))
    }

    fn from_state(state: &NodeState<Ipc>) -> Self {
        let (details, alive) = match state {
            NodeState::Alive(view) => (view.details().as_ref(), true),
            NodeState::Dead(view) => (view.details().as_ref(), false),
            // Inaccessible nodes may be alive.
            NodeState::Inaccessible(_) => (None, true),
            NodeState::Undefined(_) => (None, false),
        };
        let role = details
            .map(|d| d.name().as_str().to_owned())
            .unwrap_or_default();
        let pid = details.map_or(0, |d| d.process_id().value() as u32);
        Self { role, pid, alive }
    }
}

fn list_error(place: &Location, error: NodeListFailure) -> BusError {
    shortage::refusal_error(place, "the list of peers", format!("{error:?}"))
}
