//! The bus: entry point to services, goals and requests.

use std::time::Duration;

use atas_client::goal::{self, HOLD_S, LIFT_M, Target};
use atas_client::{Session, request_stop};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{Bus as Node, Realtime};
use shm_schemas::{
    ArenaTruth, ControlOp, ControlOutcome, ControlReply, GoalKind, GoalPolicy, GoalRequest, Hand,
    HandFrame, JointCommand, JointState, ModuleEvent, RunHeader, SensorStatus, Status, StopOutcome,
    Text, TickInputs, TickReport, Turn, WorldTruth, service,
};

use crate::errors::{AtasError, bus_error};
use crate::goal::Goal;
use crate::names::{bus_name, parse_hand};
use crate::own_thread::OwnThread;
use crate::reader::Reader;
use crate::robot::Robot;
use crate::sensor::Sensor;
use crate::teleop::Teleop;

/// Timeout of a stop request.
const STOP_TIMEOUT: Duration = Duration::from_secs(1);

/// A process's connection to a bus.
///
/// `name` is the bus (default ATAS_BUS, else "atas"). Observers and clients join an existing bus; a
/// sensor or robot that may start first passes `create=True`. `role` is the name shown to others,
/// for example in `atas doctor`. A bus and the objects that it creates belong to one thread; each
/// thread opens its own bus.
#[pyclass(module = "atas")]
pub(crate) struct Bus {
    session: OwnThread<Session>,
}

#[pymethods]
impl Bus {
    #[new]
    #[pyo3(signature = (name = None, *, role = "python", create = false))]
    fn new(name: Option<&str>, role: &str, create: bool) -> PyResult<Self> {
        let name = bus_name(name)?;
        let join = if create { Node::open } else { Node::join };
        let node = join(&name, role, Realtime::No).map_err(bus_error)?;
        Ok(Self {
            session: OwnThread::new(Session::from_bus(node)),
        })
    }

    /// Name of the bus.
    #[getter]
    fn name(&self) -> PyResult<&str> {
        Ok(self.node()?.name().as_str())
    }

    /// Folder of the bus: iceoryx2's `global.root-path`, for peers in other languages.
    #[getter]
    fn folder(&self) -> PyResult<String> {
        Ok(self.node()?.folder().display().to_string())
    }

    /// Prefix of the bus's names in /dev/shm: iceoryx2's `global.prefix`.
    #[getter]
    fn prefix(&self) -> PyResult<&str> {
        Ok(self.node()?.prefix())
    }

    /// Returns all processes on the bus: role, process id, whether it is alive.
    fn peers(&self) -> PyResult<Vec<(String, u32, bool)>> {
        let peers = self.node()?.peers().map_err(bus_error)?;
        Ok(peers
            .into_iter()
            .map(|peer| (peer.role, peer.pid, peer.alive))
            .collect())
    }

    /// Returns a reader of one hand's frames, "left" or "right" (`HandFrame`).
    fn frames(&self, hand: &str) -> PyResult<Reader> {
        let service = service::HAND_FRAME[usize::from(parse_hand(hand)? != Hand::LEFT)];
        Reader::new::<HandFrame>(self.node()?, service)
    }

    /// Returns a reader of the robot's joint states (`JointState`).
    fn joint_states(&self) -> PyResult<Reader> {
        Reader::new::<JointState>(self.node()?, service::JOINT_STATE)
    }

    /// Returns a reader of the daemon's commands (`JointCommand`). The robot needs one of the four
    /// reader slots; observers can use `reports`.
    fn commands(&self) -> PyResult<Reader> {
        Reader::new::<JointCommand>(self.node()?, service::JOINT_COMMAND)
    }

    /// Returns a reader of the tick reports (`TickReport`), one per tick.
    fn reports(&self) -> PyResult<Reader> {
        Reader::new::<TickReport>(self.node()?, service::TICK_REPORT)
    }

    /// Returns a reader of the daemon's status (`Status`), 50 Hz.
    fn statuses(&self) -> PyResult<Reader> {
        Reader::new::<Status>(self.node()?, service::STATUS)
    }

    /// Returns a reader of events (`ModuleEvent`): modules, touches, steps, modes, including the
    /// last thousand.
    fn events(&self) -> PyResult<Reader> {
        Reader::new::<ModuleEvent>(self.node()?, service::MODULE_EVENT)
    }

    /// Returns a reader of sensor health (`SensorStatus`), about 10 Hz per sensor.
    fn sensor_statuses(&self) -> PyResult<Reader> {
        Reader::new::<SensorStatus>(self.node()?, service::SENSOR_STATUS)
    }

