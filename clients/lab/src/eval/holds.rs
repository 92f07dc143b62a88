//! `atas eval sensor-effects`, `disturbances` and `gentleness`: evaluations that hold one object.

use atas_console::arguments::{Disturbances, Gentleness, HoldOptions, SensorEffects};
use atas_console::{Interrupt, Output, table};
use atas_evaluation::{
    Discards, DisturbancePlan, DisturbanceReport, EffectPlan, EffectReport, GentlenessPlan,
    GentlenessReport, GentlenessRow, RobustnessRow, Task, discards_text, reference_objects,
    reference_or_other, seeds,
};
use serde::Serialize;
use sim_backend::engine::EngineCommand;
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
    let plan = EffectPlan {
        objects: objects(&arguments.objects, usual, Object::from_name_or_file)?,
        seeds: options.seeds,
        first_seed: first_seed(options),
        engine: engine(options)?,
        threads: options.threads,
        settings: atas_core::Settings::default(),
    };
    let report = super::with_progress_bar(plan.worlds(), |done| plan.run(interrupt.flag(), done))?;
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
    let plan = DisturbancePlan {
        objects: objects(&arguments.objects, usual, Object::from_name_or_file)?,
        seeds: options.seeds,
        first_seed: first_seed(options),
        cases: arguments.cases.clone(),
        baselines: !arguments.no_baselines,
        engine: engine(options)?,
        threads: options.threads,
        settings: atas_core::Settings::default(),
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
    let plan = GentlenessPlan {
        objects: objects(&arguments.objects, reference_objects, reference_or_other)?,
        seeds: options.seeds,
        first_seed: match arguments.tune {
            true => *seeds::TUNING.start(),
            false => first_seed(options),
        },
        tunes: arguments.tune,
        engine: engine(options)?,
        threads: options.threads,
        settings: atas_core::Settings::default(),
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

fn engine(options: &HoldOptions) -> anyhow::Result<Option<EngineCommand>> {
    super::engine(options.engine.as_deref())
}

fn first_seed(options: &HoldOptions) -> u64 {
    options.first_seed.unwrap_or(seeds::EVALUATION_START)
}

fn print_effects(report: &EffectReport, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&[
        "effect",
        "joint torques",
        "trials",
        "held",
        "crushed",
        "dropped",
        "slipped",
        "not lifted",
        "warned",
    ]);
    for row in &report.rows {
        let torques = if row.torques { "yes" } else { "no" };
        let mut cells = vec![row.effect.to_owned(), torques.to_owned()];
        let counts = [
            row.trials,
            row.held,
            row.crushed,
            row.dropped,
            row.slipped,
            row.not_lifted,
            row.warned,
        ];
        cells.extend(counts.map(|count| count.to_string()));
        rows.add_row(cells);
    }
    output.table(rows)?;
    print_discards(&report.discarded, output)?;
    output.line(format_args!(
        "{}, {} seeds each from {}, purpose: {}",
        report.objects.join(", "),
        report.seeds,
        report.first_seed,
        report.purpose
    ))
}

fn print_disturbances(report: &DisturbanceReport, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&[
        "disturbance",
        "policy",
        "allowed",
        "kept",
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
    print_discards(&report.discarded, output)?;
    output.line(
        "allowed: trials in which friction could hold the object throughout; slip and response: \
         median; maximum; response: from 0.1 mm of slip to the first closing command",
    )?;
    output.line(format_args!(
        "{}, {} seeds each from {}, purpose: {}, engine: {}",
        report.objects.join(", "),
        report.seeds,
        report.first_seed,
        report.purpose,
        report.engine.as_deref().unwrap_or("built-in"),
    ))
}

fn print_gentleness(report: &GentlenessReport, output: &mut Output) -> anyhow::Result<()> {
    let mut rows = table(&GentlenessRow::HEADER);
    for row in &report.rows {
        rows.add_row(row.cells().to_vec());
    }
    output.table(rows)?;
    if !report.robustness.is_empty() {
        let mut rows = table(&RobustnessRow::HEADER);
        for row in &report.robustness {
            rows.add_row(row.cells().to_vec());
        }
        output.table(rows)?;
    }
    print_discards(&report.discarded, output)?;
    output.line(format_args!(
        "{} seeds of each object from {}, purpose: {}, engine: {}",
        report.seeds,
        report.first_seed,
        report.purpose,
        report.engine.as_deref().unwrap_or("built-in"),
    ))
}

fn print_discards(discards: &Discards, output: &mut Output) -> anyhow::Result<()> {
    match discards_text(discards) {
        text if text.is_empty() => Ok(()),
        text => output.line(text.trim_end()),
    }
}
