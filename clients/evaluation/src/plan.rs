//! What to evaluate, and how it is spread over threads.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use anyhow::Context;
use atas_core::Settings;
use rayon::prelude::*;
use robot_model::RobotModel;
use serde::Serialize;
use sim_backend::Object;

use crate::{GripPolicy, Record, Report, Task, trial};

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The task.
    pub task: Task,
    /// The nominal objects, or caps; each is the middle of a family.
    pub objects: Vec<Object>,
    /// Trials under each condition, dealt to the objects in turn.
    pub trials: u64,
    /// Number of the first trial of each object: other numbers are other members of the families.
    pub first_seed: u64,
    /// Under which conditions; the first is the one that the report is about, the others are its rows.
    pub conditions: Vec<Condition>,
    /// What to compare with, under the first condition.
    pub baselines: Vec<GripPolicy>,
    /// Threads; 0 for one per core.
    pub threads: usize,
    /// The controller's settings.
    pub settings: Settings,
}

/// How good the sensors are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Scale of the fingertip sensors' noise.
    pub noise: Noise,
    /// Frames per second of the fingertip sensors.
    pub rate_hz: u32,
}

/// A scale of noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Noise {
    /// The same in every trial.
    Scale(f64),
    /// Drawn for every trial from this range.
    Between([f64; 2]),
}

/// One trial of a plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Job {
    /// Index of the object.
    pub(super) object: usize,
    /// Number of the trial among those of its object.
    pub(super) number: u64,
    /// What governs the grip.
    pub(super) law: GripPolicy,
    /// Under which condition.
    pub(super) condition: Condition,
}

impl Plan {
    /// How many trials it has, with all conditions and baselines.
    #[must_use]
    pub fn jobs(&self) -> u64 {
        self.trials * self.series().len() as u64
    }

    /// Runs all trials; `done` is called after each, from any thread. `None` if `stop` was set meanwhile.
    ///
    /// # Errors
    /// If the robot or a world cannot be made, or there is nothing to do.
    pub fn run(&self, stop: &AtomicBool, done: impl Fn() + Sync) -> anyhow::Result<Option<Report>> {
        anyhow::ensure!(
            !self.objects.is_empty(),
            "could not evaluate because there is no object; name one with --objects"
        );
        anyhow::ensure!(
            !self.conditions.is_empty() && self.trials > 0,
            "could not evaluate because there is no trial, needs at least one; ask for it with --trials"
        );
        let robot =
            RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()?;
        let begin = Instant::now();
        let one = |job: Job| {
            if stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let record = trial::run(&robot, self, &job)?;
            done();
            Ok(Some(record))
        };
        let jobs = self.deal();
        let records: anyhow::Result<Vec<Option<Record>>> =
            pool.install(|| jobs.into_par_iter().with_max_len(1).map(one).collect());
        let wall_s = begin.elapsed().as_secs_f64();
        let records: Option<Vec<Record>> = records?.into_iter().collect();
        Ok(records.map(|records| Report::of(self, &self.sort(records), wall_s)))
    }

    /// Every law with its condition: ours under all of them, then the baselines under the first.
    pub(super) fn series(&self) -> Vec<(GripPolicy, Condition)> {
        let ours = self.conditions.iter().map(|c| (GripPolicy::Ours, *c));
        let first = self.conditions.first();
        let baselines = first.map(|c| self.baselines.iter().map(|law| (*law, *c)));
        ours.chain(baselines.into_iter().flatten()).collect()
    }

    /// Trial by trial, so that progress is even although some series take longer.
    fn deal(&self) -> Vec<Job> {
        let objects = self.objects.len();
        let series = self.series();
        let trial = |k: u64| {
            let object = (k % objects as u64) as usize;
            let number = self.first_seed + k / objects as u64;
            series.iter().map(move |(law, condition)| Job {
                object,
                number,
                law: *law,
                condition: *condition,
            })
        };
        (0..self.trials).flat_map(trial).collect()
    }

    /// The records as they were dealt, series by series.
    fn sort(&self, records: Vec<Record>) -> Vec<Vec<Record>> {
        let count = self.series().len();
        let mut series = vec![Vec::new(); count];
        for (index, record) in records.into_iter().enumerate() {
            series[index % count].push(record);
        }
        series
    }
}

impl Noise {
    /// The scale of one trial, from a number in 0 to 1 that was drawn for it.
    pub(super) fn at(self, share: f64) -> f64 {
        match self {
            Self::Scale(scale) => scale,
            Self::Between([low, high]) => low + (high - low) * share,
        }
    }
}
