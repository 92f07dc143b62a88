//! A robot: joint states out, commands in.

use std::time::{Duration, Instant};

use numpy::{AllowTypeChange, PyArray1, PyArrayLike1};
use pyo3::exceptions::PyTimeoutError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{RobotModel, RobotVector};
use shm_bus::{Bus, Publisher, Subscriber, now_ns, writer_epoch};
use shm_schemas::capacity::JOINTS;
use shm_schemas::service::{JOINT_COMMAND, JOINT_STATE};
use shm_schemas::{Accepted, JointCommand, JointState, Mode, Obedience, Orders, Stamp};

use crate::errors::{AtasError, of_bus};
use crate::goal::Goal;
use crate::pause;
use crate::reader::seconds;
use crate::rows::{finite, numbers};

/// How long a robot in lock-step looks without sleeping: a daemon that ticks answers within it.
const SPIN: Duration = Duration::from_millis(2);
/// How often it looks when that has passed, and lets a daemon that came late have the last joint state.
const POLL: Duration = Duration::from_millis(1);

type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// Publishes joint states and obeys commands as a robot must. `Bus.robot` makes it.
///
/// A command is obeyed if it is whole, for these joints, valid for a moment, newer than the last of its writer, and within
/// what the joints can do; when it expires, its positions are held with zero velocity, which keeps the grip. What is obeyed
/// is told in every joint state, so that the next daemon goes on from there.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Robot {
    states: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    speeds_rad_s: RobotVector,
    stamp: Stamp,
    sent: Option<u64>,
    obedience: Option<Obedience>,
    held: Orders,
    obeyed: Option<(Accepted, Mode, u64)>,
}

impl Robot {
    pub(crate) fn new(bus: &Bus) -> PyResult<Self> {
        let robot =
            RobotModel::two_hand_arm().map_err(|why| AtasError::new_err(why.to_string()))?;
        let mut commands = bus.subscriber(JOINT_COMMAND).map_err(of_bus)?;
        // A command from before this robot answers nothing of it.
        commands
            .newest(&mut JointCommand::default())
            .map_err(of_bus)?;
        let speeds: Vec<f64> = robot
            .joints()
            .map(|joint| joint.velocity_max_rad_s)
            .collect();
        Ok(Self {
            states: bus.publisher(JOINT_STATE).map_err(of_bus)?,
            commands,
            speeds_rad_s: RobotVector::from_slice(&speeds),
            stamp: Stamp {
                writer_epoch: writer_epoch(),
                ..Stamp::default()
            },
            sent: None,
            obedience: None,
            held: Orders::holding(&[]),
            obeyed: None,
        })
    }

    fn state(&self, values: [&[f64]; 3], captured_ns: u64) -> JointState {
        let [position_rad, velocity_rad_s, effort_n_m] = values;
        let joints = self.speeds_rad_s.len();
        let mut state = JointState {
            stamp: Stamp {
                captured_ns,
                ..self.stamp
            },
            joint_count: joints as u32,
            commanded_count: joints as u32,
            ..JointState::default()
        };
        state.position_rad[..joints].copy_from_slice(position_rad);
        state.velocity_rad_s[..joints].copy_from_slice(velocity_rad_s);
        state.effort_n_m[..joints].copy_from_slice(effort_n_m);
        state.commanded_rad = self.held.position_rad;
        if let Some((last, ..)) = &self.obeyed {
            last.tell(&mut state);
        }
        state.seal();
        state
    }

    /// Obeys a command that came, if it may be obeyed.
    fn obey(&mut self, command: &JointCommand, now_ns: u64) {
        let accepted = self
            .obedience
            .as_mut()
            .and_then(|it| it.accept(command, now_ns));
        if let Some(accepted) = accepted {
            self.held = accepted.orders;
            self.obeyed = Some((accepted, command.mode, command.tick));
        }
    }

    fn newest(&mut self) -> PyResult<Option<JointCommand>> {
        let mut command = JointCommand::default();
        let came = self.commands.newest(&mut command).map_err(of_bus)?;
        Ok(came.then_some(command))
    }

    /// What the joints shall do at this time.
    fn told<'py>(&mut self, py: Python<'py>, now_ns: u64) -> PyResult<Bound<'py, PyDict>> {
        let told = PyDict::new(py);
        let in_force = self
            .obeyed
            .is_some_and(|(last, ..)| last.valid_until_ns >= now_ns);
        if !in_force {
            self.held.velocity_rad_s = [0.0; JOINTS];
        }
        told.set_item(
            "position_rad",
            PyArray1::from_slice(py, &self.held.position_rad[..self.speeds_rad_s.len()]),
        )?;
        told.set_item(
            "velocity_rad_s",
            PyArray1::from_slice(py, &self.held.velocity_rad_s[..self.speeds_rad_s.len()]),
        )?;
        told.set_item("in_force", in_force)?;
        told.set_item(
            "mode",
            self.obeyed.map_or(Mode::INIT, |(_, mode, _)| mode).0,
        )?;
        told.set_item("tick", self.obeyed.map_or(0, |(.., tick)| tick))?;
        Ok(told)
    }
}

