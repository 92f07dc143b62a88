//! Request and response, under [`crate::goal`] and [`crate::control`].
//!
//! One server at most. Requests that nobody waits for are not delivered. Neither side ever waits for the other inside
//! a call: buffers overflow, and because the oldest is lost, the last response always arrives.

use std::cell::Cell;
use std::fmt;
use std::rc::Rc;
use std::time::{Duration, Instant};

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::client::{Client as IoxClient, RequestSendError};
use iceoryx2::port::server::Server as IoxServer;
use iceoryx2::prelude::{CallbackProgression, MessagingPattern, ServiceName};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError as CreateError, RequestResponseOpenError as OpenError,
    RequestResponseOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::request_response::PortFactory;
use iceoryx2::service::port_factory::server::ServerCreateError;
use shm_schemas::Payload;

use crate::BusError;
use crate::bus::{Bus, Cause, Ipc, Member, Refusal, require_space};
use crate::port::{loan_text, send_text};

/// How one request-response service is carried.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exchange {
    pub(crate) service: &'static str,
    /// Most clients at a time.
    pub(crate) clients: usize,
    /// Most open requests of one client.
    pub(crate) open_requests: usize,
    /// Responses that wait for the client; more, and the oldest are lost.
    pub(crate) responses: usize,
}

/// Nodes beyond the server and the clients: dead ones keep their place until someone cleans up. Ours.
const SPARE_NODES: usize = 4;
/// How often a waiting client makes sure that the server lives. Ours: quick for a person, cheap for the machine.
const LIVENESS: Duration = Duration::from_millis(250);

const PATTERN: MessagingPattern = MessagingPattern::RequestResponse;

type Factory<Q, A> = PortFactory<Ipc, Q, (), A, ()>;

/// The serving side.
pub(crate) struct Server<Q: Payload, A: Payload> {
    port: IoxServer<Ipc, Q, (), A, ()>,
    service: &'static str,
}

/// One request at the serving side. Dropping it ends the exchange.
pub(crate) struct Request<Q: Payload, A: Payload> {
    request: ActiveRequest<Ipc, Q, (), A, ()>,
    service: &'static str,
}

/// The asking side.
pub(crate) struct Client<Q: Payload, A: Payload> {
    port: IoxClient<Ipc, Q, (), A, ()>,
    member: Rc<Member>,
    exchange: Exchange,
}

/// One request at the asking side. Dropping it tells the server that nobody listens any more.
pub(crate) struct Pending<Q: Payload, A: Payload> {
    response: PendingResponse<Ipc, Q, (), A, ()>,
    member: Rc<Member>,
    service: &'static str,
    looked: Cell<Instant>,
}

impl Bus {
    pub(crate) fn server<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Server<Q, A>, BusError> {
        let (member, service) = (&self.member, exchange.service);
        let _startup = member.startup()?;
        require_space(service, 0)?;
        let factory = member.open_exchange::<Q, A>(exchange)?;
        match member.persist(service, PATTERN, || create_server(&factory)) {
            Ok(port) => Ok(Server { port, service }),
            Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                Err(member.taken_by(service, first_server(&factory)))
            }
            Err(e) => Err(member.refused(service, &e)),
        }
    }

    pub(crate) fn client<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Client<Q, A>, BusError> {
        let (member, service) = (&self.member, exchange.service);
        let _startup = member.startup()?;
        require_space(service, 0)?;
        let factory = member.open_exchange::<Q, A>(exchange)?;
        match member.persist(service, PATTERN, || create_client(&factory)) {
            Ok(port) => Ok(Client {
                port,
                member: Rc::clone(member),
                exchange,
            }),
            Err(ClientCreateError::ExceedsMaxSupportedClients) => Err(BusError::Full {
                service,
                what: "clients",
                limit: exchange.clients,
            }),
            Err(e) => Err(member.refused(service, &e)),
        }
    }
}

impl Member {
    fn open_exchange<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Factory<Q, A>, BusError> {
        let name =
            ServiceName::new(exchange.service).map_err(|e| self.refused(exchange.service, &e))?;
        let open = || {
            let service = self.node.service_builder(&name).request_response::<Q, A>();
            service
                .enable_safe_overflow_for_requests(true)
                .enable_safe_overflow_for_responses(true)
                .enable_fire_and_forget_requests(false)
                .max_active_requests_per_client(exchange.open_requests)
                .max_response_buffer_size(exchange.responses)
                .max_servers(1)
                .max_clients(exchange.clients)
                .max_nodes(1 + exchange.clients + SPARE_NODES)
                .open_or_create()
        };
        self.persist(exchange.service, PATTERN, open)
            .map_err(|e| self.refused(exchange.service, &e))
    }
}

fn first_server<Q: Payload, A: Payload>(factory: &Factory<Q, A>) -> Option<UniqueNodeId> {
    let mut first = None;
    factory.dynamic_config().list_servers(|details| {
        first = Some(details.node_id);
        CallbackProgression::Stop
    });
    first
}

