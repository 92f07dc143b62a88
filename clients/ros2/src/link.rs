//! Connection of one thread to the bus, which survives the end of a daemon.

use std::time::{Duration, Instant};

use atas_client::{ClientError, Session};
use shm_bus::BusName;

/// Pause before a missing bus is tried again. Design choice.
const RETRY: Duration = Duration::from_millis(300);

/// Session on the bus, opened on demand.
pub(crate) struct BusLink {
    bus: BusName,
    session: Option<Session>,
    tried: Option<Instant>,
}

impl BusLink {
    /// Creates the connection without opening it.
    #[must_use]
    pub(crate) fn new(bus: &BusName) -> Self {
        Self {
            bus: bus.clone(),
            session: None,
            tried: None,
        }
    }

    /// Returns the session, and opens it if necessary.
    ///
    /// # Errors
    /// There is no bus of this name.
    pub(crate) fn session(&mut self) -> Result<&Session, ClientError> {
        match &mut self.session {
            Some(session) => Ok(session),
            empty => Ok(empty.insert(Session::existing(&self.bus)?)),
        }
    }

    /// Returns the session; `None` if the last attempt to open it failed a moment ago.
    pub(crate) fn poll(&mut self) -> Option<&Session> {
        let waits = self.tried.is_some_and(|tried| tried.elapsed() < RETRY);
        if self.session.is_none() && waits {
            return None;
        }
        self.tried = Some(Instant::now());
        self.session().ok()
    }

    /// Closes the session, because a new daemon may use a new bus.
    pub(crate) fn close(&mut self) {
        self.session = None;
    }
}
