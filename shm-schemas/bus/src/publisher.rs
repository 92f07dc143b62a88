//! Write port of a stream.

use std::fmt;

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::SendError;
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::publisher::{Publisher as IoxPublisher, PublisherCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::CallbackProgression;
use iceoryx2::service::port_factory::PortFactory as _;
use shm_schemas::Payload;

use crate::bus::Bus;
use crate::error::BusError;
use crate::node::{Ipc, Realtime};
use crate::qos::Stream;
use crate::refusal::{loan_text, send_text};
use crate::shortage::{require_space, require_stack};
use crate::stream::{Factory, PATTERN, degradation_action, find_stream};

/// Writer of one stream.
pub struct Publisher<T: Payload> {
    port: IoxPublisher<Ipc, T, ()>,
    stream: &'static Stream,
}

impl Bus {
    /// Opens a writer of a stream in [`crate::STREAMS`].
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if the stream has its writer already;
    /// [`BusError::NoSpace`] if `/dev/shm` is too full.
    pub fn publisher<T: Payload>(&self, service: &str) -> Result<Publisher<T>, BusError> {
        let stream = find_stream::<T>(service)?;
        require_stack(stream.service)?;
        self.make_publisher(stream)
    }

    /// Not inlined: uses its stack after [`require_stack`].
    #[inline(never)]
    fn make_publisher<T: Payload>(
        &self,
        stream: &'static Stream,
    ) -> Result<Publisher<T>, BusError> {
        let member = &self.member;
        let _startup = member.startup()?;
        require_space(stream.service, stream.publisher_bytes())?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_publisher(&factory, member.realtime);
        match member.open_with_recovery(stream.service, PATTERN, create) {
            Ok(port) => Ok(Publisher { port, stream }),
            Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                Err(member.taken_error(stream.service, first_publisher(&factory)))
            }
            Err(e) => Err(member.refused_error(stream.service, &e)),
        }
    }
}

fn first_publisher<T: Payload>(factory: &Factory<T>) -> Option<UniqueNodeId> {
    let mut first = None;
    factory.dynamic_config().list_publishers(|details| {
        first = Some(details.node_id);
        CallbackProgression::Stop
    });
    first
}

fn create_publisher<T: Payload>(
    factory: &Factory<T>,
    realtime: Realtime,
) -> Result<IoxPublisher<Ipc, T, ()>, PublisherCreateError> {
    // Streams overflow, so there is no back-pressure. If a peer misbehaves, the payload is
    // discarded without delay.
    let builder = factory.publisher_builder().max_loaned_samples(1);
    let builder = builder.backpressure_strategy(BackpressureStrategy::DiscardData);
    let degraded = degradation_action(realtime);
    builder
        .set_degradation_handler(move |_, _| degraded)
        .create()
}

impl<T: Payload> Publisher<T> {
    /// Sends a copy of a payload to every reader. Never waits.
    ///
    /// # Errors
    /// [`BusError::Send`] if the shared memory of this process or of a reader is damaged.
    pub fn send(&self, payload: &T) -> Result<(), BusError> {
        let sample = self
            .port
            .loan_uninit()
            .map_err(|e| self.send_error(loan_text(e)))?;
        self.check_sent(sample.write_payload(*payload).send())
    }

    /// Fills a zeroed payload in place and sends it. Never waits.
    ///
    /// # Errors
    /// As [`Publisher::send`].
    pub fn send_with(&self, fill: impl FnOnce(&mut T)) -> Result<(), BusError> {
        let sample = self
            .port
            .loan_uninit()
            .map_err(|e| self.send_error(loan_text(e)))?;
        let mut sample = sample.write_payload(T::new_zeroed());
        fill(sample.payload_mut());
        self.check_sent(sample.send())
    }

    /// Delivers the history to readers that joined since the last payload. Needed by streams with
    /// long pauses.
    ///
    /// # Errors
    /// [`BusError::Send`] if a reader cannot be reached.
    pub fn connect_readers(&self) -> Result<(), BusError> {
        self.port
            .update_connections()
            .map_err(|_| self.send_error("a reader cannot be reached"))
    }

    fn check_sent(&self, sent: Result<usize, SendError>) -> Result<(), BusError> {
        sent.map(|_readers| ())
            .map_err(|e| self.send_error(send_text(e)))
    }

    fn send_error(&self, why: &'static str) -> BusError {
        BusError::Send {
            service: self.stream.service,
            why,
        }
    }
}

impl<T: Payload> fmt::Debug for Publisher<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Publisher({})", self.stream.service)
    }
}
