//! One run of a task, judged at every tick, and its phases.

use anyhow::Context;
use atas_core::limits::{JOINT_ACCELERATION_RAD_S2, JOINT_JERK_RAD_S3};
use atas_core::{OperatorRequest, Settings};
use atas_evaluation::Task;
use atas_evaluation::offline::OfflineRun;
use atas_judge::{JointBounds, JointUnit, Judge};
use robot_model::{JointKind, RobotModel};
use shm_schemas::{GoalRequest, GoalState, GoalUpdate, Reason, WorldTruth};
use sim_backend::random::{split_mix, trial_seed};
use sim_backend::{Object, Scene, TICK_NS};

use crate::catalogue::HOLDING;

/// Ticks of a daemon in lock-step before its first goal; see `atasd`.
pub(crate) const SETTLE_TICKS: u64 = 100;

/// A task with its object and seed.
#[derive(Clone, Debug)]
pub(crate) struct Course<'a> {
    pub(crate) robot: &'a RobotModel,
    pub(crate) task: Task,
    pub(crate) scene: Scene,
    pub(crate) goal: GoalRequest,
    pub(crate) settings: Settings,
    /// Seed as users number it.
    pub(crate) number: u64,
    pub(crate) seed: u64,
}

/// Phase of a task: a step when it is visited first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Phase {
    pub(crate) name: String,
    pub(crate) first_tick: u64,
    pub(crate) ticks: u64,
}

/// Task in progress.
pub(crate) struct Progress {
    pub(crate) run: OfflineRun,
    pub(crate) judge: Judge,
    request: Option<OperatorRequest>,
    goal_id: u64,
    step: String,
    /// First reason for HOLD or a more severe mode.
    pub(crate) reason: Option<Reason>,
    pub(crate) end: Option<GoalUpdate>,
}

impl<'a> Course<'a> {
    pub(crate) fn new(
        robot: &'a RobotModel,
        task: Task,
        object: &Object,
        number: u64,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let seed = trial_seed(&object.name, number);
        let scene = task.scene(robot, object.clone())?.varied(seed);
        let goal = task.goal(&scene, robot.acting_side())?;
        Ok(Self {
            robot,
            task,
            scene,
            goal,
            settings,
            number,
            seed,
        })
    }

    /// Returns the seed of the faults.
    pub(crate) fn fault_seed(&self) -> u64 {
        split_mix(self.seed)
    }

    /// Runs the task to its end and returns its phases.
    ///
    /// # Errors
    /// Without faults, the task must succeed without violation.
    pub(crate) fn phases(&self) -> anyhow::Result<Vec<Phase>> {
        self.phases_from(self.begin()?)
    }

    /// Returns the phases of a run with a daemon in lock-step, which begins its goal later.
    ///
    /// # Errors
    /// As [`Course::phases`].
    pub(crate) fn lockstep_phases(&self) -> anyhow::Result<Vec<Phase>> {
        let mut run = OfflineRun::without_tick(self.robot, &self.scene, self.seed, self.settings)?;
        (0..SETTLE_TICKS).for_each(|_| {
            run.step(None);
        });
        self.phases_from(self.begin_in(run)?)
    }

    fn phases_from(&self, mut progress: Progress) -> anyhow::Result<Vec<Phase>> {
        let mut phases: Vec<Phase> = Vec::new();
        for _ in 0..(self.task.limit_s() * 1e9) as u64 / TICK_NS {
            let tick = progress.run.ticks();
            progress.advance();
            if !progress.step.is_empty() {
                add(&mut phases, &progress.step, tick);
            }
            if progress.end.is_some() {
                break;
            }
        }
        let (name, number) = (self.task.name(), self.number);
        let end = progress.end.as_ref();
        let end = end.with_context(|| format!("{name} with seed {number} does not end"))?;
        anyhow::ensure!(
            end.state == GoalState::SUCCEEDED,
            "{name} with seed {number} fails without a fault: {}; choose another --object or seed",
            end.reason
        );
        if let Some(violation) = progress.judge.violations().first() {
            anyhow::bail!("{name} with seed {number} violates a rule without a fault: {violation}");
        }
        Ok(phases)
    }

