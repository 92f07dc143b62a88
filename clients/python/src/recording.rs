//! Recordings as arrays.

use std::path::PathBuf;

use atas_evaluation::replay::replay;
use atas_recording::{Entry, Reader, Recorded, payload};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_schemas::{
    HandFrame, JointCommand, JointState, ModuleEvent, RunHeader, SensorStatus, Status, TickInputs,
    TickReport,
};

use crate::errors::failed;
use crate::names::hand_of;
use crate::rows::{self, Row};

/// A recording of `atas record`: one file, or the files of one run in order.
#[pyclass(frozen, module = "atas")]
pub(crate) struct Recording {
    files: Vec<PathBuf>,
}

#[pymethods]
impl Recording {
    #[new]
    #[pyo3(signature = (*files))]
    fn new(files: Vec<PathBuf>) -> PyResult<Self> {
        // What cannot be opened is said now.
        for file in &files {
            Reader::open(file).map_err(failed)?;
        }
        Ok(Self { files })
    }

    /// Every frame of a hand that the daemon took in, as it came (`HandFrame`).
    fn frames<'py>(&self, py: Python<'py>, hand: &str) -> PyResult<Bound<'py, PyAny>> {
        let hand = usize::from(hand_of(hand)? != shm_schemas::Hand::LEFT);
        self.inputs::<HandFrame>(py, |part| {
            (part.has_frame[hand] != 0).then_some(&part.frames[hand])
        })
    }

    /// Every joint state that the daemon took in (`JointState`).
    #[getter]
    fn joint_states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        // What is not per frame stands in every part of a tick.
        self.inputs::<JointState>(py, |part| {
            (part.part == 0 && part.has_joints != 0).then_some(&part.joints)
        })
    }

    /// Every command (`JointCommand`).
    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.inputs::<JointCommand>(py, |part| (part.part == 0).then_some(&part.command))
    }

    /// What every tick felt and did (`TickReport`).
    #[getter]
    fn reports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<TickReport>(py)
    }

    /// What happened (`ModuleEvent`).
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<ModuleEvent>(py)
    }

    /// The daemon's status (`Status`).
    #[getter]
    fn statuses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<Status>(py)
    }

    /// The health of sensors (`SensorStatus`).
    #[getter]
    fn sensor_statuses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<SensorStatus>(py)
    }

    /// How the run began (`RunHeader`), one row.
    #[getter]
    fn headers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<RunHeader>(py)
    }

    /// Feeds what was recorded to the production controller. Returns `ticks`, `different` (ticks whose command is not the
    /// recorded one in every bit), `first_tick` and `first_field` (of the first of them, or None), and what the controller felt
    /// and did now: `reports` (`TickReport`) and `commands` (`JointCommand`).
    fn replay<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (mut reports, mut commands) = (Vec::new(), Vec::new());
        let agreement = py.detach(|| {
            replay(&self.files, |_, replayed| {
                reports.push(Row(replayed.outputs.report));
                commands.push(Row(replayed.outputs.command));
            })
        });
        let agreement = agreement.map_err(failed)?;
        let told = PyDict::new(py);
        told.set_item("ticks", agreement.ticks)?;
        told.set_item("different", agreement.different)?;
        told.set_item("first_tick", agreement.first.as_ref().map(|(tick, _)| tick))?;
        told.set_item(
            "first_field",
            agreement.first.as_ref().map(|(_, field)| field),
        )?;
        told.set_item("reports", rows::array(py, reports))?;
        told.set_item("commands", rows::array(py, commands))?;
        Ok(told)
    }

    fn __repr__(&self) -> String {
        format!("Recording({:?})", self.files)
    }
}

impl Recording {
    /// Calls `each` for every payload of a type.
    fn visit<T: Recorded>(&self, mut each: impl FnMut(&T)) -> anyhow::Result<()> {
        for file in &self.files {
            for entry in Reader::open(file)? {
                if let Entry::Message(message) = entry?
                    && let Some(found) = payload::<T>(&message)?
                {
                    each(&found);
                }
            }
        }
        Ok(())
    }

    fn all<'py, T: Recorded + Send + Sync>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        py.detach(|| self.visit::<T>(|found| rows.push(Row(*found))))
            .map_err(failed)?;
        Ok(rows::array(py, rows))
    }

    fn inputs<'py, T: shm_schemas::Payload + Send + Sync>(
        &self,
        py: Python<'py>,
        part: impl Fn(&TickInputs) -> Option<&T> + Send + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        let each = |inputs: &TickInputs| rows.extend(part(inputs).map(|found| Row(*found)));
        py.detach(|| self.visit::<TickInputs>(each))
            .map_err(failed)?;
        Ok(rows::array(py, rows))
    }
}
