//! What a run is called, what is noted of it, and what it comes to.

use serde::{Deserialize, Serialize};

use crate::condition::GOALS;
use crate::evaluate::GoalPoints;

/// A generation in which the best fitness rose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rise {
    /// 0 is the random population.
    pub generation: u32,
    /// The best fitness from then on.
    pub fitness: f32,
}

impl Rise {
    /// Adds the best fitness of a generation if it is a rise.
    pub(crate) fn note(rises: &mut Vec<Self>, generation: u32, fitness: f32) {
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

/// The individuals of a generation, all islands together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Census {
    /// 0 is the random population.
    pub generation: u32,
    /// The largest fitness.
    pub best: f64,
    /// The mean fitness.
    pub mean: f64,
    /// The smallest fitness.
    pub worst: f64,
    /// The part of bits in which two individuals differ, mean over all pairs: 0.5 in a random population, 0 if all are equal.
    pub diversity: f64,
}

/// What a finished run came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The condition.
    pub agents: usize,
    /// The run.
    pub seed: u64,
    /// The best genome, see [`crate::genome::Genome::to_hex`].
    pub genome: String,
    /// Its points per goal.
    pub points: GoalPoints,
    /// The best fitness over the generations.
    pub rises: Vec<Rise>,
}

impl Record {
    /// Which run it is of.
    #[must_use]
    pub fn job(&self) -> Job {
        Job {
            agents: self.agents,
            seed: self.seed,
        }
    }

    /// The best fitness at the end.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.rises.last().map_or(0.0, |rise| rise.fitness)
    }

    /// The best fitness at a generation.
    #[must_use]
    pub fn fitness_at(&self, generation: u32) -> f32 {
        let until = self
            .rises
            .partition_point(|rise| rise.generation <= generation);
        until
            .checked_sub(1)
            .map_or(0.0, |last| self.rises[last].fitness)
    }

    /// Goals for which the best genome earns the largest score.
    #[must_use]
    pub fn full_scores(&self) -> usize {
        (0..GOALS)
            .filter(|&goal| field::solved(self.points[goal]))
            .count()
    }
}
