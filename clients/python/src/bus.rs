//! A process's place on a bus.

use std::time::Duration;

use atas_client::Session;
use atas_client::goal::{self, HOLD_S, LIFT_M, Target};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use shm_bus::{Bus as Node, Realtime};
use shm_schemas::{
    ArenaTruth, ControlOp, ControlOutcome, ControlReply, GoalKind, GoalPolicy, GoalRequest, Hand,
    HandFrame, JointCommand, JointState, ModuleEvent, RunHeader, SensorStatus, Status, StopOutcome,
    Text, TickInputs, TickReport, Turn, WorldTruth, service,
};

use crate::errors::{AtasError, of_bus};
use crate::goal::Goal;
use crate::leader::Leader;
use crate::names::{bus_name, hand_of};
use crate::reader::Reader;
use crate::robot::Robot;
use crate::sensor::Sensor;

/// How long a stop may take to be answered.
const STOP: Duration = Duration::from_secs(1);

/// A process's place on a bus: where its arrays come from and go to.
///
/// `name` is the bus (ATAS_BUS, or "atas", if not given). Who only looks or asks joins a bus that is there; who may come first,
/// a sensor or a robot, says `create=True`. `role` is what others see, for example in `atas doctor`. A bus and what it makes
/// belong to the thread that made them; each thread opens its own.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Bus {
    session: Session,
}

#[pymethods]
impl Bus {
    #[new]
    #[pyo3(signature = (name = None, *, role = "python", create = false))]
    fn new(name: Option<&str>, role: &str, create: bool) -> PyResult<Self> {
        let name = bus_name(name)?;
        let join = if create { Node::open } else { Node::join };
        let node = join(&name, role, Realtime::No).map_err(of_bus)?;
        Ok(Self {
            session: Session::of(node),
        })
    }

    /// The bus's name.
    #[getter]
    fn name(&self) -> &str {
        self.node().name().as_str()
    }

    /// The bus's folder; iceoryx2's `global.root-path`, for peers in other languages.
    #[getter]
    fn folder(&self) -> String {
        self.node().folder().display().to_string()
    }

    /// What the bus's names in /dev/shm begin with; iceoryx2's `global.prefix`.
    #[getter]
    fn prefix(&self) -> &str {
        self.node().prefix()
    }

    /// Everyone on the bus: role, process id, whether it is alive.
    fn peers(&self) -> PyResult<Vec<(String, u32, bool)>> {
        let peers = self.node().peers().map_err(of_bus)?;
        Ok(peers
            .into_iter()
            .map(|peer| (peer.role, peer.pid, peer.alive))
            .collect())
    }

    /// Reads the frames of one hand, "left" or "right" (array type `HandFrame`).
    fn frames(&self, hand: &str) -> PyResult<Reader> {
        let service = service::HAND_FRAME[usize::from(hand_of(hand)? != Hand::LEFT)];
        Reader::new::<HandFrame>(self.node(), service)
    }

    /// Reads the robot's joint states (`JointState`).
    fn joint_states(&self) -> PyResult<Reader> {
        Reader::new::<JointState>(self.node(), service::JOINT_STATE)
    }

    /// Reads the daemon's commands (`JointCommand`). Of four places for readers the robot needs one; for looking, reports
    /// serve as well.
    fn commands(&self) -> PyResult<Reader> {
        Reader::new::<JointCommand>(self.node(), service::JOINT_COMMAND)
    }

    /// Reads what each tick felt and did (`TickReport`), one per tick.
    fn reports(&self) -> PyResult<Reader> {
        Reader::new::<TickReport>(self.node(), service::TICK_REPORT)
    }

    /// Reads the daemon's status (`Status`), 50 times a second.
    fn statuses(&self) -> PyResult<Reader> {
        Reader::new::<Status>(self.node(), service::STATUS)
    }

    /// Reads what happened (`ModuleEvent`): modules, touches, steps, modes; the last thousand from before as well.
    fn events(&self) -> PyResult<Reader> {
        Reader::new::<ModuleEvent>(self.node(), service::MODULE_EVENT)
    }

    /// Reads the health of sensors (`SensorStatus`), about ten times a second each.
    fn sensor_statuses(&self) -> PyResult<Reader> {
        Reader::new::<SensorStatus>(self.node(), service::SENSOR_STATUS)
    }

    /// Reads what the simulator knows and the robot does not (`WorldTruth`).
    fn truths(&self) -> PyResult<Reader> {
        Reader::new::<WorldTruth>(self.node(), service::WORLD_TRUTH)
    }

    /// Reads what the host of the swarm's fields knows and no agent senses (`ArenaTruth`), frame by frame.
    fn arenas(&self) -> PyResult<Reader> {
        Reader::new::<ArenaTruth>(self.node(), service::ARENA_TRUTH)
    }

    /// Reads what every tick took in (`TickInputs`); a daemon sends it with `--record-stream`, to one reader.
    fn tick_inputs(&self) -> PyResult<Reader> {
        Reader::new::<TickInputs>(self.node(), service::TICK_INPUTS)
    }

    /// Reads how a recorded run began (`RunHeader`).
    fn run_headers(&self) -> PyResult<Reader> {
        Reader::new::<RunHeader>(self.node(), service::RUN_HEADER)
    }

