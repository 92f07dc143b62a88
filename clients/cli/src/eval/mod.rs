//! Batch evaluation: many seeded trials in process, in virtual time, on all cores.
//!
//! **In:** a [`Plan`]. **Out:** a [`Report`]. Every trial has a seed of its own, made from the object's name and the
//! trial's number, and results are kept in the order of the plan: everything in the report but the times is a function
//! of the plan, whatever the number of threads.

mod report;
mod table;
mod trial;

pub use report::{Family, Feasible, Infeasible, Report, wilson};
pub(crate) use table::print;
pub use trial::{Record, trial_seed};

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::Context;
use atas::Settings;
use rayon::prelude::*;
use robot_model::RobotModel;
use sim_backend::Object;

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The nominal objects; each is the middle of a family.
    pub objects: Vec<Object>,
    /// Trials of each object: seeds 1 to this.
    pub seeds: u64,
    /// Scale of the fingertip sensors' noise.
    pub noise: f64,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// The controller's settings.
    pub settings: Settings,
}

impl Plan {
    /// How many trials it has.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.objects.len() as u64 * self.seeds
    }

    /// Runs all trials; `done` is called after each, from any thread. `None` if `stop` was set meanwhile.
    ///
    /// # Errors
    /// If the robot or a world cannot be made, or there is no object.
    pub fn run(&self, stop: &AtomicBool, done: impl Fn() + Sync) -> anyhow::Result<Option<Report>> {
        anyhow::ensure!(
            !self.objects.is_empty(),
            "could not evaluate because there is no object; name one with --objects"
        );
        let robot =
            RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()?;
        let begin = Instant::now();
        let one = |(object, seed): (usize, u64)| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let record = trial::run(&robot, self, object, seed)?;
            done();
            Ok(Some(record))
        };
        // Seed by seed, so that progress is even although some objects take longer.
        let jobs: Vec<_> = (1..=self.seeds)
            .flat_map(|seed| (0..self.objects.len()).map(move |object| (object, seed)))
            .collect();
        let records: anyhow::Result<Vec<Option<Record>>> =
            pool.install(|| jobs.into_par_iter().with_max_len(1).map(one).collect());
        let wall_s = begin.elapsed().as_secs_f64();
        let records: Option<Vec<Record>> = records?.into_iter().collect();
        Ok(records.map(|records| Report::of(self, &records, wall_s)))
    }
}
