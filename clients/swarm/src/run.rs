//! Runs: one seed each, evolved together in lock-step so that their trials fill the SIMD lanes.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::condition::{Condition, GOALS};
use crate::evaluate::{Evaluator, GoalPoints, Individual};
use crate::ga::{Population, Settings, SettingsError};
use crate::genome::{Genome, diversity};
use crate::islands::{Archipelago, Elites, IslandSettings};
use crate::rng::SplitMix64;
use crate::training::of_generation;
use crate::workers::Workers;

/// A generation in which the best fitness rose.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rise {
    /// 0 is the random population.
    pub generation: u32,
    /// The best fitness from then on.
    pub fitness: f32,
}

impl Rise {
    /// Adds the best fitness of a generation if it is a rise.
    pub(crate) fn note(rises: &mut Vec<Self>, generation: u32, fitness: f32) {
        if rises.last().is_none_or(|last| fitness > last.fitness) {
            rises.push(Self {
                generation,
                fitness,
            });
        }
    }
}

/// One run of an experiment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Job {
    /// Team size.
    pub agents: usize,
    /// Seed.
    pub seed: u64,
}

/// One run under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Names the random stream, together with the number of agents.
    pub seed: u64,
    archipelago: Archipelago,
    /// Generations done; `None` before the random population is evaluated.
    generation: Option<u32>,
    rises: Vec<Rise>,
    /// Where every generation has other trials: the best of all generations' best, by the trials of the choice.
    chosen: Option<Individual>,
}

impl Run {
    /// A run about to start.
    ///
    /// # Errors
    /// See [`Settings::check`].
    pub fn new(
        condition: &Condition,
        settings: Settings,
        islands: IslandSettings,
        seed: u64,
    ) -> Result<Self, SettingsError> {
        let agents = condition.team.get() as u64;
        let stream = |island: usize| SplitMix64::stream(&[seed, agents, island as u64]);
        let archipelago = Archipelago::new(settings, islands, condition.genome_bits(), stream)?;
        Ok(Self {
            seed,
            archipelago,
            generation: None,
            rises: Vec::new(),
            chosen: None,
        })
    }

    /// A run as it was after `generation`.
    #[must_use]
    pub fn resume(
        seed: u64,
        archipelago: Archipelago,
        generation: u32,
        (rises, chosen): (Vec<Rise>, Option<Individual>),
    ) -> Self {
        Self {
            seed,
            archipelago,
            generation: Some(generation),
            rises,
            chosen,
        }
    }

    /// The generation that is done.
    #[must_use]
    pub fn generation(&self) -> Option<u32> {
        self.generation
    }

    /// The populations.
    #[must_use]
    pub fn archipelago(&self) -> &Archipelago {
        &self.archipelago
    }

    /// When the best fitness rose, and to what.
    #[must_use]
    pub fn rises(&self) -> &[Rise] {
        &self.rises
    }

    /// The best individual so far.
    #[must_use]
    pub fn best(&self) -> Option<&Individual> {
        self.chosen.as_ref().or_else(|| self.archipelago.best())
    }

    /// See [`Run::best`]; `None` where every generation has the same trials.
    #[must_use]
    pub fn chosen(&self) -> Option<&Individual> {
        self.chosen.as_ref()
    }

    /// What the individuals of all islands are like now; `None` before the random population is evaluated.
    #[must_use]
    pub fn census(&self) -> Option<Census> {
        let members = || {
            self.archipelago
                .islands()
                .iter()
                .flat_map(Population::members)
        };
        let generation = self.generation?;
        let count = members().count();
        let fitness = || members().map(|member| f64::from(member.fitness()));
        let genomes = members().map(|member| &member.genome).collect::<Vec<_>>();
        Some(Census {
            generation,
            best: fitness().fold(0.0, f64::max),
            mean: fitness().sum::<f64>() / count as f64,
            worst: fitness().fold(f64::MAX, f64::min),
            diversity: diversity(&genomes),
        })
    }

    /// The generation to come.
    fn next(&self) -> u32 {
        self.generation.map_or(0, |generation| generation + 1)
    }

    fn accept(&mut self, evaluated: Vec<Individual>, elites: Elites) {
        let generation = self.next();
        self.archipelago.select(evaluated, generation, elites);
        self.generation = Some(generation);
        if let (Elites::Known, Some(best)) = (elites, self.archipelago.best()) {
            let fitness = best.fitness();
            Rise::note(&mut self.rises, generation, fitness);
        }
    }

    /// The genome that the run would end with if it were found better than the chosen one.
    fn candidate(&self) -> Option<Genome> {
        let best = &self.archipelago.best()?.genome;
        let known = self.chosen.as_ref().map(|chosen| &chosen.genome);
        (known != Some(best)).then(|| best.clone())
    }

