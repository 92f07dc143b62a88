//! A sensor: one hand's frames.

use numpy::{AllowTypeChange, PyArray1, PyArrayLike2, PyArrayLike3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{Bus, Publisher, now_ns, writer_epoch};
use shm_schemas::capacity::FINGERS;
use shm_schemas::layout::NamedLayout;
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, Layout, SensorStatus, Stamp, Text};

use crate::errors::of_bus;
use crate::rows::shape_of;

/// Time between two reports of the sensor's health, ns: about 10 Hz.
const HEALTH_NS: u64 = 100_000_000;

/// Publishes one hand's frames: sealed, numbered without gaps, under an epoch of its own. `Bus.sensor` makes it.
///
/// There is one sensor per hand on a bus; a second one is refused and told who the first is.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Sensor {
    frames: Publisher<HandFrame>,
    healths: Publisher<SensorStatus>,
    frame: HandFrame,
    health: SensorStatus,
    taxels: usize,
    next: u64,
    health_due_ns: u64,
}

impl Sensor {
    pub(crate) fn new(
        bus: &Bus,
        hand: Hand,
        layout: &str,
        fingers: usize,
        device: &str,
    ) -> PyResult<Self> {
        let known = known(layout)?;
        if !(1..=FINGERS).contains(&fingers) {
            return Err(PyValueError::new_err(format!(
                "could not make a sensor because it has {fingers} fingers, needs 1 to {FINGERS}"
            )));
        }
        let stamp = Stamp {
            writer_epoch: writer_epoch(),
            ..Stamp::default()
        };
        let service = HAND_FRAME[usize::from(hand != Hand::LEFT)];
        Ok(Self {
            frames: bus.publisher(service).map_err(of_bus)?,
            healths: bus.publisher(SENSOR_STATUS).map_err(of_bus)?,
            frame: HandFrame {
                stamp,
                layout_hash: known.hash(),
                hand,
                finger_count: fingers as u32,
                ..HandFrame::default()
            },
            health: SensorStatus {
                stamp,
                driver: Text::new("python"),
                device: Text::new(device),
                hand,
                alive: 1,
                ..SensorStatus::default()
            },
            taxels: known.count,
            next: 0,
            health_due_ns: 0,
        })
    }

    fn fingers(&self) -> usize {
        self.frame.finger_count as usize
    }

    /// About 10 Hz: how the sensor is.
    fn tell_health(&mut self) -> PyResult<()> {
        let now_ns = now_ns();
        if now_ns < self.health_due_ns {
            return Ok(());
        }
        self.health_due_ns = now_ns + HEALTH_NS;
        self.send_health(now_ns)
    }

    fn send_health(&mut self, now_ns: u64) -> PyResult<()> {
        self.health.stamp.captured_ns = now_ns;
        self.healths.send(&self.health).map_err(of_bus)?;
        self.health.stamp.sequence += 1;
        Ok(())
    }

    fn fill(
        &mut self,
        force_n: &PyArrayLike3<'_, f32, AllowTypeChange>,
        valid: &[Vec<bool>],
    ) -> PyResult<()> {
        let (fingers, taxels) = (self.fingers(), self.taxels);
        let view = force_n.as_array();
        if view.dim() != (fingers, taxels, 3) {
            return Err(PyValueError::new_err(format!(
                "could not publish a frame because the forces have the shape {}, needs ({fingers}, {taxels}, 3): finger, \
                 taxel, (normal, tangential 1, tangential 2)",
                shape_of(force_n)
            )));
        }
        let is_valid = |finger: usize, taxel: usize| valid.is_empty() || valid[finger][taxel];
        let wrong = view.indexed_iter().find(|((finger, taxel, _), force_n)| {
            is_valid(*finger, *taxel) && !force_n.is_finite()
        });
        if let Some(((finger, taxel, axis), force_n)) = wrong {
            return Err(PyValueError::new_err(format!(
                "could not publish a frame because force_n[{finger}, {taxel}, {axis}] was {force_n}, needs a finite number; \
                 mark the taxel in `valid`"
            )));
        }
        for finger in 0..fingers {
            let mut mask = 0;
            for taxel in 0..taxels {
                let felt = is_valid(finger, taxel);
                mask |= u64::from(felt) << taxel;
                for axis in 0..3 {
                    let force_n = view[(finger, taxel, axis)];
                    self.frame.force_n[finger][taxel][axis] = if felt { force_n } else { 0.0 };
                }
            }
            self.frame.valid_mask[finger] = mask;
        }
        Ok(())
    }

