//! Fitness of a table on courses: random courses, 100 points each, in eight groups (as the paper
//! has eight goals).
//!
//! Per robot: up to 40 points for the way to the object, 40 for the way to the goal (each the
//! covered share), and 20 for the time of a completed course. A mishap halves the points.

use sim_backend::course::{Layout, Responses};

use super::offline::{FRAMES_MAX, RobotResult, run_offline};
use crate::error::{Error, Result};
use crate::evaluate::GoalPoints;

/// Groups of courses; half of them with one robot, half with two.
pub const GROUPS: usize = core::mem::size_of::<GoalPoints>() / core::mem::size_of::<f32>();
/// Courses per group. Design choice: with fewer, tables adapt to the courses instead of the task.
const COURSES: u64 = 6;
/// Points per way, points for time, and the factor after a mishap.
const WAY_POINTS: f32 = 40.0;
const TIME_POINTS: f32 = 20.0;
const MISHAP_FACTOR: f32 = 0.5;

/// Training courses of a run.
#[derive(Clone, Debug)]
pub struct Training {
    groups: Vec<Vec<Layout>>,
}

impl Training {
    /// Draws the courses of a run.
    pub fn new(seed: u64) -> Result<Self> {
        let layout = |group: u64, k: u64| {
            let robots = if group < GROUPS as u64 / 2 { 1 } else { 2 };
            let number = seed.wrapping_mul(1000) + group * COURSES + k;
            let seed = atas_evaluation::trial_seed("training course", number);
            Layout::random(robots, seed).map_err(Error::from_part)
        };
        let groups: Result<Vec<Vec<Layout>>> = (0..GROUPS as u64)
            .map(|group| (0..COURSES).map(|k| layout(group, k)).collect())
            .collect();
        Ok(Self { groups: groups? })
    }

    /// Returns the points of a table in one group and the rows that were read.
    #[must_use]
    pub fn points(&self, group: usize, table: Responses) -> (f32, u32) {
        let (mut sum, mut rows_read) = (0.0, 0);
        for layout in &self.groups[group] {
            let (driven, rows) = run_offline(layout, table);
            let robots = driven.len() as f32;
            sum += driven.iter().map(points).sum::<f32>() / robots;
            rows_read |= rows;
        }
        (sum / COURSES as f32, rows_read)
    }

    /// Returns the points of a table in every group and the rows that were read.
    #[must_use]
    pub fn evaluate(&self, table: Responses) -> (GoalPoints, u32) {
        let (mut earned, mut rows_read) = ([0.0; GROUPS], 0);
        for (group, earned) in earned.iter_mut().enumerate() {
            let (points, rows) = self.points(group, table);
            *earned = points;
            rows_read |= rows;
        }
        (earned, rows_read)
    }
}

/// Returns the points of one robot, 0 to 100.
#[must_use]
pub fn points(driven: &RobotResult) -> f32 {
    let in_time = if driven.progress >= 2.0 {
        TIME_POINTS * (1.0 - driven.frames as f32 / FRAMES_MAX as f32)
    } else {
        0.0
    };
    let earned = WAY_POINTS * driven.progress + in_time;
    earned * if driven.mishap { MISHAP_FACTOR } else { 1.0 }
}

/// Returns the share of new courses that a table completes with every robot. None of them is used
/// in evolution.
pub fn held_out(table: Responses, robots: usize, courses: u64) -> Result<f64> {
    let mut done = 0;
    for number in 0..courses {
        let seed = atas_evaluation::trial_seed("held-out course", number);
        let layout = Layout::random(robots, seed).map_err(Error::from_part)?;
        let (driven, _) = run_offline(&layout, table);
        done += u64::from(driven.iter().all(|robot| robot.progress >= 2.0));
    }
    Ok(done as f64 / courses.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_grow_with_progress_and_halve_after_mishap() {
        let check = |progress: f32, mishap: bool, frames: u32, expected: f32| {
            let driven = RobotResult {
                progress,
                mishap,
                frames,
            };
            assert_eq!(points(&driven), expected, "{driven:?}");
        };
        check(0.0, false, 0, 0.0);
        check(0.5, false, 100, 20.0);
        check(1.5, false, 900, 60.0);
        check(1.5, true, 900, 30.0);
        check(2.0, false, FRAMES_MAX, 80.0);
        check(2.0, false, FRAMES_MAX / 2, 90.0);
    }
}
