//! `atas eval`: from arguments to a plan, with a bar while it runs.

mod table;

use std::io::IsTerminal;

use atas_console::arguments::{Eval, Evaluation};
use atas_console::{Ended, Exit, Interrupt, Output};
use atas_evaluation::{Condition, GripPolicy, Named, Noise, Plan, Task};
use indicatif::{ProgressBar, ProgressStyle};
use sim_backend::{Object, ObjectError};

/// `atas eval`.
pub(crate) fn evaluate(
    eval: &Eval,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let plan = plan(eval)?;
    let bar = bar(plan.jobs());
    let report = plan.run(interrupt.flag(), || bar.inc(1))?;
    let done = bar.position();
    bar.finish_and_clear();
    match report {
        Some(report) => table::print(&report, output),
        None => Err(Ended::with(
            Exit::Interrupted,
            format!(
                "interrupted after {done} of {} trials; nothing was reported",
                plan.jobs()
            ),
        )),
    }
}

fn plan(eval: &Eval) -> anyhow::Result<Plan> {
    let (task, arguments) = match eval {
        Eval::Grasp(arguments) => (Task::Grasp, arguments),
        Eval::PickPlace(arguments) => (Task::PickPlace, arguments),
        Eval::Screw(arguments) => (Task::Screw, arguments),
        Eval::Assembly(arguments) => (Task::Assembly, arguments),
    };
    let objects: Result<Vec<Object>, ObjectError> = if arguments.objects.is_empty() {
        task.objects()
    } else {
        let named = arguments.objects.iter();
        named.map(|name| Object::named_or_file(name)).collect()
    };
    let objects = objects.map_err(|error| Ended::with(Exit::Usage, error.to_string()))?;
    let of_each = |seeds: u64| seeds.saturating_mul(objects.len() as u64);
    Ok(Plan {
        task,
        trials: arguments.seeds.map_or(arguments.trials, of_each),
        objects,
        first_seed: arguments.first_seed,
        conditions: conditions(task, arguments)?,
        baselines: baselines(task, arguments),
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    })
}

/// The one condition that was asked for, or the task's usual ones; all with the errors asked for.
fn conditions(task: Task, arguments: &Evaluation) -> anyhow::Result<Vec<Condition>> {
    let errors = match &arguments.errors {
        Some(text) => text.parse().map_err(|error| {
            Ended::with(
                Exit::Usage,
                format!("could not use --errors because {error}"),
            )
        })?,
        None => Named::none(),
    };
    let mut conditions = task.conditions();
    if arguments.noise.is_some() || arguments.rate_hz.is_some() {
        conditions.truncate(1);
    }
    for condition in &mut conditions {
        condition.noise = arguments.noise.map_or(condition.noise, Noise::Scale);
        condition.rate_hz = arguments.rate_hz.unwrap_or(condition.rate_hz);
        condition.errors = errors.clone();
    }
    Ok(conditions)
}

fn baselines(task: Task, arguments: &Evaluation) -> Vec<GripPolicy> {
    if arguments.no_baselines {
        return Vec::new();
    }
    GripPolicy::baselines(task, arguments.fixed_force).to_vec()
}

/// A bar on a terminal, nothing elsewhere.
fn bar(trials: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = "{bar:40} {pos}/{len} trials, {elapsed} passed, {eta} left";
    let style = ProgressStyle::with_template(template);
    ProgressBar::new(trials).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
