//! One trial: a family member, its world, a goal from nominal knowledge, and the evaluation.

use anyhow::Context;
use atas_client::GoalProgress;
use robot_model::RobotModel;
use rustix::time::{ClockId, clock_gettime};
use serde::{Deserialize, Serialize};
use shm_schemas::GoalRequest;
use sim_backend::engine::EnginePool;
use sim_backend::random::{split_mix, trial_seed};
use sim_backend::{Scene, World};

use crate::Task;
use crate::drawn::Drawn;
use crate::finding::{Finding, evaluate};
use crate::held::discarded;
use crate::judge::Load;
use crate::offline::OfflineRun;
use crate::plan::{Job, Plan};
use crate::sensor_variant::SensorVariant;

/// Derives the noise-scale seed from the trial's seed. The value is arbitrary.
const NOISE_STREAM: u64 = 0x6e_6f69_7365;

/// Result of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Index of the object in the plan.
    pub object: usize,
    /// Seed of the trial, as users number it.
    pub number: u64,
    /// Values drawn at random.
    pub drawn: Drawn,
    /// Forces that decide feasibility; `None` for caps, which are always feasible.
    pub load: Option<Load>,
    /// Evaluation of the outcome.
    pub finding: Finding,
    /// Largest force of a fingertip on an object, N.
    pub max_force_n: f64,
    /// Simulated time, s.
    pub simulated_s: f64,
    /// Processor time of this thread, s; with an external engine, elapsed time. All other fields
    /// depend on the plan only.
    pub cpu_s: f64,
}

/// Records of one trial per sensor variant, with the caller's data.
pub type VariantTrial<T> = (Vec<Record>, T);

impl Record {
    /// Returns true if the task is feasible under the paper's rule.
    #[must_use]
    pub fn feasible(&self) -> bool {
        self.load.is_none_or(|load| load.is_feasible())
    }

    /// Returns true if the task is feasible by physics alone.
    #[must_use]
    pub fn feasible_by_physics(&self) -> bool {
        self.load.is_none_or(|load| load.is_physically_feasible())
    }

    /// Returns the failure key under the paper's rule; `None` on success.
    #[must_use]
    pub fn failure(&self) -> Option<&str> {
        self.finding.failure(self.feasible())
    }

    /// Returns the failure key by physics alone; `None` on success.
    #[must_use]
    pub fn failure_by_physics(&self) -> Option<&str> {
        self.finding.failure(self.feasible_by_physics())
    }
}

/// Equipment that all trials share.
pub(super) struct Laboratory {
    pub(super) robot: RobotModel,
    /// External engines; `None`: the built-in engine.
    pub(super) engines: Option<EnginePool>,
}

pub(super) fn run(laboratory: &Laboratory, plan: &Plan, job: &Job) -> anyhow::Result<Record> {
    let settings = job.policy.settings(&plan.settings);
    TrialSetup::new(laboratory, plan, job)?.run(SensorVariant::unmodified(settings))
}

pub(super) fn run_variants<T>(
    laboratory: &Laboratory,
    plan: &Plan,
    job: &Job,
    make_variants: impl Fn(&World, u64) -> anyhow::Result<(Vec<SensorVariant>, T)>,
) -> anyhow::Result<VariantTrial<T>> {
    let stage = TrialSetup::new(laboratory, plan, job)?;
    let world = World::new(&laboratory.robot, &stage.scene, stage.seed)?;
    let (corrupted, made) = make_variants(&world, stage.seed)?;
    let records: anyhow::Result<_> = corrupted
        .into_iter()
        .map(|corrupted| stage.run(corrupted))
        .collect();
    Ok((records?, made))
}

/// Initial state of a trial: a family member in its scene, and the goal.
struct TrialSetup<'a> {
    laboratory: &'a Laboratory,
    plan: &'a Plan,
    job: &'a Job,
    seed: u64,
    scene: Scene,
    goal: GoalRequest,
}

impl<'a> TrialSetup<'a> {
    fn new(laboratory: &'a Laboratory, plan: &'a Plan, job: &'a Job) -> anyhow::Result<Self> {
        let robot = &laboratory.robot;
        let nominal = &plan.objects[job.object];
        let seed = trial_seed(&nominal.name, job.number);
        let errors = &job.condition.errors.errors;
        let mut scene = plan
            .task
            .scene(robot, nominal.clone())?
            .varied(seed)
            .with_errors(errors, seed);
        scene.noise_factor = job.condition.noise.scale(share(seed ^ NOISE_STREAM));
        scene.sensor_rate_hz = [job.condition.rate_hz; 2];
        if let Some(of) = &job.condition.sensor_model {
            scene.sensor_model = of.model.clone();
        }
        let goal = plan.task.goal(&scene, robot.acting_side())?;
        Ok(Self {
            laboratory,
            plan,
            job,
            seed,
            scene,
            goal,
        })
    }

    fn world(&self) -> anyhow::Result<World> {
        let (robot, scene) = (&self.laboratory.robot, &self.scene);
        Ok(match &self.laboratory.engines {
            None => World::new(robot, scene, self.seed)?,
            Some(engines) => World::with_engine(robot, scene, self.seed, engines.borrow()?)?,
        })
    }

    /// Returns the time that this trial has cost: of this thread, or with an external engine, of
    /// the clock, because the thread waits for the engine.
    fn cost_s(&self) -> f64 {
        clock_s(match self.laboratory.engines {
            None => ClockId::ThreadCPUTime,
            Some(_) => ClockId::Monotonic,
        })
    }

    fn run(&self, mut corrupted: SensorVariant) -> anyhow::Result<Record> {
        let begin_s = self.cost_s();
        let (plan, job, robot) = (self.plan, self.job, &self.laboratory.robot);
        let reported = self.scene.grasp_hint(0).context("a task has an object")?;
        let placed = &self.scene.objects[0];
        let hand = robot.hand(robot.acting_side());
        let tips = hand.opposed_tips();
        let load = Load::from_object(&placed.object, &plan.settings.grasp, tips)
            .with_position_error(placed, reported);
        let mut progress = GoalProgress::default();
        let mut run = OfflineRun::in_world(robot, &self.scene, self.world()?, corrupted.settings);
        run.make_ready(&mut corrupted.frame_filter);
        let (goal, task) = job.policy.goal(&self.goal);
        run.set_task(task);
        let limit_s = plan.task.limit_s();
        let trial = run.run_filtered(&goal, limit_s, &mut corrupted.frame_filter, |outputs, _| {
            outputs.goal_update.iter().for_each(|u| progress.add(u));
        });
        let discarded = discarded(run.world()).with_context(|| {
            let name = &plan.objects[job.object].name;
            format!("object {name:?}, seed {}", job.number)
        })?;
        let [x_m, y_m, _] = goal.to_m;
        let objects = trial.truth.objects.iter();
        Ok(Record {
            object: job.object,
            number: job.number,
            drawn: Drawn::from_scene(&self.scene).context("a task's scene has its objects")?,
            load: matches!(plan.task, Task::Grasp | Task::PickPlace).then_some(load),
            finding: match discarded {
                None => evaluate(plan.task, hand, &trial, &progress, load, [x_m, y_m]),
                Some(reason) => Finding::discarded(&reason),
            },
            max_force_n: objects.map(|o| o.max_force_n).fold(0.0, f64::max),
            simulated_s: trial.simulated_s,
            cpu_s: self.cost_s() - begin_s,
        })
    }
}

fn share(seed: u64) -> f64 {
    (split_mix(seed) >> 11) as f64 / (1_u64 << 53) as f64
}

fn clock_s(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
