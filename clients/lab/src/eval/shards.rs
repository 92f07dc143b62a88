//! `atas eval TASK --shard I/N` and `atas eval merge`: evaluation in several parts.

use std::path::Path;

use anyhow::Context as _;
use atas_console::arguments::{Evaluation, MergeParts};
use atas_console::{Exit, ExitError, Interrupt, Output};
use atas_evaluation::parts::{Header, Part, header};
use atas_evaluation::{Shard, Task};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::{plan, rows, table, with_progress_bar};

/// Arguments of an evaluation, as stored in a part file.
#[derive(Debug, Serialize, Deserialize)]
struct StoredArguments {
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
        ExitError::with_code(Exit::Usage, format!("could not use --shard: {error}"))
    })?;
    let plan = plan(task, arguments)?;
    let reported = StoredArguments {
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
        arguments: serde_json::to_string(&reported)?,
    };
    let part = Part::open(out, &header)?;
    if let Some(warning) = part.warning() {
        tracing::warn!("{warning}");
    }
    let before = part.ended().len() as u64;
    let own = plan.jobs_of(shard);
    with_progress_bar(own - before, |done| {
        plan.run_shard(shard, part, interrupt.flag(), done)
    })?;
    if output.is_json() {
        return output.json(&json!({
            "part": shard.number, "of": shard.of, "trials": own, "ran": own - before, "file": out,
        }));
    }
    output.line(format_args!(
        "part {}/{} is complete: {own} trials, {before} of them from earlier runs; combine all \
         parts with `atas eval merge`",
        shard.number, shard.of
    ))
}

pub(super) fn merge(arguments: &MergeParts, output: &mut Output) -> anyhow::Result<()> {
    let first = arguments
        .parts
        .first()
        .context("no part given; name the part files")?;
    let reported: StoredArguments =
        serde_json::from_str(&header(first)?.arguments).with_context(|| {
            format!(
                "could not read the evaluation arguments in {}",
                first.display()
            )
        })?;
    let tasks = [Task::Grasp, Task::PickPlace, Task::Screw, Task::Assembly];
    let task = tasks.into_iter().find(|task| task.name() == reported.task);
    let task =
        task.with_context(|| format!("could not merge: unknown task {:?}", reported.task))?;
    let file = arguments.rows.as_deref().map(rows::File::create);
    let file = file.transpose()?;
    let merged = plan(task, &reported.evaluation)?.merge(&arguments.parts)?;
    if let Some(file) = file {
        file.write(merged.rows.iter().flatten())?;
    }
    table::print(&merged.report, output)
}
