//! Reports as Markdown tables for the documentation.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::Task;
use crate::condition::Noise;
use crate::physics::Physics;
use crate::report::{Baseline, Report, Row};
use crate::tally::Tally;

/// Text of an empty cell.
const NONE: &str = "";
/// Heading of the column with true grip force over needed force.
const OVER_GRIP: &str = "over-grip, median";

/// Formats one line per task and condition, with the baselines.
#[must_use]
pub fn table(reports: &[Report]) -> String {
    let trials = reports.first().map_or(0, |report| report.tally.trials);
    let mut text = format!(
        "| task, noise, sensor rate | success of {trials} [95 % interval] | held | refused | by physics | otherwise | fixed force | slip-reactive |\n\
         |---|---|---|---|---|---|---|---|\n"
    );
    for report in reports {
        for row in &report.rows {
            let compared =
                |name| baseline(report, row, name).map_or(NONE.to_owned(), baseline_cell);
            let cells = [
                format!(
                    "{}, noise {}, {} Hz",
                    task(report.task),
                    noise(row.noise),
                    row.rate_hz
                ),
                success_cell(&row.tally),
                count_cell(row, |p| (p.feasible.held, p.feasible.trials)),
                count_cell(row, |p| (p.infeasible.refused, p.infeasible.trials)),
                by_physics(row),
                failures_cell(&row.tally.failures),
                compared("fixed_force"),
                compared("slip_reactive"),
            ];
            line(&mut text, &cells);
        }
    }
    text
}

/// Formats one line per error, one column per task and baseline; all reports need equal conditions.
#[must_use]
pub fn errors_table(reports: &[Report], about: &BTreeMap<&str, &str>) -> String {
    let trials = reports.first().map_or(0, |report| report.tally.trials);
    let mut heads = vec![format!("error; success of {trials}")];
    for report in reports {
        heads.push(task(report.task).to_owned());
        let mut names: Vec<&str> = report.baseline_rows.iter().map(|b| b.baseline).collect();
        names.dedup();
        heads.extend(
            names
                .iter()
                .map(|name| format!("{}: {}", task(report.task), name.replace('_', " "))),
        );
    }
    let mut text = table_head(&heads);
    let first = reports
        .first()
        .map(|report| &report.rows[..])
        .unwrap_or_default();
    for (index, row) in first.iter().enumerate() {
        let name = row.errors.as_str();
        let mut cells = vec![about.get(name).copied().unwrap_or(name).to_owned()];
        for report in reports {
            cells.push(percent(report.rows[index].tally.success));
            let same = report
                .baseline_rows
                .iter()
                .filter(|b| b.row.errors == row.errors);
            cells.extend(same.map(|b| percent(b.row.tally.success)));
        }
        line(&mut text, &cells);
    }
    text
}

/// Results of one robot; tasks beyond its capabilities have no report.
#[derive(Debug)]
pub struct RobotResults {
    /// Robot name.
    pub robot: String,
    /// True if the robot turns caps with its wrist.
    pub turns_by_wrist: bool,
    /// Tasks and reports.
    pub reports: Vec<(Task, Option<Report>)>,
}

/// Formats one line per robot, one column per task.
#[must_use]
pub fn robots_table(robots: &[RobotResults]) -> String {
    let reports = || robots.iter().flat_map(|tried| &tried.reports);
    let trials = reports().find_map(|(_, report)| Some(report.as_ref()?.tally.trials));
    let mut heads = vec!["robot".to_owned()];
    for (tried, _) in robots.first().iter().flat_map(|tried| &tried.reports) {
        heads.push(match tried {
            Task::Grasp => success_of(trials),
            other => task(other.name()).to_owned(),
        });
        heads.extend((*tried == Task::Grasp).then(|| OVER_GRIP.to_owned()));
    }
    let mut text = table_head(&heads);
    for tried in robots {
        let mut cells = vec![tried.robot.clone()];
        for (task, report) in &tried.reports {
            let of = |message: fn(&Tally) -> String| {
                let message = report.as_ref().map(|report| message(&report.tally));
                message.unwrap_or_else(|| "cannot".to_owned())
            };
            match task {
                Task::Grasp => cells.extend([of(success_cell), of(over_grip)]),
                Task::Screw if report.is_some() && tried.turns_by_wrist => {
                    cells.push(of(|tally| percent(tally.success)) + ", by its wrist");
                }
                _ => cells.push(of(|tally| percent(tally.success))),
            }
        }
        line(&mut text, &cells);
    }
    text
}

