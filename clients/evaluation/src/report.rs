//! The report of an evaluation: counts, ratios and their uncertainty, as people and programs read them.
//!
//! The names of the fields are a contract with scripts; there may be more of them, never fewer.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::condition::{Condition, Noise};
use crate::finding::Grasped;
use crate::judge::Outcome;
use crate::plan::Plan;
use crate::statistics::{deviation, median, wilson};
use crate::trial::Record;

/// What an evaluation found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The task.
    pub task: &'static str,
    /// Our modules under the first condition.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, of a grasp.
    #[serde(flatten)]
    pub physics: Option<Physics>,
    /// Success of each baseline on the same trials, by its name.
    pub baselines: BTreeMap<&'static str, f64>,
    /// Simulated seconds per second of one core's processor time, of our modules.
    pub realtime_factor: f64,
    /// How long the evaluation took, s.
    pub wall_s: f64,
    /// Trials of each object, rounded up.
    pub seeds: u64,
    /// Scale of the sensors' noise under the first condition.
    pub noise: Noise,
    /// Frames per second of the sensors under the first condition.
    pub rate_hz: u32,
    /// Errors under the first condition, by name.
    pub errors: String,
    /// The same per family of objects.
    pub families: Vec<Family>,
    /// Our modules under every condition.
    pub rows: Vec<Row>,
    /// More about the baselines.
    pub baseline_rows: Vec<Baseline>,
}

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
    pub medians: BTreeMap<&'static str, f64>,
    /// The largest of the same.
    pub largest: BTreeMap<&'static str, f64>,
}

/// Trials by what physics allows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Physics {
    /// Trials whose object can be held: see [`crate::judge::Load::is_feasible`].
    pub feasible: Feasible,
    /// All others.
    pub infeasible: Infeasible,
    /// How many of both lie so near to F_2 that either end would be right.
    pub borderline: u64,
    /// Median of the measured F_2 over the F_2 at the true stiffness.
    pub f2_ratio_median: Option<f64>,
    /// Standard deviation of the same.
    pub f2_ratio_deviation: Option<f64>,
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
    /// Its trials.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, of a grasp.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

/// One condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Scale of the sensors' noise.
    pub noise: Noise,
    /// Frames per second of the sensors.
    pub rate_hz: u32,
    /// Errors, by name.
    pub errors: String,
    /// Its trials.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, of a grasp.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

/// One baseline.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// Its name.
    pub baseline: &'static str,
    /// Its trials.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, of a grasp.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

impl Report {
    /// Counts the records of a plan, series by series. The order within a series does not matter.
    pub(super) fn of(plan: &Plan, series: &[Vec<Record>], wall_s: f64) -> Self {
        let (ours, theirs) = series.split_at(plan.conditions.len());
        let first: Vec<&Record> = ours[0].iter().collect();
        let Condition {
            noise,
            rate_hz,
            errors,
        } = &plan.conditions[0];
        let sum = |value: fn(&Record) -> f64| ours.iter().flatten().map(value).sum::<f64>();
        let rows = plan.conditions.iter().zip(ours);
        let baseline_rows: Vec<Baseline> = plan
            .baselines
            .iter()
            .zip(theirs)
            .map(|(law, records)| Baseline::of(law.name(), &records.iter().collect::<Vec<_>>()))
            .collect();
        let success = |row: &Baseline| (row.baseline, row.tally.success);
        Self {
            task: plan.task.name(),
            tally: Tally::of(&first),
            physics: Physics::of(&first),
            baselines: baseline_rows.iter().map(success).collect(),
            realtime_factor: sum(|r| r.simulated_s) / sum(|r| r.cpu_s),
            wall_s,
            seeds: plan.trials.div_ceil(plan.objects.len() as u64),
            noise: *noise,
            rate_hz: *rate_hz,
            errors: errors.name.clone(),
            families: (0..plan.objects.len())
                .map(|object| Family::of(plan, &first, object))
                .collect(),
            rows: rows.map(|(c, records)| Row::of(c, records)).collect(),
            baseline_rows,
        }
    }
}

