//! Runs a plan on all cores: each trial once, records in the order of the plan.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use parking_lot::Mutex;
use rayon::prelude::*;
use sim_backend::engine::EnginePool;
use sim_backend::{World, simulated_skin};

use crate::parts::{self, Part};
use crate::plan::{Job, Plan, Shard};
use crate::report::Report;
use crate::rows::TrialRow;
use crate::sensor_variant::SensorVariant;
use crate::trial::{self, Laboratory, Record, VariantTrial};

/// Result of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluated {
    /// Counts and statistics.
    pub report: Report,
    /// One row per trial, grouped by series.
    pub rows: Vec<Vec<TrialRow>>,
}

impl Plan {
    /// Runs all trials; calls `done` after each, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// The robot or a world cannot be created, or the plan is empty.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<Evaluated>> {
        let begin = Instant::now();
        let records = self.run_trials(
            |_| true,
            stop,
            |_, _| {
                done();
                Ok(())
            },
        )?;
        let wall_s = begin.elapsed().as_secs_f64();
        Ok(records.map(|records| self.evaluated(&self.sort(records), wall_s)))
    }

    /// Runs the unfinished trials of one shard into its part file; `None` if stopped.
    ///
    /// # Errors
    /// As [`Plan::run`], or the file cannot be written.
    pub fn run_shard(
        &self,
        shard: Shard,
        part: Part,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<()>> {
        let ended = part.ended().clone();
        let part = Mutex::new(part);
        let open = |index: usize| shard.contains(index) && !ended.contains(&index);
        let records = self.run_trials(open, stop, |index, record| {
            done();
            part.lock().add(index, record)
        })?;
        Ok(records.map(drop))
    }

    /// Merges all shards; the report's duration is their total processor time.
    ///
    /// # Errors
    /// A part is unreadable, foreign, missing, duplicate or incomplete.
    pub fn merge(&self, parts: &[impl AsRef<Path>]) -> anyhow::Result<Evaluated> {
        let records = parts::gather(self, parts)?;
        let wall_s = records.iter().map(|record| record.cpu_s).sum();
        Ok(self.evaluated(&self.sort(records), wall_s))
    }

    /// Runs each trial of the ATAS modules once per sensor variant from `make_variants`, in the
    /// plan's order; `None` if stopped.
    ///
    /// # Errors
    /// As [`Plan::run`], or `make_variants` fails.
    pub fn run_variants<T: Send>(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
        make_variants: impl Fn(&World, u64) -> anyhow::Result<(Vec<SensorVariant>, T)> + Sync,
    ) -> anyhow::Result<Option<Vec<VariantTrial<T>>>> {
        self.run_jobs(
            |_| true,
            stop,
            |laboratory, _, job| {
                let records = trial::run_variants(laboratory, self, job, &make_variants)?;
                done();
                Ok(records)
            },
        )
    }

    /// Runs the `wanted` trials; calls `ended` after each, from any thread.
    fn run_trials(
        &self,
        wanted: impl Fn(usize) -> bool,
        stop: &AtomicBool,
        ended: impl Fn(usize, &Record) -> anyhow::Result<()> + Sync,
    ) -> anyhow::Result<Option<Vec<Record>>> {
        self.run_jobs(wanted, stop, |laboratory, index, job| {
            let record = trial::run(laboratory, self, job)?;
            ended(index, &record)?;
            Ok(record)
        })
    }

    /// Runs the `wanted` jobs; results keep the plan's order.
    fn run_jobs<T: Send>(
        &self,
        wanted: impl Fn(usize) -> bool,
        stop: &AtomicBool,
        run: impl Fn(&Laboratory, usize, &Job) -> anyhow::Result<T> + Sync,
    ) -> anyhow::Result<Option<Vec<T>>> {
        anyhow::ensure!(
            !self.objects.is_empty(),
            "could not evaluate: the plan has no object; add one with --objects"
        );
        anyhow::ensure!(
            !self.conditions.is_empty() && self.trials > 0,
            "could not evaluate: the plan has no trial; request at least one with --trials"
        );
        let robot = self.robot.load()?;
        let robot = match self.skin {
            Some(layout) => robot.with_skin(simulated_skin(layout)),
            None => robot,
        };
        self.task.check(&robot)?;
        let laboratory = Laboratory {
            robot,
            engines: self.engine.clone().map(EnginePool::new),
        };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads)
            .build()?;
        let one = |(index, job): (usize, Job)| {
            let stopped = stop.load(Ordering::Relaxed);
            (!stopped)
                .then(|| run(&laboratory, index, &job))
                .transpose()
        };
        let jobs = self.deal().into_iter().enumerate();
        let jobs: Vec<_> = jobs.filter(|(index, _)| wanted(*index)).collect();
        let ended: anyhow::Result<Vec<Option<T>>> =
            pool.install(|| jobs.into_par_iter().with_max_len(1).map(one).collect());
        Ok(ended?.into_iter().collect())
    }

    fn evaluated(&self, series: &[Vec<Record>], wall_s: f64) -> Evaluated {
        let named = self.series();
        let row = |(of, records): (&_, &Vec<Record>)| {
            let rows = records
                .iter()
                .map(|record| TrialRow::from_record(self, of, record));
            rows.collect()
        };
        Evaluated {
            report: Report::from_records(self, series, wall_s),
            rows: named.iter().zip(series).map(row).collect(),
        }
    }

    fn sort(&self, records: Vec<Record>) -> Vec<Vec<Record>> {
        let count = self.series().len();
        let mut series = vec![Vec::new(); count];
        for (index, record) in records.into_iter().enumerate() {
            series[index % count].push(record);
        }
        series
    }
}