    /// Takes a candidate that is better than the one chosen before.
    fn choose(&mut self, candidate: Individual) {
        let fitness = candidate.fitness();
        let before = self.chosen.as_ref().map(Individual::fitness);
        if before.is_none_or(|before| fitness > before) {
            self.chosen = Some(candidate);
            Rise::note(&mut self.rises, self.generation.unwrap_or(0), fitness);
        }
    }

    /// What the run came to.
    #[must_use]
    pub fn record(&self, condition: &Condition) -> Option<Record> {
        let best = self.best()?;
        Some(Record {
            agents: condition.team.get(),
            seed: self.seed,
            genome: best.genome.to_hex(),
            points: best.points,
            rises: self.rises.clone(),
        })
    }
}

/// The individuals of a generation, all islands together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Census {
    /// 0 is the random population.
    pub generation: u32,
    /// The largest fitness.
    pub best: f64,
    /// The mean fitness.
    pub mean: f64,
    /// The smallest fitness.
    pub worst: f64,
    /// The part of bits in which two individuals differ, mean over all pairs: 0.5 in a random population, 0 if all are equal.
    pub diversity: f64,
}

/// What a finished run came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The condition.
    pub agents: usize,
    /// The run.
    pub seed: u64,
    /// The best genome, see [`crate::genome::Genome::to_hex`].
    pub genome: String,
    /// Its points per goal.
    pub points: GoalPoints,
    /// The best fitness over the generations.
    pub rises: Vec<Rise>,
}

impl Record {
    /// Which run it is of.
    #[must_use]
    pub fn job(&self) -> Job {
        Job {
            agents: self.agents,
            seed: self.seed,
        }
    }

    /// The best fitness at the end.
    #[must_use]
    pub fn fitness(&self) -> f32 {
        self.rises.last().map_or(0.0, |rise| rise.fitness)
    }

    /// The best fitness at a generation.
    #[must_use]
    pub fn fitness_at(&self, generation: u32) -> f32 {
        let until = self
            .rises
            .partition_point(|rise| rise.generation <= generation);
        until
            .checked_sub(1)
            .map_or(0.0, |last| self.rises[last].fitness)
    }

    /// Goals for which the best genome earns the largest score.
    #[must_use]
    pub fn full_scores(&self) -> usize {
        (0..GOALS)
            .filter(|&goal| field::solved(self.points[goal]))
            .count()
    }
}

/// Evolves runs of one condition side by side up to `generations`; `watch` sees them after every generation and may stop
/// them. Runs stopped by it or by the workers' flag are whole: as they were after their last generation.
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
        let before = trials.may_break_off(runs).then(|| runs.to_vec());
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

/// What runs are tried on: the same trials in every generation, or other ones, and then the trials of the choice beside them.
struct Trials {
    evaluator: Evaluator,
    workers: Workers,
    choice: Option<Evaluator>,
    elites: Elites,
}

impl Trials {
    fn new(condition: &Condition, workers: Workers, runs: usize) -> Self {
        let evaluator = || Evaluator::new(condition.clone(), workers.clone(), runs);
        let drawn = condition.training().is_some();
        Self {
            evaluator: evaluator(),
            choice: drawn.then(evaluator),
            elites: match drawn {
                true => Elites::JudgedAgain,
                false => Elites::Known,
            },
            workers,
        }
    }

    /// Whether a generation has so many trials that it may be broken off.
    fn may_break_off(&self, runs: &[Run]) -> bool {
        let size = |run: &Run| run.archipelago.size();
        let genomes = 2 * runs.iter().map(size).sum::<usize>();
        let choice = self.choice.as_ref().map_or(0, Evaluator::trials_per_genome);
        let of_generation = genomes * self.evaluator.trials_per_genome();
        self.workers.may_break_off(of_generation) || self.workers.may_break_off(runs.len() * choice)
    }

    /// One generation of every open run; nothing if the workers were stopped before its end.
    fn generation(&mut self, runs: &mut [Run], open: impl Fn(&Run) -> bool) -> Option<()> {
        let elites = self.elites;
        let mut proposals = Vec::with_capacity(runs.len());
        for (index, run) in runs.iter_mut().enumerate() {
            if open(run) && elites == Elites::JudgedAgain {
                let sets = of_generation(self.evaluator.condition(), run.seed, run.next());
                self.evaluator.try_on(index, sets);
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
        self.choose(runs)
    }

    /// Tries the best of the generation on the trials of the choice.
    fn choose(&mut self, runs: &mut [Run]) -> Option<()> {
        let Some(choice) = &mut self.choice else {
            return Some(());
        };
        let candidates = runs.iter().map(|run| run.candidate().into_iter().collect());
        let judged = choice.evaluate(candidates.collect())?;
        for (run, judged) in runs.iter_mut().zip(judged) {
            judged
                .into_iter()
                .for_each(|candidate| run.choose(candidate));
        }
        Some(())
    }
}
