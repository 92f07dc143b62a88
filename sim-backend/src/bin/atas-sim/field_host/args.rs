//! Command line of `atas-sim field`.

use std::path::Path;

use atas_process::exit::Exit;
use clap::Args;
use field::{Model, Preset, TeamSize};
use shm_bus::BusName;
use sim_backend::swarm::{GOALS, SwarmSettings};

use crate::failure::Failure;
use crate::output::Format;

const EXAMPLES: &str = "\
Examples:
  atas-sim field --goal 3 --trials 2
  atas-sim field --lockstep --agents 4 --format json
";

#[derive(Debug, Args)]
#[command(after_help = format!("{EXAMPLES}\n{}\n{}", Exit::TABLE, Failure::NOTES))]
pub(crate) struct FieldArgs {
    /// Field: R3, N, N3, LB, LB2, LB3, LB4, paper, or the TOML file of a preset.
    #[arg(long, default_value = "R3")]
    preset: String,
    /// Robots on the field, 1 to 4.
    #[arg(long, default_value_t = 2)]
    agents: usize,
    /// Goal of every trial, 1 to 8 [default: goals 1 to 8 in turn].
    #[arg(long, value_name = "K")]
    goal: Option<u8>,
    /// Number of trials, 270 frames each [default: 8, or 1 with --goal].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=10_000))]
    trials: Option<u16>,
    /// Parallel fields, at most 1024 robots in total; further fields have goals in other
    /// directions.
    #[arg(long, default_value_t = 1)]
    fields: usize,
    /// Frames per second, 1 to 2000.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=2000))]
    frame_rate_hz: u32,
    /// Wait for every answer: bit-identical runs, as fast as both processes allow.
    #[arg(long)]
    pub(super) lockstep: bool,
    /// Bus of the field.
    #[arg(long, env = BusName::ENV, default_value_t)]
    pub(super) bus: BusName,
    /// Output format.
    #[arg(long, value_enum, default_value = "human")]
    pub(super) format: Format,
}

impl FieldArgs {
    pub(super) fn settings(&self) -> Result<SwarmSettings, Failure> {
        let trials = self.trials.unwrap_or(match self.goal {
            Some(_) => 1,
            None => GOALS.into(),
        });
        let goal = |trial: u16| self.goal.unwrap_or((trial % u16::from(GOALS)) as u8 + 1);
        Ok(SwarmSettings {
            model: Model::new(preset(&self.preset)?)?,
            team: TeamSize::new(self.agents)?,
            fields: self.fields,
            goals: (0..trials).map(goal).collect(),
        })
    }

    pub(super) fn period_ns(&self) -> u64 {
        1_000_000_000 / u64::from(self.frame_rate_hz)
    }

    pub(super) fn pace(&self) -> String {
        if self.lockstep {
            "lock-step".to_owned()
        } else {
            format!("{} Hz", self.frame_rate_hz)
        }
    }
}

/// Preset by name or from a file.
fn preset(text: &str) -> Result<Preset, Failure> {
    if let Some(preset) = Preset::named(text) {
        return Ok(preset);
    }
    let refuse = |why: String| Failure::Preset {
        why,
        names: Preset::ALL
            .map(|preset| preset.name.into_owned())
            .join(", "),
    };
    if !Path::new(text).exists() {
        return Err(refuse(format!("{text:?} is neither a preset nor a file")));
    }
    let content = atas_text_file::read(text).map_err(|error| refuse(format!("{text}: {error}")))?;
    toml::from_str(&content).map_err(|error| refuse(format!("{text}: {}", error.message())))
}
