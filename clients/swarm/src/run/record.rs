//! Identification, progress and result of a run.

use serde::{Deserialize, Serialize};

use crate::condition::GOALS;
use crate::evaluate::GoalPoints;

/// A generation in which the best fitness rose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rise {
    /// Generation; 0 is the random population.
    pub generation: u32,
    /// Best fitness from this generation on.
    pub fitness: f32,
}

impl Rise {
    /// Appends the best fitness of a generation if it is a rise.
    pub(crate) fn record(rises: &mut Vec<Self>, generation: u32, fitness: f32) {
        if rises.last().is_none_or(|last| fitness > last.fitness) {
            rises.push(Self {
                generation,
                fitness,
            });
        }
    }
}

/// One run of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Job {
    /// Team size.
    pub agents: usize,
    /// Seed.
    pub seed: u64,
}

/// Statistics of the individuals of a generation on all islands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GenerationStatistics {
    /// Generation; 0 is the random population.
    pub generation: u32,
    /// Largest fitness.
    pub best: f64,
    /// Mean fitness.
    pub mean: f64,
    /// Smallest fitness.
    pub worst: f64,
    /// Share of differing bits, averaged over all pairs: 0.5 in a random population, 0 if all are
    /// equal.
    pub diversity: f64,
}

/// Result of a finished run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Team size.
    pub agents: usize,
    /// Seed.
    pub seed: u64,
    /// Best genome, see [`crate::genome::Genome::to_hex`].
    pub genome: String,
    /// Points per goal of the best genome.
    pub points: GoalPoints,
    /// Rises of the best fitness.
    pub rises: Vec<Rise>,
}

impl Record {
    /// Returns the job of this run.
    #[must_use]
    pub fn job(&self) -> Job {
        Job {
            agents: self.agents,
            seed: self.seed,
        }
    }

    /// Returns the final best fitness.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.rises.last().map_or(0.0, |rise| rise.fitness)
    }

    /// Returns the best fitness at a generation.
    #[must_use]
    pub fn fitness_at(&self, generation: u32) -> f32 {
        let until = self
            .rises
            .partition_point(|rise| rise.generation <= generation);
        until
            .checked_sub(1)
            .map_or(0.0, |last| self.rises[last].fitness)
    }

    /// Counts the goals with full points.
    #[must_use]
    pub fn full_scores(&self) -> usize {
        (0..GOALS)
            .filter(|&goal| field::solved(self.points[goal]))
            .count()
    }
}
