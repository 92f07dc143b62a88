//! Report of an evaluation: counts, ratios and confidence intervals.
//!
//! Scripts depend on the field names: never remove one.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::condition::{Condition, Noise};
use crate::physics::Physics;
use crate::plan::Plan;
use crate::policy::GripPolicy;
use crate::seeds;
use crate::tally::Tally;
use crate::trial::Record;

/// Result of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Task name.
    pub task: &'static str,
    /// Robot name, as given.
    pub robot: String,
    /// Fingertip layout, if not the robot file's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skin: Option<String>,
    /// Physics engine, if not the built-in one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine: Option<String>,
    /// ATAS modules under the first condition.
    #[serde(flatten)]
    pub tally: Tally,
    /// Counts by feasibility, if an object is held.
    #[serde(flatten)]
    pub physics: Option<Physics>,
    /// Success of each baseline on the same trials, by name.
    pub baselines: BTreeMap<&'static str, f64>,
    /// Simulated time over processor time, ATAS modules.
    pub realtime_factor: f64,
    /// Duration of the evaluation, s.
    pub wall_s: f64,
    /// Trials per object, rounded up.
    pub seeds: u64,
    /// First seed.
    pub first_seed: u64,
    /// `judging`, `tuning` or `tuning and judging`.
    pub seeds_for: &'static str,
    /// Noise scale under the first condition.
    pub noise: Noise,
    /// Sensor rate under the first condition, Hz.
    pub rate_hz: u32,
    /// Errors under the first condition, by name.
    pub errors: String,
    /// Sensor model, if not that of the design.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_model: Option<String>,
    /// Results per family of objects, first condition.
    pub families: Vec<Family>,
    /// ATAS modules under every condition.
    pub rows: Vec<Row>,
    /// Results of the baselines.
    pub baseline_rows: Vec<Baseline>,
}

/// Results of one family of objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Family {
    /// Name of the family's nominal object.
    pub object: String,
    /// Outcome counts.
    #[serde(flatten)]
    pub tally: Tally,
    /// Counts by feasibility, if an object is held.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

/// Results under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Noise scale.
    pub noise: Noise,
    /// Sensor rate, Hz.
    pub rate_hz: u32,
    /// Errors, by name.
    pub errors: String,
    /// Outcome counts.
    #[serde(flatten)]
    pub tally: Tally,
    /// Counts by feasibility, if an object is held.
    #[serde(flatten)]
    pub physics: Option<Physics>,
}

/// Results of one baseline under one condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// Name of the baseline.
    pub baseline: &'static str,
    /// Forces of the baseline, as text.
    pub setting: String,
    /// Condition and results.
    #[serde(flatten)]
    pub row: Row,
}

impl Report {
    /// Counts the records, per series in any order.
    pub(super) fn from_records(plan: &Plan, series: &[Vec<Record>], wall_s: f64) -> Self {
        let (ours, theirs) = series.split_at(plan.conditions.len());
        let first: Vec<&Record> = ours[0].iter().collect();
        let condition = &plan.conditions[0];
        let sum = |value: fn(&Record) -> f64| ours.iter().flatten().map(value).sum::<f64>();
        let named = plan.series();
        let baseline_rows: Vec<Baseline> = named[ours.len()..]
            .iter()
            .zip(theirs)
            .map(|(of, records)| Baseline::from_records(of, records))
            .collect();
        Self {
            task: plan.task.name(),
            robot: plan.robot.name.to_string(),
            skin: plan.skin.map(|skin| skin.to_string()),
            engine: plan.engine.as_ref().map(ToString::to_string),
            tally: Tally::from_records(&first),
            physics: Physics::from_records(&first),
            baselines: successes(&baseline_rows),
            realtime_factor: sum(|r| r.simulated_s) / sum(|r| r.cpu_s),
            wall_s,
            seeds: plan.seeds(),
            first_seed: plan.first_seed,
            seeds_for: seeds::purpose(plan.first_seed, plan.seeds()),
            noise: condition.noise,
            rate_hz: condition.rate_hz,
            errors: condition.errors.name.clone(),
            sensor_model: condition.sensor_model.as_ref().map(|of| of.name.clone()),
            families: (0..plan.objects.len())
                .map(|object| Family::from_records(plan, &first, object))
                .collect(),
            rows: plan
                .conditions
                .iter()
                .zip(ours)
                .map(Row::from_records)
                .collect(),
            baseline_rows,
        }
    }
}

fn successes(rows: &[Baseline]) -> BTreeMap<&'static str, f64> {
    let mut successes = BTreeMap::new();
    for of in rows {
        successes.entry(of.baseline).or_insert(of.row.tally.success);
    }
    successes
}

impl Family {
    fn from_records(plan: &Plan, records: &[&Record], object: usize) -> Self {
        let own = records.iter().filter(|r| r.object == object);
        let own: Vec<&Record> = own.copied().collect();
        Self {
            object: plan.objects[object].name.clone(),
            tally: Tally::from_records(&own),
            physics: Physics::from_records(&own),
        }
    }
}

impl Row {
    fn from_records((condition, records): (&Condition, &Vec<Record>)) -> Self {
        let records: Vec<&Record> = records.iter().collect();
        Self {
            noise: condition.noise,
            rate_hz: condition.rate_hz,
            errors: condition.errors.name.clone(),
            tally: Tally::from_records(&records),
            physics: Physics::from_records(&records),
        }
    }
}

impl Baseline {
    fn from_records((policy, condition): &(GripPolicy, Condition), records: &Vec<Record>) -> Self {
        Self {
            baseline: policy.name(),
            setting: policy.setting(),
            row: Row::from_records((condition, records)),
        }
    }
}
