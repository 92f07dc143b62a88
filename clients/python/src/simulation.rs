//! The simulator with the production controller, in process.

use atas_client::GoalProgress;
use atas_core::{OperatorRequest, Outputs};
use atas_evaluation::drawing::SceneView;
use atas_evaluation::offline::OfflineRun;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{RobotFiles, RobotModel, TWO_HAND_ARM};
use shm_schemas::{
    GoalKind, GoalPolicy, GoalRequest, GraspTarget, GripOrder, HandFrame, JointCommand, JointState,
    ModuleEvent, Stamp, TickReport,
};
use sim_backend::GraspHint;

use crate::compute;
use crate::errors::AtasError;
use crate::goal::{goal_dict, goal_words};
use crate::names::{parse_hand, side_of};
use crate::picture::{self, Picture};
use crate::reader::seconds;
use crate::rows::{self, Row};
use crate::scene::{parse_settings, scene_of};
use crate::teleop::check_finite;

/// The simulator with the production controller in one process and in virtual time, without bus,
/// clock or daemon.
///
/// `scene` is "grasp", "pick-place", "screw" or "assembly". `object` is a built-in object (see
/// `objects()`) or the path of a TOML file. `robot` is a built-in robot (`atas robot list`) or the
/// path of a robot file, default "two-hand-arm"; the scene moves to its `hand`, default "right" if
/// the robot has it. With `vary`, the seed draws the object from its family. `noise` scales the
/// sensor noise, `rate_hz` is the sensor rate. `settings` changes controller parameters, for
/// example `{"grasp.f2_max_n": 6.0}`. Equal arguments give equal bits.
#[pyclass(module = "atas")]
pub(crate) struct Simulation {
    run: OfflineRun,
    robot: RobotModel,
    setup: Setup,
    view: SceneView,
    goal: GoalRequest,
    hint: GraspHint,
    targets: TeleopTargets,
    request: Option<OperatorRequest>,
    progress: GoalProgress,
    last: LastOutputs,
}

/// Arguments of a simulation, for its text.
struct Setup {
    scene: String,
    object: String,
    robot: String,
    seed: u64,
}

/// Numbering of teleoperation targets.
#[derive(Default)]
struct TeleopTargets {
    is_open: bool,
    sequence: u64,
}

