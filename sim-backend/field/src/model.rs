//! A checked preset and the constants that both simulators derive from it, once, so that their bits agree.

use thiserror::Error;

use crate::heading::cos_sin;
use crate::preset::{Contact, Corner, Goals, Preset, Start};
use crate::trial::{Layout, MAX_AGENTS, Point, Pose};

/// Half the side of the field (paper III.b.3: 800 × 800 px).
pub(crate) const FIELD_PX: f32 = 400.0;
/// An agent this much further than contact still faces the object for the count of pushing agents (ours).
const FACING_MARGIN_PX: f32 = 1.0;
/// Below this squared distance two centres coincide; keeps `0 / 0` out of the contact direction (ours).
pub(crate) const COINCIDENT_SQ: f32 = 1e-12;
/// Culls leave out only what is at least this much too far to matter: their rounding can never change a result (ours).
const CULL_MARGIN_PX: f32 = 1.0;

/// A preset or a layout that cannot be simulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "could not use preset {preset:?} because {key} was {value}, needs {needs}; correct that value"
)]
pub struct PresetError {
    /// Name of the preset.
    pub preset: String,
    /// Which value.
    pub key: &'static str,
    /// What it was.
    pub value: f32,
    /// What it may be.
    pub needs: &'static str,
}

/// How many agents share a field: 1 to [`MAX_AGENTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TeamSize(u8);

/// A number of agents that the field does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("could not place {0} agents, needs 1 to 4 (paper Fig. 13); choose one of these")]
pub struct TeamSizeError(pub usize);

impl TeamSize {
    /// Every team size, smallest first: the paper's four conditions (Fig. 14).
    pub const ALL: [Self; MAX_AGENTS] = [Self(1), Self(2), Self(3), Self(4)];

    /// Checks the number of agents.
    pub fn new(agents: usize) -> Result<Self, TeamSizeError> {
        match agents {
            1..=MAX_AGENTS => Ok(Self(agents as u8)),
            _ => Err(TeamSizeError(agents)),
        }
    }

    /// The number of agents.
    #[must_use]
    #[inline]
    pub fn get(self) -> usize {
        usize::from(self.0)
    }
}

/// A preset whose every number is finite and inside its range.
#[derive(Clone, Debug)]
pub struct Model {
    preset: Preset,
    starts: [Pose; MAX_AGENTS],
    pub(crate) constants: Constants,
}

impl Model {
    /// Checks a preset.
    ///
    /// # Errors
    /// The first value that is not finite or outside its range.
    pub fn new(preset: Preset) -> Result<Self, PresetError> {
        check(&preset)?;
        let starts = start_poses(&preset);
        let constants = Constants::new(&preset);
        let model = Self {
            preset,
            starts,
            constants,
        };
        model.layout(starts, model.training_goals()[0])?;
        Ok(model)
    }

    /// The numbers this was made from.
    #[must_use]
    pub fn preset(&self) -> &Preset {
        &self.preset
    }

    /// The eight goals of an evaluation, goal 1 on +x, counter-clockwise (paper Fig. 13 right).
    #[must_use]
    pub fn training_goals(&self) -> [Point; 8] {
        std::array::from_fn(|k| self.goal_towards(k as u8 * 8))
    }

