//! Report of the gentleness: one row per object and gripper, and one per gripper and condition.

use serde::Serialize;

use super::trial::{Ending, Figures};
use super::{Condition, GentlenessPlan, Series};
use crate::held::{HeldSummary, Outcome, Outcomes};
use crate::markdown::rows_table;
use crate::statistics::median;

/// Name of the row over all objects.
const ALL: &str = "all";

/// Result of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GentlenessReport {
    /// Always `gentleness`.
    pub task: &'static str,
    /// Objects, seeds, engine and discarded trials.
    #[serde(flatten)]
    pub summary: HeldSummary,
    /// One row per object and gripper; with several objects also one per gripper over all.
    pub rows: Vec<GentlenessRow>,
    /// One row per condition and gripper over all objects; empty for tuning.
    pub robustness: Vec<RobustnessRow>,
}

/// Results of one object and gripper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GentlenessRow {
    /// Name of the object, or `all`.
    pub object: String,
    /// Name of the gripper.
    pub gripper: &'static str,
    /// Its force or margin; empty for the ATAS modules.
    pub setting: String,
    /// Counts by outcome.
    #[serde(flatten)]
    pub outcomes: Outcomes,
    /// Median ratio of the largest force of a fingertip to the force that friction needs.
    pub peak: Option<f64>,
    /// Median compression of the object at the largest force, mm; zero if rigid.
    pub deformation_mm: Option<f64>,
    /// Median slip in the hand, mm; lifted objects.
    pub slip_mm: Option<f64>,
    /// Median time from the start until the object is lifted by half, s.
    pub lifted_s: Option<f64>,
}

/// Results of one gripper under one condition, over all objects.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessRow {
    /// Condition as text.
    pub condition: String,
    /// Name of the gripper.
    pub gripper: &'static str,
    /// Counts by outcome.
    #[serde(flatten)]
    pub outcomes: Outcomes,
    /// Median ratio of the final force to the force that friction needs, held objects.
    pub over_grip: Option<f64>,
    /// Largest such ratio.
    pub over_grip_max: Option<f64>,
}

impl GentlenessReport {
    pub(super) fn new(plan: &GentlenessPlan, series: &[(Series, Vec<Ending>)]) -> Self {
        let all = series.iter().flat_map(|(_, endings)| endings);
        let mut rows = if plan.tunes {
            Vec::new()
        } else {
            rows(plan, series)
        };
        if plan.tunes || plan.held.objects.len() > 1 {
            let quiet = series
                .iter()
                .filter(|(series, _)| series.condition == Condition::Nominal);
            let total = |(series, endings): &(Series, Vec<Ending>)| {
                GentlenessRow::new(ALL.to_owned(), *series, endings)
            };
            rows.extend(quiet.map(total));
        }
        if plan.tunes {
            rows.sort_by(|a, b| {
                b.outcomes
                    .held
                    .cmp(&a.outcomes.held)
                    .then(order(a.peak, b.peak))
            });
        }
        let robustness = series
            .iter()
            .map(|(series, endings)| RobustnessRow::new(*series, endings));
        Self {
            task: "gentleness",
            summary: plan.held.summary(all.map(|ending| &ending.discarded)),
            rows,
            robustness: if plan.tunes {
                Vec::new()
            } else {
                robustness.collect()
            },
        }
    }

    /// Returns the tables as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let rows = self.rows.iter().map(GentlenessRow::cells);
        let mut text = rows_table(&GentlenessRow::HEADER, rows);
        if !self.robustness.is_empty() {
            let rows = self.robustness.iter().map(RobustnessRow::cells);
            text += "\n";
            text += &rows_table(&RobustnessRow::HEADER, rows);
        }
        text + &self.summary.discards()
    }
}

