//! Reads recordings as arrays.

use std::path::PathBuf;

use atas_evaluation::replay::replay;
use atas_recording::{Entry, Reader, Recorded, payload};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_schemas::{
    HandFrame, JointCommand, JointState, ModuleEvent, RunHeader, SensorStatus, Status, TickInputs,
    TickReport,
};

use crate::compute;
use crate::errors::atas_error;
use crate::names::parse_hand;
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
        // Reports unreadable files at once.
        for file in &files {
            Reader::open(file).map_err(atas_error)?;
        }
        Ok(Self { files })
    }

    /// Returns all frames of a hand that the daemon received (`HandFrame`).
    fn frames<'py>(&self, py: Python<'py>, hand: &str) -> PyResult<Bound<'py, PyAny>> {
        let hand = usize::from(parse_hand(hand)? != shm_schemas::Hand::LEFT);
        self.inputs::<HandFrame>(py, |part| {
            (part.has_frame[hand] != 0).then_some(&part.frames[hand])
        })
    }

    /// All joint states that the daemon received (`JointState`).
    #[getter]
    fn joint_states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        // Values that are not per frame are repeated in every part of a tick.
        self.inputs::<JointState>(py, |part| {
            (part.part == 0 && part.has_joints != 0).then_some(&part.joints)
        })
    }

    /// All commands (`JointCommand`).
    #[getter]
    fn commands<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.inputs::<JointCommand>(py, |part| (part.part == 0).then_some(&part.command))
    }

    /// All tick reports (`TickReport`).
    #[getter]
    fn reports<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<TickReport>(py)
    }

    /// All events (`ModuleEvent`).
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<ModuleEvent>(py)
    }

    /// All status reports of the daemon (`Status`).
    #[getter]
    fn statuses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<Status>(py)
    }

    /// Health reports of the sensors (`SensorStatus`).
    #[getter]
    fn sensor_statuses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<SensorStatus>(py)
    }

    /// Header of the run (`RunHeader`), one row.
    #[getter]
    fn headers<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.all::<RunHeader>(py)
    }

    /// Replays the recording with the production controller. Returns `ticks`, `different` (ticks
    /// whose command differs in any bit), `first_tick` and `first_field` (of the first difference,
    /// or None), and the new `reports` (`TickReport`) and `commands` (`JointCommand`).
    fn replay<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (mut reports, mut commands) = (Vec::new(), Vec::new());
        let agreement = compute(py, || {
            replay(&self.files, |_, replayed| {
                reports.push(Row(replayed.outputs.report));
                commands.push(Row(replayed.outputs.command));
            })
        });
        let agreement = agreement?.map_err(atas_error)?;
        let fields = PyDict::new(py);
        fields.set_item("ticks", agreement.ticks)?;
        fields.set_item("different", agreement.different)?;
        fields.set_item(
            "first_tick",
            agreement.first_difference.as_ref().map(|(tick, _)| tick),
        )?;
        fields.set_item(
            "first_field",
            agreement.first_difference.as_ref().map(|(_, field)| field),
        )?;
        fields.set_item("reports", rows::array(py, reports))?;
        fields.set_item("commands", rows::array(py, commands))?;
        Ok(fields)
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
        compute(py, || self.visit::<T>(|found| rows.push(Row(*found))))?.map_err(atas_error)?;
        Ok(rows::array(py, rows))
    }

    fn inputs<'py, T: shm_schemas::Payload + Send + Sync>(
        &self,
        py: Python<'py>,
        part: impl Fn(&TickInputs) -> Option<&T> + Send + Sync,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut rows = Vec::new();
        let each = |inputs: &TickInputs| rows.extend(part(inputs).map(|found| Row(*found)));
        compute(py, || self.visit::<TickInputs>(each))?.map_err(atas_error)?;
        Ok(rows::array(py, rows))
    }
}
