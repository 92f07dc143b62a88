//! Fitness of genomes (paper steps 2 and 7).
//!
//! Trials of several runs are simulated together to fill the SIMD vectors. Each run has a memo: a
//! trial is not simulated again if its tables equal an earlier trial's in every row that was read.
//! Neither the memo nor the threads change a fitness.

use field::{Engine, MAX_AGENTS, Outcome, Responses, Trial};

use crate::condition::{Condition, GOALS};
use crate::genome::Genome;
use crate::memo::Memo;
use crate::training::{Set, choice_sets};
use crate::workers::Workers;

/// Points per goal, goal 1 first.
pub type GoalPoints = [f32; GOALS];

/// A genome and its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Individual {
    /// The genotype.
    pub genome: Genome,
    /// Points per goal: the mean over the sets of trials.
    pub points: GoalPoints,
}

impl Individual {
    /// Returns the fitness: the sum of the points in the order of the goals, at most 800.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.points.iter().fold(0.0, |sum, points| sum + points)
    }
}

/// Evaluates the genomes of several runs of one condition.
#[derive(Debug)]
pub struct Evaluator {
    condition: Condition,
    workers: Workers,
    runs: Vec<RunTrials>,
    pending: Vec<Pending>,
    trials: Vec<Trial>,
    outcomes: Vec<Outcome>,
}

#[derive(Debug)]
struct RunTrials {
    sets: Vec<Set>,
    memo: Memo<MAX_AGENTS>,
}

impl RunTrials {
    fn new(sets: Vec<Set>) -> Self {
        let memo = Memo::with_goals(GOALS * sets.len());
        Self { sets, memo }
    }

    fn trials_per_genome(&self) -> usize {
        GOALS * self.sets.len()
    }
}

#[derive(Debug)]
struct Pending {
    run: usize,
    /// Index in the points of the run.
    index: usize,
    /// Index in the trials of the run: set · 8 + goal.
    trial: usize,
    tables: Tables,
}

type Tables = [u128; MAX_AGENTS];

impl Evaluator {
    /// Creates an evaluator for `runs` independent runs on the trials that define the points of a
    /// table.
    #[must_use]
    pub fn new(condition: Condition, workers: impl Into<Workers>, runs: usize) -> Self {
        let sets = choice_sets(&condition);
        let tests = (0..runs).map(|_| RunTrials::new(sets.clone())).collect();
        Self {
            condition,
            workers: workers.into(),
            runs: tests,
            pending: Vec::new(),
            trials: Vec::new(),
            outcomes: Vec::new(),
        }
    }

    /// Returns the condition.
    #[must_use]
    pub fn condition(&self) -> &Condition {
        &self.condition
    }

    /// Returns the largest number of trials per genome.
    #[must_use]
    pub fn trials_per_genome(&self) -> usize {
        self.runs.first().map_or(0, RunTrials::trials_per_genome)
    }

    /// Replaces the trials of a run.
    pub fn set_trials(&mut self, run: usize, sets: Vec<Set>) {
        self.runs[run] = RunTrials::new(sets);
    }

    /// Evaluates the genomes of every run, `batches[run]`; `None` if the workers were stopped.
    pub fn evaluate(&mut self, batches: Vec<Vec<Genome>>) -> Option<Vec<Vec<Individual>>> {
        let mut points: Vec<Vec<f32>> = Vec::with_capacity(batches.len());
        for (run, batch) in batches.iter().enumerate() {
            points.push(vec![0.0; batch.len() * self.runs[run].trials_per_genome()]);
            for (genome, bits) in batch.iter().enumerate() {
                self.recall(run, genome, bits, &mut points[run]);
            }
        }
        self.simulate(&mut points)?;
        let judged = |(genome, points): (Genome, &[f32])| Individual {
            genome,
            points: mean_per_goal(points),
        };
        let of_run = |((batch, points), test): ((Vec<Genome>, Vec<f32>), &RunTrials)| {
            let each = points.chunks_exact(test.trials_per_genome());
            batch.into_iter().zip(each).map(judged).collect()
        };
        let runs = batches.into_iter().zip(points).zip(&self.runs);
        Some(runs.map(of_run).collect())
    }

    /// Returns the points of one genome.
    #[must_use]
    pub fn points_of(condition: &Condition, genome: &Genome) -> GoalPoints {
        Self::points_on(condition, choice_sets(condition), genome)
    }

    /// Returns the points of one genome on these trials.
    #[must_use]
    pub fn points_on(condition: &Condition, sets: Vec<Set>, genome: &Genome) -> GoalPoints {
        let mut evaluator = Self {
            condition: condition.clone(),
            workers: Engine::fastest().into(),
            runs: vec![RunTrials::new(sets)],
            pending: Vec::new(),
            trials: Vec::new(),
            outcomes: Vec::new(),
        };
        let evaluated = evaluator.evaluate(vec![vec![genome.clone()]]);
        evaluated.map_or([0.0; GOALS], |evaluated| evaluated[0][0].points)
    }

    /// Fills in known points and queues the other trials.
    fn recall(&mut self, run: usize, genome: usize, bits: &Genome, points: &mut [f32]) {
        let responses = self.condition.responses(bits);
        let tables = responses.map(Responses::bits);
        let RunTrials { sets, memo } = &self.runs[run];
        let first = genome * self.runs[run].trials_per_genome();
        for (place, &layout) in sets.as_flattened().iter().enumerate() {
            let index = first + place;
            match memo.recall(place, &tables) {
                Some(known) => points[index] = known,
                None => {
                    self.pending.push(Pending {
                        run,
                        index,
                        trial: place,
                        tables,
                    });
                    self.trials.push(Trial {
                        layout,
                        tables: responses,
                    });
                }
            }
        }
    }

    fn simulate(&mut self, points: &mut [Vec<f32>]) -> Option<()> {
        let Condition { model, team, .. } = &self.condition;
        let whole = self
            .workers
            .simulate(model, *team, &self.trials, &mut self.outcomes);
        self.trials.clear();
        if whole.is_break() {
            self.pending.clear();
            return None;
        }
        for (pending, outcome) in self.pending.drain(..).zip(&self.outcomes) {
            let Pending {
                run,
                index,
                trial: place,
                tables,
            } = pending;
            let earned = self.condition.points(outcome);
            points[run][index] = earned;
            let mask = Responses::row_mask(outcome.rows_read);
            self.runs[run].memo.store(place, &tables, mask, earned);
        }
        Some(())
    }
}

/// Returns the mean over the sets, in their order; for one set exactly its points.
fn mean_per_goal(points: &[f32]) -> GoalPoints {
    let (sets, _) = points.as_chunks::<GOALS>();
    std::array::from_fn(|goal| {
        let sum = sets.iter().fold(0.0, |sum, set| sum + set[goal]);
        sum / sets.len() as f32
    })
}
