//! A reflex beneath a policy: the same clumsy policy with it and without it.
//!
//! ```text
//!  Script (10 Hz, 50 ms late) ─ targets ─▶ OfflineRun ─▶ judge: lifted, as taken, unharmed
//!                                              └─▶ Onsets: from physical slip to the first harder command
//! ```
//!
//! * **In:** how many trials, from which seed. **Out:** a [`ReflexReport`].
//! * **Invariants:** a function of its arguments, whatever the number of threads. With and without the reflex, the policy streams
//!   the same targets to the same world; without it the hand feels nothing, so it obeys the widths as they are.
//! * **Absent on purpose:** objects that the hand cannot hold under the paper's rule: whoever leads a hand decides what it takes.

mod onset;
mod script;
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
use trial::{Trial, numb, run};

pub use script::Script;

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct ReflexPlan {
    /// Trials, dealt to the objects in turn.
    pub trials: u64,
    /// Number of the first seed of each object.
    pub first_seed: u64,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// The controller's settings.
    pub settings: atas_core::Settings,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ReflexReport {
    /// Always `reflex`.
    pub task: &'static str,
    /// Number of the first seed of each object.
    pub first_seed: u64,
    /// What figures over these seeds are good for: `tuning` or `judging`.
    pub purpose: &'static str,
    /// With the reflex.
    pub with: Side,
    /// Without it.
    pub without: Side,
    /// With the reflex: from the tick in which a fingertip begins to slide on what it carries to the first tick that commands
    /// it to press harder, ms.
    pub slip_to_command_ms: Latency,
}

/// One way of doing it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Side {
    /// How many there were.
    pub trials: u64,
    /// Share of those whose object was lifted, as it was taken, and in the hand at the end.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// How many objects were crushed.
    pub crushed: u64,
    /// What became of the others, and how often.
    pub failures: BTreeMap<String, u64>,
    /// The same with a policy that closes too weakly, and with one that closes too hard: trials, successes.
    pub weakly: [u64; 2],
    /// The same.
    pub hard: [u64; 2],
    /// Median over successes of the normal force in the end over the force needed; `null` without one.
    pub over_grip_median: Option<f64>,
}

/// How long it takes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Latency {
    /// Slips that were counted.
    pub count: u64,
    /// Slips during which F_2 forbade to press harder before anything was answered; not counted.
    pub at_f2: u64,
    /// Slips that stopped without an answer; counted with the time that they lasted.
    pub unanswered: u64,
    /// Half of them are answered by then, ms; `null` without a slip.
    pub p50: Option<f64>,
    /// 99 of 100, ms.
    pub p99: Option<f64>,
    /// All, ms.
    pub max: Option<f64>,
    /// 99 of 100 of these and of the slips at F_2 together, ms: those count until F_2 allowed an answer, or until they ended.
    pub p99_with_f2: Option<f64>,
}

impl ReflexPlan {
    /// Runs all trials; `done` is called after each, from any thread. `None` if `stop` was set meanwhile.
    ///
    /// # Errors
    /// If the robot or a world cannot be made.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<ReflexReport>> {
        anyhow::ensure!(
            self.trials > 0,
            "could not evaluate because there is no trial, needs at least one; ask for it with --trials"
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
                run(&robot, object, number, &numb(&self.settings))?,
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
        let side = |index: usize| Side::of(pairs.iter().map(|pair| &pair[index]));
        ReflexReport {
            task: "reflex",
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.trials.div_ceil(objects)),
            with: side(0),
            without: side(1),
            slip_to_command_ms: Latency::of(pairs.iter().map(|pair| &pair[0])),
        }
    }
}

impl Side {
    fn of<'a>(trials: impl Iterator<Item = &'a Trial> + Clone) -> Self {
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
    fn of<'a>(trials: impl Iterator<Item = &'a Trial> + Clone) -> Self {
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

/// The least of sorted values that this share of them does not exceed.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.max(1) - 1).copied()
}
