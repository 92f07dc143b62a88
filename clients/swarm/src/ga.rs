//! Simple genetic algorithm of paper III.b.1, steps 1–10.
//!
//! A generation is two calls: [`Population::propose`] makes genomes (step 1, or steps 3–6), the
//! caller evaluates them (steps 2 and 7), [`Population::select`] keeps the best (step 8). A
//! population uses neither clock nor simulator.

use serde::{Deserialize, Serialize};

use crate::evaluate::Individual;
use crate::genome::Genome;
use crate::rng::{Probability, SplitMix64};

/// Settings of the algorithm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Number of individuals, even.
    pub population: usize,
    /// Number of individuals that survive regardless of their children: 1 or more, fewer than the
    /// population.
    pub elite: usize,
    /// Flip probability per bit of a child.
    pub mutation_rate: f64,
}

impl Default for Settings {
    /// Paper III.b.3: 10 individuals, 2 elites, 1 % per bit.
    fn default() -> Self {
        Self {
            population: 10,
            elite: 2,
            mutation_rate: 0.01,
        }
    }
}

/// Invalid settings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("could not use {key}: it is {value}, needs {needs}; correct it")]
pub struct SettingsError {
    key: &'static str,
    value: f64,
    needs: &'static str,
}

impl Settings {
    /// Validates the settings; returns the mutation rate as a probability.
    ///
    /// # Errors
    /// The population is odd or out of range, the elite is zero or fills the population, or the
    /// rate is not a probability.
    pub fn check(&self) -> Result<Probability, SettingsError> {
        let refuse = |key, value, needs| Err(SettingsError { key, value, needs });
        if !(2..=10_000).contains(&self.population) || self.population % 2 == 1 {
            return refuse(
                "population",
                self.population as f64,
                "an even number from 2 to 10000",
            );
        }
        // Without an elite the best table could be lost.
        if !(1..self.population).contains(&self.elite) {
            return refuse(
                "elite",
                self.elite as f64,
                "1 or more, fewer than the population",
            );
        }
        Probability::new(self.mutation_rate).ok_or(SettingsError {
            key: "mutation_rate",
            value: self.mutation_rate,
            needs: "a probability from 0 to 1",
        })
    }
}

/// One population with its random number stream.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    settings: Settings,
    mutation: Probability,
    rng: SplitMix64,
    genome_bits: usize,
    /// Best first; empty before the first selection.
    members: Vec<Individual>,
}

impl Population {
    /// Creates a population without members.
    pub fn new(
        settings: Settings,
        genome_bits: usize,
        rng: SplitMix64,
    ) -> Result<Self, SettingsError> {
        Ok(Self {
            settings,
            mutation: settings.check()?,
            rng,
            genome_bits,
            members: Vec::new(),
        })
    }

    /// Restores a population from a checkpoint. `members` keep the order that they had after the
    /// selection.
    pub fn resume(
        settings: Settings,
        rng: SplitMix64,
        members: Vec<Individual>,
    ) -> Result<Self, SettingsError> {
        let genome_bits = members.first().map_or(0, |member| member.genome.len());
        Ok(Self {
            settings,
            mutation: settings.check()?,
            rng,
            genome_bits,
            members,
        })
    }

    /// Returns the individuals, best first.
    #[must_use]
    pub fn members(&self) -> &[Individual] {
        &self.members
    }

    /// Returns the state of the random number stream.
    #[must_use]
    pub fn rng(&self) -> &SplitMix64 {
        &self.rng
    }

    /// Returns the genomes to evaluate next: random ones at first (step 1), then children (steps
    /// 3–6).
    pub fn propose(&mut self) -> Vec<Genome> {
        let Settings { population, .. } = self.settings;
        if self.members.is_empty() {
            return (0..population)
                .map(|_| Genome::random(self.genome_bits, &mut self.rng))
                .collect();
        }
        let total = self
            .members
            .iter()
            .map(|member| f64::from(member.fitness()))
            .sum();
        (0..population / 2).flat_map(|_| self.pair(total)).collect()
    }

    /// Returns the genomes to evaluate next if every generation uses other trials: the elites,
    /// whose fitness must be evaluated again, then those of [`Population::propose`].
    pub fn propose_with_elites(&mut self) -> Vec<Genome> {
        let elites = self.members.iter().take(self.settings.elite);
        let mut genomes: Vec<Genome> = elites.map(|elite| elite.genome.clone()).collect();
        genomes.extend(self.propose());
        genomes
    }

    /// Steps 4–6: two parents by roulette, two complementary children, mutation.
    fn pair(&mut self, total: f64) -> [Genome; 2] {
        let (mother, father) = (self.roulette(total), self.roulette(total));
        let (mother, father) = (&self.members[mother].genome, &self.members[father].genome);
        let mut children = mother.crossover(father, &mut self.rng);
        for child in &mut children {
            child.mutate(self.mutation, &mut self.rng);
        }
        children
    }

    /// Step 4: returns a member with probability proportional to its fitness, in population order.
    fn roulette(&mut self, total: f64) -> usize {
        let mut left = self.rng.unit() * total;
        let spent = |member: &Individual| {
            left -= f64::from(member.fitness());
            left < 0.0
        };
        self.members
            .iter()
            .position(spent)
            .unwrap_or(self.members.len() - 1)
    }

    /// Step 8: keeps the best of elites and children. Among equals the elite comes first, then the
    /// earlier child.
    pub fn select(&mut self, children: Vec<Individual>) {
        self.members.truncate(self.settings.elite);
        self.keep_best(children);
    }

    /// Step 8 for the proposals of [`Population::propose_with_elites`]: elites count with their new
    /// fitness.
    pub fn select_among(&mut self, evaluated: Vec<Individual>) {
        self.members.clear();
        self.keep_best(evaluated);
    }

    fn keep_best(&mut self, evaluated: Vec<Individual>) {
        self.members.extend(evaluated);
        self.members
            .sort_by(|a, b| b.fitness().total_cmp(&a.fitness()));
        self.members.truncate(self.settings.population);
    }

    /// Replaces the worst individual by an immigrant and restores the order; the immigrant is
    /// placed behind its equals.
    pub fn admit(&mut self, immigrant: Individual) {
        self.members.pop();
        let place = self
            .members
            .partition_point(|member| member.fitness() >= immigrant.fitness());
        self.members.insert(place, immigrant);
    }
}