/// Outputs of the last ticks.
#[derive(Default)]
struct LastOutputs {
    command: JointCommand,
    events: Vec<Row<ModuleEvent>>,
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (object = None, *, scene = "grasp", seed = 0, hand = None, vary = true, noise = 1.0, rate_hz = 1000, settings = None, robot = None))]
    #[expect(clippy::too_many_arguments, reason = "Python has keyword arguments")]
    fn new(
        object: Option<&str>,
        scene: &str,
        seed: u64,
        hand: Option<&str>,
        vary: bool,
        noise: f64,
        rate_hz: u32,
        settings: Option<&Bound<'_, PyDict>>,
        robot: Option<&str>,
    ) -> PyResult<Self> {
        let default = TWO_HAND_ARM.name;
        let files = RobotFiles::find(robot.unwrap_or(&default));
        let files = files.map_err(|why| PyValueError::new_err(why.to_string()))?;
        let robot = files
            .load()
            .map_err(|why| PyValueError::new_err(why.to_string()))?;
        let side = side_of(&robot, &files.name, hand)?;
        let (mut set, goal) = scene_of(scene, object, &robot, side)?;
        set.noise_factor = noise;
        set.sensor_rate_hz = [rate_hz; 2];
        if vary {
            set = set.varied(seed);
        }
        let goal = goal(&set).ok_or_else(|| PyValueError::new_err("the scene has no goal"))?;
        let hint = set.grasp_hint(0);
        let hint = hint.ok_or_else(|| PyValueError::new_err("the scene has no object"))?;
        let settings = parse_settings(settings)?;
        let setup = Setup {
            scene: scene.to_owned(),
            object: set.objects[0].object.name.clone(),
            robot: files.name.to_string(),
            seed,
        };
        let view = SceneView::new(picture::load_links(&files)?, &robot, side, &set);
        let run = OfflineRun::new(&robot, &set, seed, settings)
            .map_err(|why| PyValueError::new_err(why.to_string()))?;
        Ok(Self {
            run,
            robot,
            setup,
            view,
            goal,
            hint,
            targets: TeleopTargets::default(),
            request: None,
            progress: GoalProgress::default(),
            last: LastOutputs::default(),
        })
    }

    /// Starts the scene's goal with the next tick, with the knowledge of a real client. Raises
    /// ValueError with the reason if the controller rejects it.
    fn start(&mut self) -> PyResult<()> {
        let circumstances = self.run.controller().goal_context(&self.robot, &[]);
        let checked = atas_core::check::check(&self.goal, &circumstances);
        let goal =
            checked.map_err(|reason| PyValueError::new_err(format!("goal rejected: {reason}")))?;
        self.request = Some(OperatorRequest::Start(goal));
        self.progress = GoalProgress::default();
        Ok(())
    }

    /// Starts teleoperation of the scene's hand instead of the scene's goal, and runs one tick.
    /// `send` passes targets to it; the tactile modules control the grip force. Raises ValueError
    /// with the reason if the controller rejects it.
    fn teleoperate(&mut self, py: Python<'_>) -> PyResult<()> {
        if self.targets.is_open && !has_ended(&self.progress) {
            return Err(PyValueError::new_err(
                "teleoperation rejected: it runs already; call `send`",
            ));
        }
        let request = GoalRequest {
            stamp: self.teleop_stamp(),
            goal_id: 1,
            kind: GoalKind::TELEOP,
            hand: self.goal.hand,
            policy: GoalPolicy::ATTACHED,
            ..GoalRequest::default()
        };
        let order = self.run.request(&request);
        let order =
            order.map_err(|reason| PyValueError::new_err(format!("goal rejected: {reason}")))?;
        self.request = Some(order);
        self.progress = GoalProgress::default();
        self.targets.is_open = true;
        self.advance(py, 1, |_, _| true)
    }

    /// Sends a target of the running teleoperation: see `Teleop.send`. It counts from the next tick
    /// on, for `valid` seconds of virtual time. Raises AtasError with the reason once the
    /// teleoperation has ended.
    #[pyo3(signature = (at, opening, *, yaw = std::f64::consts::FRAC_PI_2, valid = 0.4))]
    fn send(&mut self, at: [f64; 3], opening: Option<f64>, yaw: f64, valid: f64) -> PyResult<()> {
        check_finite(at, opening, yaw)?;
        if !self.targets.is_open {
            return Err(PyValueError::new_err(
                "target rejected: no teleoperation runs; call `teleoperate` first",
            ));
        }
        if has_ended(&self.progress) {
            return Err(AtasError::new_err(self.progress.text()));
        }
        let valid_ns = u64::try_from(seconds(valid)?.as_nanos()).unwrap_or(u64::MAX);
        let stamp = self.teleop_stamp();
        let mut target = GraspTarget {
            valid_until_ns: stamp.captured_ns.saturating_add(valid_ns),
            stamp,
            hand: self.goal.hand,
            grip: opening.map_or(GripOrder::HOLD, |_| GripOrder::WIDTH),
            centre_m: at,
            closing_yaw_rad: yaw,
            opening_m: opening.unwrap_or(0.0),
            ..GraspTarget::default()
        };
        target.seal();
        self.targets.sequence += 1;
        self.run.push_target(target);
        Ok(())
    }

    /// Data of the scene's object that a client may know: `at` (m), `yaw` (rad), `width` (m) and
    /// `top` (m). The true object differs slightly.
    #[getter]
    fn hint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let known = PyDict::new(py);
        known.set_item("at", self.hint.from_m)?;
        known.set_item("yaw", self.hint.yaw_rad)?;
        known.set_item("width", self.hint.width_m)?;
        known.set_item("top", self.hint.height_m)?;
        Ok(known)
    }

    /// Runs ticks of 1 ms, at most 1,000,000: sense, control, move. Returns the report of each tick
    /// (`TickReport`). Ctrl-C ends it between two ticks.
    #[pyo3(signature = (ticks = 1))]
    fn step<'py>(&mut self, py: Python<'py>, ticks: u64) -> PyResult<Bound<'py, PyAny>> {
        if ticks > TICKS_MAX {
            return Err(PyValueError::new_err(format!(
                "could not step: {ticks} ticks, at most {TICKS_MAX}; call `step` several times, or `run`"
            )));
        }
        let mut reports: Vec<Row<TickReport>> = Vec::new();
        self.advance(py, ticks, |report, _| {
            reports.push(Row(report));
            true
        })?;
        Ok(rows::array(py, reports))
    }

    /// Runs the goal to its end, at most `limit_s` of simulated time; starts it if necessary.
    /// Returns the `result`.
    #[pyo3(signature = (limit_s = 120.0))]
    fn run<'py>(&mut self, py: Python<'py>, limit_s: f64) -> PyResult<Bound<'py, PyDict>> {
        let ticks = u64::try_from(seconds(limit_s)?.as_millis()).unwrap_or(u64::MAX);
        if self.request.is_none() && self.progress.last().goal_id == 0 {
            self.start()?;
        }
        if !has_ended(&self.progress) {
            self.advance(py, ticks, |_, progress| !has_ended(progress))?;
        }
        self.result(py)
    }

    /// State of the goal; see `Goal.result`.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        goal_dict(py, &self.progress)
    }

    /// Frame of a hand's fingertips in the last tick (`HandFrame`); None if a slow sensor had no
    /// new frame.
    fn frame<'py>(&self, py: Python<'py>, hand: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let frame: &Option<HandFrame> =
            &self.run.sensed().frames[usize::from(parse_hand(hand)? != shm_schemas::Hand::LEFT)];
        frame.as_ref().map(|frame| rows::row(py, frame)).transpose()
    }

    /// Joint state in the last tick (`JointState`).
    #[getter]
    fn joint_state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state: &JointState = &self.run.sensed().joints;
        rows::row(py, state)
    }

    /// Command of the last tick (`JointCommand`).
    #[getter]
    fn command<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows::row(py, &self.last.command)
    }

    /// Events of the last call of `step` or `run` (`ModuleEvent`).
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        rows::array(py, self.last.events.clone())
    }

    /// Ground truth of the simulator, unknown to the controller (`WorldTruth`).
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows::row(py, &self.run.world().truth())
    }

    /// Mode of the controller (`Mode`).
    #[getter]
    fn mode(&self) -> u32 {
        self.run.controller().mode().0.0
    }

    /// Virtual time, ns.
    #[getter]
    fn now_ns(&self) -> u64 {
        self.run.world().now_ns()
    }

    /// Name or robot file of the robot.
    #[getter]
    fn robot(&self) -> &str {
        &self.setup.robot
    }

    /// Picture of the hand and its objects, seen obliquely: an array of uint8 (height, width, 3).
    /// Fingertips are green, objects blue, or red once crushed, dropped or tipped; the dashed line
    /// is the closing axis. The table has a grid of 100 mm.
    #[pyo3(signature = (width = 640, height = 480))]
    fn render<'py>(&self, py: Python<'py>, width: u32, height: u32) -> PyResult<Picture<'py>> {
        let truth = self.run.world().truth();
        picture::draw(py, &self.view, self.positions(), &truth, [width, height])
    }

    /// Picture of `render` as SVG, which notebooks display.
    fn _repr_svg_(&self) -> PyResult<String> {
        let truth = self.run.world().truth();
        let drawing = self.view.draw(self.positions(), &truth, NOTEBOOK_PX);
        let drawing = drawing.map_err(|why| PyValueError::new_err(why.to_string()))?;
        Ok(drawing.svg(&self.__repr__()))
    }

    fn __repr__(&self) -> String {
        let Setup {
            scene,
            object,
            robot,
            seed,
        } = &self.setup;
        format!(
            "<atas.Simulation {scene:?} with {object:?}, robot {robot:?}, seed {seed}: {:.3} s, {}, \
             {}>",
            self.run.ticks() as f64 * 1e-3,
            self.run.controller().mode().0.name(),
            goal_words(&self.progress)
        )
    }
}

