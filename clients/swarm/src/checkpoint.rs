//! Checkpoints: complete state of a run in progress. A resumed run continues bit for bit.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::condition::{Condition, Setup};
use crate::error::{Error, Result};
use crate::evaluate::{Evaluator, GoalPoints, Individual};
use crate::files::{replace_unsynced, sha256, write_atomically};
use crate::ga::{Population, Settings};
use crate::genome::Genome;
use crate::islands::{Archipelago, IslandSettings};
use crate::rng::SplitMix64;
use crate::run::{Rise, Run};
use crate::training::generation_sets;

const FORMAT: &str = "ebts-checkpoint-1";

/// A run and everything needed to continue it.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    /// Inputs of the fitness.
    pub condition: Condition,
    /// Settings of the genetic algorithm.
    pub settings: Settings,
    /// Islands and migration.
    pub islands: IslandSettings,
    /// Final generation.
    pub generations: u32,
    /// The run, after at least its random population.
    pub run: Run,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HashedContent {
    sha256: String,
    content: Content,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    format: String,
    code_version: String,
    condition: Setup,
    settings: Settings,
    islands: IslandSettings,
    generations: u32,
    seed: u64,
    generation: u32,
    rises: Vec<Rise>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    chosen: Option<Member>,
    routes: SplitMix64,
    populations: Vec<Island>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Island {
    rng: SplitMix64,
    members: Vec<Member>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Member {
    genome: String,
    points: GoalPoints,
}

impl Checkpoint {
    /// Writes the checkpoint atomically; does nothing before the random population is evaluated.
    ///
    /// # Errors
    /// The file cannot be written; an older checkpoint remains.
    pub fn write(&self, path: &Path) -> Result<()> {
        let text = self.to_text()?;
        text.map_or(Ok(()), |text| write_atomically(path, text.as_bytes()))
    }

    /// Writes as [`Checkpoint::write`] but does not wait for the disk, because many files are
    /// written at once. The hash detects a file damaged by a power cut.
    pub fn write_unsynced(&self, path: &Path) -> Result<()> {
        let text = self.to_text()?;
        text.map_or(Ok(()), |text| replace_unsynced(path, text.as_bytes()))
    }

    /// `None` before the random population is evaluated.
    fn to_text(&self) -> Result<Option<String>> {
        let Some(generation) = self.run.generation() else {
            return Ok(None);
        };
        let archipelago = self.run.archipelago();
        let member = |individual: &Individual| Member {
            genome: individual.genome.to_hex(),
            points: individual.points,
        };
        let island = |population: &Population| Island {
            rng: population.rng().clone(),
            members: population.members().iter().map(member).collect(),
        };
        let content = Content {
            format: FORMAT.to_owned(),
            code_version: env!("CARGO_PKG_VERSION").to_owned(),
            condition: Setup::from(&self.condition),
            settings: self.settings,
            islands: self.islands,
            generations: self.generations,
            seed: self.run.seed,
            generation,
            rises: self.run.rises().to_vec(),
            chosen: self.run.chosen().map(member),
            routes: archipelago.routes().clone(),
            populations: archipelago.islands().iter().map(island).collect(),
        };
        let sealed = HashedContent {
            sha256: hash(&content),
            content,
        };
        serde_json::to_string_pretty(&sealed)
            .map(Some)
            .map_err(Error::from_part)
    }

    /// Reads a checkpoint.
    ///
    /// # Errors
    /// The file is missing, damaged, or from another version of this program, whose bits may
    /// differ.
    pub fn read(path: &Path) -> Result<Self> {
        if !path.exists() {
            return Err(Error::refused(
                format_args!("resume from {}", path.display()),
                "the file does not exist",
                "the checkpoint of an interrupted run",
                "start the run without --resume",
            ));
        }
        Self::read_or_fault(path).map_err(|why| {
            Error::refused(
                format_args!("resume from {}", path.display()),
                format_args!("it {why}"),
                "an intact checkpoint of this version",
                "start the run again with --overwrite instead of --resume",
            )
        })
    }

    pub(crate) fn read_or_fault(path: &Path) -> std::result::Result<Self, String> {
        let text = std::fs::read(path).map_err(|error| format!("cannot be read ({error})"))?;
        let sealed: HashedContent =
            serde_json::from_slice(&text).map_err(|error| format!("is damaged ({error})"))?;
        let content = sealed.content;
        if sealed.sha256 != hash(&content) {
            return Err("is damaged (its hash does not match its content)".to_owned());
        }
        let version = env!("CARGO_PKG_VERSION");
        if (content.format.as_str(), content.code_version.as_str()) != (FORMAT, version) {
            let Content {
                format,
                code_version,
                ..
            } = content;
            return Err(format!("is {format} of version {code_version}"));
        }
        content
            .restore()
            .ok_or_else(|| "has a genome, points or a setting out of range".to_owned())
    }
}

impl Content {
    fn restore(self) -> Option<Checkpoint> {
        // Points of a rule that this program does not have cannot be verified.
        let condition = self.condition.build().ok()?;
        condition.fitness.is_available().then_some(())?;
        let bits = condition.genome_bits();
        let member = |member: Member| {
            Some(Individual {
                genome: Genome::from_hex(bits, &member.genome)?,
                points: member.points,
            })
        };
        let population = |island: Island| {
            let members = island
                .members
                .into_iter()
                .map(member)
                .collect::<Option<Vec<_>>>()?;
            Population::resume(self.settings, island.rng, members).ok()
        };
        let populations = self
            .populations
            .into_iter()
            .map(population)
            .collect::<Option<Vec<_>>>()?;
        let sets = generation_sets(&condition, self.seed, self.generation);
        let whole = |population: &Population| {
            let mut members = population.members().iter();
            let evaluated = |member: &Individual| {
                let points = Evaluator::points_on(&condition, sets.clone(), &member.genome);
                member.points == points
            };
            members.len() == self.settings.population && members.all(evaluated)
        };
        if populations.len() != self.islands.islands || !populations.iter().all(whole) {
            return None;
        }
        let chosen = match self.chosen {
            Some(chosen) => Some(member(chosen)?),
            None => None,
        };
        let true_points = |chosen: &Individual| {
            condition.training().is_some()
                && chosen.points == Evaluator::points_of(&condition, &chosen.genome)
        };
        if !chosen.iter().all(true_points) {
            return None;
        }
        let archipelago = Archipelago::resume(
            populations,
            self.islands,
            self.settings.population,
            self.routes,
        );
        Some(Checkpoint {
            condition,
            settings: self.settings,
            islands: self.islands,
            generations: self.generations,
            run: Run::resume(
                self.seed,
                archipelago,
                self.generation,
                (self.rises, chosen),
            ),
        })
    }
}

fn hash(content: &Content) -> String {
    sha256(
        serde_json::to_string(content)
            .unwrap_or_default()
            .as_bytes(),
    )
}
