//! The report of an evaluation: counts, ratios and their uncertainty, as people and programs read them.
//!
//! The first seven fields are a contract with scripts; further fields only ever come after them.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Plan, Record};
use crate::judge::Outcome;

/// Two-sided 95 % quantile of the normal distribution.
const Z_95: f64 = 1.959_963_984_540_054;

/// What an evaluation found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The task.
    pub task: &'static str,
    /// Trials in all.
    pub trials: u64,
    /// Trials whose object can be held, by physics: see [`crate::judge::Load::is_feasible`].
    pub feasible: Feasible,
    /// All other trials.
    pub infeasible: Infeasible,
    /// Simulated seconds per second of one core's processor time.
    pub realtime_factor: f64,
    /// How long the evaluation took, s.
    pub wall_s: f64,
    /// Share of trials that ended as physics says they should.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// How many trials ended otherwise, by what became of them.
    pub failures: BTreeMap<String, u64>,
    /// How many trials, among those counted above, lie so near to F_2 that either end would be right.
    pub borderline: u64,
    /// Trials of each object.
    pub seeds: u64,
    /// Scale of the sensors' noise.
    pub noise: f64,
    /// Frames per second of the sensors.
    pub rate_hz: u32,
    /// The same per family of objects.
    pub families: Vec<Family>,
}

/// Trials whose object can be held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Feasible {
    /// How many there were.
    pub trials: u64,
    /// Lifted, in the hand after the hold, neither crushed nor dropped.
    pub held: u64,
    /// Crushed.
    pub crushed: u64,
    /// Dropped.
    pub dropped: u64,
    /// Median over held trials of true normal force over needed force; `null` if none was held.
    pub over_grip_median: Option<f64>,
}

/// Trials whose object cannot be held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Infeasible {
    /// How many there were.
    pub trials: u64,
    /// Put back unharmed.
    pub refused: u64,
    /// Crushed.
    pub crushed: u64,
}

/// One family of objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Family {
    /// Name of the object in its middle.
    pub object: String,
    /// Its trials that can be held.
    pub feasible: Feasible,
    /// Its other trials.
    pub infeasible: Infeasible,
    /// Median of the measured F_2 over the F_2 at the true stiffness.
    pub f2_ratio_median: Option<f64>,
    /// Standard deviation of the same.
    pub f2_ratio_deviation: Option<f64>,
    /// Median slip of held objects, mm.
    pub slip_median_mm: Option<f64>,
    /// How many trials ended otherwise than physics says they should.
    pub failures: BTreeMap<String, u64>,
}

impl Report {
    /// Counts the records of a plan. Their order does not matter.
    #[must_use]
    pub fn of(plan: &Plan, records: &[Record], wall_s: f64) -> Self {
        let trials = records.len() as u64;
        let failures = failures(records);
        let successes = trials - failures.values().sum::<u64>();
        let sum = |value: fn(&Record) -> f64| records.iter().map(value).sum::<f64>();
        Self {
            task: "grasp",
            trials,
            feasible: feasible(records),
            infeasible: infeasible(records),
            realtime_factor: sum(|r| r.simulated_s) / sum(|r| r.cpu_s),
            wall_s,
            success: successes as f64 / trials as f64,
            ci95: wilson(successes, trials),
            failures,
            borderline: count(records, |r| r.load.is_borderline()),
            seeds: plan.seeds,
            noise: plan.noise,
            rate_hz: plan.rate_hz,
            families: (0..plan.objects.len())
                .map(|index| family(plan, records, index))
                .collect(),
        }
    }
}

fn family(plan: &Plan, records: &[Record], index: usize) -> Family {
    let records: Vec<Record> = records
        .iter()
        .filter(|record| record.object == index)
        .copied()
        .collect();
    let f2_ratios: Vec<f64> = records.iter().filter_map(|r| r.f2_ratio).collect();
    Family {
        object: plan.objects[index].name.clone(),
        feasible: feasible(&records),
        infeasible: infeasible(&records),
        f2_ratio_deviation: deviation(&f2_ratios),
        f2_ratio_median: median(f2_ratios),
        slip_median_mm: median(
            records
                .iter()
                .filter_map(|r| r.slip_m)
                .map(|slip_m| slip_m * 1e3)
                .collect(),
        ),
        failures: failures(&records),
    }
}

