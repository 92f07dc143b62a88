//! Vector of environments of one kind, stepped in parallel.

use rayon::prelude::*;

use crate::environment::{Environment, Outcome};
use crate::error::LearningError;
use crate::hand::ACTIONS;
use crate::reward::End;

/// Most environments of a batch. Design choice: about 2 GB.
const COUNT_MAX: usize = 10_000;
/// Most threads of a batch. Design choice: more than any machine has cores.
const THREADS_MAX: usize = 1000;

/// Environments stepped together; results do not depend on each other.
pub struct Batch {
    environments: Vec<Environment>,
    /// Final outcome per environment; `None` while its episode runs.
    ended: Vec<Option<Outcome>>,
    autoreset: bool,
    pool: rayon::ThreadPool,
}

impl Batch {
    /// Makes `count` environments on `threads` threads (0: one per core). With `autoreset`, a
    /// finished environment starts its next episode in the following step (`gymnasium`'s next-step
    /// mode); otherwise it waits for reset.
    ///
    /// # Errors
    /// More than 10,000 environments or 1,000 threads, or threads that cannot be started.
    pub fn new(
        prototype: &Environment,
        count: usize,
        threads: usize,
        autoreset: bool,
    ) -> Result<Self, LearningError> {
        let numbers = [
            ("count", count, COUNT_MAX),
            ("threads", threads, THREADS_MAX),
        ];
        if let Some((what, value, limit)) = numbers.into_iter().find(|(_, n, most)| n > most) {
            return Err(LearningError::TooMany { what, value, limit });
        }
        Ok(Self {
            environments: (0..count).map(|_| prototype.fork()).collect(),
            ended: vec![None; count],
            autoreset,
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?,
        })
    }

    /// Returns an environment of the batch.
    #[must_use]
    pub fn environment(&self, index: usize) -> Option<&Environment> {
        self.environments.get(index)
    }

    /// Returns the number of environments.
    #[must_use]
    pub fn len(&self) -> usize {
        self.environments.len()
    }

    /// Returns true if there are no environments.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.environments.is_empty()
    }

    /// Starts an episode per environment: with a seed, the first of a series, else the next. Writes
    /// one observation row each.
    ///
    /// # Errors
    /// First scene that cannot be set up.
    pub fn reset(
        &mut self,
        seeds: &[Option<u64>],
        rows: &mut [f32],
    ) -> Result<Vec<Outcome>, LearningError> {
        let Self {
            environments,
            ended: over,
            pool,
            ..
        } = self;
        over.fill(None);
        let size = environments.first().map_or(1, |it| it.layout().size());
        let each = environments
            .par_iter_mut()
            .zip(seeds)
            .zip(rows.par_chunks_exact_mut(size));
        let one = |((environment, seed), row): ((&mut Environment, &Option<u64>), &mut [f32])| {
            let outcome = environment.reset(*seed)?;
            environment.observe(row);
            Ok(outcome)
        };
        pool.install(|| each.with_max_len(1).map(one).collect())
    }

    /// Advances every environment by one step. Nothing moves if any action is not finite.
    ///
    /// # Errors
    /// First action that is not finite, or first simulation fault.
    pub fn step(
        &mut self,
        actions: &[[f32; ACTIONS]],
        rows: &mut [f32],
    ) -> Result<Vec<Outcome>, LearningError> {
        if let Some((index, value)) = actions
            .iter()
            .flatten()
            .copied()
            .enumerate()
            .find(|(_, value)| !value.is_finite())
        {
            return Err(LearningError::Action {
                index: index % ACTIONS,
                value,
            });
        }
        let Self {
            environments,
            ended,
            autoreset,
            pool,
        } = self;
        let size = environments.first().map_or(1, |it| it.layout().size());
        let each = environments
            .par_iter_mut()
            .zip(ended.par_iter_mut())
            .zip(actions)
            .zip(rows.par_chunks_exact_mut(size));
        type Seat<'a> = (
            (
                (&'a mut Environment, &'a mut Option<Outcome>),
                &'a [f32; ACTIONS],
            ),
            &'a mut [f32],
        );
        let one = |(((environment, over), action), row): Seat<'_>| {
            let outcome = match *over {
                None => environment.step(action)?,
                Some(_) if *autoreset => environment.reset(None)?,
                Some(ended) => Outcome {
                    reward: 0.0,
                    ..ended
                },
            };
            *over = (outcome.end != End::None || outcome.truncated).then_some(outcome);
            environment.observe(row);
            Ok(outcome)
        };
        pool.install(|| each.with_max_len(1).map(one).collect())
    }
}
