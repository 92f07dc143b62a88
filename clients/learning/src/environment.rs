//! An environment: episodes one after the other, each with a seed of its own.

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

/// Ticks of one step: a policy decides 50 times a second, as learned policies do.
pub const STEP_TICKS: usize = 20;
/// What turns an episode's seed into the choice of its object (ours: any number does).
const OBJECT_STREAM: u64 = 0x6f62_6a65_6374;

/// What one step led to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// What the step was worth.
    pub reward: f64,
    /// How the episode ended, if it did.
    pub end: End,
    /// Whether its time is up.
    pub truncated: bool,
    /// How far the object is lifted, m.
    pub lifted_m: f64,
    /// Largest normal force over what the object needs, less 1; 0 when it is less.
    pub over_grip: f64,
    /// Index of the object.
    pub object: usize,
    /// Seed of the episode.
    pub seed: u64,
}

/// A task with its objects, episode after episode.
pub struct Environment {
    robot: Arc<RobotModel>,
    task: Task,
    objects: Arc<[Object]>,
    noise_factor: f64,
    seed: u64,
    episodes: u64,
    now: Option<(Episode, Judge, Outcome)>,
    steps: usize,
}

impl Environment {
    /// An environment of these objects, built-in ones by name or files by path.
    ///
    /// # Errors
    /// [`LearningError`] if there is no object or one cannot be had.
    pub fn new(task: Task, objects: &[String], noise_factor: f64) -> Result<Self, LearningError> {
        let objects: Result<Arc<[Object]>, ObjectError> = objects
            .iter()
            .map(|name| Object::named_or_file(name))
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
            now: None,
            steps: 0,
        })
    }

    /// Another environment of the same kind.
    #[must_use]
    pub fn another(&self) -> Self {
        Self {
            robot: Arc::clone(&self.robot),
            objects: Arc::clone(&self.objects),
            now: None,
            ..*self
        }
    }

    /// Names of the objects.
    pub fn objects(&self) -> impl Iterator<Item = &str> {
        self.objects.iter().map(|object| object.name.as_str())
    }

    /// Begins an episode: the first of a series with this seed, or the next of the present series.
    ///
    /// # Errors
    /// [`LearningError`] if the scene cannot be set.
    pub fn reset(&mut self, seed: Option<u64>) -> Result<Outcome, LearningError> {
        (self.seed, self.episodes) = match seed {
            Some(seed) => (seed, 0),
            None => (self.seed, self.episodes + 1),
        };
        // One bit less, so that it is a number for everybody.
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
        self.now = Some((episode, judge, outcome));
        self.steps = 0;
        Ok(outcome)
    }

    /// One step. Numbers beyond −1 and 1 count as these.
    ///
    /// # Errors
    /// [`LearningError::Action`] if a number is not finite, [`LearningError::NotBegun`] without an episode under way.
    pub fn step(&mut self, action: &[f32; ACTIONS]) -> Result<Outcome, LearningError> {
        if let Some(index) = action.iter().position(|it| !it.is_finite()) {
            let value = action[index];
            return Err(LearningError::Action { index, value });
        }
        let (episode, judge, outcome) = self.now.as_mut().ok_or(LearningError::NotBegun)?;
        if outcome.end != End::None || outcome.truncated {
            return Err(LearningError::NotBegun);
        }
        let action = action.map(|share| f64::from(share.clamp(-1.0, 1.0)));
        for _ in 0..STEP_TICKS {
            episode.tick(&action)?;
        }
        self.steps += 1;
        let step_s = STEP_TICKS as f64 * TICK_S;
        let worth = judge.judge(&episode.truth(), step_s);
        outcome.reward = worth.reward;
        outcome.end = worth.end;
        outcome.lifted_m = worth.lifted_m;
        outcome.over_grip = worth.over_grip;
        let is_late = self.steps as f64 * step_s >= self.task.limit_s();
        outcome.truncated = is_late && worth.end == End::None;
        Ok(*outcome)
    }

    /// Writes what the policy is told; `row` has [`observation::SIZE`] numbers, all zero before the first episode.
    pub fn observe(&self, row: &mut [f32]) {
        debug_assert_eq!(row.len(), observation::SIZE);
        match &self.now {
            Some((episode, ..)) => episode.observe(row),
            None => row.fill(0.0),
        }
    }
}
