//! A sensor: publishes the frames of one hand.

use numpy::{AllowTypeChange, PyArray1, PyArrayLike2, PyArrayLike3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{Bus, Publisher, now_ns, writer_epoch};
use shm_schemas::capacity::FINGERS;
use shm_schemas::layout::NamedLayout;
use shm_schemas::service::{HAND_FRAME, SENSOR_STATUS};
use shm_schemas::{Hand, HandFrame, Layout, SensorStatus, Stamp, Text};

use crate::errors::bus_error;
use crate::own_thread::OwnThread;
use crate::rows::shape_of;

/// Interval of health reports, ns.
const HEALTH_NS: u64 = 100_000_000;

/// Publishes the frames of one hand: sealed, consecutively numbered, with their own epoch. Created
/// by `Bus.sensor`.
///
/// A bus has one sensor per hand; a second one is rejected, and the error names the first.
#[pyclass(module = "atas")]
pub(crate) struct Sensor {
    frames: OwnThread<Publisher<HandFrame>>,
    healths: OwnThread<Publisher<SensorStatus>>,
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
        let known = find_layout(layout)?;
        if !(1..=FINGERS).contains(&fingers) {
            return Err(PyValueError::new_err(format!(
                "sensor rejected: {fingers} fingertips, needs 1 to {FINGERS}"
            )));
        }
        let stamp = Stamp {
            writer_epoch: writer_epoch(),
            ..Stamp::default()
        };
        let service = HAND_FRAME[usize::from(hand != Hand::LEFT)];
        Ok(Self {
            frames: OwnThread::new(bus.publisher(service).map_err(bus_error)?),
            healths: OwnThread::new(bus.publisher(SENSOR_STATUS).map_err(bus_error)?),
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

    /// Reports the sensor's health at about 10 Hz.
    fn publish_health(&mut self) -> PyResult<()> {
        let now_ns = now_ns();
        if now_ns < self.health_due_ns {
            return Ok(());
        }
        self.health_due_ns = now_ns + HEALTH_NS;
        self.send_health(now_ns)
    }

    fn send_health(&mut self, now_ns: u64) -> PyResult<()> {
        self.health.stamp.captured_ns = now_ns;
        self.healths.get()?.send(&self.health).map_err(bus_error)?;
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
                "frame rejected: the forces have the shape {}, needs ({fingers}, {taxels}, 3): \
                 fingertip, taxel, (normal, tangential 1, tangential 2)",
                shape_of(force_n)
            )));
        }
        let is_valid = |finger: usize, taxel: usize| valid.is_empty() || valid[finger][taxel];
        let wrong = view.indexed_iter().find(|((finger, taxel, _), force_n)| {
            is_valid(*finger, *taxel) && !force_n.is_finite()
        });
        if let Some(((finger, taxel, axis), force_n)) = wrong {
            return Err(PyValueError::new_err(format!(
                "frame rejected: force_n[{finger}, {taxel}, {axis}] is {force_n}, needs a finite \
                 number; mark the taxel in `valid`"
            )));
        }
        for finger in 0..fingers {
            let mut mask = 0;
            for taxel in 0..taxels {
                let measured = is_valid(finger, taxel);
                mask |= u64::from(measured) << taxel;
                for axis in 0..3 {
                    let force_n = view[(finger, taxel, axis)];
                    self.frame.force_n[finger][taxel][axis] = if measured { force_n } else { 0.0 };
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
                "frame rejected: `valid` has the shape {}, needs ({}, {}): fingertip, taxel",
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
    /// Publishes one frame: forces of the object on the fingertip, N, as
    /// `[fingertip, taxel, (normal, tangential 1, tangential 2)]`.
    ///
    /// `valid[fingertip, taxel]` is False for taxels without a reading; default all True.
    /// `captured_ns` is the sampling time, ns of CLOCK_MONOTONIC (default now) or of virtual time
    /// in lock-step; it must increase. `lost` is the number of frames that the device dropped
    /// before this one; they leave a gap in the sequence. Returns the frame's sequence number.
    #[pyo3(signature = (force_n, *, valid = None, captured_ns = None, lost = 0))]
    fn publish(
        &mut self,
        force_n: PyArrayLike3<'_, f32, AllowTypeChange>,
        valid: Option<PyArrayLike2<'_, bool>>,
        captured_ns: Option<u64>,
        lost: u32,
    ) -> PyResult<u64> {
        let captured_ns = captured_ns.unwrap_or_else(now_ns);
        let last_ns = self.frame.stamp.captured_ns;
        if captured_ns <= last_ns && self.next > 0 {
            return Err(PyValueError::new_err(format!(
                "frame rejected: captured at {captured_ns} ns, needs more than the {last_ns} ns of \
                 the previous frame"
            )));
        }
        let valid = self.mask(valid)?;
        self.fill(&force_n, &valid)?;
        let sequence = self.next + u64::from(lost);
        self.frame.stamp.sequence = sequence;
        self.frame.stamp.captured_ns = captured_ns;
        self.frame.seal();
        self.frames.get()?.send(&self.frame).map_err(bus_error)?;
        self.next = sequence + 1;
        self.health.frames += 1;
        self.health.lost += u64::from(lost);
        self.publish_health()?;
        Ok(sequence)
    }

    /// Delivers the last frame to late readers, while lock-step waits for its daemon.
    fn connect_readers(&self) -> PyResult<()> {
        self.frames.get()?.connect_readers().map_err(bus_error)
    }

    /// Reports the end of the sensor. Do not publish afterwards.
    fn close(&mut self) -> PyResult<()> {
        if self.health.alive == 1 {
            self.health.alive = 0;
            self.send_health(now_ns())?;
        }
        Ok(())
    }

    /// Taxels per fingertip.
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

/// Geometry of a layout in the tip frame (z out of the centre of the sensor surface): unit vectors
/// `normal`, `tangent1`, `tangent2` and `position` (m) as arrays [taxel, axis], and the `hash` in
/// frames.
#[pyfunction]
pub(crate) fn layout<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyDict>> {
    let known = find_layout(name)?;
    let fields = PyDict::new(py);
    let tables = [
        ("normal", &known.normal),
        ("tangent1", &known.tangent1),
        ("tangent2", &known.tangent2),
        ("position", &known.position_m),
    ];
    for (key, table) in tables {
        let numbers = PyArray1::from_iter(py, table[..known.count].iter().flatten().copied());
        fields.set_item(key, numbers.reshape([known.count, 3])?)?;
    }
    fields.set_item("hash", known.hash())?;
    Ok(fields)
}

/// Returns a layout by name.
fn find_layout(name: &str) -> PyResult<Layout> {
    Layout::from_name(name).ok_or_else(|| {
        let forms = NamedLayout::FORMS;
        PyValueError::new_err(format!("unknown layout {name:?}; needs {forms}"))
    })
}
