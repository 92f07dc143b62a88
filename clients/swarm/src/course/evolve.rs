//! One run of the paper's genetic algorithm on courses.
//!
//! As on the field: a group of courses that a table drove which agrees in every row that was read then cannot come out
//! differently, and is not driven again.

use std::ops::ControlFlow;

use field::Responses;
use rayon::prelude::*;

use super::fitness::{GROUPS, Training};
use crate::error::{Error, Result};
use crate::evaluate::Individual;
use crate::ga::{Population, Settings};
use crate::genome::Genome;
use crate::rng::SplitMix64;
use crate::run::Rise;

/// Bits of a genome: Eq. 1.
pub const GENOME_BITS: usize = 128;
/// What turns a run's seed into its stream: no run of the field has it.
const STREAM: u64 = 0x0000_636f_7572_7365;
/// Trials remembered per group.
const MEMO_TRIALS: usize = 64;

/// What a run came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolved {
    /// The best genome.
    pub best: Individual,
    /// When the best fitness rose, and to what.
    pub rises: Vec<Rise>,
    /// Groups of courses that were driven.
    pub driven: u64,
}

/// A remembered group: the bits of the rows that were read, and what they earned.
#[derive(Clone, Copy, Debug)]
struct Known {
    mask: u128,
    bits: u128,
    points: f32,
}

/// The last trials of every group.
#[derive(Default)]
struct Memo {
    known: [Vec<Known>; GROUPS],
    oldest: [usize; GROUPS],
}

impl Memo {
    fn recall(&self, group: usize, bits: u128) -> Option<f32> {
        let mut known = self.known[group].iter();
        known
            .find(|known| bits & known.mask == known.bits)
            .map(|known| known.points)
    }

    fn learn(&mut self, group: usize, known: Known) {
        let (ring, oldest) = (&mut self.known[group], &mut self.oldest[group]);
        if ring.len() < MEMO_TRIALS {
            ring.push(known);
        } else {
            ring[*oldest] = known;
            *oldest = (*oldest + 1) % MEMO_TRIALS;
        }
    }
}

/// Evolves one table; `watch` hears of every generation and its best fitness, and may stop the run.
///
/// # Errors
/// The settings make no algorithm; a course cannot be drawn; the run was stopped.
pub fn evolve(
    settings: Settings,
    seed: u64,
    generations: u32,
    mut watch: impl FnMut(u32, f32) -> ControlFlow<()>,
) -> Result<Evolved> {
    let training = Training::of(seed)?;
    let rng = SplitMix64::stream(&[STREAM, seed]);
    let mut population = Population::new(settings, GENOME_BITS, rng).map_err(Error::from_part)?;
    let (mut memo, mut rises, mut driven) = (Memo::default(), Vec::<Rise>::new(), 0);
    for generation in 0..=generations {
        let children = evaluate(&training, &mut memo, population.propose(), &mut driven);
        population.select(children);
        let best = population.members()[0].fitness();
        if rises.last().is_none_or(|last| best > last.fitness) {
            rises.push(Rise {
                generation,
                fitness: best,
            });
        }
        if watch(generation, best).is_break() {
            return Err(Error::Interrupted(format!(
                "interrupted at generation {generation}; nothing was saved"
            )));
        }
    }
    Ok(Evolved {
        best: population.members()[0].clone(),
        rises,
        driven,
    })
}

/// Evaluates genomes, on all cores; which core does what changes nothing.
fn evaluate(
    training: &Training,
    memo: &mut Memo,
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
            match memo.recall(group, bits) {
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
        let mask = Responses::row_mask(rows_read);
        let known = Known {
            mask,
            bits: bits & mask,
            points,
        };
        memo.learn(group, known);
    }
    evaluated
}