    /// Advances the task to a random tick of a phase, which depends on the seed only.
    pub(crate) fn advance_into(&self, phase: &Phase, progress: &mut Progress) {
        let tick = self.tick_in(phase);
        while progress.run.ticks() < tick {
            progress.advance();
        }
    }

    /// Returns a random tick of a phase, which depends on the seed only.
    pub(crate) fn tick_in(&self, phase: &Phase) -> u64 {
        phase.first_tick + split_mix(self.seed ^ phase.first_tick) % phase.ticks.max(1)
    }

    /// Returns a random phase, which depends on the seed only.
    pub(crate) fn random_phase<'p>(&self, phases: &'p [Phase]) -> Option<&'p Phase> {
        let index = split_mix(!self.seed) % (phases.len() as u64).max(1);
        phases.get(index as usize)
    }

    /// Returns a judge of this robot.
    pub(crate) fn judge(&self) -> anyhow::Result<Judge> {
        let valid_ns = (self.settings.safety.valid_s * 1e9).round() as u64;
        Ok(Judge::new(joint_bounds(self.robot), TICK_NS, valid_ns)?)
    }

    /// Begins the task.
    pub(crate) fn begin(&self) -> anyhow::Result<Progress> {
        let new = OfflineRun::new(self.robot, &self.scene, self.seed, self.settings);
        self.begin_in(new?)
    }

    fn begin_in(&self, run: OfflineRun) -> anyhow::Result<Progress> {
        let request = run
            .request(&self.goal)
            .map_err(|reason| anyhow::anyhow!("{} is rejected: {reason}", self.task.name()))?;
        Ok(Progress {
            run,
            judge: self.judge()?,
            request: Some(request),
            goal_id: self.goal.goal_id,
            step: String::new(),
            reason: None,
            end: None,
        })
    }
}

impl Progress {
    /// Returns a copy in the present state; `None` with an external engine.
    pub(crate) fn copy(&self) -> Option<Self> {
        Some(Self {
            run: self.run.copy()?,
            judge: self.judge.clone(),
            request: self.request,
            goal_id: self.goal_id,
            step: self.step.clone(),
            reason: self.reason,
            end: self.end,
        })
    }

    /// Runs one tick and judges its command.
    pub(crate) fn advance(&mut self) {
        let outputs = self.run.step(self.request.take().as_ref());
        let (command, update) = (outputs.command, outputs.goal_update);
        self.judge.observe(&command, &self.truth());
        let (mode, reason) = self.run.controller().mode();
        if HOLDING.contains(&mode) {
            self.reason.get_or_insert(reason);
        }
        if let Some(update) = update.filter(|update| update.goal_id == self.goal_id) {
            self.step = update.step.to_string();
            self.end = Some(update).filter(|update| update.state.is_final());
        }
    }

    pub(crate) fn truth(&self) -> WorldTruth {
        self.run.world().truth()
    }
}

fn add(phases: &mut Vec<Phase>, step: &str, tick: u64) {
    match phases.iter_mut().find(|phase| phase.name == step) {
        Some(phase) if phase.first_tick + phase.ticks == tick => phase.ticks += 1,
        Some(_) => {}
        None => phases.push(Phase {
            name: step.to_owned(),
            first_tick: tick,
            ticks: 1,
        }),
    }
}

/// Returns the limits of all joints for a judge. Limits of acceleration and jerk are those that the
/// gate states.
#[must_use]
pub fn joint_bounds(robot: &RobotModel) -> Vec<JointBounds> {
    let bounds = robot.joints().map(|joint| {
        let unit = joint.radian();
        JointBounds {
            name: joint.name.to_string(),
            unit: match joint.kind {
                JointKind::Prismatic => JointUnit::Metre,
                JointKind::Revolute => JointUnit::Radian,
            },
            lower: joint.lower,
            upper: joint.upper,
            speed_max: joint.velocity_max,
            acceleration_max: JOINT_ACCELERATION_RAD_S2 * unit,
            jerk_max: JOINT_JERK_RAD_S3 * unit,
        }
    });
    bounds.collect()
}
