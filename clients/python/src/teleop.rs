//! Teleoperation of a hand by a stream of targets.

use std::time::{Duration, Instant};

use atas_client::{GoalProgress, POLL, Session, TeleopHands, TeleopTarget};
use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_schemas::Hand;

use crate::errors::{AtasError, bus_error};
use crate::goal::goal_dict;
use crate::names::parse_hand;
use crate::own_thread::OwnThread;
use crate::pause;
use crate::reader::seconds;
use crate::rows;

/// Timeout of the daemon's reply to start and end. Design choice: as for any request.
const REPLY_TIMEOUT: Duration = Duration::from_secs(1);
/// Name of both hands.
const BOTH: &str = "both";

/// Teleoperates a hand until `end` or until this object is dropped; the hand then brakes and keeps
/// its grip.
#[pyclass(module = "atas")]
pub(crate) struct Teleop {
    leader: OwnThread<atas_client::TeleopSender>,
    hand: Hand,
    /// Teleoperated hands: "left", "right" or "both".
    hands: String,
}

impl Teleop {
    /// Requests teleoperation and waits until the daemon accepts it.
    pub(crate) fn open(py: Python<'_>, session: &Session, hand: &str) -> PyResult<Self> {
        let (teleoperated, acting) = match hand {
            BOTH => (TeleopHands::Both, Hand::RIGHT),
            one => (TeleopHands::One(parse_hand(one)?), parse_hand(one)?),
        };
        let leader = atas_client::TeleopSender::open(session, teleoperated).map_err(bus_error)?;
        let mut leader = Self {
            leader: OwnThread::new(leader),
            hand: acting,
            hands: hand.to_owned(),
        };
        let begin = Instant::now();
        while leader.active_progress()?.last().goal_id == 0 || leader.leader.get()?.now_ns() == 0 {
            check_timeout(begin)?;
            pause(py, POLL)?;
        }
        Ok(leader)
    }

    fn poll(&mut self) -> PyResult<GoalProgress> {
        self.leader.get_mut()?.poll().copied().map_err(bus_error)
    }

    /// Returns the progress of the goal; an error if it has ended.
    fn active_progress(&mut self) -> PyResult<GoalProgress> {
        let progress = self.poll()?;
        if self.leader.get()?.has_ended() {
            return Err(AtasError::new_err(progress.text()));
        }
        Ok(progress)
    }
}

#[pymethods]
impl Teleop {
    /// Sends a target for a hand: the point `at` between its fingertips (m), the direction `yaw` of
    /// its closing axis (rad), and the distance `opening` between its fingertips (m), or None to
    /// hold an object. Tactile feedback controls the grip force.
    ///
    /// Call it at 1 to 1,000 Hz. After `valid` seconds (at most 2) without a new target, the hand
    /// brakes and keeps its grip. Raises AtasError with the reason once the goal has ended.
    #[pyo3(signature = (at, opening, *, yaw = std::f64::consts::FRAC_PI_2, hand = None, valid = 0.4))]
    fn send(
        &mut self,
        at: [f64; 3],
        opening: Option<f64>,
        yaw: f64,
        hand: Option<&str>,
        valid: f64,
    ) -> PyResult<()> {
        check_finite(at, opening, yaw)?;
        self.active_progress()?;
        let wanted = TeleopTarget {
            hand: hand.map_or(Ok(self.hand), parse_hand)?,
            centre_m: at,
            yaw_rad: yaw,
            opening_m: opening,
        };
        let valid_ns = seconds(valid)?.as_nanos();
        let valid_ns = u64::try_from(valid_ns).unwrap_or(u64::MAX);
        self.leader
            .get_mut()?
            .send(&wanted, valid_ns)
            .map_err(bus_error)
    }

    /// Newest tick report (`TickReport`), for example `report["hands"]["fingers"]["normal_n"]` and
    /// `["centre_m"]`.
    #[getter]
    fn report<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.poll()?;
        rows::row(py, self.leader.get()?.report())
    }

    /// State of the goal, see `Goal.result`.
    #[getter]
    fn result<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        goal_dict(py, &self.poll()?)
    }

    /// Ends the stream and waits for the daemon's confirmation: the hand brakes and keeps its grip.
    fn end(&mut self, py: Python<'_>) -> PyResult<()> {
        self.leader.get_mut()?.end();
        let begin = Instant::now();
        while !self.leader.get()?.has_ended() {
            check_timeout(begin)?;
            self.poll()?;
            pause(py, POLL)?;
        }
        Ok(())
    }

    fn __repr__(&self) -> String {
        let state = match self.leader.get() {
            Err(_) => "of another thread or process",
            Ok(leader) if leader.has_ended() => "ended",
            Ok(_) => "running",
        };
        format!("<atas.Teleop of {:?}: {state}>", self.hands)
    }
}

/// Rejects a target with a value that is not finite.
pub(crate) fn check_finite(at: [f64; 3], opening: Option<f64>, yaw: f64) -> PyResult<()> {
    let mut values = at.iter().chain(&opening).chain([&yaw]);
    if values.any(|value| !value.is_finite()) {
        return Err(PyValueError::new_err(
            "target rejected: a value is not finite; needs finite numbers",
        ));
    }
    Ok(())
}

fn check_timeout(begin: Instant) -> PyResult<()> {
    if begin.elapsed() < REPLY_TIMEOUT {
        return Ok(());
    }
    let sentence = "the daemon did not reply within 1 s; see `atas status`";
    Err(PyTimeoutError::new_err(sentence))
}
