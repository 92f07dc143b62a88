//! Range checks of a preset's numbers.

use std::borrow::Cow;

use thiserror::Error;

use crate::noise::Noise;
use crate::preset::{Goals, Preset, Push};
use crate::training::{Places, Training};
use crate::weights::Weights;

/// Largest number of goal sets. Design choice: more only lengthen a generation.
const MAX_DRAWS: u8 = 64;
/// Largest weight, ten times the points of a goal. Design choice.
const WEIGHT_MAX: f32 = 1000.0;
/// Probability 1, in 1/1024.
const PROBABILITY_MAX: u16 = 1024;

/// Invalid preset or layout.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "could not use preset {preset:?}: {}; correct {}",
    .findings.iter().map(Finding::to_string).collect::<Vec<_>>().join(", and "),
    if let [_] = .findings[..] { "that value" } else { "those values" }
)]
pub struct PresetError {
    /// Preset name.
    pub preset: String,
    /// Findings, at least one.
    pub findings: Vec<Finding>,
}

/// Value out of range.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{key} was {value}, needs {needs}")]
pub struct Finding {
    /// Name of the value.
    pub key: Cow<'static, str>,
    /// Rejected value.
    pub value: f32,
    /// Allowed range.
    pub needs: &'static str,
}

impl Finding {
    pub(crate) fn new(key: impl Into<Cow<'static, str>>, value: f32, needs: &'static str) -> Self {
        let key = key.into();
        Self { key, value, needs }
    }
}

impl PresetError {
    /// Returns the names of the values.
    #[must_use]
    pub fn keys(&self) -> Vec<&str> {
        self.findings.iter().map(|found| &*found.key).collect()
    }
}

/// Checks all values except walls and posts. Every comparison is false for NaN.
pub(crate) fn check(preset: &Preset) -> Vec<Finding> {
    let p = preset;
    let touch = p.agent_radius_px + p.object_radius_px;
    let (Goals::CirclePx(goal_distance) | Goals::SquarePx(goal_distance)) = p.goals;
    let in_range = |value: f32, low: f32, high: f32| value >= low && value <= high;
    let step = |steps: u8| in_range(f32::from(steps), 0.0, 16.0);
    let positive = f32::MIN_POSITIVE;
    let rows = [
        (
            "half_side_px",
            p.half_side_px,
            in_range(p.half_side_px, 100.0, 2000.0),
            "100 to 2000",
        ),
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
            "above 0 and at most a quarter of the sum of both radii, so that bodies do not pass \
             through each other",
        ),
        (
            "starts.distance_px",
            p.starts.distance_px,
            in_range(p.starts.distance_px, 0.0, p.half_side_px),
            "0 to half the field's side",
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
            in_range(goal_distance, 0.0, p.half_side_px - p.object_radius_px),
            "0 to half the field's side − object radius",
        ),
        (
            "goal_radius_px",
            p.goal_radius_px,
            in_range(p.goal_radius_px, 1.0, p.half_side_px),
            "1 to half the field's side",
        ),
        push(p.push),
        noise(p.noise),
        training(p.training, p.noise),
        fitness(p.fitness),
    ];
    let wrong = rows.into_iter().filter(|(_, _, good, _)| !good);
    wrong
        .map(|(key, value, _, needs)| Finding::new(key, value, needs))
        .collect()
}

/// Returns the first value out of range, else any.
fn push(push: Push) -> (&'static str, f32, bool, &'static str) {
    let part = |value: f32| (0.0..=1.0).contains(&value);
    match push {
        Push::Fitted { solo, .. } if !part(solo) => ("solo_push", solo, false, "0 to 1"),
        Push::Fitted { team, .. } => ("team_push", team, part(team), "0 to 1"),
        Push::Friction(stall_forces) => (
            "friction_per_stall_force",
            stall_forces,
            (0.0..=4.0).contains(&stall_forces),
            "0 to 4; above 4 no team moves the object",
        ),
    }
}

