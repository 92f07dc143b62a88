//! Evaluation of a coarse position policy with and without the reflex modules.
//!
//! ```text
//!  CoarsePolicy (10 Hz, 50 ms late) ─ targets ─▶ OfflineRun ─▶ judge: lifted, stable, unharmed
//!                                              └─▶ Onsets: slip to first command for more force
//! ```
//!
//! * **In:** number of trials, first seed. **Out:** a [`ReflexReport`].
//! * **Invariants:** the report depends on the arguments only. With and without the reflex, the
//!   same targets go to the same world. Without it, touch is never detected, and the hand executes
//!   the commanded widths.
//! * **Not included:** objects that are infeasible under the paper's rule; the external policy
//!   chooses the object.

mod coarse_policy;
mod onset;
mod trial;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use rayon::prelude::*;
use robot_model::RobotModel;
use serde::Serialize;

use crate::Task;
use crate::seeds;
use crate::statistics::{median, wilson};
use trial::{Trial, run, without_reflex};

pub use coarse_policy::CoarsePolicy;

/// Plan of a reflex evaluation.
#[derive(Clone, Debug)]
pub struct ReflexPlan {
    /// Trials, distributed to the objects in turn.
    pub trials: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Controller settings.
    pub settings: atas_core::Settings,
}

/// Result of a reflex evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReflexReport {
    /// Always `reflex`.
    pub task: &'static str,
    /// First seed per object.
    pub first_seed: u64,
    /// `tuning` or `judging`.
    pub purpose: &'static str,
    /// With the reflex modules.
    pub with: ReflexResults,
    /// Without the reflex modules.
    pub without: ReflexResults,
    /// With the reflex modules: time from slip onset to the first command for more force, ms.
    pub slip_to_command_ms: Latency,
}

/// Results with or without the reflex modules.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReflexResults {
    /// Trials.
    pub trials: u64,
    /// Share of trials with the object lifted, stable and in the hand at the end.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
    /// Number of crushed objects.
    pub crushed: u64,
    /// Failures by key.
    pub failures: BTreeMap<String, u64>,
    /// Trials and successes of the too weak policies.
    pub weakly: [u64; 2],
    /// Trials and successes of the too strong policies.
    pub hard: [u64; 2],
    /// Median ratio of final to needed normal force, over successes; `null` without one.
    pub over_grip_median: Option<f64>,
}

/// Statistics of the response latency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// Number of slips counted.
    pub count: u64,
    /// Slips during which F_2 prevented a response; not counted.
    pub at_f2: u64,
    /// Slips that ended without a response; counted with their duration.
    pub unanswered: u64,
    /// Median, ms; `null` without a slip.
    pub p50: Option<f64>,
    /// 99th percentile, ms.
    pub p99: Option<f64>,
    /// Maximum, ms.
    pub max: Option<f64>,
    /// 99th percentile including slips at F_2 until their response or end, ms.
    pub p99_with_f2: Option<f64>,
}

impl ReflexPlan {
    /// Runs all trials; calls `done` after each, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot or a world cannot be created, or there are no trials.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<ReflexReport>> {
        anyhow::ensure!(
            self.trials > 0,
            "could not evaluate: the plan has no trial; request at least one with --trials"
        );
        let robot =
            RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
        let objects = Task::PickPlace.objects()?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()?;
        let one = |k: u64| -> anyhow::Result<Option<[Trial; 2]>> {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let object = &objects[(k % objects.len() as u64) as usize];
            let number = self.first_seed + k / objects.len() as u64;
            let pair = [
                run(&robot, object, number, &self.settings)?,
                run(&robot, object, number, &without_reflex(&self.settings))?,
            ];
            done();
            Ok(Some(pair))
        };
        let numbers: Vec<u64> = (0..self.trials).collect();
        let pairs: anyhow::Result<Vec<Option<[Trial; 2]>>> =
            pool.install(|| numbers.into_par_iter().with_max_len(1).map(one).collect());
        let pairs: Option<Vec<[Trial; 2]>> = pairs?.into_iter().collect();
        Ok(pairs.map(|pairs| self.report(&pairs)))
    }

    fn report(&self, pairs: &[[Trial; 2]]) -> ReflexReport {
        let objects = Task::PickPlace.objects().map_or(1, |objects| objects.len()) as u64;
        let side = |index: usize| ReflexResults::from_trials(pairs.iter().map(|pair| &pair[index]));
        ReflexReport {
            task: "reflex",
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.trials.div_ceil(objects)),
            with: side(0),
            without: side(1),
            slip_to_command_ms: Latency::from_trials(pairs.iter().map(|pair| &pair[0])),
        }
    }
}

impl ReflexResults {
    fn from_trials<'a>(trials: impl Iterator<Item = &'a Trial> + Clone) -> Self {
        let count = |is: &dyn Fn(&Trial) -> bool| trials.clone().filter(|t| is(t)).count() as u64;
        let (all, successes) = (count(&|_| true), count(&|t| t.failure.is_none()));
        let mut failures = BTreeMap::new();
        for key in trials.clone().filter_map(|t| t.failure.clone()) {
            *failures.entry(key).or_default() += 1;
        }
        let of = |weakly: bool| {
            [
                count(&|t| t.weakly == weakly),
                count(&|t| t.weakly == weakly && t.failure.is_none()),
            ]
        };
        Self {
            trials: all,
            success: successes as f64 / all.max(1) as f64,
            ci95: wilson(successes, all),
            crushed: count(&|t| t.crushed),
            failures,
            weakly: of(true),
            hard: of(false),
            over_grip_median: median(trials.filter_map(|t| t.over_grip).collect()),
        }
    }
}

impl Latency {
    fn from_trials<'a>(trials: impl Iterator<Item = &'a Trial> + Clone) -> Self {
        let sorted = |of: fn(&Trial) -> &[f64]| {
            let mut ms: Vec<f64> = trials.clone().flat_map(of).copied().collect();
            ms.sort_by(f64::total_cmp);
            ms
        };
        let ms = sorted(|trial| trial.onsets.latencies_ms());
        let at_f2_ms = sorted(|trial| trial.onsets.at_f2_ms());
        let mut all_ms = [ms.as_slice(), &at_f2_ms].concat();
        all_ms.sort_by(f64::total_cmp);
        Self {
            count: ms.len() as u64,
            at_f2: at_f2_ms.len() as u64,
            unanswered: trials.clone().map(|trial| trial.onsets.unanswered()).sum(),
            p50: quantile(&ms, 0.5),
            p99: quantile(&ms, 0.99),
            max: quantile(&ms, 1.0),
            p99_with_f2: quantile(&all_ms, 0.99),
        }
    }
}

/// Returns the smallest of the sorted values that at least this share does not exceed.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}
