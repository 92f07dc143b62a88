//! Input and outcome of one trial.

use serde::{Deserialize, Serialize};

use crate::noise::{Stream, seed};
use crate::responses::Responses;

/// Largest number of agents (paper Fig. 13).
pub const MAX_AGENTS: usize = 4;
/// Frames of the execution time (paper III.b.3).
pub const EXECUTION_FRAMES: u32 = 180;
/// Frames of the evaluation time (paper III.b.3).
pub const EVALUATION_FRAMES: u32 = 90;
/// Frames of one trial.
pub const TRIAL_FRAMES: u32 = EXECUTION_FRAMES + EVALUATION_FRAMES;

/// Position on the field.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Point {
    /// Distance right of the centre.
    pub x_px: f32,
    /// Distance above the centre.
    pub y_px: f32,
}

/// Position and heading of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Pose {
    /// Distance right of the centre.
    pub x_px: f32,
    /// Distance above the centre.
    pub y_px: f32,
    /// Steps of 1/64 turn, counter-clockwise from +x, modulo 64.
    pub heading: u8,
}

impl Pose {
    pub(crate) fn position(self) -> Point {
        Point {
            x_px: self.x_px,
            y_px: self.y_px,
        }
    }
}

/// Starts and goal, validated by [`crate::Model::layout`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pub(crate) starts: [Pose; MAX_AGENTS],
    pub(crate) goal: Point,
    /// Initial state of the noise stream.
    pub(crate) noise: Stream,
}

impl Layout {
    /// Derives the noise seed from the numbers: equal layouts have equal noise.
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

    /// Replaces the noise stream.
    #[must_use]
    pub fn with_noise(self, seed: u32) -> Self {
        Self {
            noise: Stream(seed.max(1)),
            ..self
        }
    }

    /// Returns the start poses; the team uses the first ones.
    #[must_use]
    pub fn starts(&self) -> &[Pose; MAX_AGENTS] {
        &self.starts
    }

    /// Returns the goal.
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
    /// Table of each agent.
    pub tables: [Responses; MAX_AGENTS],
}

/// Distances between centres at one instant, px.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Snapshot {
    /// Object to goal.
    pub goal_px: f32,
    /// Object to each agent; 0 outside the team.
    pub agents_px: [f32; MAX_AGENTS],
}

/// Result of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct Outcome {
    /// Bit r: any agent read row r.
    pub rows_read: u32,
    /// First frame, from 1, after which the object was at the goal; 0 if never.
    pub reached_frame: u32,
    /// Distances after frame 180.
    pub executed: Snapshot,
    /// Distances after frame 270.
    pub evaluated: Snapshot,
}
