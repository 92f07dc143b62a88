//! `atas eval hybrid`: evaluates courses of mobile robots with hands.

use atas_console::arguments::HybridEvaluation;
use atas_console::{Exit, ExitError, Interrupt, Output, number, table};
use atas_evaluation::hybrid::{HybridPlan, HybridReport, Reflexes};
use atas_evaluation::{Task, seeds};
use comfy_table::Cell;
use ebts::course::table_file::CourseFile;
use sim_backend::{Object, ObjectError};

pub(super) fn hybrid(
    arguments: &HybridEvaluation,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let (_, table) = CourseFile::from_name(&arguments.table)
        .map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?;
    let objects: Result<Vec<Object>, ObjectError> = if arguments.objects.is_empty() {
        Task::PickPlace.objects()
    } else {
        let named = arguments.objects.iter();
        named.map(|name| Object::from_name_or_file(name)).collect()
    };
    let plan = HybridPlan {
        robots: arguments.robots.into(),
        trials: arguments.seeds,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        table,
        reflexes: match arguments.frozen {
            true => Reflexes::Frozen,
            false => Reflexes::On,
        },
        objects: objects.map_err(|error| ExitError::with_code(Exit::Usage, error.to_string()))?,
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    };
    let (report, _) =
        super::with_progress_bar(plan.trials, |done| plan.run(interrupt.flag(), done))?;
    if output.is_json() {
        return output.json(&report);
    }
    print(&report, output)
}

fn print(report: &HybridReport, output: &mut Output) -> anyhow::Result<()> {
    let mut lines = table(&["robots", "trials", "success", "95 %", "failures"]);
    let failures = report.failures.iter();
    let otherwise: Vec<String> = failures
        .map(|(key, count)| format!("{count} {key}"))
        .collect();
    let [low, high] = report.ci95.map(super::table::percent);
    lines.add_row(vec![
        Cell::new(report.robots),
        Cell::new(report.trials),
        Cell::new(super::table::percent(report.success)),
        Cell::new(format!("{low} to {high}")),
        Cell::new(otherwise.join(", ")),
    ]);
    output.table(lines)?;
    let objects = report.objects.iter();
    let objects: Vec<String> = objects
        .map(|(object, [robots, failed])| format!("{object} {failed} of {robots}"))
        .collect();
    output.line(format!("failed: {}", objects.join(", ")))?;
    let drive = &report.drive;
    let [median_mm, most_mm] = drive.slip_mm;
    let [up_n, down_n] = drive.grip_change_n;
    output.line(format!(
        "while driving, reflexes {}: slip median {} mm, max {} mm, above 0.1 mm on {} of {} \
         drives; grip change median +{} N, -{} N; base acceleration {} m/s² horizontal, {} m/s² \
         vertical",
        match report.reflexes {
            Reflexes::On => "on",
            Reflexes::Frozen => "frozen",
        },
        number(median_mm, 2),
        number(most_mm, 2),
        drive.slipped,
        drive.count,
        number(up_n, 2),
        number(down_n, 2),
        number(drive.shake.horizontal_m_s2, 2),
        number(drive.shake.vertical_m_s2, 2),
    ))?;
    output.line(format!(
        "simulated time per trial {} s, median; seeds from {}: {}",
        number(report.simulated_s, 0),
        report.first_seed,
        report.purpose
    ))
}
