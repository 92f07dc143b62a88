//! Evaluation report for people: table of families, conditions and baselines, and a summary.

use std::collections::BTreeMap;

use atas_console::{Output, Rating, no_break, table};
use atas_evaluation::{Noise, Physics, Report, Tally};
use comfy_table::Cell;

pub(super) fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(report);
    }
    let measures: Vec<&str> = report.tally.medians.keys().map(String::as_str).collect();
    let can_be_held = report.physics.is_some();
    let mut header = vec!["", "trials", "success"];
    if can_be_held {
        header.extend(["held", "refused", "by physics", "crush", "drop"]);
    }
    header.extend(measures.iter().map(|name| heading(name)));
    header.push("otherwise");
    let mut rows = table(&header);
    let mut add = |name: String, tally: &Tally, physics: Option<&Physics>| {
        let mut cells: Vec<Cell> = vec![name.into(), tally.trials.into()];
        cells.push(percent(tally.success).into());
        cells.extend(physics.map(physics_cells).into_iter().flatten());
        cells.extend(measures.iter().map(|name| measure_cell(tally, name)));
        cells.push(failures_cell(&tally.failures, output));
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
        let (noise, errors) = (noise(row.noise), errors(&row.errors));
        let name = format!("all, noise × {noise}, {} Hz{errors}", row.rate_hz);
        add(name, &row.tally, row.physics.as_ref());
    }
    for of in &report.baseline_rows {
        let name = format!("{}, {}{}", of.baseline, of.setting, errors(&of.row.errors));
        add(name, &of.row.tally, of.row.physics.as_ref());
    }
    output.table(rows)?;
    output.line(summary(report))
}

fn errors(name: &str) -> String {
    match name {
        "none" => String::new(),
        name => format!(", errors {name}"),
    }
}

fn heading(name: &str) -> &str {
    match name {
        "over_grip" => "over-grip",
        "over_steady" => "torsion margin",
        "slip_mm" => "slip mm",
        "turn_deg" => "turn °",
        "bottle_turn_deg" => "bottle turn °",
        "off_mm" => "off mm",
        "latency_ms" => "latency ms",
        "parting_ms" => "parting ms",
        "pressed_down_n" => "press N",
        "released_above_mm" => "above mm",
        "tilt_deg" => "tilt °",
        other => other,
    }
}

fn physics_cells(physics: &Physics) -> [Cell; 5] {
    let (feasible, infeasible) = (&physics.feasible, &physics.infeasible);
    let of = |count: u64, trials: u64| match trials {
        0 => "-".to_owned(),
        trials => no_break(&format!("{count} of {trials}")),
    };
    [
        of(feasible.held, feasible.trials).into(),
        of(infeasible.refused, infeasible.trials).into(),
        percent(physics.by_physics.success).into(),
        (feasible.crushed + infeasible.crushed).into(),
        (feasible.dropped + infeasible.dropped).into(),
    ]
}

fn measure_cell(tally: &Tally, name: &str) -> Cell {
    match (tally.medians.get(name), tally.largest.get(name)) {
        (Some(median), Some(largest)) => no_break(&format!("{median:.2} to {largest:.2}")).into(),
        _ => "-".into(),
    }
}

fn failures_cell(failures: &BTreeMap<String, u64>, output: &Output) -> Cell {
    let failures: Vec<String> = failures
        .iter()
        .map(|(key, count)| format!("{count} {key}"))
        .collect();
    match failures.as_slice() {
        [] => output.rated_cell("none", Rating::Good),
        failures => output.rated_cell(&failures.join(", "), Rating::Bad),
    }
}

fn summary(report: &Report) -> String {
    let tally = &report.tally;
    let borderline = report.physics.as_ref().map_or_else(String::new, |physics| {
        let by_physics = percent(physics.by_physics.success);
        format!(
            ", {by_physics} by physics alone, {} borderline",
            physics.borderline
        )
    });
    let hidden = hidden_text(tally).map_or_else(String::new, |text| format!("\n{text}"));
    format!(
        "{}: {} of {} trials (95 % confidence {} to {}){borderline}; figures are median to \
         maximum{hidden}\n{}; {:.1} × real time per core, {:.1} s",
        report.task,
        percent(tally.success),
        tally.trials,
        percent(tally.ci95[0]),
        percent(tally.ci95[1]),
        seeds(report),
        report.realtime_factor,
        report.wall_s,
    )
}

/// Formats hidden slides and turns; `None` without any.
fn hidden_text(tally: &Tally) -> Option<String> {
    let (slides, turns) = (tally.hidden_slides, tally.hidden_turns);
    (slides + turns > 0).then(|| {
        format!(
            "reported as success although the object moved in the hand: {slides} by more than 3 \
             mm, {turns} by more than 10°"
        )
    })
}

pub(super) fn seeds(report: &Report) -> String {
    let last = report
        .first_seed
        .saturating_add(report.seeds.saturating_sub(1));
    let warning = match report.seeds_for {
        "judging" => "",
        _ => "; quote only results of later seeds",
    };
    let end = atas_evaluation::seeds::TUNING.end();
    format!(
        "seeds {} to {last}, for {} (1 to {end} are for tuning){warning}",
        report.first_seed, report.seeds_for
    )
}

pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

fn noise(noise: Noise) -> String {
    match noise {
        Noise::Scale(scale) => format!("{scale}"),
        Noise::Between([low, high]) => format!("{low} to {high}"),
    }
}
