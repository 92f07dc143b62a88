//! Goal service: one request, answered by updates until a final one.

use shm_schemas::service::GOAL;
use shm_schemas::{GoalRequest, GoalUpdate, Payload};

use crate::bus::Bus;
use crate::client::{Client, Pending};
use crate::error::BusError;
use crate::exchange::Exchange;
use crate::server::{Request, Server};

/// Buffer of 64 updates: more than a second at the supervisor's 50 Hz.
pub(crate) const EXCHANGE: Exchange = Exchange {
    service: GOAL,
    payloads: [GoalRequest::TYPE_NAME, GoalUpdate::TYPE_NAME],
    clients: 8,
    open_requests: 4,
    responses: 64,
};

impl Bus {
    /// Opens the server of goals.
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if there is a server already.
    pub fn goal_server(&self) -> Result<GoalServer, BusError> {
        Ok(GoalServer {
            port: self.server(EXCHANGE)?,
        })
    }

    /// Opens a client of the goal service.
    ///
    /// # Errors
    /// [`BusError::Full`] if there are too many clients.
    pub fn goal_client(&self) -> Result<GoalClient, BusError> {
        Ok(GoalClient {
            port: self.client(EXCHANGE)?,
        })
    }
}

/// Server of goals (the daemon, outside its real-time thread).
#[derive(Debug)]
pub struct GoalServer {
    port: Server<GoalRequest, GoalUpdate>,
}

impl GoalServer {
    /// The next waiting goal.
    ///
    /// # Errors
    /// [`BusError::Receive`] if a client's shared memory cannot be read.
    pub fn poll(&self) -> Result<Option<ActiveGoal>, BusError> {
        Ok(self.port.poll()?.map(|request| ActiveGoal { request }))
    }
}

/// Received goal. Dropping it ends the updates: send a final update first.
#[derive(Debug)]
pub struct ActiveGoal {
    request: Request<GoalRequest, GoalUpdate>,
}

impl ActiveGoal {
    /// The request, in memory that the client can write: copy it once, then validate the copy.
    #[must_use]
    pub fn request(&self) -> &GoalRequest {
        self.request.payload()
    }

    /// Sends an update to the client.
    ///
    /// # Errors
    /// [`BusError::ClientGone`] if the client no longer waits.
    pub fn update(&self, update: &GoalUpdate) -> Result<(), BusError> {
        self.request.respond(update)
    }

    /// Returns true if the client requested to end the goal.
    #[must_use]
    pub fn cancel_requested(&self) -> bool {
        self.request.is_cancelled()
    }

    /// Returns true while the client waits. A killed client is detected after the next
    /// [`Bus::clean_dead`] of any peer.
    #[must_use]
    pub fn client_alive(&self) -> bool {
        self.request.is_awaited()
    }
}

/// Client of the goal service.
#[derive(Debug)]
pub struct GoalClient {
    port: Client<GoalRequest, GoalUpdate>,
}

impl GoalClient {
    /// Sends a goal.
    ///
    /// # Errors
    /// [`BusError::NoServer`] without a daemon; [`BusError::TooManyRequests`] if this client has 4
    /// open.
    pub fn send(&self, goal: &GoalRequest) -> Result<PendingGoal, BusError> {
        Ok(PendingGoal {
            pending: self.port.send(goal)?,
            ended: false,
        })
    }
}

/// Open goal of a client. Dropping it informs the daemon.
///
/// ```
/// use shm_bus::{Bus, FreshBus, Realtime};
/// use shm_schemas::{GoalRequest, GoalState, GoalUpdate};
///
/// let name = FreshBus::new("docs");
/// let bus = Bus::open(&name, "daemon", Realtime::No)?;
/// let (server, client) = (bus.goal_server()?, bus.goal_client()?);
/// let mut pending = client.send(&GoalRequest { goal_id: 7, ..GoalRequest::default() })?;
///
/// let active = server.poll()?.expect("the request has arrived");
/// let goal_id = active.request().goal_id;
/// active.update(&GoalUpdate { goal_id, state: GoalState::SUCCEEDED, ..GoalUpdate::default() })?;
/// assert_eq!(pending.next()?.map(|update| update.goal_id), Some(7));
/// assert!(pending.has_ended());
/// # Ok::<(), shm_bus::BusError>(())
/// ```
#[derive(Debug)]
pub struct PendingGoal {
    pending: Pending<GoalRequest, GoalUpdate>,
    ended: bool,
}

impl PendingGoal {
    /// The next update; `None` if none has arrived, and after the final one. Does not wait.
    ///
    /// # Errors
    /// [`BusError::ServerGone`] if the daemon ended before a final update. A killed daemon is
    /// detected within about 250 ms of polling.
    #[expect(
        clippy::should_implement_trait,
        reason = "an iterator must not end at `None` and go on later"
    )]
    pub fn next(&mut self) -> Result<Option<GoalUpdate>, BusError> {
        if self.ended {
            return Ok(None);
        }
        let update = self.pending.next()?;
        self.ended = update.is_some_and(|update| update.state.is_final());
        Ok(update)
    }

    /// Returns true once the final update was received.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        self.ended
    }

    /// Requests the daemon to end the goal. Updates continue until the final one.
    pub fn cancel(&self) {
        self.pending.cancel();
    }
}
