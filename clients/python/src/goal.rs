//! A running goal.

use std::time::{Duration, Instant};

use atas_client::{GoalProgress, POLL, Session};
use pyo3::exceptions::PyTimeoutError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{GoalClient, PendingGoal, writer_epoch};
use shm_schemas::{GoalRequest, GoalUpdate};

use crate::errors::bus_error;
use crate::own_thread::OwnThread;
use crate::pause;
use crate::reader::seconds;
use crate::rows::{self, Row};

/// A running goal: iterate over it for its updates, or wait for its end.
///
/// Dropping it does not end the goal, unless it was sent `attached`: then the robot holds.
#[pyclass(module = "atas")]
pub(crate) struct Goal {
    pending: OwnThread<PendingGoal>,
    progress: GoalProgress,
    /// Id of the goal, for `Bus.cancel`.
    #[pyo3(get)]
    goal_id: u64,
    _client: OwnThread<GoalClient>,
}

impl Goal {
    pub(crate) fn send(session: &Session, goal: &GoalRequest) -> PyResult<Self> {
        let request = GoalRequest {
            stamp: session.stamp(),
            goal_id: writer_epoch(),
            ..*goal
        };
        let client = session.bus().goal_client().map_err(bus_error)?;
        Ok(Self {
            pending: OwnThread::new(client.send(&request).map_err(bus_error)?),
            progress: GoalProgress::default(),
            goal_id: request.goal_id,
            _client: OwnThread::new(client),
        })
    }

    /// Processes pending updates; returns whether the goal has ended.
    pub(crate) fn has_ended(&mut self) -> PyResult<bool> {
        while self.take()?.is_some() {}
        Ok(self.pending.get()?.has_ended())
    }

    fn take(&mut self) -> PyResult<Option<GoalUpdate>> {
        let update = self.pending.get_mut()?.next().map_err(bus_error)?;
        if let Some(update) = &update {
            self.progress.add(update);
        }
        Ok(update)
    }
}

#[pymethods]
impl Goal {
    /// Returns the updates since the last call (`GoalUpdate`). Does not wait.
    fn updates<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        while let Some(update) = self.take()? {
            rows.push(Row(update));
        }
        Ok(rows::array(py, rows))
    }

    /// Waits for the end, at most `timeout` seconds if given, and returns the `result`. On timeout
    /// it raises TimeoutError, and the goal continues.
    #[pyo3(signature = (timeout = None))]
    fn wait<'py>(&mut self, py: Python<'py>, timeout: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        let (begin, limit) = (Instant::now(), timeout.map(seconds).transpose()?);
        loop {
            while self.take()?.is_some() {}
            if self.pending.get()?.has_ended() {
                return self.result(py);
            }
            if limit.is_some_and(|limit: Duration| begin.elapsed() > limit) {
                let step = self.progress.step().to_owned();
                return Err(PyTimeoutError::new_err(format!(
                    "the goal has not ended: current step {step:?}; wait longer or cancel it"
                )));
            }
            pause(py, POLL)?;
        }
    }

    /// Requests cancellation; updates continue until the final one.
    fn cancel(&self) -> PyResult<()> {
        self.pending.get()?.cancel();
        Ok(())
    }

    /// True if a received update has ended the goal.
    #[getter]
    fn ended(&self) -> PyResult<bool> {
        Ok(self.pending.get()?.has_ended())
    }

    /// State of the goal: `state` (`GoalState`), `step`, `reason` (text), `took_s`, and the
    /// estimates `f1_n`, `f2_n`, `stiffness_n_m`, `friction`, `lifted_m`, `normal_n`.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        goal_dict(py, &self.progress)
    }

    fn __repr__(&self) -> String {
        format!(
            "<atas.Goal {}: {}>",
            self.goal_id,
            goal_words(&self.progress)
        )
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        loop {
            if let Some(update) = self.take()? {
                return Ok(Some(rows::row(py, &update)?));
            }
            if self.pending.get()?.has_ended() {
                return Ok(None);
            }
            pause(py, POLL)?;
        }
    }
}

/// Returns the state of a goal in a few words: `goal running, step lift`.
pub(crate) fn goal_words(progress: &GoalProgress) -> String {
    let last = progress.last();
    if last.goal_id == 0 {
        return "no goal yet".to_owned();
    }
    let state = last.state.name();
    if last.state.is_final() {
        return format!("goal {state} after {:.2} s", progress.took_s());
    }
    match progress.step() {
        "" => format!("goal {state}"),
        step => format!("goal {state}, step {step:?}"),
    }
}

/// Returns the state of a goal as a Python dict.
pub(crate) fn goal_dict<'py>(
    py: Python<'py>,
    progress: &GoalProgress,
) -> PyResult<Bound<'py, PyDict>> {
    let (last, figures) = (progress.last(), progress.figures());
    let reason = if last.reason.is_some() {
        progress.text()
    } else {
        String::new()
    };
    let fields = PyDict::new(py);
    fields.set_item("state", last.state.0)?;
    fields.set_item("step", progress.step())?;
    fields.set_item("reason", reason)?;
    fields.set_item("took_s", progress.took_s())?;
    fields.set_item("f1_n", figures.f1_n)?;
    fields.set_item("f2_n", figures.f2_n)?;
    fields.set_item("stiffness_n_m", figures.stiffness_n_m)?;
    fields.set_item("friction", figures.friction)?;
    fields.set_item("lifted_m", figures.lifted_m)?;
    fields.set_item("normal_n", figures.normal_n)?;
    Ok(fields)
}
