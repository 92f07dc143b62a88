//! The report of an evaluation: counts, ratios and their uncertainty, as people and programs read them.
//!
//! The names of the fields are a contract with scripts; there may be more of them, never fewer.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::condition::{Condition, Noise};
use crate::physics::Physics;
use crate::plan::Plan;
use crate::policy::GripPolicy;
use crate::seeds;
use crate::tally::Tally;
use crate::trial::Record;

/// What an evaluation found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// The task.
    pub task: &'static str,
    /// The robot, as it was named.
    pub robot: String,
    /// Its fingertips' layout, if it is another than the robot file's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin: Option<String>,
    /// Our modules under the first condition.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, where something is to be held.
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
    /// The first seed.
    pub first_seed: u64,
    /// What these seeds are good for: `judging`, or `tuning`.
    pub seeds_for: &'static str,
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

/// One family of objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Family {
    /// Name of the object in its middle.
    pub object: String,
    /// Its trials.
    #[serde(flatten)]
    pub tally: Tally,
    /// What physics allows, where something is to be held.
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
    /// What physics allows, where something is to be held.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

/// One baseline under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// Its name.
    pub baseline: &'static str,
    /// Its forces, in words.
    pub setting: String,
    /// Condition and trials.
    #[serde(flatten)]
    pub row: Row,
}

impl Report {
    /// Counts the records of a plan, series by series. The order within a series does not matter.
    pub(super) fn of(plan: &Plan, series: &[Vec<Record>], wall_s: f64) -> Self {
        let (ours, theirs) = series.split_at(plan.conditions.len());
        let first: Vec<&Record> = ours[0].iter().collect();
        let condition = &plan.conditions[0];
        let sum = |value: fn(&Record) -> f64| ours.iter().flatten().map(value).sum::<f64>();
        let named = plan.series();
        let baseline_rows: Vec<Baseline> = named[ours.len()..]
            .iter()
            .zip(theirs)
            .map(|(of, records)| Baseline::of(of, records))
            .collect();
        Self {
            task: plan.task.name(),
            robot: plan.robot.name.to_string(),
            skin: plan.skin.map(|skin| skin.to_string()),
            tally: Tally::of(&first),
            physics: Physics::of(&first),
            baselines: successes(&baseline_rows),
            realtime_factor: sum(|r| r.simulated_s) / sum(|r| r.cpu_s),
            wall_s,
            seeds: plan.seeds(),
            first_seed: plan.first_seed,
            seeds_for: seeds::purpose(plan.first_seed, plan.seeds()),
            noise: condition.noise,
            rate_hz: condition.rate_hz,
            errors: condition.errors.name.clone(),
            families: (0..plan.objects.len())
                .map(|object| Family::of(plan, &first, object))
                .collect(),
            rows: plan.conditions.iter().zip(ours).map(Row::of).collect(),
            baseline_rows,
        }
    }
}

/// The first row of each baseline.
fn successes(rows: &[Baseline]) -> BTreeMap<&'static str, f64> {
    let mut successes = BTreeMap::new();
    for of in rows {
        successes.entry(of.baseline).or_insert(of.row.tally.success);
    }
    successes
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
    fn of((condition, records): (&Condition, &Vec<Record>)) -> Self {
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
    fn of((policy, condition): &(GripPolicy, Condition), records: &Vec<Record>) -> Self {
        Self {
            baseline: policy.name(),
            setting: policy.setting(),
            row: Row::of((condition, records)),
        }
    }
}