    fn mask(&self, valid: Option<PyArrayLike2<'_, bool>>) -> PyResult<Vec<Vec<bool>>> {
        let Some(valid) = valid else {
            return Ok(Vec::new());
        };
        let view = valid.as_array();
        if view.dim() != (self.fingers(), self.taxels) {
            return Err(PyValueError::new_err(format!(
                "could not publish a frame because `valid` has the shape {}, needs ({}, {}): finger, taxel",
                shape_of(&valid),
                self.fingers(),
                self.taxels
            )));
        }
        Ok(view.outer_iter().map(|row| row.to_vec()).collect())
    }
}

#[pymethods]
impl Sensor {
    /// Sends one frame: forces of the object on the tip, N, as `[finger, taxel, (normal, tangential 1, tangential 2)]`.
    ///
    /// `valid[finger, taxel]` is False for taxels that say nothing; without it all do. `captured_ns` is when the sensor
    /// sampled, ns of CLOCK_MONOTONIC (now, if not given) or of virtual time in lock-step; it must increase. `lost` frames
    /// that the device dropped before this one leave a gap in the sequence. Returns the frame's sequence.
    #[pyo3(signature = (force_n, *, valid = None, captured_ns = None, lost = 0))]
    fn publish(
        &mut self,
        force_n: PyArrayLike3<'_, f32, AllowTypeChange>,
        valid: Option<PyArrayLike2<'_, bool>>,
        captured_ns: Option<u64>,
        lost: u64,
    ) -> PyResult<u64> {
        let captured_ns = captured_ns.unwrap_or_else(now_ns);
        let last_ns = self.frame.stamp.captured_ns;
        if captured_ns <= last_ns && self.next > 0 {
            return Err(PyValueError::new_err(format!(
                "could not publish a frame because it was captured at {captured_ns} ns, needs more than the {last_ns} ns of \
                 the one before"
            )));
        }
        let valid = self.mask(valid)?;
        self.fill(&force_n, &valid)?;
        let sequence = self.next.saturating_add(lost);
        self.frame.stamp.sequence = sequence;
        self.frame.stamp.captured_ns = captured_ns;
        self.frame.seal();
        self.frames.send(&self.frame).map_err(of_bus)?;
        self.next = sequence + 1;
        self.health.frames += 1;
        self.health.lost += lost;
        self.tell_health()?;
        Ok(sequence)
    }

    /// Lets readers that came late have the last frame: while lock-step waits for its daemon.
    fn greet(&self) -> PyResult<()> {
        self.frames.connect_readers().map_err(of_bus)
    }

    /// Says that the sensor has ended; nothing is published afterwards.
    fn close(&mut self) -> PyResult<()> {
        if self.health.alive == 1 {
            self.health.alive = 0;
            self.send_health(now_ns())?;
        }
        Ok(())
    }

    /// Taxels of one finger.
    #[getter]
    fn taxels(&self) -> usize {
        self.taxels
    }

    fn __enter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&mut self, _error: &Bound<'_, pyo3::types::PyTuple>) -> PyResult<()> {
        self.close()
    }

    fn __repr__(&self) -> String {
        format!(
            "Sensor({}, {} x {} taxels)",
            self.frame.hand,
            self.fingers(),
            self.taxels
        )
    }
}

/// Where the elements of a layout sit and along which axes they feel, in the tip frame (z is out of the middle of its face): unit
/// vectors `normal`, `tangent1`, `tangent2` and places `position` (metres) as arrays [taxel, axis], and the `hash` that frames carry.
#[pyfunction]
pub(crate) fn layout<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
    let known = known(name)?;
    let told = PyDict::new(py);
    let tables = [
        ("normal", &known.normal),
        ("tangent1", &known.tangent1),
        ("tangent2", &known.tangent2),
        ("position", &known.position_m),
    ];
    for (key, table) in tables {
        let numbers = PyArray1::from_iter(py, table[..known.count].iter().flatten().copied());
        told.set_item(key, numbers.reshape([known.count, 3])?)?;
    }
    told.set_item("hash", known.hash())?;
    Ok(told)
}

/// A layout by its name.
fn known(name: &str) -> PyResult<Layout> {
    Layout::named(name).ok_or_else(|| {
        let forms = NamedLayout::FORMS;
        PyValueError::new_err(format!("a layout was {name:?}, needs {forms}"))
    })
}
