//! The report for people: a table of families, conditions and baselines, and the summary.

use std::collections::BTreeMap;

use atas_console::{Mood, Output, table};
use atas_evaluation::{Noise, Physics, Report, Tally};
use comfy_table::Cell;

/// Prints the report in the format asked for.
pub(super) fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(report);
    }
    let measures: Vec<&'static str> = report.tally.medians.keys().copied().collect();
    let of_grasps = report.physics.is_some();
    let mut header = vec!["", "trials", "success"];
    if of_grasps {
        header.extend(["held", "refused", "crush", "drop"]);
    }
    header.extend(measures.iter().map(|name| heading(name)));
    header.push("otherwise");
    let mut rows = table(&header);
    let mut add = |name: String, tally: &Tally, physics: Option<&Physics>| {
        let mut cells: Vec<Cell> = vec![name.into(), tally.trials.into()];
        cells.push(percent(tally.success).into());
        cells.extend(physics.map(counts).into_iter().flatten());
        cells.extend(measures.iter().map(|name| figure(tally, name)));
        cells.push(otherwise(&tally.failures, output));
        rows.add_row(cells);
    };
    for family in &report.families {
        add(
            family.object.clone(),
            &family.tally,
            family.physics.as_ref(),
        );
    }
    for row in &report.rows {
        let errors = match row.errors.as_str() {
            "none" => String::new(),
            errors => format!(", errors {errors}"),
        };
        let name = format!(
            "all, noise × {}, {} Hz{errors}",
            noise(row.noise),
            row.rate_hz
        );
        add(name, &row.tally, row.physics.as_ref());
    }
    for row in &report.baseline_rows {
        add(row.baseline.to_owned(), &row.tally, row.physics.as_ref());
    }
    output.table(rows)?;
    output.line(summary(report))
}

/// A measure's name as a column's heading.
fn heading(name: &str) -> &str {
    match name {
        "over_grip" => "over-grip",
        "slip_mm" => "slip mm",
        "off_mm" => "off mm",
        "latency_ms" => "latency ms",
        "parting_ms" => "parting ms",
        "released_above_mm" => "above mm",
        "tilt_deg" => "tilt °",
        other => other,
    }
}

fn counts(physics: &Physics) -> [Cell; 4] {
    let (feasible, infeasible) = (&physics.feasible, &physics.infeasible);
    let of = |count: u64, trials: u64| match trials {
        0 => "-".to_owned(),
        trials => format!("{count} of {trials}"),
    };
    [
        of(feasible.held, feasible.trials).into(),
        of(infeasible.refused, infeasible.trials).into(),
        (feasible.crushed + infeasible.crushed).into(),
        feasible.dropped.into(),
    ]
}

/// Median and largest of a measure.
fn figure(tally: &Tally, name: &str) -> Cell {
    match (tally.medians.get(name), tally.largest.get(name)) {
        (Some(median), Some(largest)) => format!("{median:.2} to {largest:.2}").into(),
        _ => "-".into(),
    }
}

fn otherwise(failures: &BTreeMap<String, u64>, output: &Output) -> Cell {
    let failures: Vec<String> = failures
        .iter()
        .map(|(key, count)| format!("{count} {key}"))
        .collect();
    match failures.as_slice() {
        [] => output.verdict("none", Mood::Good),
        failures => output.verdict(&failures.join(", "), Mood::Bad),
    }
}

fn summary(report: &Report) -> String {
    let tally = &report.tally;
    let borderline = report.physics.as_ref().map_or_else(String::new, |physics| {
        format!(", {} borderline", physics.borderline)
    });
    format!(
        "{}: {} of {} trials (95 % confidence {} to {}){borderline}; figures are median to largest\n\
         {:.1} × real time per core, {:.1} s",
        report.task,
        percent(tally.success),
        tally.trials,
        percent(tally.ci95[0]),
        percent(tally.ci95[1]),
        report.realtime_factor,
        report.wall_s,
    )
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

fn noise(noise: Noise) -> String {
    match noise {
        Noise::Scale(scale) => format!("{scale}"),
        Noise::Between([low, high]) => format!("{low} to {high}"),
    }
}
