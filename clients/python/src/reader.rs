//! Reads bus services as arrays.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use shm_bus::{StreamPayload, Subscriber};
use shm_schemas::{Payload, Stamp};
use zerocopy::FromBytes;

use crate::errors::bus_error;
use crate::own_thread::OwnThread;
use crate::pause;
use crate::rows::{self, Row};

/// Poll interval of a waiting reader: half the period of the daemon.
const POLL: Duration = Duration::from_micros(500);

/// A stream of any payload type.
trait Source {
    fn receive<'py>(&mut self, py: Python<'py>, losses: &mut Losses)
    -> PyResult<Bound<'py, PyAny>>;
    fn newest<'py>(
        &mut self,
        py: Python<'py>,
        losses: &mut Losses,
    ) -> PyResult<Option<Bound<'py, PyAny>>>;
    fn has_payload(&self) -> bool;
}

struct Typed<T: Payload> {
    subscriber: Subscriber<T>,
    most: usize,
}

impl<T: Payload + Send + Sync> Source for Typed<T> {
    fn receive<'py>(
        &mut self,
        py: Python<'py>,
        losses: &mut Losses,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut rows: Vec<Row<T>> = Vec::new();
        if self.subscriber.has_payload() {
            // Reserves the maximum number of queued payloads, so that no copied row moves.
            rows.reserve_exact(self.most);
            let copied = self
                .subscriber
                .drain(self.most, |payload| rows.push(Row(*payload)));
            copied.map_err(bus_error)?;
        }
        rows.iter().for_each(|row| losses.count(&row.0));
        Ok(rows::array(py, rows))
    }

    fn newest<'py>(
        &mut self,
        py: Python<'py>,
        losses: &mut Losses,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let mut rows: Vec<Row<T>> = Vec::new();
        let seen = |payload: &T| {
            losses.count(payload);
            rows.clear();
            rows.push(Row(*payload));
        };
        self.subscriber.drain(self.most, seen).map_err(bus_error)?;
        if rows.is_empty() {
            return Ok(None);
        }
        rows::array(py, rows).get_item(0).map(Some)
    }

    fn has_payload(&self) -> bool {
        self.subscriber.has_payload()
    }
}

/// Counts gaps in the sequences of a stream's writers.
#[derive(Default)]
struct Losses {
    next: HashMap<u64, u64>,
    lost: u64,
}

impl Losses {
    fn count<T: Payload>(&mut self, payload: &T) {
        // Every payload begins with its stamp.
        let Ok((stamp, _)) = Stamp::read_from_prefix(payload.as_bytes()) else {
            return;
        };
        let next = self
            .next
            .insert(stamp.writer_epoch, stamp.sequence.wrapping_add(1));
        let gap = next.map_or(0, |next| stamp.sequence.saturating_sub(next));
        self.lost = self.lost.saturating_add(gap);
    }
}

/// Reads a service of the bus. Each payload is copied once, from shared memory into the array.
///
/// A reader receives the payloads that are sent while it exists, and earlier ones as far as the
/// service keeps them. The queue is bounded: a slow reader loses the oldest payloads, counted in
/// `lost`. A reader belongs to the thread that created it.
#[pyclass(module = "atas")]
pub(crate) struct Reader {
    source: OwnThread<Box<dyn Source>>,
    losses: Losses,
    /// Name of the service on the bus.
    #[pyo3(get)]
    service: String,
}

impl Reader {
    pub(crate) fn new<T: StreamPayload + Send + Sync>(
        bus: &shm_bus::Bus,
        service: &str,
    ) -> PyResult<Self> {
        let line = shm_bus::STREAMS.iter().find(|line| line.service == service);
        let most = line.map_or(1, |line| line.buffer * line.publishers);
        let subscriber = bus.subscriber::<T>(service).map_err(bus_error)?;
        Ok(Self {
            source: OwnThread::new(Box::new(Typed { subscriber, most })),
            losses: Losses::default(),
            service: service.to_owned(),
        })
    }
}

#[pymethods]
impl Reader {
    /// Returns all queued payloads, oldest first, as a structured array; may be empty. Does not
    /// wait.
    fn receive<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.source.get_mut()?.receive(py, &mut self.losses)
    }

    /// Returns the newest queued payload as a record, or None; drops older ones. Does not wait.
    fn newest<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.source.get_mut()?.newest(py, &mut self.losses)
    }

    /// Waits for payloads, at most `timeout` seconds, and returns them; an empty array on timeout.
    #[pyo3(signature = (timeout = 1.0))]
    fn wait<'py>(&mut self, py: Python<'py>, timeout: f64) -> PyResult<Bound<'py, PyAny>> {
        let limit = seconds(timeout)?;
        let begin = Instant::now();
        while !self.source.get()?.has_payload() && begin.elapsed() < limit {
            pause(py, POLL)?;
        }
        self.receive(py)
    }

    /// Number of payloads that did not reach this reader, from gaps in their sequence.
    #[getter]
    fn lost(&self) -> u64 {
        self.losses.lost
    }

    fn __repr__(&self) -> String {
        format!(
            "<atas.Reader of {:?}: {} lost>",
            self.service, self.losses.lost
        )
    }
}

/// Converts a waiting time.
pub(crate) fn seconds(time_s: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(time_s).map_err(|_| {
        pyo3::exceptions::PyValueError::new_err(format!(
            "invalid time {time_s} s; needs a number of at least 0"
        ))
    })
}
