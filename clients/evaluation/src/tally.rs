//! Counts of trial outcomes, and statistics of their measured quantities.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::judge::HiddenMotion;
use crate::statistics::{median, wilson};
use crate::trial::Record;

/// Outcome counts of a group of trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tally {
    /// Trials.
    pub trials: u64,
    /// Share of successful trials.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
    /// Number of failures by outcome key.
    pub failures: BTreeMap<String, u64>,
    /// Trials reported as success although an object slid more than 3 mm in the hand.
    pub hidden_slides: u64,
    /// Trials reported as success although an object turned more than 10° in the hand.
    pub hidden_turns: u64,
    /// Median of each measured quantity, over successes.
    pub medians: BTreeMap<String, f64>,
    /// Maximum of each measured quantity, over successes.
    pub largest: BTreeMap<String, f64>,
}

impl Tally {
    pub(super) fn from_records(records: &[&Record]) -> Self {
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
        let hidden = |is: fn(&HiddenMotion) -> bool| {
            let found = records.iter().filter(|record| is(&record.finding.hidden));
            found.count() as u64
        };
        let successes = trials - failures.values().sum::<u64>();
        let largest = |values: &Vec<f64>| values.iter().copied().reduce(f64::max);
        Self {
            trials,
            success: share(successes, trials),
            ci95: wilson(successes, trials),
            failures,
            hidden_slides: hidden(|hidden| hidden.slid),
            hidden_turns: hidden(|hidden| hidden.turned),
            largest: map_values(&measures, largest),
            medians: map_values(&measures, |values| median(values.clone())),
        }
    }
}

pub(super) fn share(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

fn map_values(
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
