//! File format of a preset: every key, or `base` and the keys that differ.

use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

use crate::noise::Noise;
use crate::obstacle::{DrawnPosts, Post, Wall};
use crate::preset::{Contact, Corner, Goals, HALF_SIDE_PX, Photo, Preset, Push, Start, Starts};
use crate::training::Training;
use crate::trial::MAX_AGENTS;
use crate::weights::Weights;

impl Serialize for Preset {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        PresetFile::from(self.clone()).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Preset {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let written = PresetFile::deserialize(deserializer)?;
        Self::try_from(written).map_err(D::Error::custom)
    }
}

/// Optional keys, in the order of [`Preset`].
#[derive(Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PresetFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    base: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<Cow<'static, str>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    agent_radius_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    object_radius_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    medium_speed_px_per_frame: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    starts: Option<StartsFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ir_range_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    ir_angle_steps: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    photo: Option<PhotoFile>,
    #[serde(skip_serializing_if = "Option::is_none")]
    object_light_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    goal_light_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    goals: Option<Goals>,
    #[serde(skip_serializing_if = "Option::is_none")]
    goal_radius_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    solo_push: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    team_push: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    friction_per_stall_force: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    contact: Option<Contact>,
    /// Omitted for the paper's value.
    #[serde(skip_serializing_if = "Option::is_none")]
    half_side_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    walls: Option<Vec<Wall>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    posts: Option<Vec<Post>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drawn_posts: Option<DrawnPosts>,
    #[serde(skip_serializing_if = "Option::is_none")]
    noise: Option<Noise>,
    #[serde(skip_serializing_if = "Option::is_none")]
    training: Option<Training>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitness: Option<Weights>,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct StartsFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    distance_px: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    corners: Option<[Corner; MAX_AGENTS]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    heading: Option<Start>,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PhotoFile {
    #[serde(skip_serializing_if = "Option::is_none")]
    angle_steps: Option<u8>,
    #[serde(skip_serializing_if = "Option::is_none")]
    half_angle_cosine: Option<f32>,
}

impl From<Preset> for PresetFile {
    fn from(p: Preset) -> Self {
        let (solo_push, team_push, friction_per_stall_force) = match p.push {
            Push::Fitted { solo, team } => (Some(solo), Some(team), None),
            Push::Friction(stall_forces) => (None, None, Some(stall_forces)),
        };
        Self {
            base: None,
            name: Some(p.name),
            agent_radius_px: Some(p.agent_radius_px),
            object_radius_px: Some(p.object_radius_px),
            medium_speed_px_per_frame: Some(p.medium_speed_px_per_frame),
            starts: Some(StartsFile {
                distance_px: Some(p.starts.distance_px),
                corners: Some(p.starts.corners),
                heading: Some(p.starts.heading),
            }),
            ir_range_px: Some(p.ir_range_px),
            ir_angle_steps: Some(p.ir_angle_steps),
            photo: Some(PhotoFile {
                angle_steps: Some(p.photo.angle_steps),
                half_angle_cosine: Some(p.photo.half_angle_cosine),
            }),
            object_light_px: Some(p.object_light_px),
            goal_light_px: Some(p.goal_light_px),
            goals: Some(p.goals),
            goal_radius_px: Some(p.goal_radius_px),
            solo_push,
            team_push,
            friction_per_stall_force,
            contact: Some(p.contact),
            half_side_px: (p.half_side_px != HALF_SIDE_PX).then_some(p.half_side_px),
            walls: (!p.walls.is_empty()).then(|| p.walls.into_owned()),
            posts: (!p.posts.is_empty()).then(|| p.posts.into_owned()),
            drawn_posts: p.drawn_posts,
            noise: (!p.noise.is_none()).then_some(p.noise),
            training: p.training,
            fitness: p.fitness,
        }
    }
}

impl TryFrom<PresetFile> for Preset {
    type Error = String;

    fn try_from(written: PresetFile) -> Result<Self, String> {
        let base = match &written.base {
            None => PresetFile::default(),
            Some(name) => Preset::named(name).map(PresetFile::from).ok_or_else(|| {
                let names = Preset::ALL.map(|preset| preset.name.into_owned());
                format!(
                    "base was {name:?}, needs a built-in preset: {}",
                    names.join(", ")
                )
            })?,
        };
        written.complete(base)
    }
}

/// Key of the file, else of the base.
macro_rules! key {
    ($file:expr, $base:expr, $($key:tt).+) => {
        $file.$($key).+.or($base.$($key).+).ok_or_else(|| missing(stringify!($($key).+)))?
    };
}

