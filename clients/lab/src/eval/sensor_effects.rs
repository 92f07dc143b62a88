//! `atas eval sensor-effects`: outcomes of a long hold with a drifting, hysteretic or creeping sensor.

use atas_console::arguments::SensorEffects;
use atas_console::{Exit, ExitError, Interrupt, Output, table};
use atas_evaluation::{EffectPlan, EffectReport, seeds};
use sim_backend::{Object, ObjectError};

/// Objects without --objects: rigid, slippery, soft and heavy ones that can be held.
const OBJECTS: [&str; 5] = ["wood", "slippery-50", "paper-box", "sponge", "bottle"];

pub(super) fn sensor_effects(
    arguments: &SensorEffects,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let names: Vec<&str> = match arguments.objects.is_empty() {
        true => OBJECTS.to_vec(),
        false => arguments.objects.iter().map(String::as_str).collect(),
    };
    let objects: Result<Vec<Object>, ObjectError> =
        names.into_iter().map(Object::from_name_or_file).collect();
    let plan = EffectPlan {
        objects: objects.map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?,
        seeds: arguments.seeds,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    };
    let report = super::with_progress_bar(plan.worlds(), |done| plan.run(interrupt.flag(), done))?;
    if output.is_json() {
        return output.json(&report);
    }
    if arguments.markdown {
        return output.line(report.markdown().trim_end());
    }
    print(&report, output)
}

fn print(report: &EffectReport, output: &mut Output) -> anyhow::Result<()> {
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
    output.line(format_args!(
        "{}, {} seeds each from {}, purpose: {}",
        report.objects.join(", "),
        report.seeds,
        report.first_seed,
        report.purpose
    ))
}
