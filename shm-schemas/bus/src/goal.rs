//! Goals: one request, answered by a stream of updates until a final one.

use shm_schemas::service::GOAL;
use shm_schemas::{GoalRequest, GoalUpdate, Payload};

use crate::bus::Bus;
use crate::client::{Client, Pending};
use crate::error::BusError;
use crate::exchange::Exchange;
use crate::server::{Request, Server};

/// Updates wait 64 deep: more than a second at the 50 Hz of the daemon's supervisor.
pub(crate) const EXCHANGE: Exchange = Exchange {
    service: GOAL,
    payloads: [GoalRequest::TYPE_NAME, GoalUpdate::TYPE_NAME],
    clients: 8,
    open_requests: 4,
    responses: 64,
};

impl Bus {
    /// Begins to take goals.
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if another one does.
    pub fn goal_server(&self) -> Result<GoalServer, BusError> {
        Ok(GoalServer {
            port: self.server(EXCHANGE)?,
        })
    }

    /// Prepares to send goals.
    ///
    /// # Errors
    /// [`BusError::Full`] if there are too many clients.
    pub fn goal_client(&self) -> Result<GoalClient, BusError> {
        Ok(GoalClient {
            port: self.client(EXCHANGE)?,
        })
    }
}

/// Takes goals (the daemon, off its real-time thread).
#[derive(Debug)]
pub struct GoalServer {
    port: Server<GoalRequest, GoalUpdate>,
}

impl GoalServer {
    /// The next goal that waits.
    ///
    /// # Errors
    /// [`BusError::Receive`] if a client's shared memory cannot be read.
    pub fn poll(&self) -> Result<Option<ActiveGoal>, BusError> {
        Ok(self.port.poll()?.map(|request| ActiveGoal { request }))
    }
}

/// A goal that was taken. Dropping it ends the stream of updates: send a final update first.
#[derive(Debug)]
pub struct ActiveGoal {
    request: Request<GoalRequest, GoalUpdate>,
}

impl ActiveGoal {
    /// What was asked. It lies in memory that the client can write: copy it once, then check the copy.
    #[must_use]
    pub fn request(&self) -> &GoalRequest {
        self.request.payload()
    }

    /// Tells the client.
    ///
    /// # Errors
    /// [`BusError::ClientGone`] if nobody listens any more.
    pub fn update(&self, update: &GoalUpdate) -> Result<(), BusError> {
        self.request.respond(update)
    }

    /// Whether the client asked to end the goal.
    #[must_use]
    pub fn cancel_requested(&self) -> bool {
        self.request.is_cancelled()
    }

    /// Whether the client still listens. A killed client is noticed after the next [`Bus::clean_dead`] of anyone.
    #[must_use]
    pub fn client_alive(&self) -> bool {
        self.request.is_awaited()
    }
}

/// Sends goals.
#[derive(Debug)]
pub struct GoalClient {
    port: Client<GoalRequest, GoalUpdate>,
}

impl GoalClient {
    /// Sends a goal.
    ///
    /// # Errors
    /// [`BusError::NoServer`] if no daemon takes goals; [`BusError::TooManyRequests`] if this client has 4 open.
    pub fn send(&self, goal: &GoalRequest) -> Result<PendingGoal, BusError> {
        Ok(PendingGoal {
            pending: self.port.send(goal)?,
            ended: false,
        })
    }
}

/// A goal on its way. Dropping it tells the daemon that the client is gone.
#[derive(Debug)]
pub struct PendingGoal {
    pending: Pending<GoalRequest, GoalUpdate>,
    ended: bool,
}

impl PendingGoal {
    /// The next update; `None` if there is none yet, and after the final one. Does not wait.
    ///
    /// # Errors
    /// [`BusError::ServerGone`] if the daemon went away before a final update; a killed daemon is noticed within
    /// about 250 ms, if this is called more often than that.
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

    /// Whether the final update was received.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.ended
    }

    /// Asks the daemon to end the goal. Updates go on until the final one.
    pub fn cancel(&self) {
        self.pending.cancel();
    }
}
