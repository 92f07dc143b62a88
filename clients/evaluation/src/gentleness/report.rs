//! Report of the gentleness: one row per object and gripper, and one per gripper and condition.

use serde::Serialize;

use super::trial::{Ending, Figures};
use super::{Condition, GentlenessPlan, Series};
use crate::held::{self, Discards, Outcome, discards_text};
use crate::seeds;
use crate::statistics::median;

/// Name of the row over all objects.
const ALL: &str = "all";

/// Result of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GentlenessReport {
    /// Always `gentleness`.
    pub task: &'static str,
    /// Physics engine, if not the built-in one.
    pub engine: Option<String>,
    /// Trials per object and gripper.
    pub seeds: u64,
    /// First seed per object.
    pub first_seed: u64,
    /// `tuning` or `judging`.
    pub purpose: &'static str,
    /// One row per object and gripper; with several objects also one per gripper over all.
    pub rows: Vec<GentlenessRow>,
    /// One row per condition and gripper over all objects; empty for tuning.
    pub robustness: Vec<RobustnessRow>,
    /// Trials that the engine could not simulate, by reason.
    pub discarded: Discards,
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
    /// Trials.
    pub trials: u64,
    /// Objects in the lifted hand at the end, stable and unharmed.
    pub held: u64,
    /// Crushed objects.
    pub crushed: u64,
    /// Dropped objects.
    pub dropped: u64,
    /// Objects that slipped or turned beyond the limits of the judge.
    pub slipped: u64,
    /// Objects that were not lifted, or put back.
    pub not_lifted: u64,
    /// Trials that the engine could not simulate: never a success.
    pub discarded: u64,
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
    /// Trials.
    pub trials: u64,
    /// Objects in the lifted hand at the end, stable and unharmed.
    pub held: u64,
    /// Crushed objects.
    pub crushed: u64,
    /// Dropped objects.
    pub dropped: u64,
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
        if plan.tunes || plan.objects.len() > 1 {
            let quiet = series
                .iter()
                .filter(|(series, _)| series.condition == Condition::Nominal);
            let total = |(series, endings): &(Series, Vec<Ending>)| {
                GentlenessRow::new(ALL.to_owned(), *series, endings)
            };
            rows.extend(quiet.map(total));
        }
        if plan.tunes {
            rows.sort_by(|a, b| b.held.cmp(&a.held).then(order(a.peak, b.peak)));
        }
        let robustness = series
            .iter()
            .map(|(series, endings)| RobustnessRow::new(*series, endings));
        Self {
            task: "gentleness",
            engine: plan.engine.as_ref().map(ToString::to_string),
            seeds: plan.seeds,
            first_seed: plan.first_seed,
            purpose: seeds::purpose(plan.first_seed, plan.seeds),
            rows,
            robustness: if plan.tunes {
                Vec::new()
            } else {
                robustness.collect()
            },
            discarded: held::count_discards(all.map(|ending| &ending.discarded)),
        }
    }

    /// Returns the tables as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let table = |header: &[&str], rows: Vec<Vec<String>>| {
            let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
            let header = header.iter().map(|cell| (*cell).to_owned()).collect();
            let rule = format!("|{}\n", "---|".repeat(Vec::len(&header)));
            line(header) + &rule + &rows.into_iter().map(line).collect::<String>()
        };
        let rows = self.rows.iter().map(|row| row.cells().to_vec());
        let mut text = table(&GentlenessRow::HEADER, rows.collect());
        if !self.robustness.is_empty() {
            let rows = self.robustness.iter().map(|row| row.cells().to_vec());
            text += "\n";
            text += &table(&RobustnessRow::HEADER, rows.collect());
        }
        text + &discards_text(&self.discarded)
    }
}

/// Returns the rows of each object, all grippers within an object.
fn rows(plan: &GentlenessPlan, series: &[(Series, Vec<Ending>)]) -> Vec<GentlenessRow> {
    let quiet = series
        .iter()
        .filter(|(series, _)| series.condition == Condition::Nominal);
    let of_object = |index: usize| {
        let name = &plan.objects[index].name;
        let seeds = plan.seeds as usize;
        quiet.clone().map(move |(series, endings)| {
            let endings = &endings[index * seeds..(index + 1) * seeds];
            GentlenessRow::new(name.clone(), *series, endings)
        })
    };
    (0..plan.objects.len()).flat_map(of_object).collect()
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
        let with = |outcome: Outcome| count(endings, outcome);
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
            trials: endings.len() as u64,
            held: with(Outcome::Held),
            crushed: with(Outcome::Crushed),
            dropped: with(Outcome::Dropped),
            slipped: with(Outcome::Slipped),
            not_lifted: with(Outcome::NotLifted),
            discarded: with(Outcome::Discarded),
            peak: of(&|figures| Some(figures.peak)),
            deformation_mm: of(&|figures| Some(figures.deformation_m * 1e3)),
            slip_mm: of(&|figures| figures.lifted_s.map(|_| figures.slip_m * 1e3)),
            lifted_s: of(&|figures| figures.lifted_s),
        }
    }

    /// Returns the row as text.
    #[must_use]
    pub fn cells(&self) -> [String; 7] {
        let lost = [
            (self.crushed, "crushed"),
            (self.dropped, "dropped"),
            (self.slipped, "slipped"),
            (self.not_lifted, "not lifted"),
            (self.discarded, "discarded"),
        ];
        let lost = lost.into_iter().filter(|(count, _)| *count > 0);
        let lost: String = lost
            .map(|(count, name)| format!(", {count} {name}"))
            .collect();
        let gripper = format!("{} {}", self.gripper, self.setting);
        [
            self.object.clone(),
            gripper.trim().replace('_', " "),
            format!("{} of {}{lost}", self.held, self.trials),
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
            trials: endings.len() as u64,
            held: over_grip.len() as u64,
            crushed: count(endings, Outcome::Crushed),
            dropped: count(endings, Outcome::Dropped),
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
            format!("{} of {}", self.held, self.trials),
            self.crushed.to_string(),
            self.dropped.to_string(),
            number(self.over_grip),
            number(self.over_grip_max),
        ]
    }
}

fn count(endings: &[Ending], outcome: Outcome) -> u64 {
    let with = endings.iter().filter(|end| end.outcome == outcome);
    with.count() as u64
}

fn number(value: Option<f64>) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.2}"))
}
