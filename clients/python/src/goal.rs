//! A goal on its way.

use std::time::{Duration, Instant};

use atas_client::{GoalProgress, POLL, Session};
use pyo3::exceptions::PyTimeoutError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{GoalClient, PendingGoal, writer_epoch};
use shm_schemas::{GoalRequest, GoalUpdate};

use crate::errors::of_bus;
use crate::pause;
use crate::reader::seconds;
use crate::rows::{self, Row};

/// A goal on its way: iterate over it for its updates, or wait for its end.
///
/// Dropping it does not end the goal, unless it was sent `attached`: then the robot holds.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Goal {
    pending: PendingGoal,
    progress: GoalProgress,
    /// The goal's id, for `Bus.cancel`.
    #[pyo3(get)]
    goal_id: u64,
    _client: GoalClient,
}

impl Goal {
    pub(crate) fn send(session: &Session, goal: &GoalRequest) -> PyResult<Self> {
        let request = GoalRequest {
            stamp: session.stamp(),
            goal_id: writer_epoch(),
            ..*goal
        };
        let client = session.bus().goal_client().map_err(of_bus)?;
        Ok(Self {
            pending: client.send(&request).map_err(of_bus)?,
            progress: GoalProgress::default(),
            goal_id: request.goal_id,
            _client: client,
        })
    }

    /// Takes in what came; whether the goal has ended then.
    pub(crate) fn has_ended(&mut self) -> PyResult<bool> {
        while self.take()?.is_some() {}
        Ok(self.pending.ended())
    }

    fn take(&mut self) -> PyResult<Option<GoalUpdate>> {
        let update = self.pending.next().map_err(of_bus)?;
        if let Some(update) = &update {
            self.progress.add(update);
        }
        Ok(update)
    }
}

#[pymethods]
impl Goal {
    /// The updates that came since the last call (`GoalUpdate`). Does not wait.
    fn updates<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        while let Some(update) = self.take()? {
            rows.push(Row(update));
        }
        Ok(rows::array(py, rows))
    }

    /// Waits for the end, at most `timeout` seconds if given (else raises TimeoutError; the goal goes on). Returns what `result`
    /// is then.
    #[pyo3(signature = (timeout = None))]
    fn wait<'py>(&mut self, py: Python<'py>, timeout: Option<f64>) -> PyResult<Bound<'py, PyDict>> {
        let (begin, limit) = (Instant::now(), timeout.map(seconds).transpose()?);
        loop {
            while self.take()?.is_some() {}
            if self.pending.ended() {
                return self.result(py);
            }
            if limit.is_some_and(|limit: Duration| begin.elapsed() > limit) {
                let step = self.progress.step().to_owned();
                return Err(PyTimeoutError::new_err(format!(
                    "the goal has not ended, it is at step {step:?}; wait longer, or cancel it"
                )));
            }
            pause(py, POLL)?;
        }
    }

    /// Asks the daemon to end the goal; its updates go on until the last one.
    fn cancel(&self) {
        self.pending.cancel();
    }

    /// Whether the goal has ended, as far as its updates were received.
    #[getter]
    fn ended(&self) -> bool {
        self.pending.ended()
    }

    /// How it stands: `state` (`GoalState`), `step`, `reason` (a sentence), `took_s`, and what the hand learnt: `f1_n`, `f2_n`,
    /// `stiffness_n_m`, `friction`, `lifted_m`, `normal_n`.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        described(py, &self.progress)
    }

    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        loop {
            if let Some(update) = self.take()? {
                return Ok(Some(rows::row(py, &update)?));
            }
            if self.pending.ended() {
                return Ok(None);
            }
            pause(py, POLL)?;
        }
    }
}

/// How a goal stands, as Python has it.
pub(crate) fn described<'py>(
    py: Python<'py>,
    progress: &GoalProgress,
) -> PyResult<Bound<'py, PyDict>> {
    let (last, figures) = (progress.last(), progress.figures());
    let reason = if last.reason.is_some() {
        progress.sentence()
    } else {
        String::new()
    };
    let told = PyDict::new(py);
    told.set_item("state", last.state.0)?;
    told.set_item("step", progress.step())?;
    told.set_item("reason", reason)?;
    told.set_item("took_s", progress.took_s())?;
    told.set_item("f1_n", figures.f1_n)?;
    told.set_item("f2_n", figures.f2_n)?;
    told.set_item("stiffness_n_m", figures.stiffness_n_m)?;
    told.set_item("friction", figures.friction)?;
    told.set_item("lifted_m", figures.lifted_m)?;
    told.set_item("normal_n", figures.normal_n)?;
    Ok(told)
}
