//! Validated preset and layouts, and team sizes.

use thiserror::Error;

use crate::check::{Finding, PresetError, check};
use crate::constants::Constants;
use crate::heading::cos_sin;
use crate::obstacle::{Body, Obstacles, Post, Wall};
use crate::placement;
use crate::preset::{Corner, Goals, Preset, Start};
use crate::trial::{Layout, MAX_AGENTS, Point, Pose};

/// Number of agents on a field: 1 to [`MAX_AGENTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TeamSize(u8);

/// Unsupported number of agents.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("could not place {0} agents: a field holds 1 to 4 (paper Fig. 13); choose one of these")]
pub struct TeamSizeError(pub usize);

impl TeamSize {
    /// All team sizes: the paper's four conditions (Fig. 14).
    pub const ALL: [Self; MAX_AGENTS] = [Self(1), Self(2), Self(3), Self(4)];

    /// Validates a number of agents.
    pub fn new(agents: usize) -> Result<Self, TeamSizeError> {
        match agents {
            1..=MAX_AGENTS => Ok(Self(agents as u8)),
            _ => Err(TeamSizeError(agents)),
        }
    }

    /// Returns the number of agents.
    #[must_use]
    #[inline]
    pub fn get(self) -> usize {
        usize::from(self.0)
    }
}

/// Validated preset.
#[derive(Clone, Debug)]
pub struct Model {
    preset: Preset,
    starts: [Pose; MAX_AGENTS],
    posts: Vec<Post>,
    pub(crate) constants: Constants,
    pub(crate) obstacles: Obstacles,
}

impl Model {
    /// Validates a preset.
    ///
    /// # Errors
    /// Lists every value out of range and every required place that an obstacle blocks.
    pub fn new(preset: Preset) -> Result<Self, PresetError> {
        let refused = |findings: Vec<Finding>| PresetError {
            preset: preset.name.to_string(),
            findings,
        };
        let mut findings = check(&preset);
        let (starts, goals) = (start_poses(&preset), training_goals(preset.goals));
        let places = placement::required_places(&preset, &starts, &goals);
        if findings.is_empty() {
            findings = placement::blocked_places(&preset, &places);
        }
        findings.extend(placement::shape_findings(&preset));
        if !findings.is_empty() {
            return Err(refused(findings));
        }
        let posts =
            placement::place_posts(&preset, &places).map_err(|found| refused(vec![found]))?;
        let constants = Constants::new(&preset);
        let obstacles = Constants::obstacles(&preset, &preset.walls, &posts);
        let model = Self {
            preset,
            starts,
            posts,
            constants,
            obstacles,
        };
        model.layout(starts, model.training_goals()[0])?;
        Ok(model)
    }

    /// Returns the preset.
    #[must_use]
    pub fn preset(&self) -> &Preset {
        &self.preset
    }

    /// Returns the goals of an evaluation, goal 1 on +x, counter-clockwise (paper Fig. 13 right).
    #[must_use]
    pub fn training_goals(&self) -> [Point; 8] {
        training_goals(self.preset.goals)
    }

