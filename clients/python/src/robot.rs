//! A robot: publishes joint states, executes commands.

use std::time::{Duration, Instant};

use numpy::{AllowTypeChange, PyArray1, PyArrayLike1};
use pyo3::exceptions::{PyTimeoutError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{RobotModel, RobotVector, TWO_HAND_ARM};
use shm_bus::{Bus, Publisher, Subscriber, now_ns, writer_epoch};
use shm_schemas::capacity::JOINTS;
use shm_schemas::service::{JOINT_COMMAND, JOINT_STATE};
use shm_schemas::{
    Accepted, CommandValidator, JointCommand, JointSetpoints, JointState, Mode, Stamp,
};

use crate::errors::{AtasError, bus_error};
use crate::goal::Goal;
use crate::own_thread::OwnThread;
use crate::pause;
use crate::reader::seconds;
use crate::rows::{finite, numbers};

/// Time for which a robot in lock-step polls without sleeping; a ticking daemon replies within it.
const SPIN: Duration = Duration::from_millis(2);
/// Poll interval afterwards. Each poll delivers the last joint state to a daemon that started late.
const POLL: Duration = Duration::from_millis(1);

type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// Publishes joint states and validates commands according to the protocol. Created by `Bus.robot`.
///
/// A command is accepted if it is intact, matches the joints, is valid for a limited time, is newer
/// than the last of its writer, and respects the joints' limits. When it expires, its positions are
/// held with zero velocity, which keeps the grip. Every joint state contains the executed
/// set-points, so that the next daemon continues from them.
#[pyclass(module = "atas")]
pub(crate) struct Robot {
    /// Name or robot file of its model.
    name: String,
    states: OwnThread<Publisher<JointState>>,
    commands: OwnThread<Subscriber<JointCommand>>,
    speeds_rad_s: RobotVector,
    stamp: Stamp,
    sent: Option<u64>,
    validator: Option<CommandValidator>,
    held: JointSetpoints,
    accepted: Option<(Accepted, Mode, u64)>,
}

impl Robot {
    pub(crate) fn new(bus: &Bus, model: Option<&str>) -> PyResult<Self> {
        let default = TWO_HAND_ARM.name;
        let name = model.unwrap_or(&default).to_owned();
        let robot =
            RobotModel::find(&name).map_err(|why| PyValueError::new_err(why.to_string()))?;
        let mut commands = bus.subscriber(JOINT_COMMAND).map_err(bus_error)?;
        // Discards a command sent before this robot started.
        commands
            .newest(&mut JointCommand::default())
            .map_err(bus_error)?;
        let speeds: Vec<f64> = robot.joints().map(|joint| joint.velocity_max).collect();
        Ok(Self {
            name,
            states: OwnThread::new(bus.publisher(JOINT_STATE).map_err(bus_error)?),
            commands: OwnThread::new(commands),
            speeds_rad_s: RobotVector::from_slice(&speeds),
            stamp: Stamp {
                writer_epoch: writer_epoch(),
                ..Stamp::default()
            },
            sent: None,
            validator: None,
            held: JointSetpoints::holding(&[]),
            accepted: None,
        })
    }

    fn state(&self, values: [&[f64]; 3], captured_ns: u64) -> JointState {
        let [position, velocity, effort] = values;
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
        state.position[..joints].copy_from_slice(position);
        state.velocity[..joints].copy_from_slice(velocity);
        state.effort[..joints].copy_from_slice(effort);
        state.commanded_position = self.held.position;
        if let Some((last, ..)) = &self.accepted {
            last.write_to(&mut state);
        }
        state.seal();
        state
    }

    /// Executes a command if the validator accepts it.
    fn execute(&mut self, command: &JointCommand, now_ns: u64) {
        let accepted = self
            .validator
            .as_mut()
            .and_then(|it| it.accept(command, now_ns));
        if let Some(accepted) = accepted {
            self.held = accepted.setpoints;
            self.accepted = Some((accepted, command.mode, command.tick));
        }
    }

    fn newest(&mut self) -> PyResult<Option<JointCommand>> {
        let mut command = JointCommand::default();
        let came = self
            .commands
            .get_mut()?
            .newest(&mut command)
            .map_err(bus_error)?;
        Ok(came.then_some(command))
    }

    /// Returns the set-points of the joints at this time.
    fn setpoints<'py>(&mut self, py: Python<'py>, now_ns: u64) -> PyResult<Bound<'py, PyDict>> {
        let fields = PyDict::new(py);
        let in_force = self
            .accepted
            .is_some_and(|(last, ..)| last.valid_until_ns >= now_ns);
        if !in_force {
            self.held.velocity = [0.0; JOINTS];
        }
        fields.set_item(
            "position",
            PyArray1::from_slice(py, &self.held.position[..self.speeds_rad_s.len()]),
        )?;
        fields.set_item(
            "velocity",
            PyArray1::from_slice(py, &self.held.velocity[..self.speeds_rad_s.len()]),
        )?;
        fields.set_item("in_force", in_force)?;
        fields.set_item(
            "mode",
            self.accepted.map_or(Mode::INIT, |(_, mode, _)| mode).0,
        )?;
        fields.set_item("tick", self.accepted.map_or(0, |(.., tick)| tick))?;
        Ok(fields)
    }
}

