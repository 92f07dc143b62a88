//! The simulator with the production controller in process.

use atas_client::GoalProgress;
use atas_client::goal::{HOLD_S, LIFT_M};
use atas_core::{Order, Outputs, Settings};
use atas_evaluation::offline::{
    OfflineRun, assemble_goal, grasp_goal, pick_place_goal, screw_goal,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{RobotModel, Side};
use shm_schemas::{GoalRequest, HandFrame, JointCommand, JointState, ModuleEvent, TickReport};
use sim_backend::{Object, Scene};

use crate::errors::{AtasError, failed};
use crate::goal::described;
use crate::names::hand_of;
use crate::rows::{self, Row};

/// The simulator with the production controller in one process, in virtual time: no bus, no clock, no daemon.
///
/// `scene` is "grasp", "pick-place", "screw" or "assembly"; `object` a built-in object (see `objects()`) or the path of a TOML
/// file. With `vary` the true object is drawn from its family by the seed. `noise` scales the sensors' noise, `rate_hz` is their
/// rate. `settings` changes parameters of the controller, for example `{"grasp.f2_max_n": 6.0}`. The same arguments give the
/// same bits.
#[pyclass(unsendable, module = "atas")]
pub(crate) struct Simulation {
    run: OfflineRun,
    robot: RobotModel,
    goal: GoalRequest,
    order: Option<Order>,
    progress: GoalProgress,
    told: Told,
}

/// What the last ticks told.
#[derive(Default)]
struct Told {
    command: JointCommand,
    events: Vec<Row<ModuleEvent>>,
}

#[pymethods]
impl Simulation {
    #[new]
    #[pyo3(signature = (object = None, *, scene = "grasp", seed = 0, hand = "right", vary = true, noise = 1.0, rate_hz = 1000, settings = None))]
    #[expect(clippy::too_many_arguments, reason = "Python's are named")]
    fn new(
        object: Option<&str>,
        scene: &str,
        seed: u64,
        hand: &str,
        vary: bool,
        noise: f64,
        rate_hz: u32,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        let side = Side::BOTH[usize::from(hand_of(hand)? != shm_schemas::Hand::LEFT)];
        let (mut set, goal) = scene_of(scene, object, side)?;
        set.noise_factor = noise;
        set.sensor_rate_hz = [rate_hz; 2];
        if vary {
            set = set.varied(seed);
        }
        let goal =
            goal(&set).ok_or_else(|| PyValueError::new_err("the scene has nothing to do"))?;
        let settings = changed(settings)?;
        let robot =
            RobotModel::two_hand_arm().map_err(|why| AtasError::new_err(why.to_string()))?;
        let run = OfflineRun::new(&robot, &set, seed, settings)
            .map_err(|why| PyValueError::new_err(why.to_string()))?;
        Ok(Self {
            run,
            robot,
            goal,
            order: None,
            progress: GoalProgress::default(),
            told: Told::default(),
        })
    }

    /// Gives the controller the goal of the scene, as a client would who knows what he is told of it. It begins with the next
    /// tick; raises ValueError with the controller's sentence if it refuses.
    fn start(&mut self) -> PyResult<()> {
        let circumstances = self.run.controller().circumstances(&self.robot, &[]);
        let checked = atas_core::check::check(&self.goal, &circumstances);
        let goal = checked
            .map_err(|reason| PyValueError::new_err(format!("the goal was refused: {reason}")))?;
        self.order = Some(Order::Start(goal));
        self.progress = GoalProgress::default();
        Ok(())
    }

    /// So many ticks of 1 ms: sense, decide, move. Returns what each tick felt and did (`TickReport`).
    #[pyo3(signature = (ticks = 1))]
    fn step<'py>(&mut self, py: Python<'py>, ticks: usize) -> PyResult<Bound<'py, PyAny>> {
        let mut reports: Vec<Row<TickReport>> = Vec::with_capacity(ticks);
        self.told.events.clear();
        let Self {
            run,
            order,
            progress,
            told,
            ..
        } = self;
        py.detach(|| {
            for _ in 0..ticks {
                reports.push(Row(told.take(run.step(order.take().as_ref()), progress)));
            }
        });
        self.check()?;
        Ok(rows::array(py, reports))
    }

    /// Starts the goal if none was started, and runs to its end, at most `limit_s` of simulated time. Returns what `result`
    /// is then.
    #[pyo3(signature = (limit_s = 120.0))]
    fn run<'py>(&mut self, py: Python<'py>, limit_s: f64) -> PyResult<Bound<'py, PyDict>> {
        if self.order.is_none() && self.progress.last().goal_id == 0 {
            self.start()?;
        }
        self.told.events.clear();
        let ticks = (limit_s * 1e3) as u64;
        let mut left = ticks;
        while left > 0
            && !(self.progress.last().goal_id != 0 && self.progress.last().state.is_final())
        {
            let Self {
                run,
                order,
                progress,
                told,
                ..
            } = self;
            // A second at a time, so that Ctrl-C gets through.
            let some = left.min(1000);
            py.detach(|| {
                for _ in 0..some {
                    told.take(run.step(order.take().as_ref()), progress);
                    if progress.last().goal_id != 0 && progress.last().state.is_final() {
                        break;
                    }
                }
            });
            left -= some;
            py.check_signals()?;
            self.check()?;
        }
        self.result(py)
    }

    /// How the goal stands; see `Goal.result`.
    #[getter]
    fn result<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        described(py, &self.progress)
    }

    /// What a hand's fingertips sensed in the last tick (`HandFrame`), or None if a slow sensor had nothing new.
    fn frame<'py>(&self, py: Python<'py>, hand: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let frame: &Option<HandFrame> =
            &self.run.sensed().frames[usize::from(hand_of(hand)? != shm_schemas::Hand::LEFT)];
        frame.as_ref().map(|frame| rows::row(py, frame)).transpose()
    }

    /// The joints in the last tick (`JointState`).
    #[getter]
    fn joint_state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state: &JointState = &self.run.sensed().joints;
        rows::row(py, state)
    }

    /// The command of the last tick (`JointCommand`).
    #[getter]
    fn command<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows::row(py, &self.told.command)
    }

    /// What happened in the last call of `step` or `run` (`ModuleEvent`).
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> Bound<'py, PyAny> {
        rows::array(py, self.told.events.clone())
    }

    /// What the simulator knows and the controller does not (`WorldTruth`).
    #[getter]
    fn truth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        rows::row(py, &self.run.world().truth())
    }

    /// The controller's mode (`Mode`).
    #[getter]
    fn mode(&self) -> u32 {
        self.run.controller().mode().0.0
    }

    /// Virtual time, ns.
    #[getter]
    fn now_ns(&self) -> u64 {
        self.run.world().now_ns()
    }
}