    /// Returns a reader of the simulator's ground truth (`WorldTruth`).
    fn truths(&self) -> PyResult<Reader> {
        Reader::new::<WorldTruth>(self.node()?, service::WORLD_TRUTH)
    }

    /// Returns a reader of the swarm fields' ground truth (`ArenaTruth`), frame by frame.
    fn arenas(&self) -> PyResult<Reader> {
        Reader::new::<ArenaTruth>(self.node()?, service::ARENA_TRUTH)
    }

    /// Returns a reader of the inputs of every tick (`TickInputs`). The daemon sends them with
    /// `--record-stream`, to one reader.
    fn tick_inputs(&self) -> PyResult<Reader> {
        Reader::new::<TickInputs>(self.node()?, service::TICK_INPUTS)
    }

    /// Returns a reader of the headers of recorded runs (`RunHeader`).
    fn run_headers(&self) -> PyResult<Reader> {
        Reader::new::<RunHeader>(self.node()?, service::RUN_HEADER)
    }

    /// Returns a sensor for one hand. `layout` is "dome-41", "dome-1", "pad-N", "flat-RxC-P" or
    /// "cylinder-RxC-P-Q", as configured in the daemon (`[hands.left] layout`).
    #[pyo3(signature = (hand, *, layout = "dome-41", fingers = 2, device = ""))]
    fn sensor(&self, hand: &str, layout: &str, fingers: usize, device: &str) -> PyResult<Sensor> {
        Sensor::new(self.node()?, parse_hand(hand)?, layout, fingers, device)
    }

    /// Returns the robot: publishes joint states and executes commands. `model` is the daemon's
    /// robot: a built-in name or the path of a robot file, default "two-hand-arm".
    #[pyo3(signature = (model = None))]
    fn robot(&self, model: Option<&str>) -> PyResult<Robot> {
        Robot::new(self.node()?, model)
    }

    /// Grasps, lifts and holds the object at `at` (m, robot base frame: x forward, y left, z up).
    ///
    /// `width` is the object's width along the closing axis, m; `yaw` the direction of that axis,
    /// rad from x towards y. Optional knowledge: `top` is the object's height above `at`, m, and
    /// `max_force` its force limit, N. The goal continues after this process ends, unless
    /// `attached`.
    #[pyo3(signature = (at, *, width, yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, hold = HOLD_S, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python has keyword arguments")]
    fn grasp(
        &self,
        at: [f64; 3],
        width: f64,
        yaw: f64,
        hand: &str,
        lift: f64,
        hold: f64,
        top: f64,
        max_force: f64,
        attached: bool,
    ) -> PyResult<Goal> {
        let object = target(at, yaw, width).with_limits(top, max_force);
        let goal = goal::grasp(&object, parse_hand(hand)?, lift, hold);
        self.send(goal, attached)
    }

    /// Moves the object at `at` to `to`: the grasp centre when the object stands at its target.
    #[pyo3(signature = (at, to, *, width, yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python has keyword arguments")]
    fn pick_place(
        &self,
        at: [f64; 3],
        to: [f64; 3],
        width: f64,
        yaw: f64,
        hand: &str,
        lift: f64,
        top: f64,
        max_force: f64,
        attached: bool,
    ) -> PyResult<Goal> {
        let object = target(at, yaw, width).with_limits(top, max_force);
        let goal = goal::pick_place(&object, parse_hand(hand)?, to, lift);
        self.send(goal, attached)
    }

    /// Closes the cap at `at`, clockwise seen from above if `clockwise`.
    #[pyo3(signature = (at, *, width, yaw = std::f64::consts::FRAC_PI_2, hand = "right", clockwise = true, attached = false))]
    fn screw(
        &self,
        at: [f64; 3],
        width: f64,
        yaw: f64,
        hand: &str,
        clockwise: bool,
        attached: bool,
    ) -> PyResult<Goal> {
        let turn = if clockwise {
            Turn::CLOCKWISE
        } else {
            Turn::ANTICLOCKWISE
        };
        let goal = goal::screw(&target(at, yaw, width), parse_hand(hand)?);
        self.send(GoalRequest { turn, ..goal }, attached)
    }

