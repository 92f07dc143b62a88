//! Who simulates: an engine, threads, and a flag that stops them. None of these changes a bit.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use field::{Engine, Model, Outcome, TeamSize, Trial};

use crate::error::{Error, Result};

/// Trials between two looks at the flag: a tenth of a second on the slowest engine with SIMD, under a second without.
const TRIALS_UNTIL_LOOK: usize = 16_384;
/// Trials below which handing them to another thread takes longer than simulating them (measured: a paper-sized generation
/// has 80).
const TRIALS_PER_THREAD: usize = 256;

/// Simulates many trials on an engine and one or more threads.
#[derive(Clone, Debug)]
pub struct Workers {
    engine: Engine,
    pool: Option<Arc<ThreadPool>>,
    stop: Arc<AtomicBool>,
}

impl From<Engine> for Workers {
    /// One thread that nobody stops.
    fn from(engine: Engine) -> Self {
        Self {
            engine,
            pool: None,
            stop: Arc::default(),
        }
    }
}

impl Workers {
    /// Workers on so many threads, which stop when the flag is set.
    ///
    /// # Errors
    /// The system has no such threads.
    pub fn new(engine: Engine, threads: usize, stop: Arc<AtomicBool>) -> Result<Self> {
        let pool = match threads {
            0 | 1 => None,
            _ => Some(Arc::new(pool(threads)?)),
        };
        Ok(Self { engine, pool, stop })
    }

    /// The same engine and flag on the calling thread alone.
    #[must_use]
    pub fn alone(&self) -> Self {
        Self {
            pool: None,
            ..self.clone()
        }
    }

    /// Whether the flag is set.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Sets the flag.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether so many trials may be broken off half-way.
    #[must_use]
    pub fn may_break_off(&self, trials: usize) -> bool {
        trials > TRIALS_UNTIL_LOOK
    }

    /// Simulates every trial, in order; breaks off when stopped, with `outcomes` incomplete.
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
        for some in trials.chunks(TRIALS_UNTIL_LOOK) {
            if self.may_break_off(trials.len()) && self.stopped() {
                return ControlFlow::Break(());
            }
            outcomes.extend(self.simulate_some(model, team, some));
        }
        ControlFlow::Continue(())
    }

    fn simulate_some(&self, model: &Model, team: TeamSize, trials: &[Trial]) -> Vec<Outcome> {
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

/// Threads of our own, so that their number is what was asked for.
///
/// # Errors
/// The system has no such threads.
pub fn pool(threads: usize) -> Result<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads);
    builder.build().map_err(Error::from_part)
}