#[pymethods]
impl Robot {
    /// Sends the measured joints: positions rad, velocities rad/s and efforts N·m (zero if not measured), in the order of
    /// `JOINT_NAMES`. `captured_ns` is when the encoders were read (now, if not given). Returns the state's sequence.
    ///
    /// In lock-step send the frames of a tick first, then this, then wait for `answer`.
    #[pyo3(signature = (position_rad, velocity_rad_s = None, effort_n_m = None, *, captured_ns = None))]
    fn publish(
        &mut self,
        position_rad: Numbers<'_>,
        velocity_rad_s: Option<Numbers<'_>>,
        effort_n_m: Option<Numbers<'_>>,
        captured_ns: Option<u64>,
    ) -> PyResult<u64> {
        let joints = self.speeds_rad_s.len();
        let or_zero =
            |values: Option<Numbers<'_>>| values.map_or(vec![0.0; joints], |it| numbers(&it));
        let (positions, velocities, efforts) = (
            numbers(&position_rad),
            or_zero(velocity_rad_s),
            or_zero(effort_n_m),
        );
        finite("position_rad", &positions, joints)?;
        finite("velocity_rad_s", &velocities, joints)?;
        finite("effort_n_m", &efforts, joints)?;
        if self.obedience.is_none() {
            self.held = Orders::holding(&positions);
            self.obedience = Some(Obedience::at(&positions, &self.speeds_rad_s));
        }
        let captured_ns = captured_ns.unwrap_or_else(now_ns);
        let state = self.state([&positions, &velocities, &efforts], captured_ns);
        self.states.send(&state).map_err(of_bus)?;
        self.sent = Some(state.stamp.sequence);
        self.stamp.sequence += 1;
        Ok(state.stamp.sequence)
    }

    /// What the joints shall do now: `position_rad`, `velocity_rad_s`, `in_force` (False when the last command has expired
    /// and is only held), `mode`, `tick`. `now_ns` is the time (now, if not given; virtual time in lock-step). Does not wait.
    #[pyo3(signature = (now_ns = None))]
    fn command<'py>(
        &mut self,
        py: Python<'py>,
        now_ns: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let now_ns = now_ns.unwrap_or_else(shm_bus::now_ns);
        if let Some(command) = self.newest()? {
            self.obey(&command, now_ns);
        }
        self.told(py, now_ns)
    }

    /// Waits for the command that answers the last state, as lock-step has it, and obeys it at the virtual time `now_ns`.
    /// Returns what `command` does; raises TimeoutError after `timeout` seconds.
    ///
    /// When a goal has ended, the daemon has nothing to do and answers no more. Who gives the `goal` that this process waits for gets
    /// None then.
    #[pyo3(signature = (now_ns, goal = None, *, timeout = 60.0))]
    fn answer<'py>(
        &mut self,
        py: Python<'py>,
        now_ns: u64,
        mut goal: Option<PyRefMut<'_, Goal>>,
        timeout: f64,
    ) -> PyResult<Option<Bound<'py, PyDict>>> {
        let (begin, limit) = (Instant::now(), seconds(timeout)?);
        loop {
            match self.newest()? {
                Some(command) if Some(command.answers_sequence) == self.sent => {
                    self.obey(&command, now_ns);
                    return self.told(py, now_ns).map(Some);
                }
                // A command that answers an earlier state came late.
                _ if begin.elapsed() > limit => break,
                _ if begin.elapsed() < SPIN => py.detach(std::thread::yield_now),
                _ => {
                    if goal
                        .as_mut()
                        .is_some_and(|goal| goal.has_ended().unwrap_or(true))
                    {
                        return Ok(None);
                    }
                    self.greet()?;
                    pause(py, POLL)?;
                }
            }
        }
        Err(PyTimeoutError::new_err(format!(
            "no command answered joint state {} within {timeout} s; is `atasd --lockstep` running on this bus, and has it something \
             to do?",
            self.sent.unwrap_or(0)
        )))
    }

    /// Lets a daemon that came late have the last joint state.
    fn greet(&self) -> PyResult<()> {
        self.states.connect_readers().map_err(of_bus)
    }

    /// Commands that were refused.
    #[getter]
    fn refused(&self) -> u32 {
        self.obedience.map_or(0, |it| it.refused())
    }
}

/// Names of the joints, in the order of every array of joints.
pub(crate) fn joint_names() -> PyResult<Vec<String>> {
    let robot = RobotModel::two_hand_arm().map_err(|why| AtasError::new_err(why.to_string()))?;
    Ok(robot.joints().map(|joint| joint.name.to_string()).collect())
}
