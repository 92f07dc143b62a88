//! `atas bench restart`: kills the daemon at random moments and measures the restart.

use atas_client::percentiles;
use atas_console::arguments::BenchRestart;
use atas_console::{Exit, ExitError, Interrupt, Output, number, table};
use atas_faults::process::{Environment, RestartPlan, RestartReport};
use serde_json::json;
use sim_backend::Object;

use crate::configuration::configured;
use crate::eval;

/// Object of the grasps.
const OBJECT: &str = "wood";

pub(super) fn restarts(
    arguments: &BenchRestart,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let configured = configured(arguments.config.as_deref())?;
    let (name, files) = configured.robot_files(arguments.robot.as_ref())?;
    let plan = RestartPlan {
        robot: files.load()?,
        environment: Environment {
            robot: name,
            config: arguments.config.clone(),
        },
        settings: configured.settings,
        object: Object::built_in(OBJECT)?,
        kills: arguments.count,
        seed: arguments.seed,
    };
    let report = eval::with_progress_bar(plan.kills, |done| plan.run(interrupt.flag(), done))?;
    print(&report, output)?;
    if report.has_passed() {
        return Ok(());
    }
    let failed = report.failures.len();
    let sentence = format!("{failed} failures after {} kills", report.kills);
    Err(ExitError::with_code(Exit::Failed, sentence))
}

fn print(report: &RestartReport, output: &mut Output) -> anyhow::Result<()> {
    let ready = percentiles::from_unsorted(report.ready_ns.clone());
    let ready_ms = [ready.p50_ns, ready.p99_ns, ready.max_ns].map(|ns| ns as f64 * 1e-6);
    let ratios = || report.force_ratios.iter().copied();
    let ratio = ratios().reduce(f64::min).zip(ratios().reduce(f64::max));
    if output.is_json() {
        let [p50, p99, max] = ready_ms;
        return output.json(&json!({
            "kills": report.kills,
            "during_start": report.during_start,
            "in_grip": report.in_grip,
            "recovered": report.recovered,
            "ready_ms": {"p50": p50, "p99": p99, "max": max},
            "force_ratio": ratio.map(|(min, max)| json!({"min": min, "max": max})),
            "failures": report.failures,
        }));
    }
    let mut rows = table(&["", "p50", "p99", "max"]);
    let [p50, p99, max] = ready_ms.map(|ms| number(ms, 0));
    rows.add_row(["ready after, ms".to_owned(), p50, p99, max]);
    output.table(rows)?;
    output.line(format_args!(
        "{} of {} kills recovered: {} during a start, {} with an object in the hand",
        report.recovered, report.kills, report.during_start, report.in_grip
    ))?;
    if let Some((min, max)) = ratio {
        output.line(format_args!(
            "grip force after the last restart over that at the first kill: {min:.2} to {max:.2}"
        ))?;
    }
    for failure in &report.failures {
        output.line(format_args!("failed: {failure}"))?;
    }
    Ok(())
}