impl PresetFile {
    fn complete(self, base: Self) -> Result<Preset, String> {
        let changed = base
            .name
            .as_ref()
            .map(|base| format!("{base}-changed").into());
        let name = self.name.clone().or(changed);
        let name = name.ok_or_else(|| missing("name"))?;
        let push = self.push(&base)?;
        let (file, base) = (self, base);
        let (starts, base_starts) = (
            file.starts.unwrap_or_default(),
            base.starts.unwrap_or_default(),
        );
        let (photo, base_photo) = (
            file.photo.unwrap_or_default(),
            base.photo.unwrap_or_default(),
        );
        Ok(Preset {
            name,
            agent_radius_px: key!(file, base, agent_radius_px),
            object_radius_px: key!(file, base, object_radius_px),
            medium_speed_px_per_frame: key!(file, base, medium_speed_px_per_frame),
            starts: Starts {
                distance_px: key!(starts, base_starts, distance_px),
                corners: key!(starts, base_starts, corners),
                heading: key!(starts, base_starts, heading),
            },
            ir_range_px: key!(file, base, ir_range_px),
            ir_angle_steps: key!(file, base, ir_angle_steps),
            photo: Photo {
                angle_steps: key!(photo, base_photo, angle_steps),
                half_angle_cosine: key!(photo, base_photo, half_angle_cosine),
            },
            object_light_px: key!(file, base, object_light_px),
            goal_light_px: key!(file, base, goal_light_px),
            goals: key!(file, base, goals),
            goal_radius_px: key!(file, base, goal_radius_px),
            push,
            contact: key!(file, base, contact),
            half_side_px: file
                .half_side_px
                .or(base.half_side_px)
                .unwrap_or(HALF_SIDE_PX),
            walls: file.walls.or(base.walls).unwrap_or_default().into(),
            posts: file.posts.or(base.posts).unwrap_or_default().into(),
            drawn_posts: file.drawn_posts.or(base.drawn_posts),
            noise: file.noise.or(base.noise).unwrap_or_default(),
            training: file.training.or(base.training),
            fitness: file.fitness.or(base.fitness),
        })
    }

    /// Two fitted numbers or friction; keys of the file replace the base's law.
    fn push(&self, base: &Self) -> Result<Push, String> {
        match (self.friction_per_stall_force, self.solo_push, self.team_push) {
            (Some(_), Some(_), _) | (Some(_), _, Some(_)) => Err(
                "friction_per_stall_force is given together with solo_push or team_push, needs one \
                 of both: the friction law replaces the two numbers"
                    .to_owned(),
            ),
            (Some(stall_forces), None, None) => Ok(Push::Friction(stall_forces)),
            (None, None, None) if base.friction_per_stall_force.is_some() => {
                Ok(Push::Friction(key!(self, base, friction_per_stall_force)))
            }
            (None, solo, team) => Ok(Push::Fitted {
                solo: solo.or(base.solo_push).ok_or_else(|| missing("solo_push"))?,
                team: team.or(base.team_push).ok_or_else(|| missing("team_push"))?,
            }),
        }
    }
}

fn missing(key: &str) -> String {
    format!(
        "missing field `{key}`, needs every key of a preset, or base = \"R3\" and the keys that \
         differ"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_keys_come_from_the_base() {
        let file = PresetFile {
            base: Some("lb2".to_owned()),
            goal_radius_px: Some(40.0),
            friction_per_stall_force: Some(0.95),
            ..PresetFile::default()
        };
        let preset = Preset::try_from(file).expect("a preset");
        let expected = Preset {
            name: "LB2-changed".into(),
            ..Preset::LB3
        };
        assert_eq!(preset, expected);
    }

    #[test]
    fn every_preset_round_trips() {
        for preset in Preset::ALL {
            assert_eq!(
                Preset::try_from(PresetFile::from(preset.clone())),
                Ok(preset)
            );
        }
    }

    #[test]
    fn invalid_preset_files_are_rejected() {
        let lb2 = || PresetFile {
            base: Some("LB2".to_owned()),
            ..PresetFile::default()
        };
        let rows = [
            (PresetFile::default(), "missing field `name`"),
            (
                PresetFile {
                    base: Some("R9".to_owned()),
                    ..PresetFile::default()
                },
                "base was \"R9\"",
            ),
            (
                PresetFile {
                    friction_per_stall_force: Some(1.0),
                    solo_push: Some(0.1),
                    ..lb2()
                },
                "needs one of both",
            ),
            (
                PresetFile {
                    base: Some("LB3".to_owned()),
                    solo_push: Some(0.1),
                    ..PresetFile::default()
                },
                "missing field `team_push`",
            ),
            (
                PresetFile {
                    name: Some("mine".into()),
                    solo_push: Some(0.1),
                    team_push: Some(1.0),
                    ..PresetFile::default()
                },
                "missing field `agent_radius_px`",
            ),
        ];
        for (file, expected) in rows {
            let why = Preset::try_from(file).expect_err(expected);
            assert!(
                why.contains(expected),
                "{why:?} does not contain {expected:?}"
            );
        }
    }
}
