//! Environment: a sequence of episodes, each with its own seed.

use std::sync::Arc;

use robot_model::RobotModel;
use sim_backend::random::split_mix;
use sim_backend::{Object, ObjectError};

use crate::episode::Episode;
use crate::error::LearningError;
use crate::hand::{ACTIONS, TICK_S};
use crate::observation;
use crate::reward::{End, Judge};
use crate::task::Task;

/// Ticks per step: policy rate 50 Hz, typical of learned policies.
pub const STEP_TICKS: usize = 20;
/// Random stream for the choice of an object (arbitrary).
const OBJECT_STREAM: u64 = 0x6f62_6a65_6374;

/// Result of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Reward of the step.
    pub reward: f64,
    /// End of the episode, if it has ended.
    pub end: End,
    /// True if the time limit is reached.
    pub truncated: bool,
    /// Height of the object above its start, m.
    pub lifted_m: f64,
    /// Largest normal force divided by the required force, minus 1; at least 0.
    pub over_grip: f64,
    /// Index of the object.
    pub object: usize,
    /// Seed of the episode.
    pub seed: u64,
}

/// Task with its objects and the current episode.
pub struct Environment {
    robot: Arc<RobotModel>,
    task: Task,
    objects: Arc<[Object]>,
    noise_factor: f64,
    seed: u64,
    episodes: u64,
    current: Option<(Episode, Judge, Outcome)>,
    steps: usize,
}

impl Environment {
    /// Makes an environment with these objects: built-in names or file paths.
    ///
    /// # Errors
    /// [`LearningError`] if the list is empty or an object cannot be loaded.
    pub fn new(task: Task, objects: &[String], noise_factor: f64) -> Result<Self, LearningError> {
        let objects: Result<Arc<[Object]>, ObjectError> = objects
            .iter()
            .map(|name| Object::from_name_or_file(name))
            .collect();
        let objects = objects?;
        if objects.is_empty() {
            return Err(LearningError::NoObject);
        }
        Ok(Self {
            robot: Arc::new(RobotModel::two_hand_arm()?),
            task,
            objects,
            noise_factor,
            seed: 0,
            episodes: 0,
            current: None,
            steps: 0,
        })
    }

    /// Makes another environment of the same kind.
    #[must_use]
    pub fn fork(&self) -> Self {
        Self {
            robot: Arc::clone(&self.robot),
            objects: Arc::clone(&self.objects),
            current: None,
            ..*self
        }
    }

    /// Returns the object names.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().map(|object| object.name.as_str())
    }

    /// Starts the first episode of a series with this seed, or the next one of the current series.
    ///
    /// # Errors
    /// [`LearningError`] if the scene cannot be set up.
    pub fn reset(&mut self, seed: Option<u64>) -> Result<Outcome, LearningError> {
        (self.seed, self.episodes) = match seed {
            Some(seed) => (seed, 0),
            None => (self.seed, self.episodes + 1),
        };
        // 63 bits: fits a signed integer in other languages.
        let seed = split_mix(self.seed ^ split_mix(self.episodes)) >> 1;
        let object = (split_mix(seed ^ OBJECT_STREAM) % self.objects.len() as u64) as usize;
        let spec = self.objects[object].clone();
        let episode = Episode::begin(&self.robot, self.task, spec, seed, self.noise_factor)?;
        let judge = Judge::new(self.task, episode.place_m(), &episode.truth());
        let outcome = Outcome {
            object,
            seed,
            ..Outcome::default()
        };
        self.current = Some((episode, judge, outcome));
        self.steps = 0;
        Ok(outcome)
    }

    /// Advances by one step. Action values are clamped to −1 to 1.
    ///
    /// # Errors
    /// [`LearningError::Action`] if a value is not finite, [`LearningError::NotBegun`] without an
    /// episode.
    pub fn step(&mut self, action: &[f32; ACTIONS]) -> Result<Outcome, LearningError> {
        if let Some(index) = action.iter().position(|it| !it.is_finite()) {
            let value = action[index];
            return Err(LearningError::Action { index, value });
        }
        let (episode, judge, outcome) = self.current.as_mut().ok_or(LearningError::NotBegun)?;
        if outcome.end != End::None || outcome.truncated {
            return Err(LearningError::NotBegun);
        }
        let action = action.map(|share| f64::from(share.clamp(-1.0, 1.0)));
        for _ in 0..STEP_TICKS {
            episode.tick(&action)?;
        }
        self.steps += 1;
        let step_s = STEP_TICKS as f64 * TICK_S;
        let worth = judge.evaluate(&episode.truth(), step_s);
        outcome.reward = worth.reward;
        outcome.end = worth.end;
        outcome.lifted_m = worth.lifted_m;
        outcome.over_grip = worth.over_grip;
        let is_late = self.steps as f64 * step_s >= self.task.limit_s();
        outcome.truncated = is_late && worth.end == End::None;
        Ok(*outcome)
    }

    /// Writes the observation, [`observation::SIZE`] values; all zero before the first episode.
    pub fn observe(&self, row: &mut [f32]) {
        debug_assert_eq!(row.len(), observation::SIZE);
        match &self.current {
            Some((episode, ..)) => episode.observe(row),
            None => row.fill(0.0),
        }
    }
}
