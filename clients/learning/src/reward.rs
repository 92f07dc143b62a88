//! Reward and end of an episode, from the simulator's ground truth.

use nalgebra::Vector3;
use shm_schemas::{ObjectTruth, WorldTruth};

use crate::task::Task;

/// Required lift height, m (default of a goal), and holding time there or at the target, s (design
/// choice).
const LIFT_M: f64 = 0.04;
const HOLD_S: f64 = 0.5;
/// Tolerance below that height, m (design choice).
const SAG_M: f64 = 0.01;
/// Position tolerance at the target, m (as in the evaluation).
const PLACED_M: f64 = 0.005;
/// Rewards of the whole path and of success or failure (negative), penalty per step and unit of
/// over-grip (design choice).
const PATH_REWARD: f64 = 10.0;
const END_REWARD: f64 = 10.0;
const OVER_GRIP_PENALTY: f64 = 0.02;
/// Largest penalised over-grip.
const OVER_GRIP_MAX: f64 = 10.0;

/// End of an episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum End {
    /// Still running.
    #[default]
    None,
    /// Task completed.
    Success,
    /// Object crushed.
    Crushed,
    /// Object dropped.
    Dropped,
    /// Object tipped over.
    Tipped,
}

#[derive(Clone, Debug)]
pub(crate) struct Judge {
    task: Task,
    /// Index of the acting hand.
    hand: usize,
    place_m: Option<Vector3<f64>>,
    begin_m: Vector3<f64>,
    progress: f64,
    held_s: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct StepEvaluation {
    pub(crate) reward: f64,
    pub(crate) end: End,
    pub(crate) lifted_m: f64,
    pub(crate) over_grip: f64,
}

impl Judge {
    pub(crate) fn new(
        task: Task,
        hand: usize,
        place_m: Option<Vector3<f64>>,
        truth: &WorldTruth,
    ) -> Self {
        Self {
            task,
            hand,
            place_m,
            begin_m: truth.objects[0].position_m.into(),
            progress: 0.0,
            held_s: 0.0,
        }
    }

    pub(crate) fn evaluate(&mut self, truth: &WorldTruth, step_s: f64) -> StepEvaluation {
        let object = &truth.objects[0];
        let way = self.progress(object);
        let over_grip = over_grip(&truth.normal_n[self.hand], object);
        let mut reward = PATH_REWARD * (way - self.progress) - OVER_GRIP_PENALTY * over_grip;
        self.progress = way;
        let end = self.end(object, step_s);
        reward += match end {
            End::None => 0.0,
            End::Success => END_REWARD,
            End::Crushed | End::Dropped | End::Tipped => -END_REWARD,
        };
        StepEvaluation {
            reward,
            end,
            lifted_m: object.lifted_m,
            over_grip,
        }
    }

    /// Returns the completed share of the path: lift height, or distance to the target.
    fn progress(&self, object: &ObjectTruth) -> f64 {
        match self.place_m {
            None => (object.lifted_m / LIFT_M).clamp(0.0, 1.0),
            Some(place_m) => {
                let off_m = |at_m: &Vector3<f64>| (at_m - place_m).xy().norm();
                1.0 - off_m(&object.position_m.into()) / off_m(&self.begin_m).max(PLACED_M)
            }
        }
    }

    fn end(&mut self, object: &ObjectTruth, step_s: f64) -> End {
        if object.crushed != 0 {
            return End::Crushed;
        }
        if object.dropped != 0 {
            return End::Dropped;
        }
        if object.tipped != 0 {
            return End::Tipped;
        }
        let reached = match self.task {
            Task::Grasp => object.lifted_m > LIFT_M - SAG_M,
            Task::PickPlace => self.is_placed(object),
        };
        self.held_s = if reached { self.held_s + step_s } else { 0.0 };
        // Half a tick of tolerance for rounding errors.
        if self.held_s > HOLD_S - 5e-4 {
            End::Success
        } else {
            End::None
        }
    }

    /// Returns true if the object stands at its target without contact to the hand.
    fn is_placed(&self, object: &ObjectTruth) -> bool {
        let carried = object.carried_ns > 0 && object.table_n > 0.0 && object.pressed == 0;
        self.place_m.is_some_and(|place_m| {
            carried && (Vector3::from(object.position_m) - place_m).xy().norm() < PLACED_M
        })
    }
}

/// Returns the over-grip: larger normal force of the fingertips divided by the required force,
/// minus 1.
fn over_grip(normal_n: &[f64], object: &ObjectTruth) -> f64 {
    let pressed_n = normal_n.iter().copied().fold(0.0, f64::max);
    (pressed_n / object.needed_n - 1.0).clamp(0.0, OVER_GRIP_MAX)
}
