//! Verification of records: every number is range-checked and every genome is evaluated again.

use rayon::prelude::*;

use field::Engine;

use super::plan::Plan;
use crate::condition::Condition;
use crate::error::Result;
use crate::evaluate::{Evaluator, Individual};
use crate::genome::Genome;
use crate::run::Record;

/// Genomes evaluated together: fills the SIMD lanes and distributes over threads.
const GENOMES_PER_CHUNK: usize = 64;
/// Largest fitness (paper III.b.3: 100 points for each of eight goals).
const MAX_FITNESS: f32 = 800.0;

/// Verifies records; the error has the index of the first invalid one.
pub(super) fn verify(
    plan: &Plan,
    records: &[Record],
) -> Result<std::result::Result<(), (usize, String)>> {
    let conditions = plan.conditions()?;
    let chunk = |(index, records): (usize, &[Record])| {
        verify_chunk(plan, &conditions, records)
            .map_err(|(at, why)| (index * GENOMES_PER_CHUNK + at, why))
    };
    let chunks = records.par_chunks(GENOMES_PER_CHUNK).enumerate();
    // The lowest index, independent of thread timing.
    let wrong = chunks.map(chunk).filter_map(std::result::Result::err);
    Ok(wrong.min_by_key(|(index, _)| *index).map_or(Ok(()), Err))
}

fn verify_chunk(
    plan: &Plan,
    conditions: &[Condition],
    records: &[Record],
) -> std::result::Result<(), (usize, String)> {
    let mut genomes = Vec::with_capacity(records.len());
    for (at, record) in records.iter().enumerate() {
        let checked = check(plan, conditions, record).map_err(|why| (at, why))?;
        genomes.push(checked);
    }
    for (which, condition) in conditions.iter().enumerate() {
        let of_condition = || genomes.iter().enumerate().filter(|(_, (c, _))| *c == which);
        let batch: Vec<Genome> = of_condition()
            .map(|(_, (_, genome))| genome.clone())
            .collect();
        if batch.is_empty() {
            continue;
        }
        let mut evaluator = Evaluator::new(condition.clone(), Engine::fastest(), 1);
        let evaluated = evaluator
            .evaluate(vec![batch])
            .into_iter()
            .flatten()
            .flatten();
        for ((at, _), Individual { points, .. }) in of_condition().zip(evaluated) {
            if records[at].points != points {
                let why = format!(
                    "its points are {:?}, needs {points:?} for its genome",
                    records[at].points
                );
                return Err((at, why));
            }
        }
    }
    Ok(())
}

/// Returns the condition index and the genome of a record within range.
fn check(
    plan: &Plan,
    conditions: &[Condition],
    record: &Record,
) -> std::result::Result<(usize, Genome), String> {
    let Record {
        agents,
        seed,
        genome,
        points,
        rises,
    } = record;
    let condition = conditions
        .iter()
        .position(|condition| condition.team.get() == *agents)
        .ok_or_else(|| format!("its agents is {agents}, needs one of {:?}", plan.agents))?;
    let last_seed = plan.first_seed.saturating_add(plan.seeds.saturating_sub(1));
    if !(plan.first_seed..=last_seed).contains(seed) {
        return Err(format!(
            "its seed is {seed}, needs {} to {last_seed}",
            plan.first_seed
        ));
    }
    let bits = conditions[condition].genome_bits();
    let genome = Genome::from_hex(bits, genome)
        .ok_or_else(|| format!("its genome does not have {bits} bits"))?;
    let fitness = points.iter().fold(0.0, |sum, points| sum + points);
    let rising = rises
        .windows(2)
        .all(|pair| pair[0].generation < pair[1].generation && pair[0].fitness < pair[1].fitness);
    let inside = |rise: &crate::run::Rise| {
        rise.generation <= plan.generations && (0.0..=MAX_FITNESS).contains(&rise.fitness)
    };
    if !rising
        || !rises.iter().all(inside)
        || rises.first().is_none_or(|first| first.generation != 0)
    {
        return Err("its rises do not increase from generation 0 on".to_owned());
    }
    if record.fitness() != fitness {
        return Err(format!(
            "its fitness is {}, needs {fitness}, the sum of its points",
            record.fitness()
        ));
    }
    Ok((condition, genome))
}
