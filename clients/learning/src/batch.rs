//! Many environments of one kind at once, on all cores.

use rayon::prelude::*;

use crate::environment::{Environment, Outcome};
use crate::error::LearningError;
use crate::hand::ACTIONS;
use crate::observation;
use crate::reward::End;

/// Environments that step together. What one of them does depends on its own seed and actions only.
pub struct Batch {
    environments: Vec<Environment>,
    /// How the episode of each ended, if it has.
    over: Vec<Option<Outcome>>,
    autoreset: bool,
    pool: rayon::ThreadPool,
}

impl Batch {
    /// So many environments like this one, on so many threads; 0 for one per core. With `autoreset` one whose episode has ended
    /// begins the next in the following step, as `gymnasium`'s next-step mode has it; without, it stands still until reset.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn new(
        like: &Environment,
        count: usize,
        threads: usize,
        autoreset: bool,
    ) -> Result<Self, rayon::ThreadPoolBuildError> {
        Ok(Self {
            environments: (0..count).map(|_| like.another()).collect(),
            over: vec![None; count],
            autoreset,
            pool: rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()?,
        })
    }

    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.environments.len()
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.environments.is_empty()
    }

    /// Begins an episode in each: with a seed, the first of a series, else the next. Writes one row of numbers for each.
    ///
    /// # Errors
    /// The first scene that cannot be set.
    pub fn reset(
        &mut self,
        seeds: &[Option<u64>],
        rows: &mut [f32],
    ) -> Result<Vec<Outcome>, LearningError> {
        let Self {
            environments,
            over,
            pool,
            ..
        } = self;
        over.fill(None);
        let each = environments
            .par_iter_mut()
            .zip(seeds)
            .zip(rows.par_chunks_exact_mut(observation::SIZE));
        let one = |((environment, seed), row): ((&mut Environment, &Option<u64>), &mut [f32])| {
            let outcome = environment.reset(*seed)?;
            environment.observe(row);
            Ok(outcome)
        };
        pool.install(|| each.with_max_len(1).map(one).collect())
    }

    /// One step of each. Nothing moves if an action is not finite.
    ///
    /// # Errors
    /// The first action that is not finite, or the first world that came apart.
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
            over,
            autoreset,
            pool,
        } = self;
        let each = environments
            .par_iter_mut()
            .zip(over.par_iter_mut())
            .zip(actions)
            .zip(rows.par_chunks_exact_mut(observation::SIZE));
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
