//! Leading a hand by a stream of targets.

use std::time::{Duration, Instant};

use atas_client::{GoalProgress, Led, POLL, Session, Wanted};
use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_schemas::Hand;

use crate::errors::{AtasError, of_bus};
use crate::goal::described;
use crate::names::hand_of;
use crate::pause;
use crate::reader::seconds;
use crate::rows;

/// How long the daemon may take to take the goal, or to end it (ours: as for any request).
const ANSWER: Duration = Duration::from_secs(1);
/// What names both hands.
const BOTH: &str = "both";

/// Leads a hand until `end`, or until this object is dropped: the hand then brakes and keeps what it holds.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Leader {
    leader: atas_client::Leader,
    hand: Hand,
}

impl Leader {
    /// Asks the daemon to follow, and waits until it does.
    pub(crate) fn open(py: Python<'_>, session: &Session, hand: &str) -> PyResult<Self> {
        let (led, hand) = match hand {
            BOTH => (Led::Both, Hand::RIGHT),
            one => (Led::One(hand_of(one)?), hand_of(one)?),
        };
        let leader = atas_client::Leader::open(session, led).map_err(of_bus)?;
        let mut leader = Self { leader, hand };
        let begin = Instant::now();
        while leader.alive()?.last().goal_id == 0 || leader.leader.now_ns() == 0 {
            unanswered(begin)?;
            pause(py, POLL)?;
        }
        Ok(leader)
    }

    fn look(&mut self) -> PyResult<GoalProgress> {
        self.leader.look().copied().map_err(of_bus)
    }

    /// How the goal stands; an error if it has ended.
    fn alive(&mut self) -> PyResult<GoalProgress> {
        let progress = self.look()?;
        if self.leader.ended() {
            return Err(AtasError::new_err(progress.sentence()));
        }
        Ok(progress)
    }
}

#[pymethods]
impl Leader {
    /// Says where a hand shall be: the point `at` between its fingertips (m), the direction `yaw` of its closing axis (rad), and the
    /// distance `opening` between its fingertips (m), or None to hold what is there. Touch decides how hard.
    ///
    /// Call it 1 to 1,000 times a second: `valid` seconds (at most 2) after the last one the hand brakes and keeps what it holds.
    /// Raises AtasError with the reason once the goal has ended.
    #[pyo3(signature = (at, opening, *, yaw = std::f64::consts::FRAC_PI_2, hand = None, valid = 0.4))]
    fn lead(
        &mut self,
        at: [f64; 3],
        opening: Option<f64>,
        yaw: f64,
        hand: Option<&str>,
        valid: f64,
    ) -> PyResult<()> {
        if at
            .iter()
            .chain(&opening)
            .chain([&yaw])
            .any(|value| !value.is_finite())
        {
            return Err(PyValueError::new_err(
                "a target is not finite, needs finite numbers",
            ));
        }
        self.alive()?;
        let wanted = Wanted {
            hand: hand.map_or(Ok(self.hand), hand_of)?,
            centre_m: at,
            yaw_rad: yaw,
            opening_m: opening,
        };
        let valid_ns = seconds(valid)?.as_nanos();
        let valid_ns = u64::try_from(valid_ns).unwrap_or(u64::MAX);
        self.leader.lead(&wanted, valid_ns).map_err(of_bus)
    }

    /// The newest report of a tick (`TickReport`): `report["hands"]["fingers"]["normal_n"]`, `["centre_m"]` and what else a policy
    /// may want to know.
    #[getter]
    fn report<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.look()?;
        rows::row(py, self.leader.report())
    }

    /// How the goal stands, as `Goal.result` tells it.
    #[getter]
    fn result<'py>(&mut self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        described(py, &self.look()?)
    }

    /// Ends the stream, and waits until the daemon confirms it: the hand brakes and keeps what it holds.
    fn end(&mut self, py: Python<'_>) -> PyResult<()> {
        self.leader.end();
        let begin = Instant::now();
        while !self.leader.ended() {
            unanswered(begin)?;
            self.look()?;
            pause(py, POLL)?;
        }
        Ok(())
    }
}

fn unanswered(begin: Instant) -> PyResult<()> {
    if begin.elapsed() < ANSWER {
        return Ok(());
    }
    let sentence = "the daemon did not answer within a second; see `atas status`";
    Err(PyTimeoutError::new_err(sentence))
}
