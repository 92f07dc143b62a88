//! The report for people: a table per family, and the summary.

use super::{Family, Report};
use crate::output::{Output, table};

/// Prints the report in the format asked for.
pub(crate) fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(report);
    }
    let mut rows = table(&[
        "family",
        "trials",
        "feasible",
        "held",
        "infeasible",
        "refused",
        "crushed",
        "dropped",
        "over-grip",
        "F_2 found/true",
        "slip mm",
        "otherwise",
    ]);
    for family in &report.families {
        rows.add_row(row(family, output));
    }
    output.line(rows)?;
    output.line(summary(report))
}

fn row(family: &Family, output: &Output) -> Vec<comfy_table::Cell> {
    let (feasible, infeasible) = (&family.feasible, &family.infeasible);
    let failures: Vec<String> = family
        .failures
        .iter()
        .map(|(key, count)| format!("{count} {key}"))
        .collect();
    let f2 = match (family.f2_ratio_median, family.f2_ratio_deviation) {
        (Some(median), Some(deviation)) => format!("{median:.2} ± {deviation:.2}"),
        (median, _) => number(median, 2),
    };
    let mut cells: Vec<comfy_table::Cell> = vec![
        family.object.as_str().into(),
        (feasible.trials + infeasible.trials).into(),
        feasible.trials.into(),
        feasible.held.into(),
        infeasible.trials.into(),
        infeasible.refused.into(),
        (feasible.crushed + infeasible.crushed).into(),
        feasible.dropped.into(),
        number(feasible.over_grip_median, 2).into(),
        f2.into(),
        number(family.slip_median_mm, 2).into(),
    ];
    cells.push(match failures.as_slice() {
        [] => output.verdict("none", true),
        failures => output.verdict(&failures.join(", "), false),
    });
    cells
}

fn summary(report: &Report) -> String {
    let (feasible, infeasible) = (&report.feasible, &report.infeasible);
    format!(
        "{} trials: {} of {} feasible held, {} of {} infeasible refused, {} crushed, {} dropped, {} borderline\n\
         success {:.2} % (95 % confidence {:.2} to {:.2} %), over-grip median {}\n\
         {:.1} × real time per core, {:.1} s",
        report.trials,
        feasible.held,
        feasible.trials,
        infeasible.refused,
        infeasible.trials,
        feasible.crushed + infeasible.crushed,
        report.failures.get("dropped").unwrap_or(&0),
        report.borderline,
        report.success * 100.0,
        report.ci95[0] * 100.0,
        report.ci95[1] * 100.0,
        number(feasible.over_grip_median, 2),
        report.realtime_factor,
        report.wall_s,
    )
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}