    /// The goal in any of the 64 directions, on the same circle or square as the training goals.
    #[must_use]
    pub fn goal_towards(&self, heading: u8) -> Point {
        let (cos, sin) = cos_sin(heading);
        match self.preset.goals {
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

    /// The preset's starts with this goal.
    #[must_use]
    pub fn training_layout(&self, goal: Point) -> Layout {
        Layout {
            starts: self.starts,
            goal,
        }
    }

    /// Any starts with any goal, for held-out trials.
    ///
    /// # Errors
    /// A pose or a goal that is not finite or outside the field, or a start that overlaps the object or another start.
    pub fn layout(&self, starts: [Pose; MAX_AGENTS], goal: Point) -> Result<Layout, PresetError> {
        let limit = self.constants.agent_limit;
        for pose in &starts {
            self.within("start x", pose.x_px, limit)?;
            self.within("start y", pose.y_px, limit)?;
        }
        self.within("goal x", goal.x_px, FIELD_PX)?;
        self.within("goal y", goal.y_px, FIELD_PX)?;
        for (i, a) in starts.iter().enumerate() {
            let apart = |key, sq: f32, least: f32, needs| match sq >= least {
                true => Ok(()),
                false => Err(self.refusal(key, sq.sqrt(), needs)),
            };
            let origin = a.x_px * a.x_px + a.y_px * a.y_px;
            apart(
                "distance from a start to the object",
                origin,
                self.constants.touch_sq,
                "no overlap",
            )?;
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
        Ok(Layout { starts, goal })
    }

    fn within(&self, key: &'static str, value: f32, limit: f32) -> Result<(), PresetError> {
        match value.abs() <= limit {
            true => Ok(()),
            false => Err(self.refusal(key, value, "a finite number inside the field")),
        }
    }

    fn refusal(&self, key: &'static str, value: f32, needs: &'static str) -> PresetError {
        PresetError {
            preset: self.preset.name.to_string(),
            key,
            value,
            needs,
        }
    }
}

/// Every comparison is written so that NaN fails it.
fn check(preset: &Preset) -> Result<(), PresetError> {
    let p = preset;
    let touch = p.agent_radius_px + p.object_radius_px;
    let (Goals::CirclePx(goal_distance) | Goals::SquarePx(goal_distance)) = p.goals;
    let in_range = |value: f32, low: f32, high: f32| value >= low && value <= high;
    let step = |steps: u8| in_range(f32::from(steps), 0.0, 16.0);
    let positive = f32::MIN_POSITIVE;
    let rows = [
        (
            "agent_radius_px",
            p.agent_radius_px,
            in_range(p.agent_radius_px, 1.0, 100.0),
            "1 to 100",
        ),
        (
            "object_radius_px",
            p.object_radius_px,
            in_range(p.object_radius_px, 1.0, 100.0),
            "1 to 100",
        ),
        (
            "medium_speed_px_per_frame",
            p.medium_speed_px_per_frame,
            in_range(p.medium_speed_px_per_frame, positive, 0.25 * touch),
            "above 0, at most a quarter of the two radii's sum, or bodies pass through each other",
        ),
        (
            "starts.distance_px",
            p.starts.distance_px,
            in_range(p.starts.distance_px, 0.0, FIELD_PX),
            "0 to 400",
        ),
        (
            "ir_range_px",
            p.ir_range_px,
            in_range(p.ir_range_px, p.agent_radius_px, 800.0),
            "the agent's radius to 800",
        ),
        (
            "ir_angle_steps",
            f32::from(p.ir_angle_steps),
            step(p.ir_angle_steps),
            "0 to 16",
        ),
        (
            "photo.angle_steps",
            f32::from(p.photo.angle_steps),
            step(p.photo.angle_steps),
            "0 to 16",
        ),
        (
            "photo.half_angle_cosine",
            p.photo.half_angle_cosine,
            in_range(p.photo.half_angle_cosine, 0.0, 1.0),
            "0 to 1",
        ),
        (
            "object_light_px",
            p.object_light_px,
            in_range(p.object_light_px, 0.0, 1200.0),
            "0 to 1200",
        ),
        (
            "goal_light_px",
            p.goal_light_px,
            in_range(p.goal_light_px, 0.0, 1200.0),
            "0 to 1200",
        ),
        (
            "goals",
            goal_distance,
            in_range(goal_distance, 0.0, FIELD_PX - p.object_radius_px),
            "0 to 400 − object radius",
        ),
        (
            "goal_radius_px",
            p.goal_radius_px,
            in_range(p.goal_radius_px, 1.0, FIELD_PX),
            "1 to 400",
        ),
        (
            "solo_push",
            p.solo_push,
            in_range(p.solo_push, 0.0, 1.0),
            "0 to 1",
        ),
        (
            "team_push",
            p.team_push,
            in_range(p.team_push, 0.0, 1.0),
            "0 to 1",
        ),
    ];
    match rows.into_iter().find(|(_, _, good, _)| !good) {
        None => Ok(()),
        Some((key, value, _, needs)) => Err(PresetError {
            preset: p.name.to_string(),
            key,
            value,
            needs,
        }),
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

/// What the simulators compute with. A `_sq` is a squared distance in px².
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    pub contact: Contact,
    /// Centres of agents stay inside ± this.
    pub agent_limit: f32,
    /// The object's centre stays inside ± this.
    pub object_limit: f32,
    pub agent_radius_sq: f32,
    pub object_radius_sq: f32,
    /// Centre distance of an agent in contact with the object.
    pub touch: f32,
    pub touch_sq: f32,
    /// Centre distance of two agents in contact.
    pub pair: f32,
    pub pair_sq: f32,
    pub facing_sq: f32,
    pub ir_range: f32,
    pub ir_cos: f32,
    pub ir_sin: f32,
    pub photo_cos: f32,
    pub photo_sin: f32,
    /// Squared cosine of half the photo sensors' opening angle; 0 means a half-plane.
    pub cone_sq: f32,
    pub object_light_sq: f32,
    pub goal_light_sq: f32,
    pub goal_radius_sq: f32,
    pub solo_push: f32,
    pub team_push: f32,
    /// Travel per frame by left level + 4 · right level.
    pub travel: [f32; 16],
    /// No IR sensor can see the object beyond this.
    pub cull_object_sq: f32,
    /// No IR sensor can see another agent beyond this.
    pub cull_agent_sq: f32,
    /// Agents whose `|x|` and `|y|` are below this neither see nor reach a wall in this frame.
    pub cull_wall: f32,
}

impl Constants {
    fn new(p: &Preset) -> Self {
        let sq = |v: f32| v * v;
        let touch = p.agent_radius_px + p.object_radius_px;
        let pair = 2.0 * p.agent_radius_px;
        let (ir_cos, ir_sin) = cos_sin(p.ir_angle_steps);
        let (photo_cos, photo_sin) = cos_sin(p.photo.angle_steps);
        let half_speed = 0.5 * p.medium_speed_px_per_frame;
        let agent_limit = FIELD_PX - p.agent_radius_px;
        let reach = agent_limit - 4.0 * half_speed;
        let seen = FIELD_PX - p.ir_range_px;
        Self {
            contact: p.contact,
            agent_limit,
            object_limit: FIELD_PX - p.object_radius_px,
            agent_radius_sq: sq(p.agent_radius_px),
            object_radius_sq: sq(p.object_radius_px),
            touch,
            touch_sq: sq(touch),
            pair,
            pair_sq: sq(pair),
            facing_sq: sq(touch + FACING_MARGIN_PX),
            ir_range: p.ir_range_px,
            ir_cos,
            ir_sin,
            photo_cos,
            photo_sin,
            cone_sq: sq(p.photo.half_angle_cosine),
            object_light_sq: sq(p.object_light_px),
            goal_light_sq: sq(p.goal_light_px),
            goal_radius_sq: sq(p.goal_radius_px),
            solo_push: p.solo_push,
            team_push: p.team_push,
            travel: std::array::from_fn(|code| half_speed * ((code & 3) + (code >> 2)) as f32),
            cull_object_sq: sq(p.ir_range_px + p.object_radius_px + CULL_MARGIN_PX),
            cull_agent_sq: sq(p.ir_range_px + p.agent_radius_px + CULL_MARGIN_PX),
            cull_wall: (if reach < seen { reach } else { seen }) - CULL_MARGIN_PX,
        }
    }
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
    fn bad_values_are_refused_by_name() {
        type Spoil = fn(&mut Preset, f32);
        let keys: [(&str, Spoil); 10] = [
            ("agent_radius_px", |p, v| p.agent_radius_px = v),
            ("object_radius_px", |p, v| p.object_radius_px = v),
            ("medium_speed_px_per_frame", |p, v| {
                p.medium_speed_px_per_frame = v
            }),
            ("starts.distance_px", |p, v| p.starts.distance_px = v),
            ("ir_range_px", |p, v| p.ir_range_px = v),
            ("photo.half_angle_cosine", |p, v| {
                p.photo.half_angle_cosine = v
            }),
            ("object_light_px", |p, v| p.object_light_px = v),
            ("goals", |p, v| p.goals = Goals::CirclePx(v)),
            ("goal_radius_px", |p, v| p.goal_radius_px = v),
            ("team_push", |p, v| p.team_push = v),
        ];
        for (key, spoil) in keys {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e9] {
                let mut preset = Preset::R3;
                spoil(&mut preset, value);
                assert_eq!(
                    Model::new(preset).map_err(|e| e.key).err(),
                    Some(key),
                    "{key} = {value}"
                );
            }
        }
    }

    #[test]
    fn overlapping_starts_are_refused() {
        let mut preset = Preset::N;
        preset.starts.distance_px = 20.0;
        let error = Model::new(preset).expect_err("agents inside the object");
        assert_eq!(error.key, "distance from a start to the object");
        let mut preset = Preset::N;
        preset.starts.corners[1] = preset.starts.corners[0];
        assert_eq!(
            Model::new(preset).expect_err("two agents in one place").key,
            "distance between two starts"
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
    fn agents_start_looking_at_the_object() {
        for pose in start_poses(&Preset::R3) {
            let (cos, sin) = cos_sin(pose.heading);
            assert!(pose.x_px * cos < 0.0 && pose.y_px * sin < 0.0);
        }
    }
}
