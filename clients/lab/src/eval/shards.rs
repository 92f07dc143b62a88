//! `atas eval TASK --shard I/N` and `atas eval merge`: evaluation in several parts.

use std::path::Path;

use anyhow::Context as _;
use atas_console::arguments::{Evaluation, Merging};
use atas_console::{Ended, Exit, Interrupt, Output};
use atas_evaluation::parts::{Header, Part, header};
use atas_evaluation::{Shard, Task};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{behind_a_bar, plan, rows, table};

/// Arguments of an evaluation, as stored in a part file.
#[derive(Debug, Serialize, Deserialize)]
struct Told {
    task: String,
    evaluation: Evaluation,
}

pub(super) fn part(
    task: Task,
    arguments: &Evaluation,
    (shard, out): (&str, &Path),
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let shard: Shard = shard.parse().map_err(|error| {
        Ended::with(
            Exit::Usage,
            format!("could not use --shard because {error}"),
        )
    })?;
    let plan = plan(task, arguments)?;
    let told = Told {
        task: task.name().to_owned(),
        evaluation: Evaluation {
            shard: None,
            out: None,
            threads: 0,
            ..arguments.clone()
        },
    };
    let header = Header {
        plan_hash: plan.hash(),
        shard,
        arguments: serde_json::to_string(&told)?,
    };
    let part = Part::open(out, &header)?;
    if let Some(warning) = part.warning() {
        tracing::warn!("{warning}");
    }
    let before = part.ended().len() as u64;
    let own = plan.jobs_of(shard);
    behind_a_bar(own - before, |done| {
        plan.run_shard(shard, part, interrupt.flag(), done)
    })?;
    if output.is_json() {
        return output.json(&json!({
            "part": shard.number, "of": shard.of, "trials": own, "ran": own - before, "file": out,
        }));
    }
    output.line(format_args!(
        "part {}/{} has its {own} trials, {before} of them from before; `atas eval merge` takes all parts together",
        shard.number, shard.of
    ))
}

pub(super) fn merge(arguments: &Merging, output: &mut Output) -> anyhow::Result<()> {
    let first = arguments.parts.first().context("no part was named")?;
    let told: Told = serde_json::from_str(&header(first)?.arguments)
        .with_context(|| format!("could not read what {} is a part of", first.display()))?;
    let tasks = [Task::Grasp, Task::PickPlace, Task::Screw, Task::Assembly];
    let task = tasks.into_iter().find(|task| task.name() == told.task);
    let task =
        task.with_context(|| format!("could not merge because no task is called {:?}", told.task))?;
    let file = arguments.rows.as_deref().map(rows::File::create);
    let file = file.transpose()?;
    let merged = plan(task, &told.evaluation)?.merge(&arguments.parts)?;
    if let Some(file) = file {
        file.write(merged.rows.iter().flatten())?;
    }
    table::print(&merged.report, output)
}