/// Returns the rows of each object, all grippers within an object.
fn rows(plan: &GentlenessPlan, series: &[(Series, Vec<Ending>)]) -> Vec<GentlenessRow> {
    let quiet = series
        .iter()
        .filter(|(series, _)| series.condition == Condition::Nominal);
    let of_object = |index: usize| {
        let name = &plan.held.objects[index].name;
        let seeds = plan.held.seeds as usize;
        quiet.clone().map(move |(series, endings)| {
            let endings = &endings[index * seeds..(index + 1) * seeds];
            GentlenessRow::new(name.clone(), *series, endings)
        })
    };
    (0..plan.held.objects.len()).flat_map(of_object).collect()
}

fn order(a: Option<f64>, b: Option<f64>) -> core::cmp::Ordering {
    let or_last = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
    or_last(a).total_cmp(&or_last(b))
}

impl GentlenessRow {
    /// Headings of [`GentlenessRow::cells`].
    pub const HEADER: [&str; 7] = [
        "object",
        "gripper",
        "held",
        "peak force / needed",
        "deformation mm",
        "slip mm",
        "lifted after s",
    ];

    fn new(object: String, series: Series, endings: &[Ending]) -> Self {
        let judged = || {
            endings
                .iter()
                .filter(|end| end.outcome != Outcome::Discarded)
        };
        let of = |figure: &dyn Fn(&Figures) -> Option<f64>| {
            median(judged().filter_map(|end| figure(&end.figures)).collect())
        };
        Self {
            object,
            gripper: series.grip.name(),
            setting: series.grip.setting(),
            outcomes: endings.iter().map(|ending| ending.outcome).collect(),
            peak: of(&|figures| Some(figures.peak)),
            deformation_mm: of(&|figures| Some(figures.deformation_m * 1e3)),
            slip_mm: of(&|figures| figures.lifted_s.map(|_| figures.slip_m * 1e3)),
            lifted_s: of(&|figures| figures.lifted_s),
        }
    }

    /// Returns the row as text.
    #[must_use]
    pub fn cells(&self) -> [String; 7] {
        let of = &self.outcomes;
        let lost = [
            (of.crushed, "crushed"),
            (of.dropped, "dropped"),
            (of.slipped, "slipped"),
            (of.not_lifted, "not lifted"),
            (of.discarded, "discarded"),
        ];
        let lost = lost.into_iter().filter(|(count, _)| *count > 0);
        let lost: String = lost
            .map(|(count, name)| format!(", {count} {name}"))
            .collect();
        let gripper = format!("{} {}", self.gripper, self.setting);
        [
            self.object.clone(),
            gripper.trim().replace('_', " "),
            format!("{} of {}{lost}", of.held, of.trials),
            number(self.peak),
            number(self.deformation_mm),
            number(self.slip_mm),
            self.lifted_s.map_or("–".to_owned(), |s| format!("{s:.1}")),
        ]
    }
}

impl RobustnessRow {
    /// Headings of [`RobustnessRow::cells`].
    pub const HEADER: [&str; 7] = [
        "condition",
        "gripper",
        "held",
        "crushed",
        "dropped",
        "over-grip, median",
        "largest",
    ];

    fn new(series: Series, endings: &[Ending]) -> Self {
        let held = endings.iter().filter(|end| end.outcome == Outcome::Held);
        let over_grip: Vec<f64> = held.map(|end| end.figures.over_grip).collect();
        Self {
            condition: series.condition.name(),
            gripper: series.grip.name(),
            outcomes: endings.iter().map(|ending| ending.outcome).collect(),
            over_grip_max: over_grip.iter().copied().reduce(f64::max),
            over_grip: median(over_grip),
        }
    }

    /// Returns the row as text.
    #[must_use]
    pub fn cells(&self) -> [String; 7] {
        [
            self.condition.clone(),
            self.gripper.replace('_', " "),
            format!("{} of {}", self.outcomes.held, self.outcomes.trials),
            self.outcomes.crushed.to_string(),
            self.outcomes.dropped.to_string(),
            number(self.over_grip),
            number(self.over_grip_max),
        ]
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.2}"))
}