    /// Returns the walls.
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.preset.walls
    }

    /// Returns the posts, random ones last.
    #[must_use]
    pub fn posts(&self) -> &[Post] {
        &self.posts
    }

    /// Returns true if a body of this radius touches no obstacle here.
    #[must_use]
    pub fn is_clear(&self, at: Point, radius_px: f32) -> bool {
        self.obstacles.clearance_px(at) >= radius_px
    }

    /// Returns the goal in one of 64 directions, on the circle or square of the training goals.
    #[must_use]
    pub fn goal_towards(&self, heading: u8) -> Point {
        goal_towards(self.preset.goals, heading)
    }

    /// Returns a goal between two neighbouring directions, interpolated linearly by `part` (0 to
    /// 1).
    #[must_use]
    pub fn goal_between(&self, heading: u8, part: f32) -> Point {
        let (from, to) = (
            self.goal_towards(heading),
            self.goal_towards(heading.wrapping_add(1)),
        );
        Point {
            x_px: from.x_px + part * (to.x_px - from.x_px),
            y_px: from.y_px + part * (to.y_px - from.y_px),
        }
    }

    /// Combines the preset's starts with a goal.
    #[must_use]
    pub fn training_layout(&self, goal: Point) -> Layout {
        Layout::new(self.starts, goal)
    }

    /// Validates any starts with any goal.
    ///
    /// # Errors
    /// A place is not finite or outside the field, or a start overlaps a body or an obstacle.
    pub fn layout(&self, starts: [Pose; MAX_AGENTS], goal: Point) -> Result<Layout, PresetError> {
        let limit = self.constants.agent_limit;
        for pose in &starts {
            self.within("start x", pose.x_px, limit)?;
            self.within("start y", pose.y_px, limit)?;
        }
        self.within("goal x", goal.x_px, self.preset.half_side_px)?;
        self.within("goal y", goal.y_px, self.preset.half_side_px)?;
        for (i, a) in starts.iter().enumerate() {
            let apart = |key, sq: f32, least: f32, needs| match sq >= least {
                true => Ok(()),
                false => Err(self.error(key, sq.sqrt(), needs)),
            };
            let origin = a.x_px * a.x_px + a.y_px * a.y_px;
            apart(
                "distance from a start to the object",
                origin,
                self.constants.touch_sq,
                "no overlap",
            )?;
            let obstacles = &self.obstacles;
            if !obstacles.allows_move(Body::Agent, a.position(), a.position()) {
                let key = "distance from a start to a wall or post";
                let clearance_px = obstacles.clearance_px(a.position());
                return Err(self.error(key, clearance_px, "no overlap"));
            }
            for b in &starts[..i] {
                let (dx, dy) = (a.x_px - b.x_px, a.y_px - b.y_px);
                apart(
                    "distance between two starts",
                    dx * dx + dy * dy,
                    self.constants.pair_sq,
                    "no overlap",
                )?;
            }
        }
        Ok(Layout::new(starts, goal))
    }

    fn within(&self, key: &'static str, value: f32, limit: f32) -> Result<(), PresetError> {
        match value.abs() <= limit {
            true => Ok(()),
            false => Err(self.error(key, value, "a finite number inside the field")),
        }
    }

    fn error(&self, key: &'static str, value: f32, needs: &'static str) -> PresetError {
        PresetError {
            preset: self.preset.name.to_string(),
            findings: vec![Finding::new(key, value, needs)],
        }
    }
}

fn training_goals(goals: Goals) -> [Point; 8] {
    std::array::from_fn(|k| goal_towards(goals, k as u8 * 8))
}

fn goal_towards(goals: Goals, heading: u8) -> Point {
    let (cos, sin) = cos_sin(heading);
    match goals {
        Goals::CirclePx(radius) => Point {
            x_px: radius * cos,
            y_px: radius * sin,
        },
        Goals::SquarePx(half) => {
            let longest = if cos.abs() > sin.abs() {
                cos.abs()
            } else {
                sin.abs()
            };
            Point {
                x_px: half * (cos / longest),
                y_px: half * (sin / longest),
            }
        }
    }
}

fn start_poses(preset: &Preset) -> [Pose; MAX_AGENTS] {
    let distance = preset.starts.distance_px;
    preset.starts.corners.map(|corner| {
        let (x_px, y_px, to_centre) = match corner {
            Corner::RightTop => (distance, distance, 40),
            Corner::LeftTop => (-distance, distance, 56),
            Corner::LeftBottom => (-distance, -distance, 8),
            Corner::RightBottom => (distance, -distance, 24),
        };
        let heading = match preset.starts.heading {
            Start::ToCentre => to_centre,
            Start::East => 0,
        };
        Pose {
            x_px,
            y_px,
            heading,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shipped_presets_are_valid_and_found_by_name() {
        for preset in Preset::ALL {
            assert_eq!(
                Preset::named(&preset.name.to_lowercase()),
                Some(preset.clone())
            );
            Model::new(preset).expect("a shipped preset is valid");
        }
        assert_eq!(Preset::named("R4"), None);
    }

    #[test]
    fn overlapping_starts_are_refused() {
        let mut preset = Preset::N;
        preset.starts.distance_px = 20.0;
        let error = Model::new(preset).expect_err("agents inside the object");
        assert_eq!(error.keys(), ["distance from a start to the object"]);
        let mut preset = Preset::N;
        preset.starts.corners[1] = preset.starts.corners[0];
        assert_eq!(
            Model::new(preset)
                .expect_err("two agents in one place")
                .keys(),
            ["distance between two starts"]
        );
    }

    #[test]
    fn square_goals_lie_on_the_square() {
        let model = Model::new(Preset::N).expect("valid");
        let goals = model.training_goals().map(|g| (g.x_px, g.y_px));
        assert_eq!(goals[0], (250.0, 0.0));
        assert_eq!(goals[1], (250.0, 250.0));
        assert_eq!(goals[5], (-250.0, -250.0));
        assert_eq!(model.goal_towards(4).x_px, 250.0);
    }

    #[test]
    fn agents_start_facing_the_object() {
        for pose in start_poses(&Preset::R3) {
            let (cos, sin) = cos_sin(pose.heading);
            assert!(pose.x_px * cos < 0.0 && pose.y_px * sin < 0.0);
        }
    }
}
