//! Plan of an experiment.

use std::fmt;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use field::{FitnessRule, Model, Preset, TeamSize};

use crate::condition::{Condition, Sharing};
use crate::error::{Error, Result};
use crate::ga::Settings;
use crate::islands::IslandSettings;
use crate::run::Job;
use crate::sensors::SensorOrder;
use crate::training;

/// Plan of Fig. 14 and its variations: team sizes × seeds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Version of this crate; runs of another version may differ in bits.
    pub code_version: String,
    /// Team sizes.
    pub agents: Vec<usize>,
    /// First seed; the others follow it.
    pub first_seed: u64,
    /// Runs per team size.
    pub seeds: u64,
    /// Generations of every run.
    pub generations: u32,
    /// Assignment of tables to agents.
    pub sharing: Sharing,
    /// Order of the sensors S1–S5.
    pub sensors: SensorOrder,
    /// Scoring of trials.
    pub fitness_rule: FitnessRule,
    /// Settings of the genetic algorithm.
    pub settings: Settings,
    /// Islands and migration.
    pub islands: IslandSettings,
    /// The field.
    pub preset: Preset,
}

/// Upper limit of runs per team size, far beyond practical experiments.
const MAX_SEEDS: u64 = 1_000_000;

impl Plan {
    /// Returns the plan of Fig. 14: one to four agents (paper III.c.1).
    #[must_use]
    pub fn fig14(preset: Preset, fitness_rule: FitnessRule, seeds: u64, generations: u32) -> Self {
        Self {
            code_version: env!("CARGO_PKG_VERSION").to_owned(),
            agents: TeamSize::ALL.map(TeamSize::get).to_vec(),
            first_seed: 1,
            seeds,
            generations,
            sharing: Sharing::Shared,
            sensors: SensorOrder::default(),
            fitness_rule,
            settings: Settings::default(),
            islands: IslandSettings::default(),
            preset,
        }
    }

    /// Returns the validated conditions in the order of the team sizes.
    pub fn conditions(&self) -> Result<Vec<Condition>> {
        self.check()?;
        let model = Arc::new(Model::new(self.preset.clone()).map_err(Error::from_part)?);
        let condition = |&agents: &usize| {
            let condition = Condition {
                model: Arc::clone(&model),
                team: TeamSize::new(agents).map_err(Error::from_part)?,
                sharing: self.sharing,
                sensors: self.sensors,
                fitness: self.fitness_rule.into(),
            };
            training::check(&condition).map(|()| condition)
        };
        self.agents.iter().map(condition).collect()
    }

    fn check(&self) -> Result<()> {
        self.settings.check().map_err(Error::from_part)?;
        let refuse = |key: &str, value: String, needs: &str| {
            Err(Error::refused(
                "use an experiment",
                format_args!("its {key} is {value}"),
                needs,
                "correct it",
            ))
        };
        let once =
            |agents: &usize| self.agents.iter().filter(|other| *other == agents).count() == 1;
        if self.agents.is_empty() || !self.agents.iter().all(once) {
            return refuse(
                "agents",
                format!("{:?}", self.agents),
                "one or more team sizes, each once",
            );
        }
        if !(1..=MAX_SEEDS).contains(&self.seeds) {
            return refuse("seeds", self.seeds.to_string(), "1 to 1000000");
        }
        let IslandSettings {
            islands,
            migrate_every,
        } = self.islands;
        if !(1..=1000).contains(&islands) || migrate_every == 0 {
            return refuse(
                "islands",
                format!("{islands} every {migrate_every}"),
                "1 to 1000, every 1 or more",
            );
        }
        Ok(())
    }

    /// Returns every run, ordered by team size, then seed.
    #[must_use]
    pub fn jobs(&self) -> Vec<Job> {
        let seeds = self.first_seed..self.first_seed.saturating_add(self.seeds);
        self.agents
            .iter()
            .flat_map(|&agents| seeds.clone().map(move |seed| Job { agents, seed }))
            .collect()
    }
}

/// Part `index` of `count` of an experiment: every count-th run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Index, from 1.
    pub index: usize,
    /// Number of parts.
    pub count: usize,
}

impl Shard {
    /// The whole experiment.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// Returns the runs of this part.
    #[must_use]
    pub fn select(self, jobs: Vec<Job>) -> Vec<Job> {
        jobs.into_iter()
            .skip(self.index - 1)
            .step_by(self.count)
            .collect()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    /// Parses `i/n` with 1 ≤ i ≤ n.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let parts = text
            .split_once('/')
            .and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!(
                "a shard is {text:?}, needs i/n with i from 1 to n, as in 3/16"
            )),
        }
    }
}
