//! Options shared by several commands.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::file_name::parse_with_suffix;
use clap::{Args, ValueEnum};

use ebts::condition::Sharing;
use ebts::error::{Error, Result};
use ebts::experiment::Plan;
use ebts::files::preset;
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::sensors::SensorOrder;
use ebts::workers::Workers;
use field::{Engine, FitnessRule, Preset};

pub(super) fn toml_file(text: &str) -> std::result::Result<PathBuf, String> {
    parse_with_suffix(text, &["toml"])
}

pub(super) fn csv_file(text: &str) -> std::result::Result<PathBuf, String> {
    parse_with_suffix(text, &["csv"])
}

pub(super) fn svg_file(text: &str) -> std::result::Result<PathBuf, String> {
    parse_with_suffix(text, &["svg"])
}

pub(super) fn html_file(text: &str) -> std::result::Result<PathBuf, String> {
    parse_with_suffix(text, &["html"])
}

#[derive(Debug, Args)]
pub(super) struct EvolutionArgs {
    /// Field: a name from `ebts preset`, or a TOML file.
    ///
    /// The file has the form that `ebts preset NAME` prints, complete or with a base.
    #[arg(long, default_value = "R3", value_name = "NAME|FILE")]
    preset: String,
    /// Generations after the random population.
    #[arg(long, default_value_t = 2000)]
    pub(super) generations: u32,
    /// Scoring of trials [default: the preset's key fitness, else anti-accident; literal for preset
    /// "paper"].
    #[arg(long, value_enum)]
    fitness: Option<Fitness>,
    /// Individuals per population, even.
    #[arg(long, default_value_t = Settings::default().population)]
    population: usize,
    /// Individuals that survive regardless of their children, at least 1.
    #[arg(long, default_value_t = Settings::default().elite)]
    elite: usize,
    /// Flip probability per bit of a child.
    #[arg(long, default_value_t = Settings::default().mutation_rate)]
    mutation_rate: f64,
    /// Populations that evolve separately and exchange their best.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    islands: u16,
    /// Generations between two exchanges.
    #[arg(long, default_value_t = IslandSettings::default().migrate_every, value_parser = clap::value_parser!(u32).range(1..))]
    migrate_every: u32,
    /// Give every agent its own table instead of one for the team.
    #[arg(long)]
    table_per_agent: bool,
    /// Sensors of S1 to S5: ir-left, ir-front, ir-right, photo-left, photo-right in any order.
    #[arg(long, default_value_t, value_name = "ORDER")]
    sensors: SensorOrder,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Fitness {
    /// 100 for a carried object at the goal, else E1, limited to its value at the goal's edge (not
    /// in the paper)
    AntiAccident,
    /// E1 + E2 as printed in the paper
    Literal,
    /// E1 + E2, but nothing for accidents, found by comparing execution and evaluation (reading of
    /// the paper)
    Compared,
}

impl EvolutionArgs {
    pub(super) fn preset(&self) -> Result<Preset> {
        preset(&self.preset)
    }

    pub(super) fn fitness_rule(&self, preset: &Preset) -> FitnessRule {
        match self.fitness {
            Some(Fitness::Literal) => FitnessRule::Literal,
            Some(Fitness::Compared) => FitnessRule::Compared,
            Some(Fitness::AntiAccident) => FitnessRule::AntiAccident,
            None => FitnessRule::default_for(preset),
        }
    }

    pub(super) fn settings(&self) -> Result<Settings> {
        let Self {
            population,
            elite,
            mutation_rate,
            ..
        } = *self;
        let settings = Settings {
            population,
            elite,
            mutation_rate,
        };
        settings.check().map(|_| settings).map_err(Error::from_part)
    }

    pub(super) fn islands(&self) -> IslandSettings {
        IslandSettings {
            islands: usize::from(self.islands),
            migrate_every: self.migrate_every,
        }
    }

    pub(super) fn sharing(&self) -> Sharing {
        if self.table_per_agent {
            Sharing::PerAgent
        } else {
            Sharing::Shared
        }
    }

    pub(super) fn sensors(&self) -> SensorOrder {
        self.sensors
    }

    /// Returns the plan of Fig. 14 with these options on a preset.
    pub(super) fn plan(&self, preset: Preset, seeds: u64) -> Result<Plan> {
        let fitness_rule = self.fitness_rule(&preset);
        Ok(Plan {
            sharing: self.sharing(),
            sensors: self.sensors(),
            settings: self.settings()?,
            islands: self.islands(),
            ..Plan::fig14(preset, fitness_rule, seeds, self.generations)
        })
    }
}

#[derive(Debug, Args)]
pub(super) struct EngineArgs {
    /// Simulator: scalar, portable, avx2 or avx512 [default: the fastest]. Results are identical.
    #[arg(long)]
    engine: Option<String>,
    /// Threads [default: one per core]. Results are identical.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl EngineArgs {
    pub(super) fn engine(&self) -> Result<Engine> {
        self.engine.as_deref().map_or_else(
            || Ok(Engine::fastest()),
            |name| Engine::named(name).map_err(Error::from_part),
        )
    }

    pub(super) fn workers(&self, stop: Arc<AtomicBool>) -> Result<Workers> {
        Workers::new(self.engine()?, self.threads(), stop)
    }

    pub(super) fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }
}
