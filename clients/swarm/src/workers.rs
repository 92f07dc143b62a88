//! Simulation resources: an engine, threads and a stop flag. None of them changes a result.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use field::{Engine, Model, Outcome, TeamSize, Trial};

use crate::error::{Error, Result};

/// Trials between two checks of the stop flag: 0.1 s on the slowest SIMD engine, less than 1 s
/// without SIMD.
const TRIALS_PER_STOP_CHECK: usize = 16_384;
/// Trials below which the hand-over to another thread costs more than the simulation (measured; a
/// generation of the paper has 80).
const TRIALS_PER_THREAD: usize = 256;

/// Simulates trials on an engine and one or more threads.
#[derive(Clone, Debug)]
pub struct Workers {
    engine: Engine,
    pool: Option<Arc<ThreadPool>>,
    stop: Arc<AtomicBool>,
}

impl From<Engine> for Workers {
    /// One thread; never stopped.
    fn from(engine: Engine) -> Self {
        Self {
            engine,
            pool: None,
            stop: Arc::default(),
        }
    }
}

impl Workers {
    /// Creates workers on a number of threads, with a stop flag.
    pub fn new(engine: Engine, threads: usize, stop: Arc<AtomicBool>) -> Result<Self> {
        let pool = match threads {
            0 | 1 => None,
            _ => Some(Arc::new(pool(threads)?)),
        };
        Ok(Self { engine, pool, stop })
    }

    /// Returns workers with the same engine and flag on the calling thread only.
    #[must_use]
    pub fn single_threaded(&self) -> Self {
        Self {
            pool: None,
            ..self.clone()
        }
    }

    /// Returns whether the stop flag is set.
    #[must_use]
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Sets the stop flag.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Returns whether the simulation of this number of trials can be interrupted.
    #[must_use]
    pub fn is_interruptible(&self, trials: usize) -> bool {
        trials > TRIALS_PER_STOP_CHECK
    }

    /// Simulates the trials in order. Breaks when stopped; `outcomes` is then incomplete.
    pub fn simulate(
        &self,
        model: &Model,
        team: TeamSize,
        trials: &[Trial],
        outcomes: &mut Vec<Outcome>,
    ) -> ControlFlow<()> {
        if trials.len() <= TRIALS_PER_THREAD {
            self.engine.run(model, team, trials, outcomes);
            return ControlFlow::Continue(());
        }
        outcomes.clear();
        for some in trials.chunks(TRIALS_PER_STOP_CHECK) {
            if self.is_interruptible(trials.len()) && self.is_stopped() {
                return ControlFlow::Break(());
            }
            outcomes.extend(self.simulate_chunk(model, team, some));
        }
        ControlFlow::Continue(())
    }

    fn simulate_chunk(&self, model: &Model, team: TeamSize, trials: &[Trial]) -> Vec<Outcome> {
        let run = |trials: &[Trial]| {
            let mut outcomes = Vec::new();
            self.engine.run(model, team, trials, &mut outcomes);
            outcomes
        };
        let Some(pool) = &self.pool else {
            return run(trials);
        };
        let share = trials.len().div_ceil(pool.current_num_threads());
        let shares = trials.par_chunks(share.max(TRIALS_PER_THREAD)).map(run);
        pool.install(|| shares.collect::<Vec<_>>().concat())
    }
}

/// Creates a thread pool with exactly this number of threads.
pub fn pool(threads: usize) -> Result<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads);
    builder.build().map_err(Error::from_part)
}
