//! Report: one row per fault.

use std::collections::BTreeSet;
use std::path::Path;

use atas_core::Settings;
use serde::Serialize;

use crate::catalogue::{CATALOGUE, Evidence, Fault};
use crate::verdict::Verdict;

/// Failed runs of a fault that a report names; it counts all. Design choice: a screen.
const FAILURES_SHOWN: usize = 8;

/// Robot, tasks, faults and seeds of a run.
pub(crate) struct Extent<'a> {
    /// Name of the robot.
    pub(crate) robot: &'a str,
    pub(crate) tasks: Vec<&'static str>,
    pub(crate) faults: &'a [&'static Fault],
    /// Name or file of the object of grasp and pick and place.
    pub(crate) object: &'a str,
    /// The user's configuration.
    pub(crate) config: Option<&'a Path>,
    pub(crate) settings: &'a Settings,
}

/// Result of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FaultReport {
    /// Name of the robot.
    pub robot: String,
    /// Names of the tasks.
    pub tasks: Vec<&'static str>,
    /// One row per fault, in the order of the catalogue.
    pub faults: Vec<FaultRow>,
    /// Numbers of the catalogue that an injection, a process or a test shows.
    pub automated: usize,
    /// Numbers of the catalogue.
    pub catalogue: usize,
    /// Runs in which a command exceeded its limits, or an object was lost or harmed.
    pub unsafe_outputs: usize,
}

/// Result of one fault.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FaultRow {
    /// Number.
    pub id: &'static str,
    /// Name.
    pub name: &'static str,
    /// Required reaction; `None` if a test shows it.
    pub reaction: Option<String>,
    /// Evidence: `injection`, `process`, a test, or the reason why there is none.
    pub shown_by: String,
    /// Seeds of each task; 0 if the fault was not injected.
    pub seeds: u64,
    /// Seeds of which each run passed.
    pub passed: u64,
    /// Runs: one per seed, task and phase.
    pub runs: usize,
    /// Runs that passed.
    pub passed_runs: usize,
    /// Reason why this machine cannot show the fault.
    pub skipped: Option<String>,
    /// Slowest reaction, ticks.
    pub worst_ticks: Option<u64>,
    /// Bound of the reaction, ticks.
    pub bound_ticks: Option<u64>,
    /// Failed runs: the command that repeats it, and the cause.
    pub failures: Vec<String>,
}

impl FaultReport {
    pub(crate) fn new(extent: &Extent<'_>, verdicts: &[Verdict]) -> Self {
        let faults = extent.faults.iter();
        let rows = faults.map(|fault| row(extent, fault, verdicts));
        Self {
            robot: extent.robot.to_owned(),
            tasks: extent.tasks.clone(),
            faults: rows.collect(),
            automated: numbers(|evidence| !matches!(evidence, Evidence::Nothing(_))),
            catalogue: numbers(|_| true),
            unsafe_outputs: verdicts.iter().filter(|verdict| verdict.is_unsafe).count(),
        }
    }

    /// Returns true if every run passed.
    #[must_use]
    pub fn has_passed(&self) -> bool {
        self.faults
            .iter()
            .all(|fault| fault.passed_runs == fault.runs)
    }
}

fn row(extent: &Extent<'_>, fault: &Fault, verdicts: &[Verdict]) -> FaultRow {
    let all = verdicts.iter().filter(|verdict| verdict.fault == fault.id);
    let (skipped, own): (Vec<_>, Vec<_>) = all.partition(|verdict| verdict.skipped.is_some());
    let failed = own
        .iter()
        .filter_map(|verdict| failure(extent, fault, verdict));
    let reaction = fault.evidence.reaction();
    let reaction = reaction.map(|reaction| reaction.with_settings(extent.settings));
    let passed_runs = own.iter().filter(|verdict| verdict.failure.is_none());
    let seeds: BTreeSet<u64> = own.iter().map(|verdict| verdict.seed).collect();
    let failed_seeds: BTreeSet<u64> = own
        .iter()
        .filter(|verdict| verdict.failure.is_some())
        .map(|verdict| verdict.seed)
        .collect();
    FaultRow {
        id: fault.id,
        name: fault.name,
        reaction: reaction.map(|reaction| reaction.text()),
        shown_by: fault.evidence.text().to_owned(),
        seeds: seeds.len() as u64,
        passed: (seeds.len() - failed_seeds.len()) as u64,
        runs: own.len(),
        passed_runs: passed_runs.count(),
        skipped: skipped.first().and_then(|verdict| verdict.skipped.clone()),
        worst_ticks: own.iter().filter_map(|verdict| verdict.ticks).max(),
        bound_ticks: reaction
            .and_then(|reaction| reaction.required())
            .map(|(_, ticks)| ticks),
        failures: failed.take(FAILURES_SHOWN).collect(),
    }
}

fn failure(extent: &Extent<'_>, fault: &Fault, verdict: &Verdict) -> Option<String> {
    let why = verdict.failure.as_ref()?;
    let (task, phase, seed) = (verdict.task, &verdict.phase, verdict.seed);
    let (id, robot) = (fault.id, quoted(extent.robot));
    let (object, phase) = (quoted(extent.object), quoted(phase));
    let config = extent.config.map_or(String::new(), |file| {
        format!(" --config {}", quoted(&file.display().to_string()))
    });
    Some(format!(
        "atas fault run {id} --robot {robot}{config} --task {task} --at {phase} --seed {seed} \
         --object {object}: {why}"
    ))
}

/// Returns a word for a shell; phases and files may have spaces.
fn quoted(word: &str) -> String {
    if word.contains(char::is_whitespace) {
        format!("'{word}'")
    } else {
        word.to_owned()
    }
}

/// Counts the numbers of the catalogue of which a variant has such evidence.
fn numbers(is_counted: impl Fn(&Evidence) -> bool) -> usize {
    let counted = CATALOGUE.iter().filter(|fault| is_counted(&fault.evidence));
    let mut numbers: Vec<&str> = counted.map(|fault| &fault.id[..3]).collect();
    numbers.dedup();
    numbers.len()
}
