//! Reading streams as arrays.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use shm_bus::Subscriber;
use shm_schemas::{Payload, Stamp};
use zerocopy::FromBytes;

use crate::errors::of_bus;
use crate::pause;
use crate::rows::{self, Row};

/// How often a reader that waits looks: half a period of the daemon.
const POLL: Duration = Duration::from_micros(500);

/// A stream of any payload.
trait Source {
    fn receive<'py>(&mut self, py: Python<'py>, losses: &mut Losses)
    -> PyResult<Bound<'py, PyAny>>;
    fn newest<'py>(
        &mut self,
        py: Python<'py>,
        losses: &mut Losses,
    ) -> PyResult<Option<Bound<'py, PyAny>>>;
    fn has_news(&self) -> bool;
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
        if self.subscriber.has_news() {
            // Enough for all that can wait, so that no row is moved once it is copied.
            rows.reserve_exact(self.most);
            let copied = self
                .subscriber
                .drain(self.most, |payload| rows.push(Row(*payload)));
            copied.map_err(of_bus)?;
        }
        rows.iter().for_each(|row| losses.see(&row.0));
        Ok(rows::array(py, rows))
    }

    fn newest<'py>(
        &mut self,
        py: Python<'py>,
        losses: &mut Losses,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let mut rows: Vec<Row<T>> = Vec::new();
        let seen = |payload: &T| {
            losses.see(payload);
            rows.clear();
            rows.push(Row(*payload));
        };
        self.subscriber.drain(self.most, seen).map_err(of_bus)?;
        if rows.is_empty() {
            return Ok(None);
        }
        rows::array(py, rows).get_item(0).map(Some)
    }

    fn has_news(&self) -> bool {
        self.subscriber.has_news()
    }
}

/// Counts gaps in the sequences of the writers of a stream.
#[derive(Default)]
struct Losses {
    next: HashMap<u64, u64>,
    lost: u64,
}

impl Losses {
    fn see<T: Payload>(&mut self, payload: &T) {
        // Every payload of a stream begins with its stamp.
        let Ok((stamp, _)) = Stamp::read_from_prefix(payload.as_bytes()) else {
            return;
        };
        let next = self
            .next
            .insert(stamp.writer_epoch, stamp.sequence.wrapping_add(1));
        self.lost += next.map_or(0, |next| stamp.sequence.saturating_sub(next));
    }
}

/// Reads a stream of the bus. Each payload is copied once, from shared memory into the array.
///
/// A reader sees what is sent while it exists, and as many payloads from before as the stream keeps. What waits is bounded;
/// a slow reader loses the oldest and `lost` counts them. Readers belong to the thread that made them.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Reader {
    source: Box<dyn Source>,
    losses: Losses,
    /// The service's name on the bus.
    #[pyo3(get)]
    service: String,
}

impl Reader {
    pub(crate) fn new<T: Payload + Send + Sync>(
        bus: &shm_bus::Bus,
        service: &str,
    ) -> PyResult<Self> {
        let line = shm_bus::STREAMS.iter().find(|line| line.service == service);
        let most = line.map_or(1, |line| line.buffer * line.publishers);
        let subscriber = bus.subscriber::<T>(service).map_err(of_bus)?;
        Ok(Self {
            source: Box::new(Typed { subscriber, most }),
            losses: Losses::default(),
            service: service.to_owned(),
        })
    }
}

#[pymethods]
impl Reader {
    /// Everything that waits, oldest first, as a structured array; empty if nothing does. Does not wait.
    fn receive<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.source.receive(py, &mut self.losses)
    }

    /// The newest of what waits, as a record, or None; the older ones are dropped. Does not wait.
    fn newest<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.source.newest(py, &mut self.losses)
    }

    /// Waits until something comes, at most `timeout` seconds, and receives it; an empty array if nothing came.
    #[pyo3(signature = (timeout = 1.0))]
    fn wait<'py>(&mut self, py: Python<'py>, timeout: f64) -> PyResult<Bound<'py, PyAny>> {
        let limit = seconds(timeout)?;
        let begin = Instant::now();
        while !self.source.has_news() && begin.elapsed() < limit {
            pause(py, POLL)?;
        }
        self.receive(py)
    }

    /// Payloads that were sent but did not reach this reader, by gaps in their sequence.
    #[getter]
    fn lost(&self) -> u64 {
        self.losses.lost
    }

    fn __repr__(&self) -> String {
        format!("Reader({:?})", self.service)
    }
}

/// A time that can be waited.
pub(crate) fn seconds(time_s: f64) -> PyResult<Duration> {
    Duration::try_from_secs_f64(time_s).map_err(|_| {
        pyo3::exceptions::PyValueError::new_err(format!(
            "a time was {time_s} s, needs a number from 0 up"
        ))
    })
}
