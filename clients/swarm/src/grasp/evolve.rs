//! One run of the paper's genetic algorithm on the reduced grasp.
//!
//! As on the field: a trial whose object was tried before with a table that agrees in every row that was read then cannot come
//! out differently, and is not simulated again.

use std::ops::ControlFlow;

use pinch::{Engine, Outcome, Patience, Trial};

use super::course::{Course, GENOME_BITS, OBJECTS, Object, rows, table};
use super::fitness::points;
use crate::error::Result;
use crate::evaluate::{GoalPoints, Individual};
use crate::ga::Settings;
use crate::generations;
use crate::genome::Genome;
use crate::memo::Memo;
use crate::rng::SplitMix64;
use crate::run::Rise;

/// What turns a run's seed into its stream: no run of the field has it.
const STREAM: u64 = 0x0067_7261_7370;

/// What a run came to.
#[derive(Clone, Debug, PartialEq)]
pub struct Evolved {
    /// The best genome.
    pub best: Individual,
    /// When the best fitness rose, and to what.
    pub rises: Vec<Rise>,
    /// Grasps that were simulated.
    pub simulated: u64,
}

/// Evaluates genomes on the course.
pub struct Evaluator<'a> {
    course: Course,
    objects: &'a [Object],
    engine: Engine,
    force_limit: bool,
    memo: Memo<1>,
    outcomes: Vec<Outcome>,
    simulated: u64,
}

impl<'a> Evaluator<'a> {
    /// An evaluator on these objects.
    #[must_use]
    pub fn new(objects: &'a [Object], engine: Engine, force_limit: bool) -> Self {
        Self {
            course: Course::default(),
            objects,
            engine,
            force_limit,
            memo: Memo::default(),
            outcomes: Vec::new(),
            simulated: 0,
        }
    }

    /// Evaluates genomes.
    pub fn evaluate(&mut self, genomes: Vec<Genome>) -> Vec<Individual> {
        let mut evaluated: Vec<Individual> = genomes
            .into_iter()
            .map(|genome| Individual {
                genome,
                points: [0.0; OBJECTS],
            })
            .collect();
        let (mut pending, mut trials) = (Vec::new(), Vec::new());
        // Object by object, so that lanes end at about the same time.
        for (object, reduced) in self
            .objects
            .iter()
            .map(|o| o.reduced)
            .enumerate()
            .take(OBJECTS)
        {
            for (index, individual) in evaluated.iter_mut().enumerate() {
                let bits = individual.genome.words()[0];
                match self.memo.recall(object, &[bits]) {
                    Some(points) => individual.points[object] = points,
                    None => {
                        pending.push((index, object));
                        trials.push(Trial {
                            object: reduced,
                            rows: rows(&table(&individual.genome)),
                            seed: object as u32 + 1,
                        });
                    }
                }
            }
        }
        let interface = self.course.interface(self.force_limit, Patience::SHORT);
        self.engine.run(&interface, &trials, &mut self.outcomes);
        self.simulated += trials.len() as u64;
        for ((index, object), outcome) in pending.into_iter().zip(&self.outcomes) {
            let earned = points(&self.objects[object].reduced, outcome);
            evaluated[index].points[object] = earned;
            let bits = evaluated[index].genome.words()[0];
            self.memo
                .learn(object, &[bits], mask_of(outcome.rows_read), earned);
        }
        evaluated
    }
}

/// The bits of the rows that were read.
fn mask_of(rows_read: u64) -> u128 {
    (0..GENOME_BITS / 4)
        .filter(|row| rows_read >> row & 1 == 1)
        .fold(0, |mask, row| mask | 0xf << (4 * row))
}

/// Evolves one table; `watch` hears of every generation and its best fitness, and may stop the run.
///
/// # Errors
/// The settings make no algorithm; the run was stopped.
pub fn evolve(
    evaluator: &mut Evaluator<'_>,
    settings: Settings,
    seed: u64,
    generations: u32,
    watch: impl FnMut(u32, f32) -> ControlFlow<()>,
) -> Result<Evolved> {
    let rng = SplitMix64::stream(&[STREAM, seed]);
    let evaluate = |genomes| evaluator.evaluate(genomes);
    let kept = "whole runs are saved, this one begins anew";
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

/// What a table earns per object, and which rows it read.
#[must_use]
pub fn evaluate_table(
    objects: &[Object],
    genome: &Genome,
    force_limit: bool,
) -> (GoalPoints, u64, Vec<Outcome>) {
    let course = Course::default();
    let trials: Vec<Trial> = (objects.iter().zip(1..))
        .map(|(object, seed)| Trial {
            object: object.reduced,
            rows: rows(&table(genome)),
            seed,
        })
        .collect();
    let mut outcomes = Vec::new();
    let interface = course.interface(force_limit, Patience::SHORT);
    Engine::fastest().run(&interface, &trials, &mut outcomes);
    let mut earned = [0.0; OBJECTS];
    for (earned, (object, outcome)) in earned.iter_mut().zip(objects.iter().zip(&outcomes)) {
        *earned = points(&object.reduced, outcome);
    }
    let read = outcomes
        .iter()
        .fold(0, |read, outcome| read | outcome.rows_read);
    (earned, read, outcomes)
}