fn noise(noise: Noise) -> (&'static str, f32, bool, &'static str) {
    let Noise {
        sensor_flips_per_1024: flips,
        wheel_slips_per_1024: slips,
    } = noise;
    let (key, parts) = if flips > PROBABILITY_MAX {
        ("noise.sensor_flips_per_1024", flips)
    } else {
        ("noise.wheel_slips_per_1024", slips)
    };
    (key, f32::from(parts), parts <= PROBABILITY_MAX, "0 to 1024")
}

/// Returns the first weight out of range, else checks that one is above 0.
fn fitness(weights: Option<Weights>) -> (&'static str, f32, bool, &'static str) {
    let terms = weights.map(|weights| weights.terms());
    let wrong = |(_, weight): &&(&str, f32)| !(-WEIGHT_MAX..=WEIGHT_MAX).contains(weight);
    match terms.as_ref().and_then(|terms| terms.iter().find(wrong)) {
        Some(&(key, weight)) => (key, weight, false, "-1000 to 1000"),
        None => {
            let counts = terms.is_none_or(|terms| terms.iter().any(|(_, weight)| *weight > 0.0));
            (
                "fitness",
                0.0,
                counts,
                "a weight above 0; otherwise every trial scores 0",
            )
        }
    }
}

fn training(training: Option<Training>, noise: Noise) -> (&'static str, f32, bool, &'static str) {
    let Some(Training {
        starts,
        goals,
        draws,
    }) = training
    else {
        return ("training", 0.0, true, "nothing");
    };
    let drawn = starts == Places::Drawn || goals == Places::Drawn || !noise.is_none();
    let most = if drawn { MAX_DRAWS } else { 1 };
    let needs = if drawn {
        "1 to 64"
    } else {
        "1 if starts, goals and noise are not random, because all sets are identical then"
    };
    (
        "training.draws",
        f32::from(draws),
        (1..=most).contains(&draws),
        needs,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_and_draws_out_of_range_are_refused_by_name() {
        let noise = |flips, slips| Noise {
            sensor_flips_per_1024: flips,
            wheel_slips_per_1024: slips,
        };
        let fixed = |draws| {
            Some(Training {
                starts: Places::Preset,
                goals: Places::Preset,
                draws,
            })
        };
        let drawn = |draws| {
            Some(Training {
                draws,
                ..Training::default()
            })
        };
        let rows = [
            (noise(1024, 1024), drawn(64), None),
            (noise(1025, 0), None, Some("noise.sensor_flips_per_1024")),
            (noise(0, 9999), None, Some("noise.wheel_slips_per_1024")),
            (noise(0, 0), drawn(0), Some("training.draws")),
            (noise(0, 0), drawn(65), Some("training.draws")),
            (noise(0, 0), fixed(2), Some("training.draws")),
            (noise(0, 1), fixed(2), None),
        ];
        for (noise, training, expected) in rows {
            let preset = Preset {
                noise,
                training,
                ..Preset::R3
            };
            let found = check(&preset);
            let keys: Vec<&str> = found.iter().map(|found| &*found.key).collect();
            assert_eq!(keys, Vec::from_iter(expected), "{noise:?} {training:?}");
        }
    }

    #[test]
    fn bad_values_are_refused_by_name() {
        type SetValue = fn(&mut Preset, f32);
        let keys: [(&str, SetValue); 14] = [
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
            ("solo_push", |p, v| {
                p.push = Push::Fitted { solo: v, team: 0.5 }
            }),
            ("team_push", |p, v| {
                p.push = Push::Fitted { solo: 0.5, team: v }
            }),
            ("friction_per_stall_force", |p, v| {
                p.push = Push::Friction(v)
            }),
            ("half_side_px", |p, v| p.half_side_px = v),
            ("fitness", |p, v| {
                let accuracy = if v < 0.0 { 0.0 } else { v };
                p.fitness = Some(Weights {
                    accuracy,
                    ..Weights::default()
                });
            }),
        ];
        for (key, spoil) in keys {
            for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 1e9] {
                let mut preset = Preset::R3;
                spoil(&mut preset, value);
                let found = check(&preset);
                assert!(
                    found.iter().any(|found| found.key.starts_with(key)),
                    "{key} = {value}: {found:?}"
                );
            }
        }
    }
}
