//! Control service: one request, one reply.

use std::time::{Duration, Instant};

use shm_schemas::service::CONTROL;
use shm_schemas::{ControlReply, ControlRequest, Payload};

use crate::bus::Bus;
use crate::client::Client;
use crate::error::BusError;
use crate::exchange::Exchange;
use crate::server::{Request, Server};

pub(crate) const EXCHANGE: Exchange = Exchange {
    service: CONTROL,
    payloads: [ControlRequest::TYPE_NAME, ControlReply::TYPE_NAME],
    clients: 16,
    open_requests: 2,
    responses: 1,
};
/// Poll interval of a waiting client. Design choice: imperceptible delay, negligible load.
const POLL: Duration = Duration::from_millis(1);

impl Bus {
    /// Opens the server of control requests.
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if there is a server already.
    pub fn control_server(&self) -> Result<ControlServer, BusError> {
        Ok(ControlServer {
            port: self.server(EXCHANGE)?,
        })
    }

    /// Opens a client of the control service.
    ///
    /// # Errors
    /// [`BusError::Full`] if there are too many clients.
    pub fn control_client(&self) -> Result<ControlClient, BusError> {
        Ok(ControlClient {
            port: self.client(EXCHANGE)?,
        })
    }
}

/// Server of control requests (the daemon, outside its real-time thread).
#[derive(Debug)]
pub struct ControlServer {
    port: Server<ControlRequest, ControlReply>,
}

impl ControlServer {
    /// The next waiting request.
    ///
    /// # Errors
    /// [`BusError::Receive`] if a client's shared memory cannot be read.
    pub fn poll(&self) -> Result<Option<ControlCall>, BusError> {
        Ok(self.port.poll()?.map(|request| ControlCall { request }))
    }
}

/// Request that waits for its reply.
#[derive(Debug)]
pub struct ControlCall {
    request: Request<ControlRequest, ControlReply>,
}

impl ControlCall {
    /// The request, in memory that the client can write: copy it once, then validate the copy.
    #[must_use]
    pub fn request(&self) -> &ControlRequest {
        self.request.payload()
    }

    /// Sends the reply.
    ///
    /// # Errors
    /// [`BusError::ClientGone`] if the client no longer waits.
    pub fn reply(self, reply: &ControlReply) -> Result<(), BusError> {
        self.request.respond(reply)
    }
}

/// Client of the control service.
#[derive(Debug)]
pub struct ControlClient {
    port: Client<ControlRequest, ControlReply>,
}

impl ControlClient {
    /// Sends a request and waits for the reply.
    ///
    /// # Errors
    /// [`BusError::NoServer`] without a daemon, [`BusError::ServerGone`] if it ends meanwhile,
    /// [`BusError::NoAnswer`] after `within`.
    pub fn call(
        &self,
        request: &ControlRequest,
        within: Duration,
    ) -> Result<ControlReply, BusError> {
        let begin = Instant::now();
        let pending = self.port.send(request)?;
        loop {
            if let Some(reply) = pending.next()? {
                return Ok(reply);
            }
            if begin.elapsed() >= within {
                return Err(self.port.no_answer_error(within));
            }
            std::thread::sleep(POLL);
        }
    }
}
