//! The results of a demo.

use serde_json::{Value, json};

use super::performance::Performance;
use crate::output::{Output, number, table};

/// Share of missed milliseconds above which the results may be the machine's fault (ours: an idle machine misses none).
const STARVED_SHARE: f64 = 0.002;

/// Prints the results in the format asked for.
pub(super) fn print(performances: &[Performance], output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&json!({
            "task": "grasp",
            "as_expected": performances.iter().all(Performance::is_expected),
            "objects": performances.iter().map(value).collect::<Vec<Value>>(),
        }));
    }
    let mut rows = table(&[
        "object",
        "needed N",
        "F_n N",
        "F_2 N",
        "hardness N/m",
        "slip mm",
        "lifted mm",
        "outcome",
        "reason",
    ]);
    for performance in performances {
        let figures = &performance.figures;
        let mut cells: Vec<comfy_table::Cell> = vec![
            performance.object.as_str().into(),
            format!("{:.2}", performance.load.needed_n).into(),
            number(mean_normal_n(performance).into(), 2).into(),
            format!("{:.2}", figures.f2_n).into(),
            format!("{:.0}", figures.hardness_n_m).into(),
            format!("{:.2}", performance.slip_m * 1e3).into(),
            number(performance.lifted_m * 1e3, 1).into(),
        ];
        cells.push(output.verdict(performance.outcome.name(), performance.is_expected()));
        cells.push(performance.reason.as_str().into());
        rows.add_row(cells);
    }
    output.line(rows)?;
    let starved = performances.iter().map(|p| p.starved).fold(0.0, f64::max);
    if starved > STARVED_SHARE {
        output.line(format!(
            "This machine was too busy for real time: up to {:.1} % of the milliseconds were missed, and what is held may \
             slip. End other programs, or use --lockstep.",
            starved * 100.0
        ))?;
    }
    Ok(())
}

fn value(performance: &Performance) -> Value {
    let (load, figures) = (&performance.load, &performance.figures);
    json!({
        "object": performance.object,
        "needed_n": load.needed_n,
        "crush_n": finite(load.crush_n),
        "feasible": load.is_feasible(),
        "normal_n": figures.normal_n[..robot_model::FINGERS],
        "f1_n": figures.f1_n,
        "f2_n": figures.f2_n,
        "hardness_n_m": figures.hardness_n_m,
        "slip_mm": performance.slip_m * 1e3,
        "lifted_mm": performance.lifted_m * 1e3,
        "outcome": performance.outcome.name(),
        "as_expected": performance.is_expected(),
        "reason": performance.reason,
        "starved": performance.starved,
    })
}

/// JSON has no infinity: `null` if nothing crushes it.
fn finite(value: f64) -> Value {
    value.is_finite().then_some(value).into()
}

/// What the fingers press on average, N.
fn mean_normal_n(performance: &Performance) -> f32 {
    let pressed_n = &performance.figures.normal_n[..robot_model::FINGERS];
    pressed_n.iter().sum::<f32>() / pressed_n.len() as f32
}
