//! `atas eval all` and `atas eval errors`: all tasks in one table.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Context;
use atas_console::arguments::Summary;
use atas_console::{Interrupt, Output};
use atas_evaluation::{Condition, Evaluated, GripPolicy, Plan, Report, Task, TrialRow};
use atas_evaluation::{errors_table, seeds, table};
use sim_backend::Errors;

use super::rows::File;

struct Kind {
    name: &'static str,
    trials: u64,
    conditions: fn(Task) -> Vec<Condition>,
    compare_everywhere: bool,
}

const ALL: Kind = Kind {
    name: "all",
    trials: 200,
    conditions: atas_evaluation::conditions,
    compare_everywhere: false,
};
const ERRORS: Kind = Kind {
    name: "errors",
    trials: 48,
    conditions: atas_evaluation::error_conditions,
    compare_everywhere: true,
};
/// Stored sample trials per series: the first and the middle one.
const SAMPLES: usize = 2;

pub(super) fn all(
    summary: &Summary,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    report(&ALL, summary, table, interrupt, output)
}

pub(super) fn errors(
    summary: &Summary,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let abouts = Errors::KINDS.iter().map(|kind| (kind.name, kind.about));
    let abouts: BTreeMap<&str, &str> = abouts.chain([("all", "all errors together")]).collect();
    let text = |reports: &[Report]| errors_table(reports, &abouts);
    report(&ERRORS, summary, text, interrupt, output)
}

fn report(
    kind: &Kind,
    summary: &Summary,
    text: impl Fn(&[Report]) -> String,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    make_folder(summary.golden.as_deref())?;
    let evaluated = run(kind, summary, interrupt)?;
    let reports: Vec<Report> = evaluated.iter().map(|e| e.report.clone()).collect();
    let text = text(&reports);
    print(summary.markdown, &evaluated, &text, output)?;
    match &summary.golden {
        Some(folder) => save(folder, kind.name, &text, &evaluated),
        None => Ok(()),
    }
}

fn run(kind: &Kind, summary: &Summary, interrupt: &Interrupt) -> anyhow::Result<Vec<Evaluated>> {
    let named: Vec<Task> = summary
        .tasks
        .iter()
        .map(|name| super::task(*name))
        .collect();
    let tasks = if named.is_empty() {
        &Task::ALL[..]
    } else {
        &named
    };
    let of = |task: &Task| {
        let baselines = match summary.no_baselines {
            true => Vec::new(),
            false => GripPolicy::baselines(*task, None).to_vec(),
        };
        let plan = Plan {
            robot: robot_model::TWO_HAND_ARM,
            skin: None,
            task: *task,
            objects: task.objects()?,
            trials: summary.trials.unwrap_or(kind.trials),
            first_seed: summary.first_seed.unwrap_or(seeds::EVALUATION_START),
            conditions: (kind.conditions)(*task),
            baselines,
            compare_everywhere: kind.compare_everywhere,
            engine: None,
            threads: summary.threads,
            settings: atas_core::Settings::default(),
        };
        super::run(&plan, interrupt)
    };
    tasks.iter().map(of).collect()
}

/// Creates the output folder early, so that a long run does not fail at its end.
pub(super) fn make_folder(golden: Option<&Path>) -> anyhow::Result<()> {
    let Some(folder) = golden else { return Ok(()) };
    std::fs::create_dir_all(folder)
        .with_context(|| format!("could not make the folder {}", folder.display()))
}

pub(super) fn print(
    markdown: bool,
    evaluated: &[Evaluated],
    text: &str,
    output: &mut Output,
) -> anyhow::Result<()> {
    let mut reports = evaluated.iter().map(|evaluated| &evaluated.report);
    if output.is_json() {
        return reports.try_for_each(|report| output.json(report));
    }
    output.line(text.trim_end())?;
    if markdown {
        return Ok(());
    }
    reports.try_for_each(|report| {
        let (task, wall_s) = (report.task, report.wall_s);
        output.line(format!(
            "{task}: {}; {wall_s:.0} s",
            super::table::seeds(report)
        ))
    })
}

/// Writes the table and some of its trials; a test repeats these trials.
pub(super) fn save(
    folder: &Path,
    name: &str,
    text: &str,
    evaluated: &[Evaluated],
) -> anyhow::Result<()> {
    let path = folder.join(format!("{name}.md"));
    std::fs::write(&path, text).with_context(|| format!("could not write {}", path.display()))?;
    let series = evaluated.iter().flat_map(|e| &e.rows);
    let samples: Vec<&TrialRow> = series.flat_map(|rows| sample_rows(rows)).collect();
    File::create(&folder.join(format!("{name}.csv")))?.write(samples.into_iter())
}

fn sample_rows(rows: &[TrialRow]) -> impl Iterator<Item = &TrialRow> {
    rows.iter().step_by(rows.len().div_ceil(SAMPLES).max(1))
}
