//! Read port of a stream.

use std::fmt;

use iceoryx2::port::ReceiveError;
use iceoryx2::port::subscriber::{Subscriber as IoxSubscriber, SubscriberCreateError};
use shm_schemas::Payload;

use crate::bus::Bus;
use crate::error::BusError;
use crate::node::{Ipc, Realtime};
use crate::qos::Stream;
use crate::shortage::{require_space, require_stack};
use crate::stream::{Factory, PATTERN, known, on_degradation};

/// Reader of one stream.
pub struct Subscriber<T: Payload> {
    port: IoxSubscriber<Ipc, T, ()>,
    stream: &'static Stream,
}

impl Bus {
    /// Opens a reader of a stream in [`crate::STREAMS`]. Writers may start and end at any time.
    ///
    /// # Errors
    /// [`BusError::Full`] if all reader slots are taken; [`BusError::NoSpace`] if `/dev/shm` is too
    /// full.
    pub fn subscriber<T: Payload>(&self, service: &str) -> Result<Subscriber<T>, BusError> {
        let stream = known::<T>(service)?;
        require_stack(stream.service)?;
        self.make_subscriber(stream)
    }

    /// Not inlined: uses its stack after [`require_stack`].
    #[inline(never)]
    fn make_subscriber<T: Payload>(
        &self,
        stream: &'static Stream,
    ) -> Result<Subscriber<T>, BusError> {
        let member = &self.member;
        let _startup = member.startup()?;
        require_space(stream.service, 0)?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_subscriber(&factory, member.realtime);
        match member.open_despite_remains(stream.service, PATTERN, create) {
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

impl<T: Payload> Subscriber<T> {
    /// Copies the newest payload into `out` and drops older ones. Returns false, with `out`
    /// unchanged, if there is none. Never waits, never allocates.
    ///
    /// # Errors
    /// [`BusError::Receive`] if the shared memory of a writer cannot be read.
    pub fn newest(&mut self, out: &mut T) -> Result<bool, BusError> {
        let mut newest = None;
        // Bounded, so that a flooding writer cannot block the reader.
        for _ in 0..self.capacity() {
            match self.port.receive().map_err(|e| self.unreceived(&e))? {
                Some(sample) => newest = Some(sample),
                None => break,
            }
        }
        Ok(newest.map(|sample| *out = *sample).is_some())
    }

    /// Passes at most `max` payloads to `each`, oldest first, and drops them. Returns their number.
    /// Never waits, never allocates.
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

    /// Returns true if a payload is waiting; false if the writer cannot be read. Never waits, never
    /// allocates.
    #[must_use]
    pub fn has_news(&self) -> bool {
        self.port.has_samples().unwrap_or(false)
    }

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

impl<T: Payload> fmt::Debug for Subscriber<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Subscriber({})", self.stream.service)
    }
}
