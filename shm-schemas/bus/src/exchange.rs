//! Request-response services, the basis of [`crate::goal`] and [`crate::control`].
//!
//! At most one server. A request whose client has gone is not delivered. Calls never wait for the
//! other side: buffers overflow and lose the oldest entry, so the last response always arrives.

use iceoryx2::prelude::{MessagingPattern, ServiceName};
use iceoryx2::service::port_factory::request_response::PortFactory;
use shm_schemas::Payload;

use crate::error::BusError;
use crate::member::Member;
use crate::node::Ipc;

/// Settings of one request-response service.
#[derive(Clone, Copy, Debug)]
pub struct Exchange {
    /// Service name.
    pub service: &'static str,
    /// Type names of the request and of its responses.
    pub payloads: [&'static str; 2],
    /// Maximum number of clients.
    pub clients: usize,
    /// Maximum number of open requests per client.
    pub open_requests: usize,
    /// Capacity of the client's response buffer; the oldest response is lost on overflow.
    pub responses: usize,
}

impl Exchange {
    /// Maximum number of processes that have the service open.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        1 + self.clients + SPARE_NODES
    }
}

/// Nodes beyond server and clients, because a dead node keeps its slot until a clean-up. Design
/// choice.
const SPARE_NODES: usize = 4;
pub(crate) const PATTERN: MessagingPattern = MessagingPattern::RequestResponse;

pub(crate) type Factory<Q, A> = PortFactory<Ipc, Q, (), A, ()>;

impl Member {
    pub(crate) fn open_exchange<Q: Payload, A: Payload>(
        &self,
        exchange: Exchange,
    ) -> Result<Factory<Q, A>, BusError> {
        let name = ServiceName::new(exchange.service)
            .map_err(|e| self.refused_error(exchange.service, &e))?;
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
                .max_nodes(exchange.nodes())
                .open_or_create()
        };
        self.open_with_recovery(exchange.service, PATTERN, open)
            .map_err(|e| self.refused_error(exchange.service, &e))
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
pub(crate) use debug_by_service;
