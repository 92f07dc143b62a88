//! Agreement between reduced and full simulation: verdicts of the same hand-written rules on the
//! same objects.

use std::collections::BTreeMap;
use std::sync::atomic::AtomicBool;

use atas_evaluation::{Condition, GripPolicy, NamedErrors, Noise, Plan, Task, TrialRow};
use pinch::{Engine, TimeLimit, Trial};
use serde::Serialize;

use super::course::{Course, reduced, rows};
use super::fitness::{Verdict, full_verdict, verdict};
use super::rules::Rules;
use crate::error::{Error, Result};

/// Agreement of both simulations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Pairs of object and rule set.
    pub pairs: u64,
    /// Pairs with the same verdict.
    pub agree: u64,
    /// Share of pairs with the same verdict.
    pub share: f64,
    /// First seed of the objects' families.
    pub first_seed: u64,
    /// Members of each of the eight families.
    pub seeds: u64,
    /// Number of pairs by verdict, "full/reduced".
    pub verdicts: BTreeMap<String, u64>,
    /// Agreement per rule set.
    pub rules: Vec<RuleAgreement>,
    /// Share of agreement per object.
    pub objects: BTreeMap<String, f64>,
    /// Pairs with different verdicts.
    pub differ: Vec<Difference>,
    /// Duration, s.
    pub wall_s: f64,
}

/// Pair with different verdicts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Family of the object.
    pub object: String,
    /// Seed of the family member.
    pub seed: u64,
    /// Rules in the set.
    pub rule: String,
    /// Outcome in the full simulation.
    pub full: String,
    /// Verdict of the reduced simulation.
    pub reduced: Verdict,
}

/// Agreement of one rule set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RuleAgreement {
    /// Rules in the set.
    pub rule: String,
    /// Share of its pairs with the same verdict.
    pub share: f64,
}

/// Simulates every rule set on members of all families in both simulations; `None` if `stop` was
/// set.
pub fn measure(
    seeds: u64,
    first_seed: u64,
    threads: usize,
    stop: &AtomicBool,
    done: impl Fn() + Sync,
) -> Result<Option<Agreement>> {
    let rules = Rules::all();
    let laws = rules.iter().map(|rules| GripPolicy::Table {
        table: rules.table(),
        force_limit: false,
    });
    let plan = plan(laws.collect(), seeds, first_seed, threads)?;
    let Some(evaluated) = plan.run(stop, done).map_err(Error::from_part)? else {
        return Ok(None);
    };
    // The first series has the controller's own modules, which the reduced simulation lacks.
    let series = &evaluated.rows[1..];
    let compared: Vec<Vec<Compared>> = rules
        .iter()
        .zip(series)
        .map(|(r, s)| compare(r, s))
        .collect();
    Ok(Some(Agreement::new(
        &rules,
        &compared,
        (first_seed, seeds),
        evaluated.report.wall_s,
    )))
}

/// Returns the number of grasps that [`measure`] runs in the full simulation.
#[must_use]
pub fn jobs(seeds: u64) -> u64 {
    (Rules::all().len() as u64 + 1) * seeds * super::course::FAMILIES as u64
}

/// Returns a plan of grasps under the standard condition: the controller's own modules, then these
/// policies.
pub(super) fn plan(
    laws: Vec<GripPolicy>,
    seeds: u64,
    first_seed: u64,
    threads: usize,
) -> Result<Plan> {
    let objects = Task::Grasp.objects().map_err(Error::from_part)?;
    Ok(Plan {
        robot: robot_model::TWO_HAND_ARM,
        skin: None,
        task: Task::Grasp,
        trials: seeds * objects.len() as u64,
        objects,
        first_seed,
        conditions: vec![Condition {
            noise: Noise::Scale(1.0),
            rate_hz: 1000,
            errors: NamedErrors::none(),
            sensor_model: None,
        }],
        baselines: laws,
        compare_everywhere: false,
        engine: None,
        threads,
        settings: atas_core::Settings::default(),
    })
}

struct Compared {
    object: String,
    seed: u64,
    outcome: String,
    full: Verdict,
    reduced: Verdict,
}

fn compare(rules: &Rules, series: &[TrialRow]) -> Vec<Compared> {
    let course = Course::default();
    let rows = rows(&rules.table());
    let infinite = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    let trial = |row: &TrialRow| Trial {
        object: reduced(
            row.mass_kg.unwrap_or(0.1),
            row.friction.unwrap_or(0.5),
            infinite(row.stiffness_n_m),
            infinite(row.crush_n),
        ),
        rows,
        seed: row.seed as u32,
    };
    let trials: Vec<Trial> = series.iter().map(trial).collect();
    let mut outcomes = Vec::new();
    Engine::fastest().run(
        &course.interface(false, TimeLimit::LONG),
        &trials,
        &mut outcomes,
    );
    let compared = |(row, outcome): (&TrialRow, &pinch::Outcome)| Compared {
        object: row.object.clone(),
        seed: row.seed,
        outcome: row.outcome.clone(),
        full: full_verdict(&row.outcome),
        reduced: verdict(outcome),
    };
    series.iter().zip(&outcomes).map(compared).collect()
}

impl Agreement {
    fn new(
        rules: &[Rules],
        compared: &[Vec<Compared>],
        (first_seed, seeds): (u64, u64),
        wall_s: f64,
    ) -> Self {
        let all = || compared.iter().flatten();
        let mut verdicts = BTreeMap::new();
        let mut objects: BTreeMap<String, (u64, u64)> = BTreeMap::new();
        for pair in all() {
            let key = format!("{:?}/{:?}", pair.full, pair.reduced).to_lowercase();
            *verdicts.entry(key).or_default() += 1;
            let (same, of) = objects.entry(pair.object.clone()).or_default();
            *same += u64::from(pair.full == pair.reduced);
            *of += 1;
        }
        let same = |pairs: &[Compared]| pairs.iter().filter(|p| p.full == p.reduced).count() as u64;
        let share = |same: u64, of: u64| same as f64 / of.max(1) as f64;
        let (pairs, agree) = (all().count() as u64, compared.iter().map(|c| same(c)).sum());
        let differ = |(rules, pairs): (&Rules, &Vec<Compared>)| {
            let differ = |pair: &Compared| Difference {
                object: pair.object.clone(),
                seed: pair.seed,
                rule: rules.name(),
                full: pair.outcome.clone(),
                reduced: pair.reduced,
            };
            let pairs = pairs.iter().filter(|pair| pair.full != pair.reduced);
            pairs.map(differ).collect::<Vec<_>>()
        };
        let rule = |(rules, pairs): (&Rules, &Vec<Compared>)| RuleAgreement {
            rule: rules.name(),
            share: share(same(pairs), pairs.len() as u64),
        };
        Self {
            pairs,
            agree,
            share: share(agree, pairs),
            first_seed,
            seeds,
            verdicts,
            rules: rules.iter().zip(compared).map(rule).collect(),
            objects: objects
                .into_iter()
                .map(|(name, (a, b))| (name, share(a, b)))
                .collect(),
            differ: rules.iter().zip(compared).flat_map(differ).collect(),
            wall_s,
        }
    }
}
