//! Write port of a stream.

use std::fmt;
use std::rc::Rc;

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
use crate::member::Member;
use crate::node::{Ipc, Realtime};
use crate::qos::Stream;
use crate::refusal::{loan_text, send_text};
use crate::shortage::require_space;
use crate::stream::{Factory, PATTERN, degradation_action};

/// Writer of one stream.
pub struct Publisher<T> {
    port: Box<dyn WritePort<T>>,
    stream: &'static Stream,
    /// Dropped last: its departure may remove the files of the bus.
    _member: Rc<Member>,
}

/// Write port of iceoryx2. Errors are causes.
trait WritePort<T> {
    fn send(&self, payload: &T) -> Result<(), &'static str>;
    fn send_with(&self, fill: &mut dyn FnMut(&mut T)) -> Result<(), &'static str>;
    fn connect_readers(&self) -> Result<(), &'static str>;
}

impl Bus {
    /// Not inlined: uses its stack after [`crate::shortage::require_stack`].
    #[inline(never)]
    pub(crate) fn make_publisher<T: Payload>(
        &self,
        stream: &'static Stream,
    ) -> Result<Publisher<T>, BusError> {
        let member = &self.member;
        let _startup = member.startup()?;
        require_space(stream.service, stream.publisher_bytes())?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_publisher(&factory, member.realtime);
        match member.open_with_recovery(stream.service, PATTERN, create) {
            Ok(port) => Ok(Publisher {
                port: Box::new(port),
                stream,
                _member: Rc::clone(member),
            }),
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

impl<T: Payload> WritePort<T> for IoxPublisher<Ipc, T, ()> {
    fn send(&self, payload: &T) -> Result<(), &'static str> {
        let sample = self.loan_uninit().map_err(loan_text)?;
        checked(sample.write_payload(*payload).send())
    }

    fn send_with(&self, fill: &mut dyn FnMut(&mut T)) -> Result<(), &'static str> {
        let sample = self.loan_uninit().map_err(loan_text)?;
        let mut sample = sample.write_payload(T::new_zeroed());
        fill(sample.payload_mut());
        checked(sample.send())
    }

    fn connect_readers(&self) -> Result<(), &'static str> {
        self.update_connections()
            .map_err(|_| "a reader cannot be reached")
    }
}

fn checked(sent: Result<usize, SendError>) -> Result<(), &'static str> {
    sent.map(|_readers| ()).map_err(send_text)
}

impl<T> Publisher<T> {
    /// Sends a copy of a payload to every reader. Never waits.
    ///
    /// # Errors
    /// [`BusError::Send`] if the shared memory of this process or of a reader is damaged.
    pub fn send(&self, payload: &T) -> Result<(), BusError> {
        self.port.send(payload).map_err(|why| self.send_error(why))
    }

    /// Fills a zeroed payload in place and sends it. Never waits.
    ///
    /// # Errors
    /// As [`Publisher::send`].
    pub fn send_with(&self, fill: impl FnOnce(&mut T)) -> Result<(), BusError> {
        let mut fill = Some(fill);
        let mut fill_once = |payload: &mut T| {
            if let Some(fill) = fill.take() {
                fill(payload);
            }
        };
        self.port
            .send_with(&mut fill_once)
            .map_err(|why| self.send_error(why))
    }

    /// Delivers the history to readers that joined since the last payload. Needed by streams with
    /// long pauses.
    ///
    /// # Errors
    /// [`BusError::Send`] if a reader cannot be reached.
    pub fn connect_readers(&self) -> Result<(), BusError> {
        self.port
            .connect_readers()
            .map_err(|why| self.send_error(why))
    }

    fn send_error(&self, why: &'static str) -> BusError {
        BusError::Send {
            service: self.stream.service,
            why,
        }
    }
}

impl<T> fmt::Debug for Publisher<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Publisher({})", self.stream.service)
    }
}
