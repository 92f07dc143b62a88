//! Server side of a request-response service.

use std::fmt;
use std::rc::Rc;

use iceoryx2::active_request::ActiveRequest;
use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::server::Server as IoxServer;
use iceoryx2::prelude::CallbackProgression;
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::server::ServerCreateError;
use shm_schemas::Payload;

use crate::bus::Bus;
use crate::error::BusError;
use crate::exchange::{Exchange, Factory, PATTERN, debug_by_service};
use crate::member::Member;
use crate::node::Ipc;
use crate::opaque::Opaque;
use crate::refusal::{loan_text, send_text};
use crate::shortage::{require_space, require_stack};

pub(crate) struct Server<Q: Payload, A: Payload> {
    port: Opaque<IoxServer<Ipc, Q, (), A, ()>>,
    service: &'static str,
    /// Dropped last: its departure may remove the files of the bus.
    _member: Rc<Member>,
}

/// Open request at the server. Dropping it ends the exchange.
pub(crate) struct Request<Q: Payload, A: Payload> {
    request: Opaque<ActiveRequest<Ipc, Q, (), A, ()>>,
    service: &'static str,
}

impl Bus {
    pub(crate) fn server<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Server<Q, A>, BusError> {
        require_stack(exchange.service)?;
        self.make_server(exchange)
    }

    /// Not inlined: uses its stack after [`require_stack`].
    #[inline(never)]
    fn make_server<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Server<Q, A>, BusError> {
        let (member, service) = (&self.member, exchange.service);
        let _startup = member.startup()?;
        require_space(service, 0)?;
        let factory = member.open_exchange::<Q, A>(exchange)?;
        match member.open_with_recovery(service, PATTERN, || create_server(&factory)) {
            Ok(port) => Ok(Server {
                port: Opaque::new(port),
                service,
                _member: Rc::clone(member),
            }),
            Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                Err(member.taken_error(service, first_server(&factory)))
            }
            Err(e) => Err(member.refused_error(service, &e)),
        }
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

impl<Q: Payload, A: Payload> Server<Q, A> {
    /// The next request whose client still waits.
    pub(crate) fn poll(&self) -> Result<Option<Request<Q, A>>, BusError> {
        let received = self.port.receive();
        let failed = |_| BusError::Receive {
            service: self.service,
            why: "a client's shared memory cannot be opened",
        };
        Ok(received.map_err(failed)?.map(|request| Request {
            request: Opaque::new(request),
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

    /// Returns true if the client requested an end.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.request.has_disconnect_hint()
    }

    /// Returns true while the client waits. A killed client counts as waiting until a clean-up.
    pub(crate) fn is_awaited(&self) -> bool {
        self.request.is_connected()
    }
}

debug_by_service!(Server: service, Request: service);
