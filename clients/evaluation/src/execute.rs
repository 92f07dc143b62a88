//! A plan on all cores: every trial once, the records in the order of the plan.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use crate::plan::{Job, Plan};
use crate::report::Report;
use crate::rows::TrialRow;
use crate::trial::{self, Record};

/// What became of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluated {
    /// Counted.
    pub report: Report,
    /// Trial by trial, series by series.
    pub rows: Vec<Vec<TrialRow>>,
}

impl Plan {
    /// Runs all trials; `done` is called after each, from any thread. `None` if `stop` was set meanwhile.
    ///
    /// # Errors
    /// If the robot or a world cannot be made, or there is nothing to do.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<Evaluated>> {
        anyhow::ensure!(
            !self.objects.is_empty(),
            "could not evaluate because there is no object; name one with --objects"
        );
        anyhow::ensure!(
            !self.conditions.is_empty() && self.trials > 0,
            "could not evaluate because there is no trial, needs at least one; ask for it with --trials"
        );
        let robot = self.robot.load()?;
        self.task.check(&robot)?;
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
        Ok(records.map(|records| self.evaluated(&self.sort(records), wall_s)))
    }

    fn evaluated(&self, series: &[Vec<Record>], wall_s: f64) -> Evaluated {
        let named = self.series();
        let row = |(of, records): (&_, &Vec<Record>)| {
            let rows = records.iter().map(|record| TrialRow::of(self, of, record));
            rows.collect()
        };
        Evaluated {
            report: Report::of(self, series, wall_s),
            rows: named.iter().zip(series).map(row).collect(),
        }
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
