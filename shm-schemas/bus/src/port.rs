//! Streams: typed publishers and subscribers.

use std::fmt;

use iceoryx2::identifiers::UniqueNodeId;
use iceoryx2::port::backpressure_strategy::BackpressureStrategy;
use iceoryx2::port::publisher::{Publisher as IoxPublisher, PublisherCreateError};
use iceoryx2::port::subscriber::{Subscriber as IoxSubscriber, SubscriberCreateError};
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{DegradationAction, LoanError, ReceiveError, SendError};
use iceoryx2::prelude::{CallbackProgression, MessagingPattern, ServiceName};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError as CreateError, PublishSubscribeOpenError as OpenError,
    PublishSubscribeOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use shm_schemas::Payload;

use crate::BusError;
use crate::bus::{Bus, Cause, Ipc, Member, Realtime, Refusal, require_space};
use crate::qos::{BORROWED, Stream};

const PATTERN: MessagingPattern = MessagingPattern::PublishSubscribe;

type Factory<T> = PortFactory<Ipc, T, ()>;

/// Writes one stream.
pub struct Publisher<T: Payload> {
    port: IoxPublisher<Ipc, T, ()>,
    stream: &'static Stream,
}

/// Reads one stream.
pub struct Subscriber<T: Payload> {
    port: IoxSubscriber<Ipc, T, ()>,
    stream: &'static Stream,
}

impl Bus {
    /// Begins to write a stream of the table [`crate::STREAMS`].
    ///
    /// # Errors
    /// [`BusError::Taken`], naming the process, if the stream has its writer already; [`BusError::NoSpace`] if
    /// `/dev/shm` is too full.
    pub fn publisher<T: Payload>(&self, service: &str) -> Result<Publisher<T>, BusError> {
        let (member, stream) = (&self.member, line::<T>(service)?);
        let _startup = member.startup()?;
        require_space(stream.service, stream.publisher_bytes())?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_publisher(&factory, member.realtime);
        match member.persist(stream.service, PATTERN, create) {
            Ok(port) => Ok(Publisher { port, stream }),
            Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                Err(member.taken_by(stream.service, first_publisher(&factory)))
            }
            Err(e) => Err(member.refused(stream.service, &e)),
        }
    }

    /// Begins to read a stream of the table [`crate::STREAMS`]. The writer need not exist yet, and may come and go.
    ///
    /// # Errors
    /// [`BusError::Full`] if all places for readers are taken; [`BusError::NoSpace`] if `/dev/shm` is too full.
    pub fn subscriber<T: Payload>(&self, service: &str) -> Result<Subscriber<T>, BusError> {
        let (member, stream) = (&self.member, line::<T>(service)?);
        let _startup = member.startup()?;
        require_space(stream.service, 0)?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_subscriber(&factory, member.realtime);
        match member.persist(stream.service, PATTERN, create) {
            Ok(port) => Ok(Subscriber { port, stream }),
            Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) => Err(BusError::Full {
                service: stream.service,
                what: "readers",
                limit: stream.subscribers,
            }),
            Err(e) => Err(member.refused(stream.service, &e)),
        }
    }
}

impl Member {
    fn open_stream<T: Payload>(&self, stream: &'static Stream) -> Result<Factory<T>, BusError> {
        let name =
            ServiceName::new(stream.service).map_err(|e| self.refused(stream.service, &e))?;
        let open = || {
            let service = self.node.service_builder(&name).publish_subscribe::<T>();
            service
                .enable_safe_overflow(true)
                .history_size(stream.history)
                .subscriber_max_buffer_size(stream.buffer)
                .subscriber_max_borrowed_samples(BORROWED)
                .max_publishers(stream.publishers)
                .max_subscribers(stream.subscribers)
                .max_nodes(stream.nodes())
                .open_or_create()
        };
        self.persist(stream.service, PATTERN, open)
            .map_err(|e| self.refused(stream.service, &e))
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

fn line<T: Payload>(service: &str) -> Result<&'static Stream, BusError> {
    let unknown = || BusError::Unknown {
        service: service.to_owned(),
        payload: T::TYPE_NAME,
    };
    Stream::of::<T>(service).ok_or_else(unknown)
}

fn create_publisher<T: Payload>(
    factory: &Factory<T>,
    realtime: Realtime,
) -> Result<IoxPublisher<Ipc, T, ()>, PublisherCreateError> {
    // Streams overflow, so there is no back-pressure; should a peer misbehave, its payload is lost, not our time.
    let builder = factory.publisher_builder().max_loaned_samples(1);
    let builder = builder.backpressure_strategy(BackpressureStrategy::DiscardData);
    let degraded = on_degradation(realtime);
    builder
        .set_degradation_handler(move |_, _| degraded)
        .create()
}

fn create_subscriber<T: Payload>(
    factory: &Factory<T>,
    realtime: Realtime,
) -> Result<IoxSubscriber<Ipc, T, ()>, SubscriberCreateError> {
    let degraded = on_degradation(realtime);
    factory
        .subscriber_builder()
        .set_degradation_handler(move |_, _| degraded)
        .create()
}

/// A peer that cannot be reached is logged, but not on a tick.
fn on_degradation(realtime: Realtime) -> DegradationAction {
    match realtime {
        Realtime::Yes => DegradationAction::Ignore,
        Realtime::No => DegradationAction::Warn,
    }
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
            .map_err(|e| self.unsent(loan_text(e)))?;
        self.delivered(sample.write_payload(*payload).send())
    }

