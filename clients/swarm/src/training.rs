//! Trials that a table is evaluated on: the eight goals of the preset, or sets of eight drawn for
//! every generation.
//!
//! Inputs: a condition and a purpose (a generation of a run, the choice of a run's table, a
//! held-out test). Output: sets of eight layouts. Each purpose has its own random stream, so no two
//! purposes share a trial. Without [`field::Training`] every purpose uses the eight of the preset.

use field::{Layout, MAX_AGENTS, Model, Places, Point, Pose, Training};

use crate::condition::{Condition, GOALS};
use crate::error::{Error, Result};
use crate::rng::SplitMix64;

/// Eight layouts, goal 1 first.
pub type Set = [Layout; GOALS];

/// Names of random streams. [`GENERATION`] is followed by the seed of the run.
const GENERATION: u64 = 0x6765_6e65;
const CHOICE: u64 = 0x6368_6f69;
const UNSEEN: u64 = 0x756e_7365;

/// Sets used to choose the table of a run among the best of its generations. Measured on R3: the
/// standard error of the fitness is about 13 of 800 points, and with eight draws per generation the
/// choice takes two fifths of the run time.
const CHOICE_SETS: usize = 64;
/// Attempts to place one agent before the field is rejected as too crowded.
const ATTEMPTS: usize = 1000;

/// Returns the sets for all individuals of a run in this generation.
#[must_use]
pub fn generation_sets(condition: &Condition, seed: u64, generation: u32) -> Vec<Set> {
    let name = [GENERATION, seed, u64::from(generation)];
    sets(condition, |training| training.draws.into(), &name)
}

/// Returns the sets that decide the final table of a run. The points of a table refer to these
/// sets.
#[must_use]
pub fn choice_sets(condition: &Condition) -> Vec<Set> {
    sets(condition, |_| CHOICE_SETS, &[CHOICE])
}

fn sets(condition: &Condition, count: impl Fn(Training) -> usize, name: &[u64]) -> Vec<Set> {
    condition.training().map_or_else(
        || vec![condition.layouts()],
        |training| draw_sets(condition, training, count(training), name),
    )
}

/// Returns held-out sets: no table was evolved or chosen on them.
#[must_use]
pub fn held_out_sets(
    condition: &Condition,
    starts: Places,
    goals: Places,
    count: usize,
) -> Vec<Set> {
    let training = Training {
        starts,
        goals,
        ..Training::default()
    };
    draw_sets(condition, training, count, &[UNSEEN])
}

fn draw_sets(condition: &Condition, training: Training, count: usize, name: &[u64]) -> Vec<Set> {
    let mut rng = SplitMix64::stream(name);
    (0..count)
        .map(|_| draw_set(condition, training, &mut rng))
        .collect()
}

/// Checks that the field has room for drawn starts.
pub fn check(condition: &Condition) -> Result<()> {
    let Some(Training {
        starts: Places::Drawn,
        ..
    }) = condition.training()
    else {
        return Ok(());
    };
    let mut rng = SplitMix64::stream(&[CHOICE]);
    let room = (0..GOALS).all(|_| draw_starts(&condition.model, &mut rng).is_some());
    room.then_some(()).ok_or_else(|| {
        Error::refused(
            "draw starts",
            "the field is too crowded for four agents and the object",
            "enough room that nothing touches",
            "make half_side_px larger or the radii smaller",
        )
    })
}

/// Draws one set of eight. A start without room on a crowded field falls back to that of the
/// preset.
fn draw_set(condition: &Condition, training: Training, rng: &mut SplitMix64) -> Set {
    let model = &condition.model;
    let mut layout = |preset: Layout, eighth: usize| {
        let (starts_at, goal_at) = (draw_starts(model, rng), draw_goal(model, eighth, rng));
        let starts = match training.starts {
            Places::Preset => *preset.starts(),
            Places::Drawn => starts_at.unwrap_or(*preset.starts()),
        };
        let goal = match training.goals {
            Places::Preset => preset.goal(),
            Places::Drawn => goal_at,
        };
        // Valid starts and valid goals always form a valid layout.
        let layout = model.layout(starts, goal).unwrap_or(preset);
        layout.with_noise(rng.next_u64() as u32)
    };
    let mut eighth = 0..;
    condition
        .layouts()
        .map(|preset| layout(preset, eighth.next().unwrap_or(0)))
}

/// Draws a goal in an eighth of the circle or square around the preset's goal, without an obstacle
/// in the object's way.
fn draw_goal(model: &Model, eighth: usize, rng: &mut SplitMix64) -> Point {
    let mut anywhere = || {
        let steps = 8 * eighth + 60 + rng.below(8);
        model.goal_between((steps % field::HEADINGS) as u8, rng.unit() as f32)
    };
    let object_px = model.preset().object_radius_px;
    let free = (0..ATTEMPTS).map(|_| anywhere());
    let mut free = free.filter(|goal| model.is_clear(*goal, object_px));
    free.next().unwrap_or(model.training_goals()[eighth])
}

