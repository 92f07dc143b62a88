//! Nominal trial: one trial of a task with its default object and without errors.
//!
//! Kinematics show which tasks a robot may do. They do not show whether the hand grips, or whether
//! its rest pose is clear of the scene. In: a robot. Out: outcome and reason. One seed, so the
//! result is the same in every run.

use anyhow::Context;
use atas_client::GoalProgress;
use atas_core::Settings;
use rayon::prelude::*;
use robot_model::{HandModel, RobotModel};
use shm_schemas::GoalState;
use sim_backend::{Object, Scene, Shape};

use crate::Task;
use crate::finding::{Finding, evaluate};
use crate::held::discarded;
use crate::judge::Load;
use crate::offline::OfflineRun;

/// Seed of the sensor noise. The value is arbitrary.
const SEED: u64 = 1;
/// Largest share of the hand's opening that the default object may take. Design choice: the hand
/// needs room for its approach.
const WIDTH_SHARE: f64 = 0.7;

/// Result of one nominal trial.
#[derive(Clone, Debug, PartialEq)]
pub struct NominalTrial {
    /// Task of the trial.
    pub task: Task,
    /// Name of the object.
    pub object: String,
    /// Width of the object, m.
    pub width_m: f64,
    /// True if the task succeeded.
    pub done: bool,
    /// Outcome key, as in reports.
    pub outcome: String,
    /// The controller's reason, if the goal did not succeed.
    pub reason: Option<String>,
    /// Height of the object's top above the table, m.
    pub object_top_m: f64,
    /// Height of the lowest point of the fingertips at rest above the table, m.
    pub rest_height_m: f64,
    /// Simulated time, s.
    pub simulated_s: f64,
}

impl NominalTrial {
    /// Tries all tasks that the robot's kinematics allow, in parallel. The time limit of a trial
    /// bounds its simulated time; the simulation runs about 80 times faster.
    ///
    /// # Errors
    /// A world cannot be created, or has a fault.
    pub fn run_all(robot: &RobotModel) -> anyhow::Result<Vec<Self>> {
        let tasks = Task::ALL.into_par_iter();
        let tasks = tasks.filter(|task| task.is_supported_by(robot));
        tasks.map(|task| Self::run(robot, task)).collect()
    }

    /// Returns true if the fingertips at rest are lower than the object's top. Such a hand may hit
    /// the object on its way.
    #[must_use]
    pub fn rests_below_object(&self) -> bool {
        self.rest_height_m < self.object_top_m
    }

    /// Tries one task.
    ///
    /// # Errors
    /// The world cannot be created, or has a fault.
    pub fn run(robot: &RobotModel, task: Task) -> anyhow::Result<Self> {
        let (side, settings) = (robot.acting_side(), Settings::default());
        let hand = robot.hand(side);
        let object = object(hand, task)?;
        let (name, width_m) = (object.name.clone(), object.shape.width_m());
        let load = Load::from_object(&object, &settings.grasp, hand.opposed_tips());
        let scene = task.scene(robot, object)?;
        let hint = scene
            .grasp_hint(0)
            .context("a task's scene has its object")?;
        let tip_m = hand.tip_radius_m().iter().copied().fold(0.0, f64::max);
        let goal = task.goal(&scene, side)?;
        let mut run = OfflineRun::new(robot, &scene, SEED, settings)?;
        let mut progress = GoalProgress::default();
        let trial = run.run(&goal, task.limit_s(), |outputs, _| {
            outputs.goal_update.iter().for_each(|u| progress.add(u));
        });
        let finding = match discarded(run.world()).with_context(|| task.name())? {
            None => evaluate(
                task,
                hand,
                &trial,
                &progress,
                load,
                [goal.to_m[0], goal.to_m[1]],
            ),
            Some(reason) => Finding::discarded(&reason),
        };
        let succeeded = trial.end.state == GoalState::SUCCEEDED;
        Ok(Self {
            task,
            object: name,
            width_m,
            done: finding.done,
            outcome: finding.outcome,
            reason: (!succeeded).then(|| trial.end.reason.to_string()),
            object_top_m: hint.height_m,
            rest_height_m: hand.home_m().z - tip_m,
            simulated_s: trial.simulated_s,
        })
    }
}

/// Returns the default object of the task; for a hand that does not open wide enough, a smaller
/// one.
fn object(hand: &HandModel, task: Task) -> anyhow::Result<Object> {
    if matches!(task, Task::Screw | Task::Assembly) {
        return Ok(Object::built_in(Scene::CAP)?);
    }
    let mut object = Object::built_in(Scene::OBJECT)?;
    let width_max_m = WIDTH_SHARE * hand.max_opening_m();
    if let Shape::Box { half_m } = &mut object.shape {
        let scale = (width_max_m / (2.0 * half_m.x)).min(1.0);
        half_m.x *= scale;
        half_m.y *= scale;
    }
    Ok(object)
}
