//! Machine-readable summary of an experiment.

use std::path::Path;

use serde::Serialize;

use field::FitnessRule;

use crate::analysis::Findings;
use crate::error::{Error, Result};
use crate::experiment::Plan;
use crate::files::write_atomically;
use crate::run::Record;
use crate::stats::{Estimate, mean, quantile, sorted};

/// Numbers of Fig. 14. `wall_s` and `cpu_s` refer to the process that prints them.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the preset.
    pub preset: String,
    /// Scoring of the runs.
    pub fitness_rule: FitnessRule,
    /// Smallest number of finished runs of a condition.
    pub seeds: usize,
    /// Generations per run.
    pub generations: u32,
    /// Elapsed time, s.
    pub wall_s: f64,
    /// CPU time of all processors, s.
    pub cpu_s: f64,
    /// One per team size.
    pub conditions: Vec<ConditionSummary>,
    /// Probabilities of the paper's orderings between two runs.
    pub p_order: OrderSummary,
}

/// Best fitness at the last generation over the runs of one team size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names are self-explanatory")]
pub struct ConditionSummary {
    pub agents: usize,
    pub q1: f32,
    pub median: f32,
    pub q3: f32,
    pub mean: f32,
}

/// Probabilities of orderings, see [`crate::analysis::Order`]; null without runs of these team
/// sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "documented at their estimates")]
pub struct OrderSummary {
    pub three_gt_four: Option<f64>,
    pub two_gt_four: Option<f64>,
    pub three_gt_two: Option<f64>,
    pub multi_ge_5x_single: Option<f64>,
}

impl Summary {
    /// Summarises the finished runs.
    #[must_use]
    pub fn new(
        plan: &Plan,
        records: &[Record],
        findings: &Findings,
        wall_s: f64,
        cpu_s: f64,
    ) -> Self {
        let order = &findings.order;
        let value = |estimate: Option<Estimate>| estimate.map(|estimate| estimate.value);
        let of = |agents: usize| records.iter().filter(move |record| record.agents == agents);
        let condition = |&agents: &usize| {
            let fitness = sorted(&of(agents).map(Record::fitness).collect::<Vec<_>>());
            let at = |q| quantile(&fitness, q);
            ConditionSummary {
                agents,
                q1: at(0.25),
                median: at(0.5),
                q3: at(0.75),
                mean: mean(&fitness),
            }
        };
        Self {
            preset: plan.preset.name.to_string(),
            fitness_rule: plan.fitness_rule,
            seeds: plan
                .agents
                .iter()
                .map(|&agents| of(agents).count())
                .min()
                .unwrap_or(0),
            generations: plan.generations,
            wall_s,
            cpu_s,
            conditions: plan.agents.iter().map(condition).collect(),
            p_order: OrderSummary {
                three_gt_four: value(order.three_gt_four),
                two_gt_four: value(order.two_gt_four),
                three_gt_two: value(order.three_gt_two),
                multi_ge_5x_single: value(order.multi_ge_5x_single),
            },
        }
    }
}

pub(super) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let json = serde_json::to_string_pretty(value).map_err(Error::from_part)?;
    write_atomically(path, json.as_bytes())
}

/// Writes `summary.json`.
pub fn write_summary(folder: &Path, summary: &Summary) -> Result<()> {
    write_json(&folder.join("summary.json"), summary)
}
