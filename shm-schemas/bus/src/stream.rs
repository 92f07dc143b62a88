//! Opening of streams.

use iceoryx2::port::DegradationAction;
use iceoryx2::prelude::{MessagingPattern, ServiceName};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use shm_schemas::Payload;

use crate::error::BusError;
use crate::member::Member;
use crate::node::{Ipc, Realtime};
use crate::qos::{BORROWED_MAX, Stream};

pub(crate) const PATTERN: MessagingPattern = MessagingPattern::PublishSubscribe;

pub(crate) type Factory<T> = PortFactory<Ipc, T, ()>;

impl Member {
    pub(crate) fn open_stream<T: Payload>(
        &self,
        stream: &'static Stream,
    ) -> Result<Factory<T>, BusError> {
        let name =
            ServiceName::new(stream.service).map_err(|e| self.refused_error(stream.service, &e))?;
        let open = || {
            let service = self.node.service_builder(&name).publish_subscribe::<T>();
            service
                .enable_safe_overflow(true)
                .history_size(stream.history)
                .subscriber_max_buffer_size(stream.buffer)
                .subscriber_max_borrowed_samples(BORROWED_MAX)
                .max_publishers(stream.publishers)
                .max_subscribers(stream.subscribers)
                .max_nodes(stream.nodes())
                .open_or_create()
        };
        self.open_with_recovery(stream.service, PATTERN, open)
            .map_err(|e| self.refused_error(stream.service, &e))
    }
}

pub(crate) fn find_stream<T: Payload>(service: &str) -> Result<&'static Stream, BusError> {
    let unknown = || BusError::Unknown {
        service: service.to_owned(),
        payload: T::TYPE_NAME,
    };
    Stream::find::<T>(service).ok_or_else(unknown)
}

/// Unreachable peers are logged, except on real-time threads.
pub(crate) fn degradation_action(realtime: Realtime) -> DegradationAction {
    match realtime {
        Realtime::Yes => DegradationAction::Ignore,
        Realtime::No => DegradationAction::Warn,
    }
}
