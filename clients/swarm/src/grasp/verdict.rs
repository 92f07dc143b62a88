//! Verdict in the full simulation with the production controller: evolved tables, the paper's
//! rules, the hand-written modules (complete and reduced), and both baselines, on members of all
//! object families that were used neither in evolution nor tuning.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use atas_core::tasks::BehaviourTable;
use atas_evaluation::{GripPolicy, Task, TrialRow, median, wilson};
use serde::Serialize;
use shm_schemas::ModuleId;

use super::agreement::plan;
use super::rules::Rules;
use crate::error::{Error, Result};

/// Hand-written modules that are removed one by one.
const REMOVED_MODULES: [ModuleId; 5] = [
    ModuleId::FIRST_TOUCH,
    ModuleId::SLIP,
    ModuleId::FORCE_LIMIT,
    ModuleId::RELAX,
    ModuleId::LIFT_VERIFICATION,
];

/// Grasp results of one policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Score {
    /// Number of grasps.
    pub trials: u64,
    /// Objects held.
    pub held: u64,
    /// Objects refused, unharmed.
    pub refused: u64,
    /// Objects crushed.
    pub crushed: u64,
    /// Median of normal force over required force for held objects; `null` if none was held.
    pub over_grip_median: Option<f64>,
    /// Median simulated time of held objects, s.
    pub time_median_s: Option<f64>,
    /// Share of objects with the verdict expected by the paper's rule: held or refused.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// Success by physics alone, the fair measure for a policy without F_2.
    pub success_by_physics: f64,
    /// Number of grasps per outcome.
    pub outcomes: BTreeMap<String, u64>,
}

/// Verdict on one table.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TableScore {
    /// Seed of the run that evolved it.
    pub seed: u64,
    /// Fitness in the reduced simulation, of 800.
    pub fitness: f32,
    /// Hash of the table.
    pub hash: String,
    /// Grasp results.
    #[serde(flatten)]
    pub score: Score,
}

/// Results of all policies on the same objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PolicyScores {
    /// Every evolved table in the given order, without modules.
    pub tables: Vec<TableScore>,
    /// The first (fittest) table with Module 3.
    pub with_module_3: Score,
    /// The paper's rules as a table.
    pub rules: Score,
    /// Modules of the controller.
    pub modules: Score,
    /// Modules of the controller without one of them, by its name.
    pub without: BTreeMap<String, Score>,
    /// Baseline that reacts to slip.
    pub slip_reactive: Score,
    /// Baseline with a fixed force.
    pub fixed_force: Score,
}

/// Returns the number of grasps of a verdict.
#[must_use]
pub fn jobs(tables: usize, seeds: u64) -> u64 {
    (policies(&vec![Rules::PAPER.table(); tables]).len() as u64 + 1)
        * seeds
        * super::course::FAMILIES as u64
}

fn policies(tables: &[BehaviourTable]) -> Vec<GripPolicy> {
    let law = |table: BehaviourTable, force_limit| GripPolicy::Table { table, force_limit };
    let alone = tables.iter().map(|table| law(*table, false));
    let beside = tables.first().map(|table| law(*table, true));
    alone
        .chain(beside)
        .chain([law(Rules::PAPER.table(), false)])
        .chain(REMOVED_MODULES.map(GripPolicy::Without))
        .chain(GripPolicy::baselines(Task::Grasp, None))
        .collect()
}

/// Evaluates tables, each with seed and fitness, best first; `None` if `stop` was set.
pub fn evaluate(
    tables: &[(BehaviourTable, u64, f32)],
    (seeds, first_seed): (u64, u64),
    threads: usize,
    stop: &AtomicBool,
    done: impl Fn() + Sync,
) -> Result<Option<PolicyScores>> {
    let bare: Vec<BehaviourTable> = tables.iter().map(|(table, ..)| *table).collect();
    let plan = plan(policies(&bare), seeds, first_seed, threads)?;
    let Some(evaluated) = plan.run(stop, done).map_err(Error::from_part)? else {
        return Ok(None);
    };
    let mut series = evaluated.rows.iter().map(|rows| Score::from_rows(rows));
    let mut next = || {
        series
            .next()
            .ok_or_else(|| Error::from_part("a policy has no grasps"))
    };
    let modules = next()?;
    let mut scores = Vec::new();
    for (table, seed, fitness) in tables {
        scores.push(TableScore {
            seed: *seed,
            fitness: *fitness,
            hash: format!("{:016x}", table.hash()),
            score: next()?,
        });
    }
    let (with_module_3, rules) = (next()?, next()?);
    let mut without = BTreeMap::new();
    for module in REMOVED_MODULES {
        without.insert(module.to_string(), next()?);
    }
    let (fixed_force, slip_reactive) = (next()?, next()?);
    Ok(Some(PolicyScores {
        tables: scores,
        with_module_3,
        rules,
        modules,
        without,
        slip_reactive,
        fixed_force,
    }))
}

impl Score {
    fn from_rows(rows: &[TrialRow]) -> Self {
        let count =
            |is: &dyn Fn(&TrialRow) -> bool| rows.iter().filter(|row| is(row)).count() as u64;
        let held = || rows.iter().filter(|row| row.outcome == "held");
        let trials = rows.len() as u64;
        let successes = count(&|row| row.success);
        let mut outcomes = BTreeMap::new();
        for row in rows {
            *outcomes.entry(row.outcome.clone()).or_default() += 1;
        }
        let share = |count: u64| count as f64 / trials.max(1) as f64;
        Self {
            trials,
            held: held().count() as u64,
            refused: count(&|row| row.outcome.starts_with("refused")),
            crushed: count(&|row| row.outcome == "crushed"),
            over_grip_median: median(held().filter_map(|row| row.over_grip).collect()),
            time_median_s: median(held().filter_map(|row| row.simulated_s).collect()),
            success: share(successes),
            ci95: wilson(successes, trials),
            success_by_physics: share(count(&|row| row.success_by_physics)),
            outcomes,
        }
    }
}
