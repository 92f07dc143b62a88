//! Islands: several populations that evolve separately and exchange their best individuals at
//! intervals (design choice, not in the paper). One island is the paper's algorithm.

use serde::{Deserialize, Serialize};

use crate::evaluate::Individual;
use crate::ga::{Population, Settings, SettingsError};
use crate::genome::Genome;
use crate::rng::SplitMix64;

/// Number of islands and interval of exchange.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct IslandSettings {
    /// Number of populations, each of the full size.
    pub islands: usize,
    /// Generations between two migrations; unused with one island.
    pub migrate_every: u32,
}

impl Default for IslandSettings {
    fn default() -> Self {
        Self {
            islands: 1,
            migrate_every: 50,
        }
    }
}

/// Validity of the elites' fitness in the next generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EliteFitness {
    /// Valid: every generation has the same trials.
    Known,
    /// Invalid: every generation has other trials, so elites are evaluated again.
    Reevaluated,
}

/// The populations of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Archipelago {
    islands: Vec<Population>,
    settings: IslandSettings,
    population: usize,
    routes: SplitMix64,
}

impl Archipelago {
    /// Creates islands without members. `stream(i)` is the random stream of island i;
    /// `stream(islands)` is that of migration.
    pub fn new(
        settings: Settings,
        islands: IslandSettings,
        genome_bits: usize,
        stream: impl Fn(usize) -> SplitMix64,
    ) -> Result<Self, SettingsError> {
        let populations: Result<Vec<_>, _> = (0..islands.islands)
            .map(|i| Population::new(settings, genome_bits, stream(i)))
            .collect();
        Ok(Self {
            islands: populations?,
            settings: islands,
            population: settings.population,
            routes: stream(islands.islands),
        })
    }

    /// Restores islands from a checkpoint.
    #[must_use]
    pub fn resume(
        islands: Vec<Population>,
        settings: IslandSettings,
        population: usize,
        routes: SplitMix64,
    ) -> Self {
        Self {
            islands,
            settings,
            population,
            routes,
        }
    }

    /// Returns the populations.
    #[must_use]
    pub fn islands(&self) -> &[Population] {
        &self.islands
    }

    /// Returns the number of individuals of all islands.
    #[must_use]
    pub fn size(&self) -> usize {
        self.population * self.islands.len()
    }

    /// Returns the state of the migration stream.
    #[must_use]
    pub fn routes(&self) -> &SplitMix64 {
        &self.routes
    }

    /// Returns the best individual of all islands; among equals, that of the first island.
    #[must_use]
    pub fn best(&self) -> Option<&Individual> {
        let firsts = self
            .islands
            .iter()
            .filter_map(|island| island.members().first());
        firsts.reduce(|best, other| {
            if other.fitness() > best.fitness() {
                other
            } else {
                best
            }
        })
    }

    /// Returns the genomes of all islands to evaluate next, island by island.
    pub fn propose(&mut self, elites: EliteFitness) -> Vec<Genome> {
        let propose = match elites {
            EliteFitness::Known => Population::propose,
            EliteFitness::Reevaluated => Population::propose_with_elites,
        };
        self.islands.iter_mut().flat_map(propose).collect()
    }

    /// Completes generation `generation` with the evaluated proposals, in the order of
    /// [`Archipelago::propose`].
    pub fn select(&mut self, evaluated: Vec<Individual>, generation: u32, elites: EliteFitness) {
        let select = match elites {
            EliteFitness::Known => Population::select,
            EliteFitness::Reevaluated => Population::select_among,
        };
        let share = evaluated.len() / self.islands.len().max(1);
        let mut evaluated = evaluated.into_iter();
        for island in &mut self.islands {
            select(island, evaluated.by_ref().take(share).collect());
        }
        let IslandSettings {
            islands,
            migrate_every,
        } = self.settings;
        if islands > 1 && generation > 0 && generation.is_multiple_of(migrate_every.max(1)) {
            self.migrate();
        }
    }

    /// Sends the best of every island to the next one on a ring with a random order.
    fn migrate(&mut self) {
        let n = self.islands.len();
        let mut ring: Vec<usize> = (0..n).collect();
        for last in (1..n).rev() {
            ring.swap(last, self.routes.below(last + 1));
        }
        let migrants: Vec<Option<Individual>> = self
            .islands
            .iter()
            .map(|i| i.members().first().cloned())
            .collect();
        for (place, &from) in ring.iter().enumerate() {
            if let Some(migrant) = &migrants[from] {
                self.islands[ring[(place + 1) % n]].admit(migrant.clone());
            }
        }
    }
}
