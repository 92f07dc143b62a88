//! Report of the disturbances: one row per case and policy.

use serde::Serialize;

use super::DisturbancePlan;
use super::trial::{Ending, Outcome};
use crate::held::{Grip, HeldSummary};
use crate::statistics::median;

/// Result of the evaluation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisturbanceReport {
    /// Always `disturbances`.
    pub task: &'static str,
    /// Objects, seeds, engine and discarded trials.
    #[serde(flatten)]
    pub summary: HeldSummary,
    /// One row per case and policy.
    pub rows: Vec<DisturbanceRow>,
}

/// Outcomes of one case with one policy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisturbanceRow {
    /// Name of the disturbance.
    pub case: String,
    /// Name of the grip policy.
    pub policy: &'static str,
    /// Its forces; empty for the ATAS modules.
    pub setting: String,
    /// Trials.
    pub trials: u64,
    /// Trials in which friction could hold the object throughout, within hand and crush force.
    pub allowed: u64,
    /// Objects in the lifted hand at the end, unharmed.
    pub kept: u64,
    /// Kept objects among the allowed trials.
    pub kept_allowed: u64,
    /// Trials in which F_2 and kinetic friction could stop the sliding object.
    pub catchable: u64,
    /// Kept objects among the catchable trials with a slip of at most 3 mm.
    pub caught: u64,
    /// Crushed objects.
    pub crushed: u64,
    /// Dropped objects.
    pub dropped: u64,
    /// Objects lowered without a drop after the disturbance.
    pub put_back: u64,
    /// Objects not in the lifted hand before the disturbance.
    pub not_lifted: u64,
    /// Trials that the engine could not simulate: never a success.
    pub discarded: u64,
    /// Median and maximum of the slip in the hand since the disturbance, mm.
    pub slip_mm: Option<[f64; 2]>,
    /// Trials in which a fingertip slid by more than 0.1 mm.
    pub slipped: u64,
    /// Of these, trials with a closing command.
    pub answered: u64,
    /// Median and maximum of the time from slip to command, ms; 0 if the command came before.
    pub slip_to_command_ms: Option<[f64; 2]>,
    /// Median ratio of the force at the end to the force then needed, kept objects.
    pub over_grip: Option<f64>,
}

impl DisturbanceReport {
    /// Summarises the endings in the order of the plan.
    pub(super) fn new(plan: &DisturbancePlan, endings: &[Ending]) -> Self {
        let grips = plan.grips();
        let cases = plan
            .cases()
            .into_iter()
            .flat_map(|case| grips.iter().map(move |grip| (case, grip)));
        let rows = cases.zip(endings.chunks(plan.held.worlds() as usize));
        let rows =
            rows.map(|((case, grip), endings)| DisturbanceRow::new(case.name(), *grip, endings));
        Self {
            task: "disturbances",
            summary: plan.held.summary(endings.iter().map(|end| &end.discarded)),
            rows: rows.collect(),
        }
    }

    /// Returns a Markdown table with one line per case.
    #[must_use]
    pub fn markdown(&self) -> String {
        let policies = self.policies();
        let mut text = "| disturbance | allowed |".to_owned();
        for policy in &policies {
            text += &format!(" {policy}: kept | caught | slip mm | response ms | over-grip |");
        }
        text += &format!("\n|---|---|{}\n", "---|".repeat(5 * policies.len()));
        for rows in self.rows.chunks(policies.len()) {
            text += &format!("| {} | {} |", rows[0].case, rows[0].allowed);
            for row in rows {
                text += &format!(" {} |", row.cells().join(" | "));
            }
            text += "\n";
        }
        text + &self.summary.discards()
    }

    /// Returns the names of the policies with their settings.
    #[must_use]
    pub fn policies(&self) -> Vec<String> {
        let first = self
            .rows
            .iter()
            .take_while(|row| row.case == self.rows[0].case);
        let name = |row: &DisturbanceRow| format!("{} {}", row.policy, row.setting);
        first
            .map(|row| name(row).trim().replace('_', " "))
            .collect()
    }
}

impl DisturbanceRow {
    fn new(case: String, grip: Grip, endings: &[Ending]) -> Self {
        let count =
            |is: &dyn Fn(&Ending) -> bool| endings.iter().filter(|end| is(end)).count() as u64;
        let with = |outcome: Outcome| count(&|end| end.outcome == outcome);
        Self {
            case,
            policy: grip.name(),
            setting: grip.setting(),
            trials: endings.len() as u64,
            allowed: count(&|end| end.allowed),
            kept: with(Outcome::Kept),
            kept_allowed: count(&|end| end.allowed && end.outcome == Outcome::Kept),
            catchable: count(&|end| end.catchable),
            caught: count(&Ending::is_caught),
            crushed: with(Outcome::Crushed),
            dropped: with(Outcome::Dropped),
            put_back: with(Outcome::PutBack),
            not_lifted: with(Outcome::NotLifted),
            discarded: with(Outcome::Discarded),
            slip_mm: spread(endings.iter().filter_map(|end| Some(end.slip_m? * 1e3))),
            slipped: count(&|end| end.slipped),
            answered: count(&|end| end.latency_ms.is_some()),
            slip_to_command_ms: spread(endings.iter().filter_map(|end| end.latency_ms)),
            over_grip: median(endings.iter().filter_map(|end| end.over_grip).collect()),
        }
    }

    /// Returns outcomes, caught objects, slip, response and over-grip as text.
    #[must_use]
    pub fn cells(&self) -> [String; 5] {
        let lost = [
            (self.dropped, "dropped"),
            (self.crushed, "crushed"),
            (self.put_back, "put back"),
            (self.not_lifted, "not lifted"),
            (self.discarded, "discarded"),
        ];
        let lost = lost.into_iter().filter(|(count, _)| *count > 0);
        let lost = lost.map(|(count, name)| format!(", {count} {name}"));
        let pair = |pair: Option<[f64; 2]>, digits: usize| match pair {
            Some([middle, most]) => format!("{middle:.digits$}; {most:.digits$}"),
            None => "–".to_owned(),
        };
        let response = match self.slipped {
            0 => "no slip".to_owned(),
            slipped => {
                let times = pair(self.slip_to_command_ms, 0);
                format!("{times} ({} of {slipped})", self.answered)
            }
        };
        [
            format!(
                "{} of {}{}",
                self.kept,
                self.trials,
                lost.collect::<String>()
            ),
            format!("{} of {}", self.caught, self.catchable),
            pair(self.slip_mm, 2),
            response,
            self.over_grip
                .map_or("–".to_owned(), |over| format!("{over:.2}")),
        ]
    }
}

/// Returns median and maximum.
fn spread(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let values: Vec<f64> = values.collect();
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    median(values).map(|middle| [middle, most])
}
