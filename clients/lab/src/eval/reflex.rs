//! `atas eval reflex`: evaluates an imprecise policy with and without the reflex layer.

use atas_console::arguments::ReflexEvaluation;
use atas_console::{Interrupt, Output, number, table};
use atas_evaluation::{ReflexPlan, ReflexReport, seeds};
use comfy_table::Cell;

pub(super) fn reflex(
    arguments: &ReflexEvaluation,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let plan = ReflexPlan {
        trials: arguments.trials,
        first_seed: arguments.first_seed.unwrap_or(seeds::EVALUATION_START),
        threads: arguments.threads,
        settings: atas_core::Settings::default(),
    };
    let report = super::with_progress_bar(plan.trials, |done| plan.run(interrupt.flag(), done))?;
    if output.is_json() {
        return output.json(&report);
    }
    print(&report, output)
}

fn print(report: &ReflexReport, output: &mut Output) -> anyhow::Result<()> {
    let mut lines = table(&[
        "policy",
        "trials",
        "success",
        "weak closing",
        "hard closing",
        "crushed",
        "other failures",
    ]);
    for (name, side) in [("with reflex", &report.with), ("without", &report.without)] {
        let of = |[trials, successes]: [u64; 2]| format!("{successes} of {trials}");
        let otherwise = side.failures.iter().filter(|(key, _)| *key != "crushed");
        let otherwise: Vec<String> = otherwise
            .map(|(key, count)| format!("{count} {key}"))
            .collect();
        lines.add_row(vec![
            Cell::new(name),
            Cell::new(side.trials),
            Cell::new(super::table::percent(side.success)),
            Cell::new(of(side.weakly)),
            Cell::new(of(side.hard)),
            Cell::new(side.crushed),
            Cell::new(otherwise.join(", ")),
        ]);
    }
    output.table(lines)?;
    let over_grip = |median: Option<f64>| median.map_or("-".to_owned(), |m| number(m, 2));
    output.line(format!(
        "median over-grip of held objects: {} with reflex, {} without",
        over_grip(report.with.over_grip_median),
        over_grip(report.without.over_grip_median),
    ))?;
    let slip = &report.slip_to_command_ms;
    let ms = |ms: Option<f64>| ms.map_or("-".to_owned(), |ms| number(ms, 0));
    output.line(format!(
        "slip onset to command: p50 {} ms, p99 {} ms, max {} ms over {} slips; {} more at F_2, p99 \
         including them {} ms; {} without a response",
        ms(slip.p50),
        ms(slip.p99),
        ms(slip.max),
        slip.count,
        slip.at_f2,
        ms(slip.p99_with_f2),
        slip.unanswered,
    ))?;
    output.line(format!(
        "seeds from {} for each object, purpose: {}",
        report.first_seed, report.purpose
    ))
}
