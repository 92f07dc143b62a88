//! Generations of several runs of one condition, simulated together to fill the SIMD lanes.

use std::ops::ControlFlow;

use super::Run;
use crate::condition::Condition;
use crate::evaluate::Evaluator;
use crate::islands::EliteFitness;
use crate::training::generation_sets;
use crate::workers::Workers;

/// Evolves runs of one condition together up to `generations`. `watch` receives them after every
/// generation and may stop them. After a stop by `watch` or by the workers' flag, the runs are in
/// the state after their last complete generation.
pub fn evolve(
    condition: &Condition,
    workers: impl Into<Workers>,
    runs: &mut [Run],
    generations: u32,
    mut watch: impl FnMut(&[Run]) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let mut trials = Trials::new(condition, workers.into(), runs.len());
    let open = |run: &Run| run.generation.is_none_or(|done| done < generations);
    while runs.iter().any(open) {
        let before = trials.is_interruptible(runs).then(|| runs.to_vec());
        if trials.generation(runs, open).is_none() {
            for (run, before) in runs.iter_mut().zip(before.into_iter().flatten()) {
                *run = before;
            }
            return ControlFlow::Break(());
        }
        watch(runs)?;
    }
    ControlFlow::Continue(())
}

/// Trials of the runs: the same in every generation, or drawn ones together with the trials of the
/// choice.
struct Trials {
    evaluator: Evaluator,
    workers: Workers,
    choice: Option<Evaluator>,
    elites: EliteFitness,
}

impl Trials {
    fn new(condition: &Condition, workers: Workers, runs: usize) -> Self {
        let evaluator = || Evaluator::new(condition.clone(), workers.clone(), runs);
        let drawn = condition.training().is_some();
        Self {
            evaluator: evaluator(),
            choice: drawn.then(evaluator),
            elites: match drawn {
                true => EliteFitness::Reevaluated,
                false => EliteFitness::Known,
            },
            workers,
        }
    }

    fn is_interruptible(&self, runs: &[Run]) -> bool {
        let size = |run: &Run| run.archipelago.size();
        let genomes = 2 * runs.iter().map(size).sum::<usize>();
        let choice = self.choice.as_ref().map_or(0, Evaluator::trials_per_genome);
        let of_generation = genomes * self.evaluator.trials_per_genome();
        self.workers.is_interruptible(of_generation)
            || self.workers.is_interruptible(runs.len() * choice)
    }

    /// Runs one generation of every open run; `None` if the workers were stopped before its end.
    fn generation(&mut self, runs: &mut [Run], open: impl Fn(&Run) -> bool) -> Option<()> {
        let elites = self.elites;
        let mut proposals = Vec::with_capacity(runs.len());
        for (index, run) in runs.iter_mut().enumerate() {
            if open(run) && elites == EliteFitness::Reevaluated {
                let sets =
                    generation_sets(self.evaluator.condition(), run.seed, run.next_generation());
                self.evaluator.set_trials(index, sets);
            }
            proposals.push(match open(run) {
                true => run.archipelago.propose(elites),
                false => Vec::new(),
            });
        }
        let evaluated = self.evaluator.evaluate(proposals)?;
        for (run, evaluated) in runs.iter_mut().zip(evaluated) {
            if open(run) {
                run.accept(evaluated, elites);
            }
        }
        self.evaluate_candidates(runs)
    }

    fn evaluate_candidates(&mut self, runs: &mut [Run]) -> Option<()> {
        let Some(choice) = &mut self.choice else {
            return Some(());
        };
        let candidates = runs.iter().map(|run| run.candidate().into_iter().collect());
        let judged = choice.evaluate(candidates.collect())?;
        for (run, judged) in runs.iter_mut().zip(judged) {
            judged
                .into_iter()
                .for_each(|candidate| run.update_chosen(candidate));
        }
        Some(())
    }
}
