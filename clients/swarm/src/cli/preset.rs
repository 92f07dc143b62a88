//! `ebts preset`: lists the built-in fields and prints a field as a file to edit.

use clap::Args;
use serde::Serialize;

use ebts::error::{Error, Result};
use ebts::files::preset;
use field::{FitnessRule, Preset, Push};

use super::{Format, answer};

const EXAMPLES: &str = "Examples:
  ebts preset                        # the built-in presets
  ebts preset R3 > mine.toml         # all values of one, to edit
  printf 'base = \"R3\"\\ngoal_radius_px = 40.0\\n' > mine.toml
  ebts evolve --preset mine.toml";

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PresetArgs {
    /// Preset to print as complete TOML, by name or from a file [default: list the built-in ones].
    name: Option<String>,
}

const KEYS: [(&str, &str); 23] = [
    ("name", "name of the preset"),
    ("agent_radius_px", "1 to 100"),
    ("object_radius_px", "1 to 100"),
    (
        "medium_speed_px_per_frame",
        "wheel travel at medium speed; high is twice that",
    ),
    (
        "starts",
        "|x| and |y| of every start; the corner of agents 1 to 4; heading: to-centre or east",
    ),
    (
        "ir_range_px",
        "range of the three IR sensors from the agent's centre",
    ),
    (
        "ir_angle_steps",
        "angle of the side IR sensors from straight ahead, in 1/64 turns",
    ),
    (
        "photo",
        "both photo sensors: angle from straight ahead, 1/64 turns; cosine of half the opening",
    ),
    ("object_light_px", "range of the object's light"),
    ("goal_light_px", "range of the goal's light"),
    (
        "goals",
        "eight, every 45 degrees: { circle-px = radius } or { square-px = half side }",
    ),
    (
        "goal_radius_px",
        "largest distance of an object at the goal",
    ),
    (
        "solo_push",
        "share of an overlap by which one agent moves the object",
    ),
    (
        "team_push",
        "... two or more; friction_per_stall_force = phi replaces both: max(0, 1 - phi / k) for k agents",
    ),
    (
        "friction_per_stall_force",
        "k agents move the object by max(0, 1 - this / k) of an overlap; replaces solo_push, team_push",
    ),
    ("contact", "sliding or blocking"),
    (
        "half_side_px",
        "half the side of the square field; default 400",
    ),
    (
        "walls",
        "straight walls inside the field, each { from_px = [x, y], to_px = [x, y] }; impassable, \
         detected by IR",
    ),
    (
        "posts",
        "round posts, impassable, detected by IR, each { at_px = [x, y], radius_px = r }",
    ),
    (
        "drawn_posts",
        "further posts at places drawn with a seed: { count, radius_px, seed }; with walls and \
         posts at most 16",
    ),
    (
        "noise",
        "probabilities in 1/1024 per frame: a sensor is inverted; a wheel slips and stands still",
    ),
    (
        "training",
        "trials drawn for every generation: starts, goals: drawn or preset; draws: sets of eight goals",
    ),
    (
        "fitness",
        "points of a trial, 0 to 100: the sum of delivered, reached, accompanied, each_companion, and times E1 accuracy, times E2 efficiency",
    ),
];

#[derive(Serialize)]
struct Listed {
    name: String,
    fitness_rule: FitnessRule,
    preset: Preset,
}

pub(super) fn print(args: PresetArgs, format: Format) -> Result<()> {
    match args.name {
        Some(name) => {
            let preset = preset(&name)?;
            let text = file(&preset)?;
            answer(format, &preset, || text)
        }
        None => list(format),
    }
}

fn list(format: Format) -> Result<()> {
    let presets = Preset::ALL.map(|preset| Listed {
        name: preset.name.to_string(),
        fitness_rule: FitnessRule::default_for(&preset),
        preset,
    });
    answer(format, &presets, || {
        let mut text = String::from(
            "name   agent  object  goal  contact   push alone / by two  fitness rule\n",
        );
        for Listed {
            name,
            fitness_rule,
            preset,
        } in &presets
        {
            let [one, two, ..] = preset.push.by_agents();
            let law = match preset.push {
                Push::Friction(_) => " (law)",
                Push::Fitted { .. } => "",
            };
            let contact = format!("{:?}", preset.contact).to_lowercase();
            text += &format!(
                "{name:<5}  {:>5}  {:>6}  {:>4}  {contact:<8}  {:<19}  {fitness_rule}\n",
                preset.agent_radius_px,
                preset.object_radius_px,
                preset.goal_radius_px,
                format!("{one:.3} / {two:.3}{law}"),
            );
        }
        text + "radii in px; ebts preset NAME prints all values of one\n"
    })
}

pub(super) fn file(preset: &Preset) -> Result<String> {
    let table = toml::Table::try_from(preset).map_err(Error::from_part)?;
    let mut text = String::new();
    for (key, meaning) in KEYS {
        if let Some(value) = table.get(key) {
            text += &format!("# {meaning}\n{key} = {}\n", ebts::table_file::inline(value));
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_explained_and_presets_round_trip() {
        let wide = Preset {
            half_side_px: 500.0,
            ..Preset::R3
        };
        let drawn = Preset {
            noise: field::Noise {
                sensor_flips_per_1024: 10,
                wheel_slips_per_1024: 20,
            },
            training: Some(field::Training::default()),
            walls: vec![field::Wall {
                from_px: [-10.0, 90.5],
                to_px: [10.0, 90.0],
            }]
            .into(),
            posts: vec![field::Post {
                at_px: [0.0, 120.0],
                radius_px: 3.0,
            }]
            .into(),
            drawn_posts: Some(field::DrawnPosts {
                count: 2,
                radius_px: 9.5,
                seed: u32::MAX,
            }),
            fitness: Some(field::Weights {
                delivered: 60.0,
                each_companion: -1.5,
                ..field::Weights::default()
            }),
            ..Preset::N
        };
        for preset in Preset::ALL.into_iter().chain([wide, drawn]) {
            let table = toml::Table::try_from(&preset).expect("a table");
            for key in table.keys() {
                assert!(
                    KEYS.iter().any(|(known, _)| known == key),
                    "{key} is not explained"
                );
            }
            let text = file(&preset).expect("a file");
            assert_eq!(
                toml::from_str::<Preset>(&text).expect("a preset"),
                preset,
                "{text}"
            );
        }
    }
}
