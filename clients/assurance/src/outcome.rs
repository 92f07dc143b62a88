//! Result of an item of evidence, from the JSON or the text that its command prints.

use anyhow::Context;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::evidence::{Evidence, SourceTree};

/// Stored result of an item of evidence.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Outcome {
    /// Number of the fault, `file::name` of the test, `soak` or `stops`.
    pub evidence: String,
    /// Fingerprint of the definition.
    pub definition: String,
    /// Version of the programs.
    pub version: String,
    /// Processor cores of the machine.
    pub cores: usize,
    /// Robot, tasks and first seed, in words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub conditions: String,
    /// Seeds per task, ticks or stops; 1 for a test.
    pub extent: u64,
    /// Trials.
    pub tried: u64,
    /// Trials that passed.
    pub passed: u64,
    /// Worst value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub worst: Option<u64>,
    /// Bound of the worst value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<u64>,
    /// Reason why the machine does not permit the evidence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skipped: Option<String>,
}

impl Outcome {
    /// Returns true if there was at least one trial and all passed within the bound.
    #[must_use]
    pub fn has_passed(&self) -> bool {
        let is_within = match (self.worst, self.bound) {
            (Some(worst), Some(bound)) => worst <= bound,
            _ => true,
        };
        self.tried > 0 && self.passed == self.tried && is_within
    }
}

/// Version, machine and source tree of new results.
#[derive(Clone, Debug)]
pub struct Origin<'a> {
    /// Version of the programs.
    pub version: &'a str,
    /// Processor cores of the machine.
    pub cores: usize,
    /// Source tree, for the fingerprints.
    pub tree: &'a SourceTree,
}

impl Origin<'_> {
    fn outcome(&self, item: &Evidence) -> Option<Outcome> {
        Some(Outcome {
            evidence: item.key(),
            definition: item.fingerprint(self.tree)?,
            version: self.version.to_owned(),
            cores: self.cores,
            conditions: String::new(),
            extent: 0,
            tried: 0,
            passed: 0,
            worst: None,
            bound: None,
            skipped: None,
        })
    }
}

/// Reads the JSON of `atas fault run`, `atas soak` or `atas bench stop`. `items`: those of
/// interest.
///
/// # Errors
/// The JSON is of another command, or a field is missing.
pub fn from_report(
    report: &Value,
    items: &[Evidence],
    origin: &Origin<'_>,
) -> anyhow::Result<Vec<Outcome>> {
    let has = |key: &str| report.get(key).is_some();
    if has("faults") {
        from_faults(report, items, origin)
    } else if has("within_3_ticks") {
        from_stops(report, origin)
    } else if has("violations") {
        from_soak(report, origin)
    } else {
        anyhow::bail!(
            "neither `atas fault run`, `atas soak` nor `atas bench stop` prints this JSON"
        )
    }
}

/// Reads the JSON of `atas fault run`.
fn from_faults(
    report: &Value,
    items: &[Evidence],
    origin: &Origin<'_>,
) -> anyhow::Result<Vec<Outcome>> {
    let rows = report["faults"]
        .as_array()
        .context("the report has no rows")?;
    let tasks = report["tasks"]
        .as_array()
        .context("the report has no tasks")?;
    let tasks: Vec<&str> = tasks.iter().filter_map(Value::as_str).collect();
    let robot = report["robot"]
        .as_str()
        .context("the report has no robot")?;
    let conditions = format!("{robot}; {}", tasks.join(", "));
    let mut outcomes = Vec::new();
    for item in items {
        let is_row = |row: &&Value| row["id"].as_str() == Some(&item.key());
        let (Some(row), Some(outcome)) = (rows.iter().find(is_row), origin.outcome(item)) else {
            continue;
        };
        outcomes.push(Outcome {
            conditions: conditions.clone(),
            extent: number(row, "seeds")?,
            tried: number(row, "runs")?,
            passed: number(row, "passed_runs")?,
            worst: row["worst_ticks"].as_u64(),
            bound: row["bound_ticks"].as_u64(),
            skipped: row["skipped"].as_str().map(str::to_owned),
            ..outcome
        });
    }
    Ok(outcomes)
}

/// Reads the JSON of `atas soak`.
fn from_soak(report: &Value, origin: &Origin<'_>) -> anyhow::Result<Vec<Outcome>> {
    let ticks = number(report, "ticks")?;
    let violations = number(report, "violations")?;
    let (episodes, seed) = (number(report, "episodes")?, number(report, "seed")?);
    let outcome = origin.outcome(&Evidence::Soak).map(|outcome| Outcome {
        conditions: format!("{episodes} episodes, seed {seed}"),
        extent: ticks,
        tried: ticks,
        passed: ticks.saturating_sub(violations),
        worst: Some(violations),
        bound: Some(0),
        ..outcome
    });
    Ok(outcome.into_iter().collect())
}

/// Reads the JSON of `atas bench stop`.
fn from_stops(report: &Value, origin: &Origin<'_>) -> anyhow::Result<Vec<Outcome>> {
    let stops = number(report, "stops")?;
    let (within, goals) = (number(report, "within_3_ticks")?, number(report, "goals")?);
    let worst = number(&report["ticks"], "max")?;
    let outcome = origin.outcome(&Evidence::Stops).map(|outcome| Outcome {
        conditions: format!("during {goals} goals of six clients"),
        extent: stops,
        tried: stops,
        passed: within,
        worst: Some(worst),
        bound: Some(3),
        ..outcome
    });
    Ok(outcome.into_iter().collect())
}

/// Reads the lines of `cargo test`. A test without a line has no result.
#[must_use]
pub fn from_tests(lines: &[String], items: &[Evidence], origin: &Origin<'_>) -> Vec<Outcome> {
    let mut outcomes = Vec::new();
    for item in items {
        let Evidence::Test(test) = item else {
            continue;
        };
        let name = test.rsplit("::").next().unwrap_or(test);
        let ends: Vec<&str> = lines
            .iter()
            .filter_map(|line| line.strip_prefix("test ")?.split_once(" ... "))
            .filter(|(path, _)| path.rsplit("::").next() == Some(name))
            .map(|(_, end)| end)
            .collect();
        let passed = ends.iter().filter(|end| **end == "ok").count() as u64;
        let outcome = origin.outcome(item).filter(|_| !ends.is_empty());
        outcomes.extend(outcome.map(|outcome| Outcome {
            extent: 1,
            tried: ends.len() as u64,
            passed,
            ..outcome
        }));
    }
    outcomes
}

fn number(value: &Value, key: &str) -> anyhow::Result<u64> {
    value[key]
        .as_u64()
        .with_context(|| format!("the report has no number {key}"))
}