/// Most ticks per call of `step`, which keeps their reports: 1000 s, about 0.4 GB.
const TICKS_MAX: u64 = 1_000_000;
/// Size of a picture in a notebook, px.
const NOTEBOOK_PX: [u32; 2] = [480, 360];
/// Ticks between two checks for Ctrl-C.
const TICKS_UNCHECKED: u64 = 1000;

fn has_ended(progress: &GoalProgress) -> bool {
    progress.last().goal_id != 0 && progress.last().state.is_final()
}

/// Writer epoch of teleoperation targets. Any value different from a sensor's.
const TELEOP_EPOCH: u64 = 0x7465_6c65_6f70;

impl Simulation {
    /// Measured positions of all joints, rad or m.
    fn positions(&self) -> &[f64] {
        let joints = &self.run.sensed().joints;
        &joints.position[..joints.joint_count as usize]
    }

    /// Stamp of the next target, or of the request for teleoperation.
    fn teleop_stamp(&self) -> Stamp {
        Stamp {
            sequence: self.targets.sequence,
            captured_ns: self.run.world().now_ns(),
            writer_epoch: TELEOP_EPOCH,
        }
    }

    /// Runs ticks until `each` returns false, with the Python lock released.
    fn advance(
        &mut self,
        py: Python<'_>,
        ticks: u64,
        mut each: impl FnMut(TickReport, &GoalProgress) -> bool + Send,
    ) -> PyResult<()> {
        self.last.events.clear();
        let (mut left, mut goes_on) = (ticks, true);
        while left > 0 && goes_on {
            let some = left.min(TICKS_UNCHECKED);
            let Self {
                run,
                request,
                progress,
                last,
                ..
            } = self;
            goes_on = compute(py, || {
                (0..some).all(|_| {
                    let report = last.update(run.step(request.take().as_ref()), progress);
                    each(report, progress)
                })
            })?;
            left -= some;
            self.check()?;
            py.check_signals()?;
        }
        Ok(())
    }

    fn check(&self) -> PyResult<()> {
        self.run
            .world()
            .fault()
            .map_or(Ok(()), |fault| Err(AtasError::new_err(fault.to_string())))
    }
}

impl LastOutputs {
    fn update(&mut self, outputs: &Outputs, progress: &mut GoalProgress) -> TickReport {
        self.command = outputs.command;
        self.events
            .extend(outputs.events.as_slice().iter().map(|event| Row(*event)));
        outputs
            .goal_update
            .iter()
            .for_each(|update| progress.add(update));
        outputs.report
    }
}