fn feasible(records: &[Record]) -> Feasible {
    let count_of = |outcome| count(records, |r| r.load.is_feasible() && r.outcome == outcome);
    let over_grips = records.iter().filter(|r| r.load.is_feasible());
    Feasible {
        trials: count(records, |r| r.load.is_feasible()),
        held: count_of(Outcome::Held),
        crushed: count_of(Outcome::Crushed),
        dropped: count_of(Outcome::Dropped),
        over_grip_median: median(over_grips.filter_map(|r| r.over_grip).collect()),
    }
}

fn infeasible(records: &[Record]) -> Infeasible {
    let is = |r: &Record| !r.load.is_feasible();
    Infeasible {
        trials: count(records, is),
        refused: count(records, |r| {
            is(r) && matches!(r.outcome, Outcome::Refused(_))
        }),
        crushed: count(records, |r| is(r) && r.outcome == Outcome::Crushed),
    }
}

fn failures(records: &[Record]) -> BTreeMap<String, u64> {
    let mut failures = BTreeMap::new();
    let unexpected = |r: &&Record| !r.outcome.is_expected(r.load.is_feasible());
    for record in records.iter().filter(unexpected) {
        *failures
            .entry(record.outcome.key(record.step.as_str()))
            .or_default() += 1;
    }
    failures
}

fn count(records: &[Record], is: impl Fn(&Record) -> bool) -> u64 {
    records.iter().filter(|record| is(record)).count() as u64
}

/// The middle value, or the mean of the two in the middle.
fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = values.len() / 2;
    match values.len() {
        0 => None,
        odd if odd % 2 == 1 => Some(values[upper]),
        _ => Some((values[upper - 1] + values[upper]) / 2.0),
    }
}

/// Standard deviation of a sample; `None` below two values.
fn deviation(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((squares / (count - 1.0)).sqrt())
}

/// Wilson score interval of a share, 95 % (Wilson 1927). Of nothing, everything is possible.
#[must_use]
pub fn wilson(successes: u64, trials: u64) -> [f64; 2] {
    if trials == 0 {
        return [0.0, 1.0];
    }
    let (n, p) = (trials as f64, successes as f64 / trials as f64);
    let z2 = Z_95 * Z_95;
    let centre = p + z2 / (2.0 * n);
    let half = Z_95 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt();
    let scale = 1.0 / (1.0 + z2 / n);
    [
        ((centre - half) * scale).max(0.0),
        ((centre + half) * scale).min(1.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilson_intervals() {
        let check = |successes, trials, expected: [f64; 2]| {
            let interval = wilson(successes, trials);
            let near = |side: usize| (interval[side] - expected[side]).abs() < 1e-4;
            assert!(near(0) && near(1), "{successes}/{trials}: {interval:?}");
        };
        // Values from R's binom::binom.confint(method = "wilson").
        check(0, 0, [0.0, 1.0]);
        check(0, 10, [0.0, 0.2775]);
        check(10, 10, [0.7225, 1.0]);
        check(5, 10, [0.2366, 0.7634]);
        check(599, 600, [0.9906, 0.9997]);
    }

    #[test]
    fn medians_and_deviations() {
        let check = |values: &[f64], expected_median, expected_deviation: Option<f64>| {
            assert_eq!(median(values.to_vec()), expected_median, "{values:?}");
            assert_eq!(deviation(values), expected_deviation, "{values:?}");
        };
        check(&[], None, None);
        check(&[3.0], Some(3.0), None);
        check(&[3.0, 1.0], Some(2.0), Some(2.0_f64.sqrt()));
        check(&[3.0, 1.0, 2.0], Some(2.0), Some(1.0));
    }
}