    /// Fills a payload, zero at first, where the readers will find it, and sends it. Never waits.
    ///
    /// # Errors
    /// As [`Publisher::send`].
    pub fn send_with(&self, fill: impl FnOnce(&mut T)) -> Result<(), BusError> {
        let sample = self
            .port
            .loan_uninit()
            .map_err(|e| self.unsent(loan_text(e)))?;
        let mut sample = sample.write_payload(T::new_zeroed());
        fill(sample.payload_mut());
        self.delivered(sample.send())
    }

    /// Lets readers that joined since the last payload have the history now. Only streams with long pauses need it.
    ///
    /// # Errors
    /// [`BusError::Send`] if a reader cannot be reached.
    pub fn greet(&self) -> Result<(), BusError> {
        self.port
            .update_connections()
            .map_err(|_| self.unsent("a reader cannot be reached"))
    }

    fn delivered(&self, sent: Result<usize, SendError>) -> Result<(), BusError> {
        sent.map(|_readers| ())
            .map_err(|e| self.unsent(send_text(e)))
    }

    fn unsent(&self, why: &'static str) -> BusError {
        BusError::Send {
            service: self.stream.service,
            why,
        }
    }
}

impl<T: Payload> Subscriber<T> {
    /// Copies the newest payload that waits into `out` and drops the older ones. False, and `out` unchanged, if none
    /// waits. Never waits, never allocates.
    ///
    /// # Errors
    /// [`BusError::Receive`] if the shared memory of a writer cannot be read.
    pub fn newest(&mut self, out: &mut T) -> Result<bool, BusError> {
        let mut newest = None;
        // Bounded, because a writer that floods must not keep the reader here.
        for _ in 0..self.capacity() {
            match self.port.receive().map_err(|e| self.unreceived(&e))? {
                Some(sample) => newest = Some(sample),
                None => break,
            }
        }
        Ok(newest.map(|sample| *out = *sample).is_some())
    }

    /// Shows at most `max` waiting payloads to `each`, oldest first, and drops them. Returns how many. Never waits,
    /// never allocates.
    ///
    /// # Errors
    /// [`BusError::Receive`] if the shared memory of a writer cannot be read.
    pub fn drain(&mut self, max: usize, mut each: impl FnMut(&T)) -> Result<usize, BusError> {
        for count in 0..max {
            match self.port.receive().map_err(|e| self.unreceived(&e))? {
                Some(sample) => each(&sample),
                None => return Ok(count),
            }
        }
        Ok(max)
    }

    /// Most payloads that can wait.
    fn capacity(&self) -> usize {
        self.stream.buffer * self.stream.publishers
    }

    fn unreceived(&self, error: &ReceiveError) -> BusError {
        let why = match error {
            ReceiveError::ExceedsMaxBorrows => "too many payloads are held",
            ReceiveError::ConnectionFailure(_) => "a writer's shared memory cannot be opened",
        };
        BusError::Receive {
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

impl<T: Payload> fmt::Debug for Subscriber<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Subscriber({})", self.stream.service)
    }
}

/// Texts instead of formatting, because these errors can arise on a tick.
pub(crate) fn send_text(error: SendError) -> &'static str {
    match error {
        SendError::LoanError(error) => loan_text(error),
        SendError::ConnectionCorrupted => "a connection is damaged",
        SendError::ConnectionError(_) => "a reader cannot be reached",
        _ => "iceoryx2 failed inside",
    }
}

pub(crate) fn loan_text(error: LoanError) -> &'static str {
    match error {
        LoanError::OutOfMemory => "its shared memory is used up",
        LoanError::ExceedsMaxLoans => "another payload is still being filled",
        _ => "iceoryx2 failed inside",
    }
}

impl Refusal for OpenOrCreateError {
    fn cause(&self) -> Cause {
        match self {
            Self::SystemInFlux
            | Self::PublishSubscribeOpenError(
                OpenError::HangsInCreation
                | OpenError::IsMarkedForDestruction
                | OpenError::ServiceInCorruptedState
                | OpenError::DoesNotExist,
            )
            | Self::PublishSubscribeCreateError(
                CreateError::AlreadyExists
                | CreateError::HangsInCreation
                | CreateError::IsBeingCreatedByAnotherInstance
                | CreateError::ServiceInCorruptedState,
            ) => Cause::Transient,
            Self::PublishSubscribeOpenError(OpenError::ExceedsMaxNumberOfNodes) => Cause::NoPlace,
            _ => Cause::Permanent,
        }
    }
}

impl Refusal for PublisherCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedPublishers {
            Cause::NoPlace
        } else {
            Cause::Permanent
        }
    }
}

impl Refusal for SubscriberCreateError {
    fn cause(&self) -> Cause {
        if *self == Self::ExceedsMaxSupportedSubscribers {
            Cause::NoPlace
        } else {
            Cause::Permanent
        }
    }
}
