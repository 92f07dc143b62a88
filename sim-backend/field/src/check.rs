//! Which numbers a preset may have.

use thiserror::Error;

use crate::constants::FIELD_PX;
use crate::preset::{Goals, Preset};

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

/// Every comparison is written so that NaN fails it.
pub(crate) fn check(preset: &Preset) -> Result<(), PresetError> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
                    check(&preset).map_err(|e| e.key).err(),
                    Some(key),
                    "{key} = {value}"
                );
            }
        }
    }
}
