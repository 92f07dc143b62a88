//! One run of the paper's genetic algorithm on courses.
//!
//! A memo avoids repeated runs: a group of courses is not simulated again if the table equals an
//! earlier one in every row that was read.

use std::ops::ControlFlow;

use field::Responses;
use rayon::prelude::*;

use super::fitness::{GROUPS, Training};
use crate::error::Result;
use crate::evaluate::Individual;
use crate::ga::Settings;
use crate::generations;
use crate::genome::Genome;
use crate::memo::Memo;
use crate::rng::SplitMix64;
use crate::run::Rise;

/// Bits of a genome, Eq. (1).
pub const GENOME_BITS: usize = 128;
/// Name of the random stream of course runs; differs from those of field runs.
const STREAM: u64 = 0x0000_636f_7572_7365;

/// Result of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolved {
    /// The best genome.
    pub best: Individual,
    /// Rises of the best fitness.
    pub rises: Vec<Rise>,
    /// Simulated groups of courses.
    pub simulated_groups: u64,
}

/// Evolves one table. `watch` receives every generation and its best fitness and may stop the run.
///
/// # Errors
/// The settings are invalid, a course cannot be drawn, or the run was stopped.
pub fn evolve(
    settings: Settings,
    seed: u64,
    generations: u32,
    watch: impl FnMut(u32, f32) -> ControlFlow<()>,
) -> Result<Evolved> {
    let training = Training::new(seed)?;
    let rng = SplitMix64::stream(&[STREAM, seed]);
    let (mut memo, mut driven) = (Memo::default(), 0);
    let evaluate = |genomes| evaluate(&training, &mut memo, genomes, &mut driven);
    let kept = "nothing was saved";
    let (best, rises) = generations::evolve(
        settings,
        (GENOME_BITS, rng),
        generations,
        kept,
        evaluate,
        watch,
    )?;
    Ok(Evolved {
        best,
        rises,
        simulated_groups: driven,
    })
}

/// The result does not depend on the distribution over cores.
fn evaluate(
    training: &Training,
    memo: &mut Memo<1>,
    genomes: Vec<Genome>,
    driven: &mut u64,
) -> Vec<Individual> {
    let mut evaluated: Vec<Individual> = genomes
        .into_iter()
        .map(|genome| Individual {
            genome,
            points: [0.0; GROUPS],
        })
        .collect();
    let mut pending = Vec::new();
    for (index, individual) in evaluated.iter_mut().enumerate() {
        let bits = individual.genome.words()[0];
        for (group, points) in individual.points.iter_mut().enumerate() {
            match memo.recall(group, &[bits]) {
                Some(known) => *points = known,
                None => pending.push((index, group, bits)),
            }
        }
    }
    *driven += pending.len() as u64;
    let drive = |&(_, group, bits): &(usize, usize, u128)| {
        training.points(group, Responses::from_motor_bits(bits))
    };
    let earned: Vec<(f32, u32)> = pending.par_iter().with_max_len(1).map(drive).collect();
    for ((index, group, bits), (points, rows_read)) in pending.into_iter().zip(earned) {
        evaluated[index].points[group] = points;
        memo.store(group, &[bits], Responses::row_mask(rows_read), points);
    }
    evaluated
}