    /// Runs a task of the daemon's configuration by its name.
    #[pyo3(signature = (name, at, *, width, to = [0.0; 3], yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, hold = HOLD_S, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python has keyword arguments")]
    fn task(
        &self,
        name: &str,
        at: [f64; 3],
        width: f64,
        to: [f64; 3],
        yaw: f64,
        hand: &str,
        lift: f64,
        hold: f64,
        top: f64,
        max_force: f64,
        attached: bool,
    ) -> PyResult<Goal> {
        let object = target(at, yaw, width).with_limits(top, max_force);
        let goal = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new(name),
            hold_s: hold,
            ..goal::pick_place(&object, parse_hand(hand)?, to, lift)
        };
        self.send(goal, attached)
    }

    /// Starts teleoperation of a hand ("left", "right" or "both") by a stream of targets, until
    /// `Teleop.end`. Only one client at a time may teleoperate.
    #[pyo3(signature = (hand = "right"))]
    fn teleop(&self, py: Python<'_>, hand: &str) -> PyResult<Teleop> {
        Teleop::open(py, self.session.get()?, hand)
    }

    /// Opens a hand at its current position and moves it home.
    #[pyo3(signature = (hand = "right", *, attached = false))]
    fn release(&self, hand: &str, attached: bool) -> PyResult<Goal> {
        let goal = GoalRequest {
            kind: GoalKind::RELEASE,
            hand: parse_hand(hand)?,
            ..GoalRequest::default()
        };
        self.send(goal, attached)
    }

    /// Stops the robot until `recover`. Uses a separate channel that other requests cannot block,
    /// and a control request if that channel does not answer.
    ///
    /// Returns True when a tick has executed the stop, False while it is pending.
    #[pyo3(signature = (reason = "requested from Python"))]
    fn estop(&self, py: Python<'_>, reason: &str) -> PyResult<bool> {
        let name = self.node()?.name().clone();
        let answer = py
            .detach(|| request_stop(&name, reason, STOP_TIMEOUT))
            .map_err(bus_error)?;
        Ok(answer.outcome == StopOutcome::STOPPED)
    }

    /// Ends the stop; the robot then holds until all inputs are valid.
    fn recover(&self) -> PyResult<()> {
        self.demand(ControlOp::RECOVER, 0.0, "").map(drop)
    }

    /// Cancels the goal with this id; no effect if it has ended.
    fn cancel(&self, goal_id: u64) -> PyResult<()> {
        self.demand(ControlOp::CANCEL, 0.0, &goal_id.to_string())
            .map(drop)
    }

    /// Sets the current reading of a hand's sensor as zero force.
    fn bias(&self, hand: &str) -> PyResult<()> {
        self.demand(ControlOp::BIAS, f64::from(parse_hand(hand)?.0), "")
            .map(drop)
    }

    /// Returns all parameters by name: value, lower limit, upper limit, description.
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for index in 0_u32.. {
            let reply = self.ask(ControlOp::PARAM_LIST, f64::from(index), "")?;
            if reply.outcome != ControlOutcome::DONE {
                break;
            }
            let (name, meaning) = reply
                .text
                .as_str()
                .split_once('\n')
                .unwrap_or((reply.text.as_str(), ""));
            all.set_item(name, (reply.value, reply.lower, reply.upper, meaning))?;
        }
        Ok(all)
    }

    /// Sets a parameter of the daemon, for example `grasp.f2_max_n`.
    fn set_parameter(&self, name: &str, value: f64) -> PyResult<()> {
        self.demand(ControlOp::PARAM_SET, value, name).map(drop)
    }

    fn __repr__(&self) -> String {
        self.name().map_or_else(
            |_| "<atas.Bus of another thread or process>".to_owned(),
            |name| format!("Bus({name:?})"),
        )
    }
}

impl Bus {
    fn node(&self) -> PyResult<&Node> {
        Ok(self.session.get()?.bus())
    }

    fn send(&self, goal: GoalRequest, attached: bool) -> PyResult<Goal> {
        let policy = if attached {
            GoalPolicy::ATTACHED
        } else {
            GoalPolicy::DETACHED
        };
        Goal::send(self.session.get()?, &GoalRequest { policy, ..goal })
    }

    fn ask(&self, op: ControlOp, value: f64, name: &str) -> PyResult<ControlReply> {
        self.session
            .get()?
            .request(op, value, name)
            .map_err(bus_error)
    }

    fn demand(&self, op: ControlOp, value: f64, name: &str) -> PyResult<ControlReply> {
        self.session
            .get()?
            .request_success(op, value, name)
            .map_err(|why| AtasError::new_err(why.to_string()))
    }
}

fn target(at_m: [f64; 3], yaw_rad: f64, width_m: f64) -> Target {
    Target {
        at_m,
        yaw_rad,
        width_m,
        ..Target::default()
    }
}

/// Removes the folder and the shared memory of an unused bus. Returns the number of removed
/// entries.
#[pyfunction]
pub(crate) fn wipe(name: &str) -> PyResult<usize> {
    Node::wipe(&bus_name(Some(name))?).map_err(bus_error)
}
