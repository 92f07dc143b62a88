//! `atas eval sensor-effects`, `disturbances` and `gentleness`: evaluations that hold one object.

use atas_console::arguments::{Disturbances, Gentleness, HoldOptions, SensorEffects};
use atas_console::{Interrupt, Output, table};
use atas_evaluation::{
    DisturbancePlan, DisturbanceReport, EffectReport, EffectRow, GentlenessPlan, GentlenessReport,
    GentlenessRow, HeldPlan, HeldSummary, RobustnessRow, Task, reference_objects,
    reference_or_other, seeds,
};
use serde::Serialize;
use sim_backend::{Object, ObjectError};

/// Objects of the sensor effects without --objects: rigid, slippery, soft and heavy ones that can
/// be held.
const EFFECT_OBJECTS: [&str; 5] = ["wood", "slippery-50", "paper-box", "sponge", "bottle"];

pub(super) fn sensor_effects(
    arguments: &SensorEffects,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let usual = || EFFECT_OBJECTS.map(Object::built_in).into_iter().collect();
    let options = &arguments.hold;
    let objects = objects(&arguments.objects, usual, Object::from_name_or_file)?;
    let plan = held_plan(objects, options)?;
    let report = super::with_progress_bar(plan.worlds(), |done| {
        atas_evaluation::sensor_effects(&plan, interrupt.flag(), done)
    })?;
    show(
        &report,
        options,
        EffectReport::markdown,
        print_effects,
        output,
    )
}

pub(super) fn disturbances(
    arguments: &Disturbances,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let usual = || Task::PickPlace.objects();
    let options = &arguments.hold;
    let objects = objects(&arguments.objects, usual, Object::from_name_or_file)?;
    let plan = DisturbancePlan {
        held: held_plan(objects, options)?,
        cases: arguments.cases.clone(),
        baselines: !arguments.no_baselines,
    };
    let report = super::with_progress_bar(plan.trials(), |done| plan.run(interrupt.flag(), done))?;
    show(
        &report,
        options,
        DisturbanceReport::markdown,
        print_disturbances,
        output,
    )
}

pub(super) fn gentleness(
    arguments: &Gentleness,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let options = &arguments.hold;
    let objects = objects(&arguments.objects, reference_objects, reference_or_other)?;
    let mut held = held_plan(objects, options)?;
    if arguments.tune {
        held.first_seed = *seeds::TUNING.start();
    }
    let plan = GentlenessPlan {
        held,
        tunes: arguments.tune,
    };
    let report = super::with_progress_bar(plan.trials(), |done| plan.run(interrupt.flag(), done))?;
    show(
        &report,
        options,
        GentlenessReport::markdown,
        print_gentleness,
        output,
    )
}

fn held_plan(objects: Vec<Object>, options: &HoldOptions) -> anyhow::Result<HeldPlan> {
    Ok(HeldPlan {
        objects,
        seeds: options.seeds,
        first_seed: options.first_seed.unwrap_or(seeds::EVALUATION_START),
        engine: super::engine(options.engine.as_deref())?,
        threads: options.threads,
        settings: atas_core::Settings::default(),
    })
}

/// Returns the named objects, or the usual ones if no name is given.
fn objects(
    names: &[String],
    usual: impl FnOnce() -> Result<Vec<Object>, ObjectError>,
    find: impl Fn(&str) -> Result<Object, ObjectError>,
) -> anyhow::Result<Vec<Object>> {
    let objects = match names {
        [] => usual(),
        names => names.iter().map(|name| find(name)).collect(),
    };
    objects.map_err(|error| super::usage(error.to_string()))
}

/// Prints a report in the requested form.
fn show<R: Serialize>(
    report: &R,
    options: &HoldOptions,
    markdown: impl FnOnce(&R) -> String,
    print: impl FnOnce(&R, &mut Output) -> anyhow::Result<()>,
    output: &mut Output,
) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(report);
    }
    if options.markdown {
        return output.line(markdown(report).trim_end());
    }
    print(report, output)
}

fn print_effects(report: &EffectReport, output: &mut Output) -> anyhow::Result<()> {
    let rows = report.rows.iter().map(EffectRow::cells);
    print_rows(&EffectRow::HEADER, rows, output)?;
    print_summary(&report.summary, output)
}

fn print_disturbances(report: &DisturbanceReport, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&[
        "disturbance",
        "policy",
        "allowed",
        "kept",
        "caught",
        "slip mm",
        "response ms",
        "over-grip",
    ]);
    for row in &report.rows {
        let policy = format!("{} {}", row.policy, row.setting);
        let mut cells = vec![row.case.clone(), policy, row.allowed.to_string()];
        cells.extend(row.cells());
        rows.add_row(cells);
    }
    output.table(rows)?;
    output.line(
        "allowed: trials in which friction could hold the object throughout; slip and response: \
         median; maximum; response: from 0.1 mm of slip to the first closing command",
    )?;
    print_summary(&report.summary, output)
}

fn print_gentleness(report: &GentlenessReport, output: &mut Output) -> anyhow::Result<()> {
    let rows = report.rows.iter().map(GentlenessRow::cells);
    print_rows(&GentlenessRow::HEADER, rows, output)?;
    if !report.robustness.is_empty() {
        let rows = report.robustness.iter().map(RobustnessRow::cells);
        print_rows(&RobustnessRow::HEADER, rows, output)?;
    }
    print_summary(&report.summary, output)
}

fn print_rows<const N: usize>(
    heads: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
    output: &mut Output,
) -> anyhow::Result<()> {
    let mut printed = table(heads);
    for row in rows {
        printed.add_row(row);
    }
    output.table(printed)
}

/// Prints discarded trials, objects, seeds and engine.
fn print_summary(summary: &HeldSummary, output: &mut Output) -> anyhow::Result<()> {
    output.line(format_args!(
        "{}{}; {} seeds each from {}, purpose: {}, engine: {}",
        summary.discards(),
        summary.objects.join(", "),
        summary.seeds,
        summary.first_seed,
        summary.purpose,
        summary.engine.as_deref().unwrap_or("built-in"),
    ))
}
