//! What an experiment comes to, in the form that programs read, and the files derived from it.

use std::path::Path;

use serde::Serialize;

use super::plan::Plan;
use crate::analysis::Findings;
use crate::error::{Error, Result};
use crate::files::write_atomically;
use crate::run::Record;
use crate::stats::{mean, quantile, sorted};
use crate::table_file::TableFile;

/// The numbers of Fig. 14. `wall_s` and `cpu_s` are those of the process that prints it.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the preset.
    pub preset: String,
    /// Finished runs per condition, the fewest.
    pub seeds: usize,
    /// Generations per run.
    pub generations: u32,
    /// Elapsed time.
    pub wall_s: f64,
    /// Time on all processors.
    pub cpu_s: f64,
    /// One per team size.
    pub conditions: Vec<ConditionSummary>,
    /// Probabilities of the paper's orderings between two runs.
    pub p_order: OrderSummary,
}

/// Best fitness at the last generation over the runs of one team size.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "the names say it")]
pub struct ConditionSummary {
    pub agents: usize,
    pub q1: f32,
    pub median: f32,
    pub q3: f32,
    pub mean: f32,
}

/// See [`crate::analysis::Order`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "documented where they are estimated")]
pub struct OrderSummary {
    pub three_gt_four: f64,
    pub two_gt_four: f64,
    pub three_gt_two: f64,
    pub multi_ge_5x_single: f64,
}

impl Summary {
    /// Sums up the finished runs.
    #[must_use]
    pub fn new(
        plan: &Plan,
        records: &[Record],
        findings: &Findings,
        wall_s: f64,
        cpu_s: f64,
    ) -> Self {
        let order = &findings.order;
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
                three_gt_four: order.three_gt_four.value,
                two_gt_four: order.two_gt_four.value,
                three_gt_two: order.three_gt_two.value,
                multi_ge_5x_single: order.multi_ge_5x_single.value,
            },
        }
    }
}

/// Generations between two rows of `curves.csv`; the first ones, where most happens, are all there.
const CURVE_STEP: u32 = 10;

/// Writes `findings.json`, `runs.csv`, `curves.csv` and the best table of every team size. The same runs give the same bytes.
///
/// # Errors
/// The system refused.
pub fn write_results(
    folder: &Path,
    plan: &Plan,
    records: &[Record],
    findings: &Findings,
) -> Result<()> {
    let json = serde_json::to_string_pretty(findings).map_err(Error::from_part)?;
    write_atomically(&folder.join("findings.json"), json.as_bytes())?;
    write_csv(&folder.join("runs.csv"), runs_csv(records))?;
    write_csv(&folder.join("curves.csv"), curves_csv(plan, records))?;
    for condition in plan.conditions()? {
        let agents = condition.team.get();
        let runs = records.iter().filter(|record| record.agents == agents);
        let best = runs.reduce(|best, other| {
            if other.fitness() > best.fitness() {
                other
            } else {
                best
            }
        });
        if let Some(best) = best {
            TableFile::from_record(&condition, best, plan.generations)?
                .write(&folder.join(format!("best-{agents}.toml")))?;
        }
    }
    Ok(())
}

type Rows = Vec<Vec<String>>;

fn runs_csv(records: &[Record]) -> Rows {
    let header = [
        "agents",
        "seed",
        "fitness",
        "goals_solved",
        "last_rise",
        "genome",
    ]
    .map(str::to_owned)
    .to_vec();
    let row = |record: &Record| {
        vec![
            record.agents.to_string(),
            record.seed.to_string(),
            record.fitness().to_string(),
            record.goals_solved().to_string(),
            record
                .rises
                .last()
                .map_or(0, |rise| rise.generation)
                .to_string(),
            record.genome.clone(),
        ]
    };
    std::iter::once(header)
        .chain(records.iter().map(row))
        .collect()
}

fn curves_csv(plan: &Plan, records: &[Record]) -> Rows {
    let mut rows = vec![
        ["agents", "seed", "generation", "max_fitness"]
            .map(str::to_owned)
            .to_vec(),
    ];
    for record in records {
        for generation in (0..=plan.generations)
            .filter(|g| *g < 50 || g % CURVE_STEP == 0 || *g == plan.generations)
        {
            let fitness = record.fitness_at(generation);
            rows.push(
                [
                    record.agents.to_string(),
                    record.seed.to_string(),
                    generation.to_string(),
                    fitness.to_string(),
                ]
                .to_vec(),
            );
        }
    }
    rows
}

fn write_csv(path: &Path, rows: Rows) -> Result<()> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.write_record(row).map_err(Error::from_part)?;
    }
    let bytes = writer.into_inner().map_err(Error::from_part)?;
    write_atomically(path, &bytes)
}