fn create_server<Q: Payload, A: Payload>(
    factory: &Factory<Q, A>,
) -> Result<IoxServer<Ipc, Q, (), A, ()>, ServerCreateError> {
    let builder = factory.server_builder().max_loaned_responses_per_request(1);
    builder
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
}

fn create_client<Q: Payload, A: Payload>(
    factory: &Factory<Q, A>,
) -> Result<IoxClient<Ipc, Q, (), A, ()>, ClientCreateError> {
    factory
        .client_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
}

impl<Q: Payload, A: Payload> Server<Q, A> {
    /// The next request whose client still waits.
    pub(crate) fn poll(&self) -> Result<Option<Request<Q, A>>, BusError> {
        let received = self.port.receive();
        let failed = |_| BusError::Receive {
            service: self.service,
            why: "a client's shared memory cannot be opened",
        };
        Ok(received.map_err(failed)?.map(|request| Request {
            request,
            service: self.service,
        }))
    }
}

impl<Q: Payload, A: Payload> Request<Q, A> {
    pub(crate) fn payload(&self) -> &Q {
        self.request.payload()
    }

    pub(crate) fn respond(&self, answer: &A) -> Result<(), BusError> {
        if !self.is_awaited() {
            return Err(BusError::ClientGone {
                service: self.service,
            });
        }
        let failed = |why| BusError::Send {
            service: self.service,
            why,
        };
        let response = self
            .request
            .loan_uninit()
            .map_err(|e| failed(loan_text(e)))?;
        response
            .write_payload(*answer)
            .send()
            .map_err(|e| failed(send_text(e)))
    }

    /// Whether the client asked for an end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.request.has_disconnect_hint()
    }

    /// Whether the client still listens. A killed client counts as listening until someone cleans up.
    pub(crate) fn is_awaited(&self) -> bool {
        self.request.is_connected()
    }
}

impl<Q: Payload, A: Payload> Client<Q, A> {
    pub(crate) fn send(&self, request: &Q) -> Result<Pending<Q, A>, BusError> {
        let service = self.exchange.service;
        // A dead server that still has its place would count as one.
        self.member.clean_dead();
        let failed = |why| BusError::Send { service, why };
        let loan = match self.port.loan_uninit() {
            Ok(loan) => loan.write_payload(*request),
            Err(e) => return Err(failed(loan_text(e))),
        };
        match loan.send() {
            Ok(response) if response.number_of_server_connections() > 0 => Ok(Pending {
                response,
                member: Rc::clone(&self.member),
                service,
                looked: Cell::new(Instant::now()),
            }),
            Ok(_) => Err(BusError::NoServer {
                service,
                bus: self.member.place.bus.to_string(),
                root: self.member.place.root.clone(),
            }),
            Err(RequestSendError::ExceedsMaxActiveRequests) => Err(BusError::TooManyRequests {
                service,
                limit: self.exchange.open_requests,
            }),
            Err(RequestSendError::SendError(e)) => Err(failed(send_text(e))),
        }
    }

    pub(crate) fn unanswered(&self, within: Duration) -> BusError {
        BusError::NoAnswer {
            service: self.exchange.service,
            within,
            bus: self.member.place.bus.to_string(),
        }
    }
}

impl<Q: Payload, A: Payload> Pending<Q, A> {
    /// The next response; `None` if there is none yet.
    pub(crate) fn next(&self) -> Result<Option<A>, BusError> {
        self.look_after_server();
        // In this order, so that what the server said last is heard before its end is seen.
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

    /// A killed server looks alive until someone cleans up after it.
    fn look_after_server(&self) {
        if self.looked.get().elapsed() >= LIVENESS {
            self.member.clean_dead();
            self.looked.set(Instant::now());
        }
    }
}

macro_rules! debug_by_service {
    ($($name:ident: $field:ident $(. $inner:ident)?),*) => {$(
        impl<Q: Payload, A: Payload> fmt::Debug for $name<Q, A> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($name), "({})"), self.$field $(. $inner)?)
            }
        }
    )*};
}
debug_by_service!(Server: service, Request: service, Client: exchange.service, Pending: service);

impl Refusal for OpenOrCreateError {
    fn cause(&self) -> Cause {
        match self {
            Self::SystemInFlux
            | Self::RequestResponseOpenError(
                OpenError::HangsInCreation
                | OpenError::IsMarkedForDestruction
                | OpenError::ServiceInCorruptedState
                | OpenError::DoesNotExist,
            )
            | Self::RequestResponseCreateError(
                CreateError::AlreadyExists
                | CreateError::HangsInCreation
                | CreateError::IsBeingCreatedByAnotherInstance
                | CreateError::ServiceInCorruptedState,
            ) => Cause::Transient,
            Self::RequestResponseOpenError(OpenError::ExceedsMaxNumberOfNodes) => Cause::NoPlace,
            _ => Cause::Permanent,
        }
    }
}

impl Refusal for ServerCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedServers {
            Cause::NoPlace
        } else {
            Cause::Permanent
        }
    }
}

impl Refusal for ClientCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedClients {
            Cause::NoPlace
        } else {
            Cause::Permanent
        }
    }
}
