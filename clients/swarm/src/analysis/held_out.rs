//! Generalisation: fitness of a team with goals and starts that were not used in evolution.

use serde::Serialize;

use field::{Engine, Layout, MAX_AGENTS, Model, Point, Pose};

use super::points_in;
use crate::condition::Condition;
use crate::genome::Genome;
use crate::rng::SplitMix64;

const START_SETS: usize = 8;
/// Name of the random stream of held-out starts, equal for every team.
const STARTS_STREAM: u64 = 0x5741_5254;

/// Fitness (of 800) in training and held-out trials.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HeldOut {
    /// Eight training goals, starts of the preset.
    pub training: f32,
    /// Eight goals halfway between them, starts of the preset.
    pub goals: f32,
    /// Training goals, random starts; mean over eight sets of starts.
    pub starts: f32,
    /// Goals in between, random starts.
    pub goals_and_starts: f32,
}

/// Evaluates a team on held-out trials.
#[must_use]
pub fn held_out(condition: &Condition, engine: Engine, genome: &Genome) -> HeldOut {
    let model = &condition.model;
    let between: Vec<Point> = (0..8).map(|k| model.goal_towards(k * 8 + 4)).collect();
    let training = model.training_goals();
    let elsewhere = random_starts(model);
    let from_preset = |goals: &[Point]| {
        goals
            .iter()
            .map(|&goal| model.training_layout(goal))
            .collect::<Vec<_>>()
    };
    let from_elsewhere = |goals: &[Point]| -> Vec<Layout> {
        let layouts = elsewhere
            .iter()
            .flat_map(|&starts| goals.iter().map(move |&goal| (starts, goal)));
        // Valid starts and valid goals always form a valid layout.
        layouts
            .filter_map(|(starts, goal)| model.layout(starts, goal).ok())
            .collect()
    };
    let responses = condition.responses(genome);
    let points = |layouts: &[Layout]| points_in(condition, engine, responses, layouts);
    HeldOut {
        training: points(&from_preset(&training)),
        goals: points(&from_preset(&between)),
        starts: points(&from_elsewhere(&training)) / START_SETS as f32,
        goals_and_starts: points(&from_elsewhere(&between)) / START_SETS as f32,
    }
}

fn random_starts(model: &Model) -> Vec<[Pose; MAX_AGENTS]> {
    /// Limit of draws. On a crowded field fewer sets may be returned.
    const ATTEMPTS: usize = 100_000;
    let mut rng = SplitMix64::stream(&[STARTS_STREAM]);
    let limit = f64::from(model.preset().half_side_px - model.preset().agent_radius_px);
    let mut place = || (limit * (2.0 * rng.unit() - 1.0)) as f32;
    let goal = model.training_goals()[0];
    let drawn = (0..ATTEMPTS).map(|_| {
        [(); MAX_AGENTS].map(|()| Pose {
            x_px: place(),
            y_px: place(),
            heading: (place().to_bits() % 64) as u8,
        })
    });
    drawn
        .filter(|&starts| model.layout(starts, goal).is_ok())
        .take(START_SETS)
        .collect()
}
