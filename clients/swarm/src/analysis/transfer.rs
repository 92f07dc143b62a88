//! Transfer: share of a table's fitness that remains with new starts and goals.
//!
//! Unseen trials are drawn like those of [`field::Training`] from a separate random stream
//! ([`crate::training::held_out_sets`]), whether or not the tables were evolved on drawn trials.

use rayon::prelude::*;
use serde::Serialize;

use field::{Engine, Places};

use super::points_in;
use crate::condition::Condition;
use crate::error::Result;
use crate::experiment::Plan;
use crate::genome::Genome;
use crate::run::Record;
use crate::stats::{Estimate, bootstrap, mean};
use crate::table_file::TableFile;
use crate::training::{Set, held_out_sets};

/// Sets of eight unseen trials. The standard error of one table's fitness is then about 13 of 800
/// points (measured on R3).
pub const UNSEEN_SETS: usize = 64;

/// Mean fitness (of 800) of the tables of one team size, and the share that remains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Transfer {
    /// Team size.
    pub agents: usize,
    /// Number of tables.
    pub tables: usize,
    /// Fitness in evolution.
    pub training: f32,
    /// Starts and eight goals of the preset.
    pub preset: f32,
    /// Starts of the preset, unseen goals.
    pub goals: f32,
    /// Unseen starts, goals of the preset.
    pub starts: f32,
    /// Unseen starts and goals.
    pub both: f32,
    /// `both` over `training`; resampled over the tables, or for one table over the unseen sets.
    pub kept: Estimate,
}

struct TableFitness {
    training: f32,
    preset: f32,
    goals: f32,
    starts: f32,
    both: Vec<f32>,
}

struct UnseenTrials {
    goals: Vec<Set>,
    starts: Vec<Set>,
    both: Vec<Set>,
}

impl UnseenTrials {
    fn new(condition: &Condition) -> Self {
        let sets = |starts, goals| held_out_sets(condition, starts, goals, UNSEEN_SETS);
        Self {
            goals: sets(Places::Preset, Places::Drawn),
            starts: sets(Places::Drawn, Places::Preset),
            both: sets(Places::Drawn, Places::Drawn),
        }
    }

    fn evaluate(
        &self,
        (condition, engine): (&Condition, Engine),
        genome: &Genome,
        training: f32,
    ) -> TableFitness {
        let responses = condition.responses(genome);
        let in_set = |set: &Set| points_in(condition, engine, responses, set);
        let of = |sets: &[Set]| -> f32 {
            points_in(condition, engine, responses, sets.as_flattened()) / sets.len() as f32
        };
        TableFitness {
            training,
            preset: in_set(&condition.layouts()),
            goals: of(&self.goals),
            starts: of(&self.starts),
            both: self.both.iter().map(in_set).collect(),
        }
    }
}

/// Returns the transfer of the tables of an experiment per team size.
pub fn transfers(plan: &Plan, engine: Engine, records: &[Record]) -> Result<Vec<Transfer>> {
    let conditions = plan.conditions()?;
    let of_condition = |condition: &Condition| {
        let unseen = UnseenTrials::new(condition);
        let agents = condition.team.get();
        let runs = records.par_iter().filter(|run| run.agents == agents);
        let table = |run: &Record| {
            let genome = Genome::from_hex(condition.genome_bits(), &run.genome)?;
            Some(unseen.evaluate((condition, engine), &genome, run.fitness()))
        };
        let tables: Vec<TableFitness> = runs.filter_map(table).collect();
        let ratios: Vec<(f32, f32)> = tables
            .iter()
            .map(|table| (mean(&table.both), table.training))
            .collect();
        (!tables.is_empty()).then(|| summary(agents, &tables, bootstrap(&[&ratios], ratio)))
    };
    Ok(conditions.iter().filter_map(of_condition).collect())
}

/// Returns the transfer of one table.
#[must_use]
pub fn transfer(file: &TableFile, engine: Engine) -> Transfer {
    let condition = &file.condition;
    let (genome, training) = (&file.individual.genome, file.individual.fitness());
    let table = UnseenTrials::new(condition).evaluate((condition, engine), genome, training);
    let sets: Vec<(f32, f32)> = table.both.iter().map(|&both| (both, training)).collect();
    let kept = bootstrap(&[&sets], ratio);
    summary(condition.team.get(), &[table], kept)
}

fn ratio(groups: &[Vec<(f32, f32)>]) -> f64 {
    let sum = |part: fn(&(f32, f32)) -> f32| -> f64 {
        groups[0].iter().map(|pair| f64::from(part(pair))).sum()
    };
    sum(|pair| pair.0) / sum(|pair| pair.1).max(f64::MIN_POSITIVE)
}

fn summary(agents: usize, tables: &[TableFitness], kept: Estimate) -> Transfer {
    let of = |part: fn(&TableFitness) -> f32| mean(&tables.iter().map(part).collect::<Vec<_>>());
    Transfer {
        agents,
        tables: tables.len(),
        training: of(|table| table.training),
        preset: of(|table| table.preset),
        goals: of(|table| table.goals),
        starts: of(|table| table.starts),
        both: of(|table| mean(&table.both)),
        kept,
    }
}
