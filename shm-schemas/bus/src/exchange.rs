//! Request and response, under [`crate::goal`] and [`crate::control`].
//!
//! One server at most. Requests that nobody waits for are not delivered. Neither side ever waits for the other inside
//! a call: buffers overflow, and because the oldest is lost, the last response always arrives.

use iceoryx2::prelude::{MessagingPattern, ServiceName};
use iceoryx2::service::port_factory::request_response::PortFactory;
use shm_schemas::Payload;

use crate::error::BusError;
use crate::member::Member;
use crate::node::Ipc;

/// How one request-response service is carried.
#[derive(Clone, Copy, Debug)]
pub struct Exchange {
    /// Name of the service.
    pub service: &'static str,
    /// Type names of the request and of its responses.
    pub payloads: [&'static str; 2],
    /// Most clients at a time.
    pub clients: usize,
    /// Most open requests of one client.
    pub open_requests: usize,
    /// Responses that wait for the client; more, and the oldest are lost.
    pub responses: usize,
}

impl Exchange {
    /// Most processes that may have the service open.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        1 + self.clients + SPARE_NODES
    }
}

/// Nodes beyond the server and the clients: dead ones keep their place until someone cleans up. Ours.
const SPARE_NODES: usize = 4;
pub(crate) const PATTERN: MessagingPattern = MessagingPattern::RequestResponse;

pub(crate) type Factory<Q, A> = PortFactory<Ipc, Q, (), A, ()>;

impl Member {
    pub(crate) fn open_exchange<Q: Payload, A: Payload>(
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
                .max_nodes(exchange.nodes())
                .open_or_create()
        };
        self.open_despite_remains(exchange.service, PATTERN, open)
            .map_err(|e| self.refused(exchange.service, &e))
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