#[pymethods]
impl Robot {
    /// Publishes the measured joints: positions rad, velocities rad/s and efforts N·m (0 if not
    /// measured), in the order of `JOINT_NAMES`. `captured_ns` is the sampling time of the encoders
    /// (default now). Returns the state's sequence number.
    ///
    /// In lock-step, send the frames of a tick first, then this, then wait for `answer`.
    #[pyo3(signature = (position, velocity = None, effort = None, *, captured_ns = None))]
    fn publish(
        &mut self,
        position: Numbers<'_>,
        velocity: Option<Numbers<'_>>,
        effort: Option<Numbers<'_>>,
        captured_ns: Option<u64>,
    ) -> PyResult<u64> {
        let joints = self.speeds_rad_s.len();
        let or_zero =
            |values: Option<Numbers<'_>>| values.map_or(vec![0.0; joints], |it| numbers(&it));
        let (positions, velocities, efforts) =
            (numbers(&position), or_zero(velocity), or_zero(effort));
        finite("position", &positions, joints)?;
        finite("velocity", &velocities, joints)?;
        finite("effort", &efforts, joints)?;
        if self.validator.is_none() {
            self.held = JointSetpoints::holding(&positions);
            self.validator = Some(CommandValidator::new(&positions, &self.speeds_rad_s));
        }
        let captured_ns = captured_ns.unwrap_or_else(now_ns);
        let state = self.state([&positions, &velocities, &efforts], captured_ns);
        self.states.get()?.send(&state).map_err(bus_error)?;
        self.sent = Some(state.stamp.sequence);
        self.stamp.sequence += 1;
        Ok(state.stamp.sequence)
    }

    /// Returns the set-points of the joints: `position`, `velocity`, `in_force` (False if
    /// the last command has expired and is only held), `mode`, `tick`. `now_ns` is the time
    /// (default now; virtual time in lock-step). Does not wait.
    #[pyo3(signature = (now_ns = None))]
    fn command<'py>(
        &mut self,
        py: Python<'py>,
        now_ns: Option<u64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let now_ns = now_ns.unwrap_or_else(shm_bus::now_ns);
        if let Some(command) = self.newest()? {
            self.execute(&command, now_ns);
        }
        self.setpoints(py, now_ns)
    }

    /// Waits for the command that answers the last state (lock-step) and executes it at the virtual
    /// time `now_ns`. Returns the same dict as `command`; raises TimeoutError after `timeout`
    /// seconds.
    ///
    /// After the end of a goal the daemon stops ticking. If `goal` is given, returns None once it
    /// has ended.
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
                    self.execute(&command, now_ns);
                    return self.setpoints(py, now_ns).map(Some);
                }
                // A late command that answers an earlier state.
                _ if begin.elapsed() > limit => break,
                _ if begin.elapsed() < SPIN => py.detach(std::thread::yield_now),
                _ => {
                    if goal
                        .as_mut()
                        .is_some_and(|goal| goal.has_ended().unwrap_or(true))
                    {
                        return Ok(None);
                    }
                    self.connect_readers()?;
                    pause(py, POLL)?;
                }
            }
        }
        Err(PyTimeoutError::new_err(format!(
            "no command for joint state {} within {timeout} s; check that `atasd --lockstep` runs \
             on this bus and has an active goal",
            self.sent.unwrap_or(0)
        )))
    }

    /// Delivers the last joint state to a daemon that started late.
    fn connect_readers(&self) -> PyResult<()> {
        self.states.get()?.connect_readers().map_err(bus_error)
    }

    /// Number of rejected commands.
    #[getter]
    fn rejected(&self) -> u32 {
        self.validator.map_or(0, |it| it.rejected())
    }

    fn __repr__(&self) -> String {
        format!(
            "<atas.Robot {:?}: {} joints, {} states published, {} commands rejected>",
            self.name,
            self.speeds_rad_s.len(),
            self.stamp.sequence,
            self.rejected()
        )
    }
}

/// Names of the joints, in the order of all joint arrays.
pub(crate) fn joint_names() -> PyResult<Vec<String>> {
    let robot = RobotModel::two_hand_arm().map_err(|why| AtasError::new_err(why.to_string()))?;
    Ok(robot.joints().map(|joint| joint.name.to_string()).collect())
}
