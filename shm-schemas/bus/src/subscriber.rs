//! Read port of a stream.

use std::fmt;
use std::rc::Rc;

use iceoryx2::port::ReceiveError;
use iceoryx2::port::subscriber::{Subscriber as IoxSubscriber, SubscriberCreateError};
use shm_schemas::Payload;

use crate::bus::Bus;
use crate::error::BusError;
use crate::member::Member;
use crate::node::{Ipc, Realtime};
use crate::qos::Stream;
use crate::shortage::require_space;
use crate::stream::{Factory, PATTERN, degradation_action};

/// Reader of one stream.
pub struct Subscriber<T> {
    port: Box<dyn ReadPort<T>>,
    stream: &'static Stream,
    /// Dropped last: its departure may remove the files of the bus.
    _member: Rc<Member>,
}

/// Read port of iceoryx2.
trait ReadPort<T> {
    /// Copies the newest of at most `max` payloads into `out`. Returns false if there is none.
    fn newest(&self, max: usize, out: &mut T) -> Result<bool, ReceiveError>;
    /// Passes at most `max` payloads to `each` and returns their number.
    fn drain(&self, max: usize, each: &mut dyn FnMut(&T)) -> Result<usize, ReceiveError>;
    fn has_payload(&self) -> bool;
}

impl Bus {
    /// Not inlined: uses its stack after [`crate::shortage::require_stack`].
    #[inline(never)]
    pub(crate) fn make_subscriber<T: Payload>(
        &self,
        stream: &'static Stream,
    ) -> Result<Subscriber<T>, BusError> {
        let member = &self.member;
        let _startup = member.startup()?;
        require_space(stream.service, 0)?;
        let factory = member.open_stream::<T>(stream)?;
        let create = || create_subscriber(&factory, member.realtime);
        match member.open_with_recovery(stream.service, PATTERN, create) {
            Ok(port) => Ok(Subscriber {
                port: Box::new(port),
                stream,
                _member: Rc::clone(member),
            }),
            Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) => Err(BusError::Full {
                service: stream.service,
                what: "readers",
                limit: stream.subscribers,
            }),
            Err(e) => Err(member.refused_error(stream.service, &e)),
        }
    }
}

fn create_subscriber<T: Payload>(
    factory: &Factory<T>,
    realtime: Realtime,
) -> Result<IoxSubscriber<Ipc, T, ()>, SubscriberCreateError> {
    let degraded = degradation_action(realtime);
    factory
        .subscriber_builder()
        .set_degradation_handler(move |_, _| degraded)
        .create()
}

impl<T: Payload> ReadPort<T> for IoxSubscriber<Ipc, T, ()> {
    fn newest(&self, max: usize, out: &mut T) -> Result<bool, ReceiveError> {
        let mut newest = None;
        for _ in 0..max {
            match self.receive()? {
                Some(sample) => newest = Some(sample),
                None => break,
            }
        }
        Ok(newest.map(|sample| *out = *sample).is_some())
    }

    fn drain(&self, max: usize, each: &mut dyn FnMut(&T)) -> Result<usize, ReceiveError> {
        for count in 0..max {
            match self.receive()? {
                Some(sample) => each(&sample),
                None => return Ok(count),
            }
        }
        Ok(max)
    }

    fn has_payload(&self) -> bool {
        self.has_samples().unwrap_or(false)
    }
}

impl<T> Subscriber<T> {
    /// Copies the newest payload into `out` and drops older ones. Returns false, with `out`
    /// unchanged, if there is none. Never waits, never allocates.
    ///
    /// # Errors
    /// [`BusError::Receive`] if the shared memory of a writer cannot be read.
    pub fn newest(&mut self, out: &mut T) -> Result<bool, BusError> {
        // Bounded, so that a flooding writer cannot block the reader.
        let newest = self.port.newest(self.capacity(), out);
        newest.map_err(|e| self.receive_error(&e))
    }

    /// Passes at most `max` payloads to `each`, oldest first, and drops them. Returns their number.
    /// Never waits, never allocates.
    ///
    /// # Errors
    /// [`BusError::Receive`] if the shared memory of a writer cannot be read.
    ///
    /// ```
    /// use shm_bus::{Bus, FreshBus, Realtime};
    /// use shm_schemas::{TickReport, service};
    ///
    /// let name = FreshBus::new("docs");
    /// let bus = Bus::open(&name, "daemon", Realtime::No)?;
    /// let mut reports = bus.subscriber::<TickReport>(service::TICK_REPORT)?;
    /// let daemon = bus.publisher::<TickReport>(service::TICK_REPORT)?;
    /// for tick in 0..3 {
    ///     daemon.send(&TickReport { tick, ..TickReport::default() })?;
    /// }
    /// let mut ticks = Vec::new();
    /// reports.drain(64, |report| ticks.push(report.tick))?;
    /// assert_eq!(ticks, [0, 1, 2]);
    /// # Ok::<(), shm_bus::BusError>(())
    /// ```
    pub fn drain(&mut self, max: usize, mut each: impl FnMut(&T)) -> Result<usize, BusError> {
        let count = self.port.drain(max, &mut each);
        count.map_err(|e| self.receive_error(&e))
    }

    /// Returns true if a payload is waiting; false if the writer cannot be read. Never waits, never
    /// allocates.
    #[must_use]
    pub fn has_payload(&self) -> bool {
        self.port.has_payload()
    }

    fn capacity(&self) -> usize {
        self.stream.buffer * self.stream.publishers
    }

    fn receive_error(&self, error: &ReceiveError) -> BusError {
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

impl<T> fmt::Debug for Subscriber<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Subscriber({})", self.stream.service)
    }
}
