//! Plan and report of a hybrid evaluation.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;
use atas_core::Settings;
use rayon::prelude::*;
use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::Object;
use sim_backend::course::{BaseAcceleration, DriveFigures, Responses, Scenario};

use super::pilot::Reflexes;
use super::trial::{HybridTrial, run};
use crate::seeds;
use crate::statistics::{median, wilson};

/// Plan of a hybrid evaluation.
#[derive(Clone, Debug)]
pub struct HybridPlan {
    /// Robots per course, 1 or 2.
    pub robots: usize,
    /// Trials.
    pub trials: u64,
    /// First seed.
    pub first_seed: u64,
    /// Behaviour table of every base.
    pub table: Responses,
    /// Reflex modules during the drive.
    pub reflexes: Reflexes,
    /// Objects, distributed in turn.
    pub objects: Vec<Object>,
    /// Threads; 0: one per core.
    pub threads: usize,
    /// Controller settings.
    pub settings: Settings,
}

/// Result of a hybrid evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HybridReport {
    /// Always `hybrid`.
    pub task: &'static str,
    /// Robots per course.
    pub robots: usize,
    /// Reflex modules during the drive.
    pub reflexes: Reflexes,
    /// Trials.
    pub trials: u64,
    /// Share of trials in which every robot succeeded.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
    /// Failed trials by key of the first failed robot.
    pub failures: BTreeMap<String, u64>,
    /// Seeds of the failed trials.
    pub failed_seeds: Vec<u64>,
    /// Number of robots and of failures per object.
    pub objects: BTreeMap<String, [u64; 2]>,
    /// Grip statistics of all drives.
    pub drive: DriveReport,
    /// Median simulated time, s.
    pub simulated_s: f64,
    /// First seed.
    pub first_seed: u64,
    /// `tuning` or `judging`.
    pub purpose: &'static str,
}

/// Grip statistics of all drives.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DriveReport {
    /// Number of drives.
    pub count: u64,
    /// Slip during a drive, mm: median and maximum.
    pub slip_mm: [f64; 2],
    /// Drives with a slip above 0.1 mm.
    pub slipped: u64,
    /// Medians of the largest increase and decrease of the grip, N.
    pub grip_change_n: [f64; 2],
    /// Medians of the largest accelerations.
    pub shake: BaseAcceleration,
}

/// Stack of a thread: controllers and worlds, built in place, exceed the default.
const STACK_BYTES: usize = 16 << 20;
/// Slip above which a drive counts as slipped, m. Design choice: several times the skin's creep.
const SLIP_MIN_M: f64 = 1e-4;

impl DriveReport {
    fn from_drives(drives: &[DriveFigures]) -> Self {
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
            slipped: drives.iter().filter(|d| d.slip_m > SLIP_MIN_M).count() as u64,
            grip_change_n: [
                middle(&|drive| drive.most_n - drive.began_n),
                middle(&|drive| drive.began_n - drive.least_n),
            ],
            shake: BaseAcceleration {
                horizontal_m_s2: middle(&|drive| drive.shake.horizontal_m_s2),
                vertical_m_s2: middle(&|drive| drive.shake.vertical_m_s2),
            },
        }
    }
}

impl HybridPlan {
    /// Runs all trials; calls `done` after each, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The plan is empty, or a robot, course or world cannot be created.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<(HybridReport, Vec<HybridTrial>)>> {
        anyhow::ensure!(
            self.trials > 0 && !self.objects.is_empty(),
            "could not evaluate: the plan has no trial or no object; request trials with --seeds"
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

    /// Runs trial `k`; calls `watch` when a phase begins: robot index, phase, time (s).
    ///
    /// # Errors
    /// A course or world cannot be created.
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
        let cast = Scenario::random(number, &objects)?;
        let how = (number, self.reflexes);
        run(model, &cast, self.table, how, &self.settings, watch)
    }

    /// Counts the trials.
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
            drive: DriveReport::from_drives(&drives),
            simulated_s: median(times).unwrap_or(0.0),
            first_seed: self.first_seed,
            purpose: seeds::purpose(self.first_seed, self.trials),
        }
    }
}