impl Simulation {
    fn check(&self) -> PyResult<()> {
        self.run
            .world()
            .fault()
            .map_or(Ok(()), |fault| Err(AtasError::new_err(fault.to_string())))
    }
}

impl Told {
    fn take(&mut self, outputs: &Outputs, progress: &mut GoalProgress) -> TickReport {
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

type GoalOf = Box<dyn Fn(&Scene) -> Option<GoalRequest>>;

/// A scene by its name, and the goal that belongs to it once it is drawn.
fn scene_of(name: &str, object: Option<&str>, side: Side) -> PyResult<(Scene, GoalOf)> {
    let found = |name: &str| {
        Object::named_or_file(name).map_err(|why| PyValueError::new_err(why.to_string()))
    };
    let thing = || found(object.unwrap_or(Scene::OBJECT));
    let (cap, bottle) = (
        || found(object.unwrap_or(Scene::CAP)),
        || found(Scene::BOTTLE),
    );
    Ok(match name {
        "grasp" => (
            Scene::grasp(thing()?, side),
            Box::new(move |scene| {
                Some(numbered(grasp_goal(
                    &scene.grasp_hint(0)?,
                    side,
                    LIFT_M,
                    HOLD_S,
                )))
            }),
        ),
        "pick-place" => (
            Scene::pick_place(thing()?, side),
            Box::new(move |scene| {
                let place = scene.place?;
                let goal = pick_place_goal(&scene.grasp_hint(0)?, side, &place, LIFT_M);
                Some(numbered(goal))
            }),
        ),
        "screw" => (
            Scene::screw(cap()?, bottle()?, side),
            Box::new(move |scene| Some(numbered(screw_goal(&scene.grasp_hint(0)?, side)))),
        ),
        "assembly" => (
            Scene::assembly(cap()?, bottle()?, side),
            Box::new(move |scene| {
                let (cap, bottle) = (scene.grasp_hint(0)?, scene.grasp_hint(1)?);
                Some(numbered(assemble_goal(
                    &cap,
                    &scene.place?,
                    bottle.width_m,
                    side,
                )))
            }),
        ),
        _ => {
            return Err(PyValueError::new_err(format!(
                "a scene was {name:?}, needs \"grasp\", \"pick-place\", \"screw\" or \"assembly\""
            )));
        }
    })
}

/// Every goal of a simulation is its first.
fn numbered(goal: GoalRequest) -> GoalRequest {
    GoalRequest { goal_id: 1, ..goal }
}

fn changed(settings: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    let mut changed = Settings::default();
    for (name, value) in settings.into_iter().flat_map(|it| it.iter()) {
        let (name, value): (String, f64) = (name.extract()?, value.extract()?);
        changed.set(&name, value).map_err(|why| {
            PyValueError::new_err(format!("could not set {name:?} to {value}: {why}"))
        })?;
    }
    changed
        .check()
        .map_err(|why| failed(anyhow::anyhow!("the settings contradict each other: {why}")))?;
    Ok(changed)
}

/// Names of the built-in objects that can be grasped.
#[pyfunction]
pub(crate) fn objects() -> Vec<&'static str> {
    Object::names().collect()
}
