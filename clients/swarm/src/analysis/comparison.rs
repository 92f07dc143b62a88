//! Comparison of evolved tables with baselines and held-out trials.

use rayon::prelude::*;
use serde::Serialize;

use field::Engine;

use super::baseline::{Baselines, baselines};
use super::held_out::{HeldOut, held_out};
use crate::condition::Condition;
use crate::error::Result;
use crate::experiment::Plan;
use crate::genome::Genome;
use crate::run::Record;
use crate::stats::median;

/// Results of one team size and its baselines.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Comparison {
    /// Team size.
    pub agents: usize,
    /// Median fitness over the runs.
    pub evolved_median: f32,
    /// Tables without evolution.
    pub baselines: Baselines,
    /// Median held-out fitness over the runs.
    pub held_out: HeldOut,
}

/// Compares every team size of an experiment.
pub fn comparisons(
    plan: &Plan,
    records: &[Record],
    engine: Engine,
    random_tables: usize,
) -> Result<Vec<Comparison>> {
    let conditions = plan.conditions()?;
    let compare = |condition: &Condition| compare(condition, records, engine, random_tables);
    Ok(conditions.par_iter().map(compare).collect())
}

fn compare(
    condition: &Condition,
    records: &[Record],
    engine: Engine,
    random_tables: usize,
) -> Comparison {
    let agents = condition.team.get();
    let runs: Vec<&Record> = records.iter().filter(|run| run.agents == agents).collect();
    let genome = |run: &&Record| Genome::from_hex(condition.genome_bits(), &run.genome);
    let held: Vec<HeldOut> = runs
        .iter()
        .filter_map(genome)
        .map(|genome| held_out(condition, engine, &genome))
        .collect();
    let of = |part: fn(&HeldOut) -> f32| median(&held.iter().map(part).collect::<Vec<_>>());
    Comparison {
        agents,
        evolved_median: median(&runs.iter().map(|run| run.fitness()).collect::<Vec<_>>()),
        baselines: baselines(condition, engine, random_tables),
        held_out: HeldOut {
            training: of(|held| held.training),
            goals: of(|held| held.goals),
            starts: of(|held| held.starts),
            goals_and_starts: of(|held| held.goals_and_starts),
        },
    }
}
