//! How many trials went how, and what was measured in them.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::statistics::{median, wilson};
use crate::trial::Record;

/// How many trials went how.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tally {
    /// Trials in all.
    pub trials: u64,
    /// Share of them that are a success.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// How many are not, by what became of them.
    pub failures: BTreeMap<String, u64>,
    /// Medians of what was measured, over successes.
    pub medians: BTreeMap<String, f64>,
    /// The largest of the same.
    pub largest: BTreeMap<String, f64>,
}

impl Tally {
    pub(super) fn of(records: &[&Record]) -> Self {
        let trials = records.len() as u64;
        let mut failures = BTreeMap::<String, u64>::new();
        let mut measures = BTreeMap::<&str, Vec<f64>>::new();
        for record in records {
            if let Some(key) = record.failure() {
                *failures.entry(key.to_owned()).or_default() += 1;
                continue;
            }
            for (name, value) in &record.finding.measures {
                measures.entry(name).or_default().push(*value);
            }
        }
        let successes = trials - failures.values().sum::<u64>();
        let largest = |values: &Vec<f64>| values.iter().copied().reduce(f64::max);
        Self {
            trials,
            success: share(successes, trials),
            ci95: wilson(successes, trials),
            failures,
            largest: of_each(&measures, largest),
            medians: of_each(&measures, |values| median(values.clone())),
        }
    }
}

/// A share of so many; of none, 0.
pub(super) fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

fn of_each(
    measures: &BTreeMap<&str, Vec<f64>>,
    figure: impl Fn(&Vec<f64>) -> Option<f64>,
) -> BTreeMap<String, f64> {
    let figures = measures
        .iter()
        .map(|(name, values)| (*name, figure(values)));
    figures
        .filter_map(|(name, f)| Some((name.to_owned(), f?)))
        .collect()
}