/// Grasp results of one kind of fingertip.
#[derive(Debug)]
pub struct SkinResults {
    /// Name of the fingertip.
    pub name: String,
    /// Report of the grasp task.
    pub report: Report,
}

/// Formats one line per kind of fingertip.
#[must_use]
pub fn skins_table(skins: &[SkinResults]) -> String {
    let trials = skins.first().map(|tried| tried.report.tally.trials);
    let heads = [
        "fingertips".to_owned(),
        success_of(trials),
        OVER_GRIP.to_owned(),
    ];
    let mut text = table_head(&heads);
    for tried in skins {
        let tally = &tried.report.tally;
        line(
            &mut text,
            &[tried.name.clone(), success_cell(tally), over_grip(tally)],
        );
    }
    text
}

fn success_of(trials: Option<u64>) -> String {
    format!("grasp, success of {} [95 % interval]", trials.unwrap_or(0))
}

fn over_grip(tally: &Tally) -> String {
    let median = tally.medians.get("over_grip");
    median.map_or(NONE.to_owned(), |median| format!("{median:.2}"))
}

fn table_head(heads: &[String]) -> String {
    let mut text = String::new();
    line(&mut text, heads);
    line(&mut text, &vec!["---".to_owned(); heads.len()]);
    text
}

/// Formats headings and rows of equal length.
pub(crate) fn rows_table<const N: usize>(
    heads: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> String {
    let mut text = table_head(&heads.map(str::to_owned));
    for row in rows {
        line(&mut text, &row);
    }
    text
}

fn line(text: &mut String, cells: &[String]) {
    // Writing into memory cannot fail.
    let _ = writeln!(text, "| {} |", cells.join(" | "));
}

fn task(name: &str) -> &str {
    match name {
        "pick-place" => "pick and place",
        "screw" => "screwing",
        name => name,
    }
}

fn noise(noise: Noise) -> String {
    match noise {
        Noise::Scale(scale) => format!("× {scale}"),
        Noise::Between([low, high]) => format!("× {low} to {high}"),
    }
}

fn baseline<'a>(report: &'a Report, row: &Row, name: &str) -> Option<&'a Baseline> {
    let same = |b: &&Baseline| {
        let of = &b.row;
        b.baseline == name
            && (of.noise, of.rate_hz, &of.errors) == (row.noise, row.rate_hz, &row.errors)
    };
    report.baseline_rows.iter().find(same)
}

fn percent(share: f64) -> String {
    let tenths = (share * 1000.0).round() / 10.0;
    format!("{tenths} %")
}

fn success_cell(tally: &Tally) -> String {
    let [low, high] = tally.ci95.map(|share| format!("{:.1}", share * 100.0));
    let high = high.replace("100.0", "100");
    format!("**{}** [{low}, {high}]", percent(tally.success))
}

fn count_cell(row: &Row, of: fn(&Physics) -> (u64, u64)) -> String {
    match row.physics.as_ref().map(of) {
        Some((count, trials)) if trials > 0 => format!("{count} of {trials}"),
        _ => NONE.to_owned(),
    }
}

fn by_physics(row: &Row) -> String {
    let physics = row.physics.as_ref();
    physics.map_or(NONE.to_owned(), |p| percent(p.by_physics.success))
}

fn baseline_cell(baseline: &Baseline) -> String {
    let success = percent(baseline.row.tally.success);
    let held = count_cell(&baseline.row, |p| (p.feasible.held, p.feasible.trials));
    let refused = count_cell(&baseline.row, |p| {
        (p.infeasible.refused, p.infeasible.trials)
    });
    match (held.as_str(), refused.as_str()) {
        ("", _) => success,
        (held, "") => format!("{success}: {held} held"),
        (held, refused) => {
            let physics = by_physics(&baseline.row);
            format!("{success}: {held} held, {refused} refused; {physics} by physics")
        }
    }
}

fn failures_cell(failures: &BTreeMap<String, u64>) -> String {
    let mut failures: Vec<(&String, &u64)> = failures.iter().collect();
    failures.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let words = failures.iter().map(|(key, count)| format!("{count} {key}"));
    words.collect::<Vec<_>>().join(", ")
}
