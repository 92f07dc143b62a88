//! `atas eval`: makes evaluation plans from arguments and runs them with a progress bar.

mod calibration;
mod holds;
mod hybrid;
mod recording;
mod reflex;
mod rows;
mod shards;
mod summary;
mod table;
mod tune;
mod variants;

use std::io::IsTerminal;

use atas_console::arguments::{Eval, Evaluation, TaskName};
use atas_console::{Exit, ExitError, Interrupt, Output};
use atas_evaluation::{
    Condition, Evaluated, GripPolicy, NamedSensorModel, Noise, Plan, Task, seeds,
};
use indicatif::{ProgressBar, ProgressStyle};
use robot_model::RobotFiles;
use shm_schemas::layout::UnknownLayout;
use sim_backend::engine::{EngineCommand, EngineError};
use sim_backend::{Object, ObjectError, SensorModelError};

/// Value of `--errors` for one row per error.
const EACH: &str = "each";

pub(crate) fn evaluate(
    eval: &Eval,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    match eval {
        Eval::Grasp(arguments) => evaluate_task(Task::Grasp, arguments, interrupt, output),
        Eval::PickPlace(arguments) => evaluate_task(Task::PickPlace, arguments, interrupt, output),
        Eval::Screw(arguments) => evaluate_task(Task::Screw, arguments, interrupt, output),
        Eval::Assembly(arguments) => evaluate_task(Task::Assembly, arguments, interrupt, output),
        Eval::Recording(arguments) => recording::evaluate_recording(arguments, output),
        Eval::All(summary) => summary::all(summary, interrupt, output),
        Eval::Errors(summary) => summary::errors(summary, interrupt, output),
        Eval::Robots(arguments) => variants::robots(arguments, interrupt, output),
        Eval::Skins(arguments) => variants::skins(arguments, interrupt, output),
        Eval::Reflex(arguments) => reflex::reflex(arguments, interrupt, output),
        Eval::Calibration(arguments) => calibration::calibration(arguments, interrupt, output),
        Eval::Hybrid(arguments) => hybrid::hybrid(arguments, interrupt, output),
        Eval::SensorEffects(arguments) => holds::sensor_effects(arguments, interrupt, output),
        Eval::Disturbances(arguments) => holds::disturbances(arguments, interrupt, output),
        Eval::Gentleness(arguments) => holds::gentleness(arguments, interrupt, output),
        Eval::Merge(merging) => shards::merge(merging, output),
        Eval::Tune(tuning) => tune::tune(tuning, interrupt, output),
    }
}

fn evaluate_task(
    task: Task,
    arguments: &Evaluation,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    if let (Some(shard), Some(out)) = (&arguments.shard, &arguments.out) {
        return shards::part(task, arguments, (shard, out), interrupt, output);
    }
    let plan = plan(task, arguments)?;
    let file = arguments.rows.as_deref().map(rows::File::create);
    let file = file.transpose()?;
    let evaluated = run(&plan, interrupt)?;
    if let Some(file) = file {
        file.write(evaluated.rows.iter().flatten())?;
    }
    table::print(&evaluated.report, output)
}

fn run(plan: &Plan, interrupt: &Interrupt) -> anyhow::Result<Evaluated> {
    with_progress_bar(plan.jobs(), |done| plan.run(interrupt.flag(), done))
}

/// Runs trials with a progress bar. `run` receives a callback for each finished trial and returns
/// `None` if it was interrupted.
pub(crate) fn with_progress_bar<T>(
    trials: u64,
    run: impl FnOnce(&(dyn Fn() + Sync)) -> anyhow::Result<Option<T>>,
) -> anyhow::Result<T> {
    let bar = bar(trials);
    let evaluated = run(&|| bar.inc(1))?;
    let done = bar.position();
    bar.finish_and_clear();
    evaluated.ok_or_else(|| {
        let sentence =
            format!("interrupted after {done} of {trials} trials; no report was written");
        ExitError::with_code(Exit::Interrupted, sentence)
    })
}

