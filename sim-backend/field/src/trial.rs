//! One trial: agents, an object and a goal for 270 frames, and what is left of it for the fitness.

use serde::{Deserialize, Serialize};

use crate::chance::{Stream, seed};
use crate::responses::Responses;

/// Agents that one field holds (paper Fig. 13).
pub const MAX_AGENTS: usize = 4;
/// Frames of the task execution time (paper III.b.3).
pub const EXECUTION_FRAMES: u32 = 180;
/// Frames of the task evaluation time that follows (paper III.b.3).
pub const EVALUATION_FRAMES: u32 = 90;
/// Frames of one trial: one goal.
pub const TRIAL_FRAMES: u32 = EXECUTION_FRAMES + EVALUATION_FRAMES;

/// A position on the field.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point {
    /// To the right of the field's centre.
    pub x_px: f32,
    /// Above the field's centre.
    pub y_px: f32,
}

/// Where an agent is and where it looks.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Pose {
    /// To the right of the field's centre.
    pub x_px: f32,
    /// Above the field's centre.
    pub y_px: f32,
    /// Steps of 1/64 turn, counter-clockwise from +x; only the value mod 64 matters.
    pub heading: u8,
}

impl Pose {
    /// Where the agent is.
    pub(crate) fn position(self) -> Point {
        Point {
            x_px: self.x_px,
            y_px: self.y_px,
        }
    }
}

/// Starts and goal of one trial, checked by [`crate::Model::layout`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pub(crate) starts: [Pose; MAX_AGENTS],
    pub(crate) goal: Point,
    /// Where the stream of the trial's noise begins.
    pub(crate) noise: Stream,
}

impl Layout {
    /// A layout whose noise its own numbers name: the same starts and goal have the same noise, wherever they are tried.
    pub(crate) fn new(starts: [Pose; MAX_AGENTS], goal: Point) -> Self {
        let poses = starts
            .iter()
            .flat_map(|pose| [pose.x_px, pose.y_px, pose.heading.into()]);
        let numbers = poses.chain([goal.x_px, goal.y_px]);
        Self {
            starts,
            goal,
            noise: Stream(seed(numbers).max(1)),
        }
    }

    /// The same with the noise of another stream.
    #[must_use]
    pub fn with_noise(self, seed: u32) -> Self {
        Self {
            noise: Stream(seed.max(1)),
            ..self
        }
    }

    /// Where the agents stand at frame 0; agents beyond the team's size do not take part.
    #[must_use]
    pub fn starts(&self) -> &[Pose; MAX_AGENTS] {
        &self.starts
    }

    /// Where the object should go.
    #[must_use]
    pub fn goal(&self) -> Point {
        self.goal
    }
}

/// One trial to simulate.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Starts and goal.
    pub layout: Layout,
    /// The table of each agent. A team with one shared table has it four times.
    pub tables: [Responses; MAX_AGENTS],
}

/// Distances at one instant, px between centres.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Snapshot {
    /// Object to goal.
    pub goal_px: f32,
    /// Object to each agent; 0 for agents that do not take part.
    pub agents_px: [f32; MAX_AGENTS],
}

/// What a trial came to.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Bit r is set if any agent read row r.
    pub rows_read: u32,
    /// The first frame, from 1, after which the object was within the goal's radius; 0 if it never was.
    pub reached_frame: u32,
    /// After frame 180.
    pub executed: Snapshot,
    /// After frame 270.
    pub evaluated: Snapshot,
}
