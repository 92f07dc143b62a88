//! Client side of a request-response service.

use std::cell::Cell;
use std::fmt;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::client::{Client as IoxClient, RequestSendError};
use iceoryx2::service::port_factory::client::ClientCreateError;
use shm_schemas::Payload;

use crate::bus::Bus;
use crate::error::BusError;
use crate::exchange::{Exchange, Factory, PATTERN, debug_by_service};
use crate::member::Member;
use crate::node::Ipc;
use crate::opaque::Opaque;
use crate::refusal::{loan_text, send_text};
use crate::shortage::{require_space, require_stack};

/// Interval at which a waiting client checks that the server is alive. Design choice: short for a
/// person, cheap.
const LIVENESS_INTERVAL: Duration = Duration::from_millis(250);

pub(crate) struct Client<Q: Payload, A: Payload> {
    port: Opaque<IoxClient<Ipc, Q, (), A, ()>>,
    member: Rc<Member>,
    exchange: Exchange,
}

/// Open request of a client. Dropping it informs the server.
pub(crate) struct Pending<Q: Payload, A: Payload> {
    response: Opaque<PendingResponse<Ipc, Q, (), A, ()>>,
    member: Rc<Member>,
    service: &'static str,
    last_cleanup: Cell<Instant>,
}

impl Bus {
    pub(crate) fn client<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Client<Q, A>, BusError> {
        require_stack(exchange.service)?;
        self.make_client(exchange)
    }

    /// Not inlined: uses its stack after [`require_stack`].
    #[inline(never)]
    fn make_client<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Client<Q, A>, BusError> {
        let (member, service) = (&self.member, exchange.service);
        let _startup = member.startup()?;
        require_space(service, 0)?;
        let factory = member.open_exchange::<Q, A>(exchange)?;
        match member.open_with_recovery(service, PATTERN, || create_client(&factory)) {
            Ok(port) => Ok(Client {
                port: Opaque::new(port),
                member: Rc::clone(member),
                exchange,
            }),
            Err(ClientCreateError::ExceedsMaxSupportedClients) => Err(BusError::Full {
                service,
                what: "clients",
                limit: exchange.clients,
            }),
            Err(e) => Err(member.refused_error(service, &e)),
        }
    }
}

fn create_client<Q: Payload, A: Payload>(
    factory: &Factory<Q, A>,
) -> Result<IoxClient<Ipc, Q, (), A, ()>, ClientCreateError> {
    factory
        .client_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
}

impl<Q: Payload, A: Payload> Client<Q, A> {
    pub(crate) fn send(&self, request: &Q) -> Result<Pending<Q, A>, BusError> {
        let service = self.exchange.service;
        // A dead server that still has its slot would count as a server.
        self.member.clean_dead();
        let failed = |why| BusError::Send { service, why };
        let loan = match self.port.loan_uninit() {
            Ok(loan) => loan.write_payload(*request),
            Err(e) => return Err(failed(loan_text(e))),
        };
        match loan.send() {
            Ok(response) if response.number_of_server_connections() > 0 => Ok(Pending {
                response: Opaque::new(response),
                member: Rc::clone(&self.member),
                service,
                last_cleanup: Cell::new(Instant::now()),
            }),
            Ok(_) => Err(BusError::NoServer {
                service,
                bus: self.member.location.bus().to_string(),
                root: self.member.location.root().to_owned(),
            }),
            Err(RequestSendError::ExceedsMaxActiveRequests) => Err(BusError::TooManyRequests {
                service,
                limit: self.exchange.open_requests,
            }),
            Err(RequestSendError::SendError(e)) => Err(failed(send_text(e))),
        }
    }

    pub(crate) fn no_answer_error(&self, within: Duration) -> BusError {
        BusError::NoAnswer {
            service: self.exchange.service,
            within,
            bus: self.member.location.bus().to_string(),
        }
    }
}

impl<Q: Payload, A: Payload> Pending<Q, A> {
    /// The next response, if one has arrived.
    pub(crate) fn next(&self) -> Result<Option<A>, BusError> {
        self.remove_dead_server();
        // Reads the connection state first, so that the server's last response is received before
        // its end is reported.
        let connected = self.response.is_connected();
        let failed = |_| BusError::Receive {
            service: self.service,
            why: "the server's shared memory cannot be opened",
        };
        match self.response.receive().map_err(failed)? {
            Some(response) => Ok(Some(*response)),
            None if connected => Ok(None),
            None => Err(BusError::ServerGone {
                service: self.service,
            }),
        }
    }

    pub(crate) fn cancel(&self) {
        self.response.set_disconnect_hint();
    }

    /// A killed server looks alive until a clean-up.
    fn remove_dead_server(&self) {
        if self.last_cleanup.get().elapsed() >= LIVENESS_INTERVAL {
            self.member.clean_dead();
            self.last_cleanup.set(Instant::now());
        }
    }
}

debug_by_service!(Client: exchange.service, Pending: service);
