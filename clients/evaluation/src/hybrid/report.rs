//! Many trials, counted.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use atas_core::Settings;
use rayon::prelude::*;
use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::Object;
use sim_backend::course::{Cast, DriveFigures, Responses, Shake};

use super::pilot::Reflexes;
use super::trial::{HybridTrial, run};
use crate::seeds;
use crate::statistics::{median, wilson};

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct HybridPlan {
    /// Robots on each course, 1 or 2.
    pub robots: usize,
    /// Trials.
    pub trials: u64,
    /// Number of the first seed.
    pub first_seed: u64,
    /// The table of every base.
    pub table: Responses,
    /// Whether the hands feel on the way.
    pub reflexes: Reflexes,
    /// Objects, dealt in turn.
    pub objects: Vec<Object>,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// The controllers' settings.
    pub settings: Settings,
}

/// What became of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HybridReport {
    /// Always `hybrid`.
    pub task: &'static str,
    /// Robots on each course.
    pub robots: usize,
    /// Whether the hands felt on the way.
    pub reflexes: Reflexes,
    /// How many trials there were.
    pub trials: u64,
    /// Share of those in which every robot brought its object to its goal.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// What became of the others, and how often; of two robots what became of the first that failed.
    pub failures: BTreeMap<String, u64>,
    /// Their seeds.
    pub failed_seeds: Vec<u64>,
    /// Object by object: how many robots had it to fetch, and how many of these failed.
    pub objects: BTreeMap<String, [u64; 2]>,
    /// How the grip fared on the way.
    pub drive: DriveReport,
    /// Median simulated time, s.
    pub simulated_s: f64,
    /// Number of the first seed.
    pub first_seed: u64,
    /// What figures over these seeds are good for: `tuning` or `judging`.
    pub purpose: &'static str,
}

/// How the grip fared on all drives.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DriveReport {
    /// Drives that began.
    pub count: u64,
    /// Slip on the way, mm: median and most.
    pub slip_mm: [f64; 2],
    /// Drives on which the object slipped by more than 0.1 mm.
    pub slipped: u64,
    /// Most that the grip changed by, upwards and downwards, N: medians.
    pub grip_change_n: [f64; 2],
    /// The largest accelerations, medians.
    pub shake: Shake,
}

/// Stack of a thread that puts controllers and worlds together, which is done in place and moved: more than threads have by
/// themselves.
const STACK_BYTES: usize = 16 << 20;
/// Slip that counts as slipping, m (ours: several times the skin's creep).
const SLIPPED_M: f64 = 1e-4;

impl DriveReport {
    fn of(drives: &[DriveFigures]) -> Self {
        let of = |value: &dyn Fn(&DriveFigures) -> f64| -> Vec<f64> {
            drives.iter().map(value).collect()
        };
        let middle = |value: &dyn Fn(&DriveFigures) -> f64| median(of(value)).unwrap_or(0.0);
        let slips_mm = of(&|drive| drive.slip_m * 1e3);
        Self {
            count: drives.len() as u64,
            slip_mm: [
                middle(&|drive| drive.slip_m * 1e3),
                slips_mm.iter().copied().fold(0.0, f64::max),
            ],
            slipped: drives.iter().filter(|d| d.slip_m > SLIPPED_M).count() as u64,
            grip_change_n: [
                middle(&|drive| drive.most_n - drive.began_n),
                middle(&|drive| drive.began_n - drive.least_n),
            ],
            shake: Shake {
                horizontal_m_s2: middle(&|drive| drive.shake.horizontal_m_s2),
                vertical_m_s2: middle(&|drive| drive.shake.vertical_m_s2),
            },
        }
    }
}

impl HybridPlan {
    /// Runs all trials; `done` is called after each, from any thread. `None` if `stop` was set meanwhile.
    ///
    /// # Errors
    /// There is nothing to do, or a robot, a course or a world cannot be made.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<(HybridReport, Vec<HybridTrial>)>> {
        anyhow::ensure!(
            self.trials > 0 && !self.objects.is_empty(),
            "could not evaluate because there is no trial, needs one and an object; ask for it with --seeds"
        );
        let model =
            RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .stack_size(STACK_BYTES)
            .build()?;
        let one = |k: u64| -> anyhow::Result<Option<HybridTrial>> {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let trial = self.trial(&model, k, |_, _, _| ())?;
            done();
            Ok(Some(trial))
        };
        let numbers: Vec<u64> = (0..self.trials).collect();
        let trials: anyhow::Result<Vec<Option<HybridTrial>>> =
            pool.install(|| numbers.into_par_iter().with_max_len(1).map(one).collect());
        let trials: Option<Vec<HybridTrial>> = trials?.into_iter().collect();
        Ok(trials.map(|trials| (self.report(&trials), trials)))
    }

    /// Trial `k` of the plan; `watch` hears of every phase that a robot begins: its index, the phase, the time in seconds.
    ///
    /// # Errors
    /// A course or a world cannot be made.
    pub fn trial(
        &self,
        model: &RobotModel,
        k: u64,
        watch: impl FnMut(usize, &'static str, f64),
    ) -> anyhow::Result<HybridTrial> {
        let number = self.first_seed + k;
        let count = self.objects.len();
        let dealt = |robot: usize| self.objects[(k as usize + robot) % count].clone();
        let objects: Vec<Object> = (0..self.robots).map(dealt).collect();
        let cast = Cast::drawn(number, &objects)?;
        let how = (number, self.reflexes);
        run(model, &cast, self.table, how, &self.settings, watch)
    }

    /// The trials, counted.
    #[must_use]
    pub fn report(&self, trials: &[HybridTrial]) -> HybridReport {
        let mut failures = BTreeMap::new();
        let failed = || trials.iter().filter(|trial| trial.failure().is_some());
        for failure in failed().filter_map(HybridTrial::failure) {
            *failures.entry(failure.to_owned()).or_default() += 1;
        }
        let all = trials.len() as u64;
        let successes = all - failed().count() as u64;
        let robots = || trials.iter().flat_map(|trial| &trial.robots);
        let drives: Vec<DriveFigures> = robots().filter_map(|robot| robot.drive).collect();
        let mut objects = BTreeMap::new();
        for robot in robots() {
            let [fetched, lost]: &mut [u64; 2] = objects.entry(robot.object.clone()).or_default();
            *fetched += 1;
            *lost += u64::from(robot.failure.is_some());
        }
        let times: Vec<f64> = trials.iter().map(|trial| trial.simulated_s).collect();
        HybridReport {
            task: "hybrid",
            robots: self.robots,
            reflexes: self.reflexes,
            trials: all,
            success: successes as f64 / all.max(1) as f64,
            ci95: wilson(successes, all),
            failures,
            failed_seeds: failed().map(|trial| trial.seed).collect(),
            objects,
            drive: DriveReport::of(&drives),
            simulated_s: median(times).unwrap_or(0.0),
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.trials),
        }
    }
}