fn plan(task: Task, arguments: &Evaluation) -> anyhow::Result<Plan> {
    let objects: Result<Vec<Object>, ObjectError> = if arguments.objects.is_empty() {
        task.objects()
    } else {
        let named = arguments.objects.iter();
        named.map(|name| Object::from_name_or_file(name)).collect()
    };
    let objects = objects.map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
    let of_each = |seeds: u64| seeds.saturating_mul(objects.len() as u64);
    let baselines = match arguments.no_baselines {
        true => Vec::new(),
        false => GripPolicy::baselines(task, arguments.fixed_force).to_vec(),
    };
    let robot = RobotFiles::find(&arguments.robot)
        .map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
    let skin = arguments.skin.as_deref().map(str::parse).transpose();
    let skin = skin.map_err(|error: UnknownLayout| {
        ExitError::with_code(Exit::Usage, format!("could not use --skin: {error}"))
    })?;
    Ok(Plan {
        engine: engine(arguments.engine.as_deref())?,
        robot,
        skin,
        task,
        trials: arguments.seeds.map_or(arguments.trials, of_each),
        objects,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        conditions: conditions(task, arguments)?,
        baselines,
        compare_everywhere: arguments.errors.as_deref() == Some(EACH),
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    })
}

/// Parses the value of --engine.
fn engine(text: Option<&str>) -> anyhow::Result<Option<EngineCommand>> {
    let engine = text.map(str::parse).transpose();
    engine.map_err(|error: EngineError| usage(error.to_string()))
}

fn usage(text: String) -> anyhow::Error {
    ExitError::with_code(Exit::Usage, text)
}

/// Returns the requested conditions, or the task's default ones, with the requested errors.
fn conditions(task: Task, arguments: &Evaluation) -> anyhow::Result<Vec<Condition>> {
    let mut conditions = match arguments.errors.as_deref() {
        None => atas_evaluation::conditions(task),
        Some(EACH) => atas_evaluation::error_conditions(task),
        Some(text) => {
            let named = text.parse().map_err(|error| {
                ExitError::with_code(Exit::Usage, format!("could not use --errors: {error}"))
            })?;
            let under = |condition| Condition {
                errors: Clone::clone(&named),
                ..condition
            };
            atas_evaluation::conditions(task)
                .into_iter()
                .map(under)
                .collect()
        }
    };
    let one_was_named = arguments.noise.is_some() || arguments.rate_hz.is_some();
    if one_was_named && arguments.errors.as_deref() != Some(EACH) {
        conditions.truncate(1);
    }
    let sensor_model = sensor_model(arguments)?;
    let model_hz = sensor_model.as_ref().and_then(|of| of.model.rate_hz);
    if model_hz.is_some() && arguments.errors.as_deref() != Some(EACH) {
        conditions.truncate(1);
    }
    for condition in &mut conditions {
        condition.rate_hz = model_hz.unwrap_or(condition.rate_hz);
        condition.sensor_model.clone_from(&sensor_model);
        condition.noise = arguments.noise.map_or(condition.noise, Noise::Scale);
        condition.rate_hz = arguments.rate_hz.unwrap_or(condition.rate_hz);
    }
    Ok(conditions)
}

fn sensor_model(arguments: &Evaluation) -> anyhow::Result<Option<NamedSensorModel>> {
    let model = arguments.sensor_model.as_deref().map(str::parse);
    model.transpose().map_err(|error: SensorModelError| {
        ExitError::with_code(
            Exit::Usage,
            format!("could not use --sensor-model: {error}"),
        )
    })
}

pub(crate) fn task(name: TaskName) -> Task {
    match name {
        TaskName::Grasp => Task::Grasp,
        TaskName::PickPlace => Task::PickPlace,
        TaskName::Screw => Task::Screw,
        TaskName::Assembly => Task::Assembly,
    }
}

/// Makes a progress bar; hidden if standard error is not a terminal.
fn bar(trials: u64) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = "{bar:40} {pos}/{len} trials, {elapsed} elapsed, {eta} left";
    let style = ProgressStyle::with_template(template);
    ProgressBar::new(trials).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
