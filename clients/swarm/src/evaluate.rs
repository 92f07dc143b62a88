//! From genomes to fitness: paper steps 2 and 7.
//!
//! Trials of several runs are simulated together, because full vectors are fast vectors. Each run has a memo: a trial whose
//! goal was already simulated with tables that agree in every row that was read then cannot come out differently, and is not
//! simulated again. Neither changes a bit of any fitness, nor do threads that share the trials of a large population.

use field::{Engine, MAX_AGENTS, Outcome, Responses, Trial};

use crate::condition::{Condition, GOALS};
use crate::genome::Genome;
use crate::memo::Memo;
use crate::workers::Workers;

/// Points per goal, goal 1 first.
pub type GoalPoints = [f32; GOALS];

/// A genome with what it is worth.
#[derive(Clone, Debug, PartialEq)]
pub struct Individual {
    /// The genotype.
    pub genome: Genome,
    /// Points per goal.
    pub points: GoalPoints,
}

impl Individual {
    /// The fitness: the sum of the points in the order of the goals, at most 800.
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
    layouts: [field::Layout; GOALS],
    memos: Vec<Memo<MAX_AGENTS>>,
    pending: Vec<Pending>,
    trials: Vec<Trial>,
    outcomes: Vec<Outcome>,
}

/// A trial that has to be simulated.
#[derive(Debug)]
struct Pending {
    run: usize,
    genome: usize,
    goal: usize,
    tables: Tables,
}

type Tables = [u128; MAX_AGENTS];

impl Evaluator {
    /// An evaluator of `runs` independent runs.
    #[must_use]
    pub fn new(condition: Condition, workers: impl Into<Workers>, runs: usize) -> Self {
        let layouts = condition.layouts();
        let memos = (0..runs).map(|_| Memo::default()).collect();
        Self {
            condition,
            workers: workers.into(),
            layouts,
            memos,
            pending: Vec::new(),
            trials: Vec::new(),
            outcomes: Vec::new(),
        }
    }

    /// The condition it evaluates.
    #[must_use]
    pub fn condition(&self) -> &Condition {
        &self.condition
    }

    /// Evaluates the genomes of every run, `batches[run]`; nothing if the workers were stopped before the end.
    pub fn evaluate(&mut self, batches: Vec<Vec<Genome>>) -> Option<Vec<Vec<Individual>>> {
        let mut evaluated: Vec<Vec<Individual>> = batches
            .into_iter()
            .map(|batch| {
                batch
                    .into_iter()
                    .map(|genome| Individual {
                        genome,
                        points: [0.0; GOALS],
                    })
                    .collect()
            })
            .collect();
        for (run, batch) in evaluated.iter_mut().enumerate() {
            for (genome, individual) in batch.iter_mut().enumerate() {
                self.recall(run, genome, individual);
            }
        }
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
            let points = self.condition.points(outcome);
            evaluated[pending.run][pending.genome].points[pending.goal] = points;
            let mask = Responses::row_mask(outcome.rows_read);
            self.memos[pending.run].learn(pending.goal, &pending.tables, mask, points);
        }
        Some(evaluated)
    }

    /// The points of one genome on its own.
    #[must_use]
    pub fn points_of(condition: &Condition, genome: &Genome) -> GoalPoints {
        let mut evaluator = Self::new(condition.clone(), Engine::fastest(), 1);
        let evaluated = evaluator.evaluate(vec![vec![genome.clone()]]);
        evaluated.map_or([0.0; GOALS], |evaluated| evaluated[0][0].points)
    }

    /// Fills in the points that the memo knows, and queues a trial for each of the others.
    fn recall(&mut self, run: usize, genome: usize, individual: &mut Individual) {
        let responses = self.condition.responses(&individual.genome);
        let tables = responses.map(Responses::bits);
        for goal in 0..GOALS {
            match self.memos[run].recall(goal, &tables) {
                Some(points) => individual.points[goal] = points,
                None => {
                    self.pending.push(Pending {
                        run,
                        genome,
                        goal,
                        tables,
                    });
                    self.trials.push(Trial {
                        layout: self.layouts[goal],
                        tables: responses,
                    });
                }
            }
        }
    }
}
