//! Options that several commands share.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use atas_process::file_name::ending_in;
use clap::{Args, ValueEnum};

use ebts::condition::Sharing;
use ebts::error::{Error, Result};
use ebts::experiment::Plan;
use ebts::files::read_text;
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::sensors::SensorOrder;
use ebts::workers::Workers;
use field::{Engine, FitnessRule, Model, Preset};

/// A table file to write.
pub(super) fn toml_file(text: &str) -> std::result::Result<PathBuf, String> {
    ending_in(text, &["toml"])
}

/// A file of rows to write.
pub(super) fn csv_file(text: &str) -> std::result::Result<PathBuf, String> {
    ending_in(text, &["csv"])
}

/// A figure to write.
pub(super) fn svg_file(text: &str) -> std::result::Result<PathBuf, String> {
    ending_in(text, &["svg"])
}

/// A web page to write.
pub(super) fn html_file(text: &str) -> std::result::Result<PathBuf, String> {
    ending_in(text, &["html"])
}

/// The field, the scoring and the genetic algorithm.
#[derive(Debug, Args)]
pub(super) struct EvolutionArgs {
    /// Field: one of those that `ebts preset` lists, or a TOML file as `ebts preset NAME` prints it, whole or with a base.
    #[arg(long, default_value = "R3", value_name = "NAME|FILE")]
    preset: String,
    /// Generations after the random population.
    #[arg(long, default_value_t = 2000)]
    pub(super) generations: u32,
    /// How trials are scored [default: as the preset's key fitness says, else anti-accident; literal for the preset "paper"].
    #[arg(long, value_enum)]
    fitness: Option<Fitness>,
    /// Individuals per population, an even number.
    #[arg(long, default_value_t = Settings::default().population)]
    population: usize,
    /// Individuals that survive whatever their children do, at least 1.
    #[arg(long, default_value_t = Settings::default().elite)]
    elite: usize,
    /// Probability of a flip per bit of a child.
    #[arg(long, default_value_t = Settings::default().mutation_rate)]
    mutation_rate: f64,
    /// Populations that evolve apart and exchange their best.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1000))]
    islands: u16,
    /// Generations between two exchanges.
    #[arg(long, default_value_t = IslandSettings::default().migrate_every, value_parser = clap::value_parser!(u32).range(1..))]
    migrate_every: u32,
    /// Give every agent a table of its own instead of one for the team.
    #[arg(long)]
    table_per_agent: bool,
    /// What S1 to S5 are: five of ir-left, ir-front, ir-right, photo-left, photo-right.
    #[arg(long, default_value_t, value_name = "ORDER")]
    sensors: SensorOrder,
}

/// How trials are scored, at most 100 points a goal.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Fitness {
    /// Ours: 100 for a carried object at the goal, else E1, at most as on the goal's edge
    AntiAccident,
    /// E1 + E2 as the paper prints them
    Literal,
    /// The paper's reading: E1 + E2, but nothing for accidents, by comparing execution and evaluation
    Compared,
}

impl EvolutionArgs {
    /// The preset, by name or from a file, checked.
    pub(super) fn preset(&self) -> Result<Preset> {
        preset(&self.preset)
    }

    pub(super) fn fitness_rule(&self, preset: &Preset) -> FitnessRule {
        match self.fitness {
            Some(Fitness::Literal) => FitnessRule::Literal,
            Some(Fitness::Compared) => FitnessRule::Compared,
            Some(Fitness::AntiAccident) => FitnessRule::AntiAccident,
            None => FitnessRule::usual(preset),
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

    /// Fig. 14 with all of this on a preset.
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

/// A preset, by name or from a file, checked.
pub(super) fn preset(name: &str) -> Result<Preset> {
    let preset = match Preset::named(name) {
        Some(preset) => preset,
        None if Path::new(name).exists() => preset_file(Path::new(name))?,
        None => {
            let names = Preset::ALL
                .map(|preset| preset.name.into_owned())
                .join(", ");
            return Err(Error::refused(
                "choose a preset",
                format_args!("{name:?} is neither a preset nor a file"),
                format_args!("one of {names}, or a TOML file"),
                "correct --preset",
            ));
        }
    };
    checked(preset)
}

/// The preset, if it can be simulated.
pub(super) fn checked(preset: Preset) -> Result<Preset> {
    Model::new(preset)
        .map(|model| model.preset().clone())
        .map_err(Error::from_part)
}

fn preset_file(path: &Path) -> Result<Preset> {
    toml::from_str(&read_text(path)?).map_err(|error| {
        Error::refused(
            format_args!("use preset {}", path.display()),
            error.message(),
            "a preset as ebts preset prints it, or base and the keys that differ",
            "correct the file",
        )
    })
}

/// What simulates.
#[derive(Debug, Args)]
pub(super) struct EngineArgs {
    /// Simulator: scalar, portable, avx2 or avx512 [default: the fastest here]. All give the same bits.
    #[arg(long)]
    engine: Option<String>,
    /// Threads [default: one per core]. The number changes no bit.
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

    /// Workers that stop with the flag.
    pub(super) fn workers(&self, stop: Arc<AtomicBool>) -> Result<Workers> {
        Workers::new(self.engine()?, self.threads(), stop)
    }

    pub(super) fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.map_or_else(cores, usize::from)
    }
}