    /// Feels for one hand: `layout` is "dome-41", "dome-1", "pad-N", "flat-RxC-P" or
    /// "cylinder-RxC-P-Q", as the daemon is configured (`[hands.left] layout`).
    #[pyo3(signature = (hand, *, layout = "dome-41", fingers = 2, device = ""))]
    fn sensor(&self, hand: &str, layout: &str, fingers: usize, device: &str) -> PyResult<Sensor> {
        Sensor::new(self.node(), hand_of(hand)?, layout, fingers, device)
    }

    /// Is the robot: publishes joint states and obeys commands.
    fn robot(&self) -> PyResult<Robot> {
        Robot::new(self.node())
    }

    /// Grasps, lifts and holds what stands at `at` (m, from the robot's base: x forward, y left, z up).
    ///
    /// `width` is the object's along the closing axis, m; `yaw` the direction of that axis, rad from x towards y; `top` how far
    /// the object reaches above `at`, m, and `max_force` what it may be pressed with at most, N, if that is known. The goal
    /// goes on when this process ends, unless `attached`.
    #[pyo3(signature = (at, *, width, yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, hold = HOLD_S, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python's are named")]
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
        let object = target(at, yaw, width).knowing(top, max_force);
        let goal = goal::grasp(&object, hand_of(hand)?, lift, hold);
        self.send(goal, attached)
    }

    /// Carries what stands at `at` to `to`: where the fingertips shall be when it stands there.
    #[pyo3(signature = (at, to, *, width, yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python's are named")]
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
        let object = target(at, yaw, width).knowing(top, max_force);
        let goal = goal::pick_place(&object, hand_of(hand)?, to, lift);
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
        let goal = goal::screw(&target(at, yaw, width), hand_of(hand)?);
        self.send(GoalRequest { turn, ..goal }, attached)
    }

    /// Pursues a task of the daemon's configuration by its name.
    #[pyo3(signature = (name, at, *, width, to = [0.0; 3], yaw = std::f64::consts::FRAC_PI_2, hand = "right", lift = LIFT_M, hold = HOLD_S, top = 0.0, max_force = 0.0, attached = false))]
    #[expect(clippy::too_many_arguments, reason = "Python's are named")]
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
        let object = target(at, yaw, width).knowing(top, max_force);
        let goal = GoalRequest {
            kind: GoalKind::CUSTOM,
            task: Text::new(name),
            hold_s: hold,
            ..goal::pick_place(&object, hand_of(hand)?, to, lift)
        };
        self.send(goal, attached)
    }

    /// Leads a hand ("left", "right" or "both") by a stream of targets, from now on until `Leader.end`. One client at a time may.
    #[pyo3(signature = (hand = "right"))]
    fn follow(&self, py: Python<'_>, hand: &str) -> PyResult<Leader> {
        Leader::open(py, &self.session, hand)
    }

    /// Opens a hand where it is and moves it home.
    #[pyo3(signature = (hand = "right", *, attached = false))]
    fn release(&self, hand: &str, attached: bool) -> PyResult<Goal> {
        let goal = GoalRequest {
            kind: GoalKind::RELEASE,
            hand: hand_of(hand)?,
            ..GoalRequest::default()
        };
        self.send(goal, attached)
    }

    /// Stops the robot now; it stays stopped until `recover`. Goes a way of its own that nothing else can occupy.
    ///
    /// Returns True when a tick has taken the stop, False while it waits for the next one.
    #[pyo3(signature = (reason = "asked from Python"))]
    fn estop(&self, py: Python<'_>, reason: &str) -> PyResult<bool> {
        let name = self.node().name().clone();
        let answer = py
            .detach(|| shm_bus::stop::request(&name, reason, STOP))
            .map_err(of_bus)?;
        Ok(answer.outcome == StopOutcome::STOPPED)
    }

    /// Leaves the stop; the robot then holds until nothing is in doubt.
    fn recover(&self) -> PyResult<()> {
        self.demand(ControlOp::RECOVER, 0.0, "").map(drop)
    }

    /// Ends the goal with this id; nothing if it has ended.
    fn cancel(&self, goal_id: u64) -> PyResult<()> {
        self.demand(ControlOp::CANCEL, 0.0, &goal_id.to_string())
            .map(drop)
    }

    /// Takes the present reading of a hand's sensor as zero force.
    fn bias(&self, hand: &str) -> PyResult<()> {
        self.demand(ControlOp::BIAS, f64::from(hand_of(hand)?.0), "")
            .map(drop)
    }

    /// Every parameter by its name: value, lowest, highest, meaning.
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
        format!("Bus({:?})", self.name())
    }
}

impl Bus {
    fn node(&self) -> &Node {
        self.session.bus()
    }

    fn send(&self, goal: GoalRequest, attached: bool) -> PyResult<Goal> {
        let policy = if attached {
            GoalPolicy::ATTACHED
        } else {
            GoalPolicy::DETACHED
        };
        Goal::send(&self.session, &GoalRequest { policy, ..goal })
    }

    fn ask(&self, op: ControlOp, value: f64, name: &str) -> PyResult<ControlReply> {
        self.session.ask(op, value, name).map_err(of_bus)
    }

    fn demand(&self, op: ControlOp, value: f64, name: &str) -> PyResult<ControlReply> {
        self.session
            .demand(op, value, name)
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

/// Removes a bus that nobody is on: its folder and its shared memory. Returns how many entries that were.
#[pyfunction]
pub(crate) fn wipe(name: &str) -> PyResult<usize> {
    Node::wipe(&bus_name(Some(name))?).map_err(of_bus)
}