impl Tally {
    fn of(records: &[&Record]) -> Self {
        let trials = records.len() as u64;
        let mut failures = BTreeMap::<String, u64>::new();
        let mut measures = BTreeMap::<&'static str, Vec<f64>>::new();
        for record in records {
            if let Some(key) = record.finding.failure() {
                *failures.entry(key.to_owned()).or_default() += 1;
                continue;
            }
            for (name, value) in record.finding.measures() {
                measures.entry(name).or_default().push(value);
            }
        }
        let successes = trials - failures.values().sum::<u64>();
        let largest = |values: &Vec<f64>| values.iter().copied().reduce(f64::max);
        Self {
            trials,
            success: successes as f64 / trials.max(1) as f64,
            ci95: wilson(successes, trials),
            failures,
            largest: of_each(&measures, largest),
            medians: of_each(&measures, |values| median(values.clone())),
        }
    }
}

fn of_each(
    measures: &BTreeMap<&'static str, Vec<f64>>,
    figure: impl Fn(&Vec<f64>) -> Option<f64>,
) -> BTreeMap<&'static str, f64> {
    let figures = measures
        .iter()
        .map(|(name, values)| (*name, figure(values)));
    figures.filter_map(|(name, f)| Some((name, f?))).collect()
}

impl Family {
    fn of(plan: &Plan, records: &[&Record], object: usize) -> Self {
        let own = records.iter().filter(|r| r.object == object);
        let own: Vec<&Record> = own.copied().collect();
        Self {
            object: plan.objects[object].name.clone(),
            tally: Tally::of(&own),
            physics: Physics::of(&own),
        }
    }
}

impl Row {
    fn of(condition: &Condition, records: &[Record]) -> Self {
        let records: Vec<&Record> = records.iter().collect();
        Self {
            noise: condition.noise,
            rate_hz: condition.rate_hz,
            errors: condition.errors.name.clone(),
            tally: Tally::of(&records),
            physics: Physics::of(&records),
        }
    }
}

impl Baseline {
    fn of(baseline: &'static str, records: &[&Record]) -> Self {
        Self {
            baseline,
            tally: Tally::of(records),
            physics: Physics::of(records),
        }
    }
}

impl Physics {
    /// `None` unless there are grasps.
    fn of(records: &[&Record]) -> Option<Self> {
        let grasps: Vec<&Grasped> = records.iter().filter_map(|r| r.finding.grasped()).collect();
        if grasps.is_empty() {
            return None;
        }
        let f2_ratios: Vec<f64> = grasps.iter().filter_map(|g| g.f2_ratio).collect();
        Some(Self {
            feasible: feasible(&grasps),
            infeasible: infeasible(&grasps),
            borderline: count(&grasps, |g| g.load.is_borderline()),
            f2_ratio_deviation: deviation(&f2_ratios),
            f2_ratio_median: median(f2_ratios),
        })
    }
}

fn feasible(grasps: &[&Grasped]) -> Feasible {
    let count_of = |outcome| count(grasps, |g| g.load.is_feasible() && g.outcome == outcome);
    let over_grips = grasps.iter().filter(|g| g.load.is_feasible());
    Feasible {
        trials: count(grasps, |g| g.load.is_feasible()),
        held: count_of(Outcome::Held),
        crushed: count_of(Outcome::Crushed),
        dropped: count_of(Outcome::Dropped),
        over_grip_median: median(over_grips.filter_map(|g| g.over_grip).collect()),
    }
}

fn infeasible(grasps: &[&Grasped]) -> Infeasible {
    let is = |g: &Grasped| !g.load.is_feasible();
    Infeasible {
        trials: count(grasps, is),
        refused: count(grasps, |g| {
            is(g) && matches!(g.outcome, Outcome::Refused(_))
        }),
        crushed: count(grasps, |g| is(g) && g.outcome == Outcome::Crushed),
    }
}

fn count(grasps: &[&Grasped], is: impl Fn(&Grasped) -> bool) -> u64 {
    grasps.iter().filter(|grasp| is(grasp)).count() as u64
}
