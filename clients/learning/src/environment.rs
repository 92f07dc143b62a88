//! Environment: a sequence of episodes, each with its own seed.

use std::sync::Arc;

use robot_model::{RobotFiles, RobotModel, TWO_HAND_ARM};
use shm_schemas::WorldTruth;
use sim_backend::random::split_mix;
use sim_backend::{Object, ObjectError, Scene};

use crate::episode::{CLEARANCE_M, Episode};
use crate::error::LearningError;
use crate::hand::{ACTIONS, TICK_S};
use crate::observation::Layout;
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
    files: Arc<RobotFiles>,
    robot: Arc<RobotModel>,
    layout: Arc<Layout>,
    task: Task,
    objects: Arc<[Object]>,
    noise_factor: f64,
    seed: u64,
    episodes: u64,
    current: Option<(Episode, Judge, Outcome)>,
    steps: usize,
}

impl Environment {
    /// Makes an environment of the built-in robot with two hands and these objects: built-in names
    /// or file paths.
    ///
    /// # Errors
    /// [`LearningError`] if the list is empty or an object cannot be loaded.
    pub fn new(task: Task, objects: &[String], noise_factor: f64) -> Result<Self, LearningError> {
        Self::with_robot(TWO_HAND_ARM, task, Some(objects), noise_factor)
    }

    /// Makes an environment of a robot; its acting hand moves. Without objects, it uses those of
    /// [`Task::OBJECTS`] that fit into the hand.
    ///
    /// # Errors
    /// [`LearningError`] if the robot or an object cannot be loaded, an object is too wide for the
    /// hand, or no object remains.
    pub fn with_robot(
        files: RobotFiles,
        task: Task,
        objects: Option<&[String]>,
        noise_factor: f64,
    ) -> Result<Self, LearningError> {
        let robot = files.load()?;
        let hand = robot.hand(robot.acting_side());
        let limit_m = hand.max_opening_m() - 2.0 * CLEARANCE_M;
        let fits = |object: &Object| object.shape.width_m() <= limit_m;
        let load = |name: &str| Object::from_name_or_file(name);
        let objects: Vec<Object> = match objects {
            Some(names) => {
                let all: Result<Vec<Object>, ObjectError> =
                    names.iter().map(|name| load(name)).collect();
                all?
            }
            None => {
                let all: Result<Vec<Object>, ObjectError> =
                    Task::OBJECTS.into_iter().map(load).collect();
                all?.into_iter().filter(fits).collect()
            }
        };
        if let Some(wide) = objects.iter().find(|object| !fits(object)) {
            return Err(LearningError::TooWide {
                object: wide.name.clone(),
                width_m: wide.shape.width_m(),
                limit_m,
            });
        }
        if objects.is_empty() {
            return Err(LearningError::NoObject);
        }
        Ok(Self {
            layout: Arc::new(Layout::from_hand(hand)),
            files: Arc::new(files),
            robot: Arc::new(robot),
            task,
            objects: objects.into(),
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
            files: Arc::clone(&self.files),
            robot: Arc::clone(&self.robot),
            layout: Arc::clone(&self.layout),
            objects: Arc::clone(&self.objects),
            current: None,
            ..*self
        }
    }

    /// Returns the task.
    #[must_use]
    pub fn task(&self) -> Task {
        self.task
    }

    /// Returns the files of the robot.
    #[must_use]
    pub fn files(&self) -> &RobotFiles {
        &self.files
    }

    /// Returns the robot.
    #[must_use]
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Returns the layout of an observation.
    #[must_use]
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Returns scene, measured joint positions (rad or m) and ground truth of the current episode.
    #[must_use]
    pub fn state(&self) -> Option<(&Scene, &[f64], WorldTruth)> {
        let (episode, ..) = self.current.as_ref()?;
        Some((episode.scene(), episode.positions(), episode.truth()))
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
        let judge = Judge::new(
            self.task,
            self.robot.acting_side().index(),
            episode.place_m(),
            &episode.truth(),
        );
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

    /// Writes the observation, [`Layout::size`] values; all zero before the first episode.
    pub fn observe(&self, row: &mut [f32]) {
        debug_assert_eq!(row.len(), self.layout.size());
        match &self.current {
            Some((episode, ..)) => episode.observe(&self.layout, row),
            None => row.fill(0.0),
        }
    }
}
