//! `atas eval tune`: finds the best force of each baseline on the tuning seeds.

use atas_console::arguments::Tuning;
use atas_console::{Interrupt, Output, Rating, table};
use atas_evaluation::{Baseline, GripPolicy, Plan, Report, conditions};
use comfy_table::Cell;

pub(super) fn tune(
    tuning: &Tuning,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let task = super::task(tuning.task);
    let plan = Plan {
        robot: robot_model::TWO_HAND_ARM,
        skin: None,
        task,
        objects: task.objects()?,
        trials: tuning.trials,
        first_seed: tuning.first_seed,
        conditions: conditions(task)[..1].to_vec(),
        baselines: GripPolicy::candidates(),
        compare_everywhere: false,
        engine: None,
        threads: tuning.threads,
        settings: atas_core::Settings::default(),
    };
    let report = super::run(&plan, interrupt)?.report;
    if output.is_json() {
        return output.json(&report);
    }
    print(&report, output)
}

fn print(report: &Report, output: &mut Output) -> anyhow::Result<()> {
    let mut lines = table(&["baseline", "force", "by physics", "success", ""]);
    let best = ["fixed_force", "slip_reactive"].map(|name| best(&report.baseline_rows, name));
    for (index, of) in report.baseline_rows.iter().enumerate() {
        let is_best = best.contains(&Some(index));
        let verdict = if is_best { "best" } else { "" };
        lines.add_row(vec![
            Cell::new(of.baseline),
            Cell::new(&of.setting),
            Cell::new(super::table::percent(by_physics(of))),
            Cell::new(super::table::percent(of.row.tally.success)),
            output.rated_cell(verdict, Rating::Good),
        ]);
    }
    output.table(lines)?;
    output.line(super::table::seeds(report))
}

/// Returns the row with the highest success by physics; among equals the first one, with the lowest
/// force.
fn best(rows: &[Baseline], name: &str) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (index, of) in rows.iter().enumerate() {
        let success = by_physics(of);
        if of.baseline == name && best.is_none_or(|(_, most)| success > most) {
            best = Some((index, success));
        }
    }
    best.map(|(index, _)| index)
}

/// Returns the success by physics; the plain success rate for tasks without holding.
fn by_physics(of: &Baseline) -> f64 {
    let physics = of.row.physics.as_ref();
    physics.map_or(of.row.tally.success, |physics| physics.by_physics.success)
}
