//! One run of the paper's genetic algorithm on the reduced grasp simulation.
//!
//! A memo avoids repeated simulations: a family is not simulated again if the table equals an
//! earlier one in every row that was read.

use std::ops::ControlFlow;

use pinch::{Engine, Outcome, TimeLimit, Trial};
use rayon::prelude::*;

use super::course::{Course, FAMILIES, Family, GENOME_BITS, MEMBERS, rows, table};
use super::fitness::points;
use crate::error::Result;
use crate::evaluate::{GoalPoints, Individual};
use crate::ga::Settings;
use crate::generations;
use crate::genome::Genome;
use crate::memo::Memo;
use crate::rng::SplitMix64;
use crate::run::Rise;

/// Name of the random stream of grasp runs; differs from those of field runs.
const STREAM: u64 = 0x0067_7261_7370;

/// Result of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolved {
    /// The best genome.
    pub best: Individual,
    /// Rises of the best fitness.
    pub rises: Vec<Rise>,
    /// Number of simulated grasps.
    pub simulated: u64,
}

/// Evaluates genomes on the grasp course.
pub struct Evaluator<'a> {
    course: Course,
    families: &'a [Family],
    engine: Engine,
    force_limit: bool,
    memo: Memo<1>,
    simulated: u64,
}

impl<'a> Evaluator<'a> {
    /// Creates an evaluator for these families.
    #[must_use]
    pub fn new(families: &'a [Family], engine: Engine, force_limit: bool) -> Self {
        Self {
            course: Course::default(),
            families,
            engine,
            force_limit,
            memo: Memo::default(),
            simulated: 0,
        }
    }

    /// Evaluates genomes.
    pub fn evaluate(&mut self, genomes: Vec<Genome>) -> Vec<Individual> {
        let mut evaluated: Vec<Individual> = genomes
            .into_iter()
            .map(|genome| Individual {
                genome,
                points: [0.0; FAMILIES],
            })
            .collect();
        for (family, known) in self.families.iter().enumerate().take(FAMILIES) {
            let (mut pending, mut trials) = (Vec::new(), Vec::new());
            for (index, individual) in evaluated.iter_mut().enumerate() {
                let bits = individual.genome.words()[0];
                match self.memo.recall(family, &[bits]) {
                    Some(points) => individual.points[family] = points,
                    None => {
                        pending.push(index);
                        trials.extend(trials_of(family, known, &individual.genome));
                    }
                }
            }
            let outcomes = self.simulate(&trials);
            for (index, outcomes) in pending.into_iter().zip(outcomes.chunks(MEMBERS)) {
                let (earned, rows_read) = earned(known, outcomes);
                evaluated[index].points[family] = earned;
                let bits = evaluated[index].genome.words()[0];
                self.memo
                    .store(family, &[bits], genome_mask(rows_read), earned);
            }
        }
        evaluated
    }

    /// The result does not depend on the distribution over cores.
    fn simulate(&mut self, trials: &[Trial]) -> Vec<Outcome> {
        self.simulated += trials.len() as u64;
        let interface = self.course.interface(self.force_limit, TimeLimit::SHORT);
        let part = |trials: &[Trial]| {
            let mut outcomes = Vec::new();
            self.engine.run(&interface, trials, &mut outcomes);
            outcomes
        };
        trials
            .par_chunks(TRIALS_PER_TASK)
            .flat_map_iter(part)
            .collect()
    }
}

/// Trials per task: two batches of the widest engine.
const TRIALS_PER_TASK: usize = 32;

fn trials_of(family: usize, known: &Family, genome: &Genome) -> impl Iterator<Item = Trial> {
    let rows = rows(&table(genome));
    let first_seed = (family * MEMBERS) as u32 + 1;
    let trial = move |(object, seed)| Trial { object, rows, seed };
    known.members.into_iter().zip(first_seed..).map(trial)
}

fn earned(family: &Family, outcomes: &[Outcome]) -> (f32, u64) {
    let members = family.members.iter().zip(outcomes);
    let sum: f32 = members
        .map(|(object, outcome)| points(object, outcome))
        .sum();
    let rows_read = outcomes
        .iter()
        .fold(0, |read, outcome| read | outcome.rows_read);
    (sum / MEMBERS as f32, rows_read)
}

fn genome_mask(rows_read: u64) -> u128 {
    (0..GENOME_BITS / 4)
        .filter(|row| rows_read >> row & 1 == 1)
        .fold(0, |mask, row| mask | 0xf << (4 * row))
}

/// Evolves one table. `watch` receives every generation and its best fitness and may stop the run.
///
/// # Errors
/// The settings are invalid, or the run was stopped.
pub fn evolve(
    evaluator: &mut Evaluator<'_>,
    settings: Settings,
    seed: u64,
    generations: u32,
    watch: impl FnMut(u32, f32) -> ControlFlow<()>,
) -> Result<Evolved> {
    let rng = SplitMix64::stream(&[STREAM, seed]);
    let evaluate = |genomes| evaluator.evaluate(genomes);
    let kept = "finished runs are saved, this run will start again";
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
        simulated: evaluator.simulated,
    })
}

/// Returns the points of a table per family, the rows that were read, and the outcome of each
/// family's first member.
#[must_use]
pub fn evaluate_table(
    families: &[Family],
    genome: &Genome,
    force_limit: bool,
) -> (GoalPoints, u64, Vec<Outcome>) {
    let mut evaluator = Evaluator::new(families, Engine::fastest(), force_limit);
    let (mut points, mut read, mut firsts) = ([0.0; FAMILIES], 0, Vec::new());
    for (index, (family, points)) in families.iter().zip(&mut points).enumerate() {
        let trials: Vec<Trial> = trials_of(index, family, genome).collect();
        let outcomes = evaluator.simulate(&trials);
        let (earned, rows_read) = earned(family, &outcomes);
        *points = earned;
        read |= rows_read;
        firsts.extend(outcomes.into_iter().next());
    }
    (points, read, firsts)
}