/// Draws four starts on the field with random headings. They touch neither the object nor an
/// obstacle nor each other.
fn draw_starts(model: &Model, rng: &mut SplitMix64) -> Option<[Pose; MAX_AGENTS]> {
    let preset = model.preset();
    let limit = f64::from(preset.half_side_px - preset.agent_radius_px);
    let touch = preset.agent_radius_px + preset.object_radius_px;
    let pair = 2.0 * preset.agent_radius_px;
    let apart = |a: &Pose, x: f32, y: f32, least: f32| {
        let (dx, dy) = (a.x_px - x, a.y_px - y);
        dx * dx + dy * dy >= least * least
    };
    let mut placed: Vec<Pose> = Vec::with_capacity(MAX_AGENTS);
    for _ in 0..MAX_AGENTS {
        let free = |pose: &Pose| {
            let (x_px, y_px) = (pose.x_px, pose.y_px);
            apart(pose, 0.0, 0.0, touch)
                && model.is_clear(Point { x_px, y_px }, preset.agent_radius_px)
                && placed.iter().all(|p| apart(p, pose.x_px, pose.y_px, pair))
        };
        let mut anywhere = || {
            let mut place = || (limit * (2.0 * rng.unit() - 1.0)) as f32;
            let (x_px, y_px) = (place(), place());
            let heading = rng.below(field::HEADINGS) as u8;
            Pose {
                x_px,
                y_px,
                heading,
            }
        };
        let pose = (0..ATTEMPTS).map(|_| anywhere()).find(free)?;
        placed.push(pose);
    }
    placed.try_into().ok()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use field::{FitnessRule, Preset, TeamSize};

    use super::*;

    fn condition(preset: Preset) -> Condition {
        let model = Model::new(preset).expect("a valid preset");
        let team = TeamSize::new(3).expect("three agents");
        Condition::new(Arc::new(model), team, FitnessRule::AntiAccident)
    }

    fn draw_sets(preset: Preset) -> Condition {
        let training = Some(Training::default());
        condition(Preset { training, ..preset })
    }

    #[test]
    fn without_training_preset_layouts_are_used() {
        let condition = condition(Preset::R3);
        let eight = vec![condition.layouts()];
        assert_eq!(generation_sets(&condition, 7, 3), eight);
        assert_eq!(choice_sets(&condition), eight);
    }

    #[test]
    fn purposes_have_disjoint_repeatable_trials() {
        let condition = draw_sets(Preset::N);
        let both = |count| held_out_sets(&condition, Places::Drawn, Places::Drawn, count);
        let asked = || {
            [
                generation_sets(&condition, 1, 0),
                generation_sets(&condition, 1, 1),
                generation_sets(&condition, 2, 0),
                choice_sets(&condition),
                both(8),
            ]
        };
        let sets = asked();
        assert_eq!(sets, asked());
        let layouts: Vec<Layout> = sets.concat().concat();
        for (index, layout) in layouts.iter().enumerate() {
            let others = &layouts[..index];
            let seen = |other: &&Layout| {
                other.starts()[0] == layout.starts()[0] || other.goal() == layout.goal()
            };
            assert_eq!(others.iter().find(seen), None, "{layout:?}");
        }
    }

    /// Starts are valid, and every goal is in its own eighth of the preset's circle or square.
    #[test]
    fn drawn_layouts_are_valid() {
        for preset in Preset::ALL {
            let condition = draw_sets(preset);
            check(&condition).expect("room for starts");
            for set in choice_sets(&condition) {
                for (layout, preset) in set.iter().zip(condition.layouts()) {
                    let model = &condition.model;
                    assert!(model.layout(*layout.starts(), layout.goal()).is_ok());
                    let (a, b) = (layout.goal(), preset.goal());
                    let along = a.x_px * b.x_px + a.y_px * b.y_px;
                    let size = |p: Point| (p.x_px * p.x_px + p.y_px * p.y_px).sqrt();
                    assert!(along > 0.9 * size(a) * size(b), "{a:?} is not near {b:?}");
                }
            }
        }
    }

    #[test]
    fn crowded_field_is_rejected() {
        let crowded = Preset {
            agent_radius_px: 90.0,
            object_radius_px: 20.0,
            ir_range_px: 100.0,
            half_side_px: 185.0,
            starts: field::Starts {
                distance_px: 95.0,
                ..Preset::R3.starts
            },
            goals: field::Goals::CirclePx(100.0),
            ..Preset::R3
        };
        let error = check(&draw_sets(crowded)).expect_err("no room");
        assert!(error.to_string().contains("too crowded"), "{error}");
    }
}
