//! Runs: one seed each, evolved together in lock-step so that their trials fill the SIMD lanes.

mod evolve;
mod record;

pub use evolve::evolve;
pub use record::{GenerationStatistics, Job, Record, Rise};

use crate::condition::Condition;
use crate::evaluate::Individual;
use crate::ga::{Population, Settings, SettingsError};
use crate::genome::{Genome, diversity};
use crate::islands::{Archipelago, EliteFitness, IslandSettings};
use crate::rng::SplitMix64;

/// One run in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Seed; with the number of agents it selects the random stream.
    pub seed: u64,
    archipelago: Archipelago,
    /// Completed generations; `None` before the random population is evaluated.
    generation: Option<u32>,
    rises: Vec<Rise>,
    /// For drawn trials: the best of all generations' best on the trials of the choice.
    chosen: Option<Individual>,
}

impl Run {
    /// Creates a run.
    pub fn new(
        condition: &Condition,
        settings: Settings,
        islands: IslandSettings,
        seed: u64,
    ) -> Result<Self, SettingsError> {
        let agents = condition.team.get() as u64;
        let stream = |island: usize| SplitMix64::stream(&[seed, agents, island as u64]);
        let archipelago = Archipelago::new(settings, islands, condition.genome_bits(), stream)?;
        Ok(Self {
            seed,
            archipelago,
            generation: None,
            rises: Vec::new(),
            chosen: None,
        })
    }

    /// Restores a run after `generation`.
    #[must_use]
    pub fn resume(
        seed: u64,
        archipelago: Archipelago,
        generation: u32,
        (rises, chosen): (Vec<Rise>, Option<Individual>),
    ) -> Self {
        Self {
            seed,
            archipelago,
            generation: Some(generation),
            rises,
            chosen,
        }
    }

    /// Returns the last completed generation.
    #[must_use]
    pub fn generation(&self) -> Option<u32> {
        self.generation
    }

    /// Returns the populations.
    #[must_use]
    pub fn archipelago(&self) -> &Archipelago {
        &self.archipelago
    }

    /// Returns the generations in which the best fitness rose.
    #[must_use]
    pub fn rises(&self) -> &[Rise] {
        &self.rises
    }

    /// Returns the best individual so far.
    #[must_use]
    pub fn best(&self) -> Option<&Individual> {
        self.chosen.as_ref().or_else(|| self.archipelago.best())
    }

    /// Returns the chosen individual, see [`Run::best`]; `None` if every generation has the same
    /// trials.
    #[must_use]
    pub fn chosen(&self) -> Option<&Individual> {
        self.chosen.as_ref()
    }

    /// Returns statistics of the individuals of all islands; `None` before the random population is
    /// evaluated.
    #[must_use]
    pub fn statistics(&self) -> Option<GenerationStatistics> {
        let members = || {
            self.archipelago
                .islands()
                .iter()
                .flat_map(Population::members)
        };
        let generation = self.generation?;
        let count = members().count();
        let fitness = || members().map(|member| f64::from(member.fitness()));
        let genomes = members().map(|member| &member.genome).collect::<Vec<_>>();
        Some(GenerationStatistics {
            generation,
            best: fitness().fold(0.0, f64::max),
            mean: fitness().sum::<f64>() / count as f64,
            worst: fitness().fold(f64::MAX, f64::min),
            diversity: diversity(&genomes),
        })
    }

    fn next_generation(&self) -> u32 {
        self.generation.map_or(0, |generation| generation + 1)
    }

    fn accept(&mut self, evaluated: Vec<Individual>, elites: EliteFitness) {
        let generation = self.next_generation();
        self.archipelago.select(evaluated, generation, elites);
        self.generation = Some(generation);
        if let (EliteFitness::Known, Some(best)) = (elites, self.archipelago.best()) {
            let fitness = best.fitness();
            Rise::record(&mut self.rises, generation, fitness);
        }
    }

    /// Returns the best genome of the generation if it differs from the chosen one.
    fn candidate(&self) -> Option<Genome> {
        let best = &self.archipelago.best()?.genome;
        let known = self.chosen.as_ref().map(|chosen| &chosen.genome);
        (known != Some(best)).then(|| best.clone())
    }

    /// Replaces the chosen individual by a better candidate.
    fn update_chosen(&mut self, candidate: Individual) {
        let fitness = candidate.fitness();
        let before = self.chosen.as_ref().map(Individual::fitness);
        if before.is_none_or(|before| fitness > before) {
            self.chosen = Some(candidate);
            Rise::record(&mut self.rises, self.generation.unwrap_or(0), fitness);
        }
    }

    /// Returns the result of the run.
    #[must_use]
    pub fn record(&self, condition: &Condition) -> Option<Record> {
        let best = self.best()?;
        Some(Record {
            agents: condition.team.get(),
            seed: self.seed,
            genome: best.genome.to_hex(),
            points: best.points,
            rises: self.rises.clone(),
        })
    }
}
