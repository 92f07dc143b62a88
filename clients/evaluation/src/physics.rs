//! Counts of trials by feasibility: success means holding a feasible object and refusing an
//! infeasible one.
//!
//! Feasibility has two definitions: the paper's rule, which limits the force by F_2
//! ([`Load::is_feasible`]), and physics alone ([`Load::is_physically_feasible`]). Physics alone is
//! the fair measure for a policy without F_2.
//!
//! [`Load::is_feasible`]: crate::judge::Load::is_feasible [`Load::is_physically_feasible`]:
//! crate::judge::Load::is_physically_feasible

use serde::Serialize;

use crate::statistics::{deviation, median, wilson};
use crate::tally::share;
use crate::trial::Record;

/// Counts of trials by feasibility.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Physics {
    /// Trials that are feasible under the paper's rule.
    pub feasible: Feasible,
    /// All other trials.
    pub infeasible: Infeasible,
    /// Counts with feasibility by physics alone.
    pub by_physics: ByPhysics,
    /// Number of trials so near to F_2 that either outcome is right.
    pub borderline: u64,
    /// Median ratio of measured F_2 to F_2 at the true stiffness.
    pub f2_ratio_median: Option<f64>,
    /// Standard deviation of that ratio.
    pub f2_ratio_deviation: Option<f64>,
}

/// Counts with feasibility by physics alone: the force against rotation is below the crush force
/// and the hand's maximum.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByPhysics {
    /// Share of successful trials.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
    /// Feasible trials.
    pub feasible: Feasible,
    /// All other trials.
    pub infeasible: Infeasible,
}

/// Feasible trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Feasible {
    /// Trials.
    pub trials: u64,
    /// Succeeded.
    pub held: u64,
    /// Put back unharmed although feasible.
    pub refused: u64,
    /// Crushed.
    pub crushed: u64,
    /// Dropped.
    pub dropped: u64,
    /// Share of held trials.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
    /// Median ratio of true to needed normal force, held trials; `null` without one.
    pub over_grip_median: Option<f64>,
}

/// Infeasible trials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Infeasible {
    /// Trials.
    pub trials: u64,
    /// Left unharmed, upright and in place.
    pub refused: u64,
    /// Held or placed although infeasible.
    pub held: u64,
    /// Crushed.
    pub crushed: u64,
    /// Dropped.
    pub dropped: u64,
    /// Share of refused trials.
    pub success: f64,
    /// 95 % Wilson interval of `success`.
    pub ci95: [f64; 2],
}

impl Physics {
    /// Counts trials; `None` if no trial has a load (screwing, assembly).
    pub(super) fn from_records(records: &[&Record]) -> Option<Self> {
        let loads: Vec<_> = records.iter().filter_map(|r| r.load).collect();
        if loads.is_empty() {
            return None;
        }
        let f2_ratios: Vec<f64> = records.iter().filter_map(|r| r.finding.f2_ratio).collect();
        let (feasible, infeasible) = split_by_feasibility(records, Record::feasible);
        Some(Self {
            feasible,
            infeasible,
            by_physics: ByPhysics::from_records(records),
            borderline: loads.iter().filter(|load| load.is_borderline()).count() as u64,
            f2_ratio_deviation: deviation(&f2_ratios),
            f2_ratio_median: median(f2_ratios),
        })
    }
}

impl ByPhysics {
    fn from_records(records: &[&Record]) -> Self {
        let (feasible, infeasible) = split_by_feasibility(records, Record::feasible_by_physics);
        let (successes, trials) = (feasible.held + infeasible.refused, records.len() as u64);
        Self {
            success: share(successes, trials),
            ci95: wilson(successes, trials),
            feasible,
            infeasible,
        }
    }
}

fn split_by_feasibility(
    records: &[&Record],
    is_feasible: fn(&Record) -> bool,
) -> (Feasible, Infeasible) {
    let (can, cannot): (Vec<&Record>, Vec<&Record>) =
        records.iter().copied().partition(|r| is_feasible(r));
    (count_feasible(&can), count_infeasible(&cannot))
}

fn count_feasible(records: &[&Record]) -> Feasible {
    let (trials, held) = (records.len() as u64, count(records, |r| r.finding.done));
    let held_ones = records.iter().filter(|r| r.finding.done);
    let over_grips = held_ones.filter_map(|r| r.finding.measure("over_grip"));
    Feasible {
        trials,
        held,
        refused: count(records, |r| r.finding.refused),
        crushed: count(records, |r| r.finding.crushed),
        dropped: count(records, |r| r.finding.dropped),
        success: share(held, trials),
        ci95: wilson(held, trials),
        over_grip_median: median(over_grips.collect()),
    }
}

fn count_infeasible(records: &[&Record]) -> Infeasible {
    let (trials, refused) = (records.len() as u64, count(records, |r| r.finding.refused));
    Infeasible {
        trials,
        refused,
        held: count(records, |r| r.finding.done),
        crushed: count(records, |r| r.finding.crushed),
        dropped: count(records, |r| r.finding.dropped),
        success: share(refused, trials),
        ci95: wilson(refused, trials),
    }
}

fn count(records: &[&Record], is: impl Fn(&Record) -> bool) -> u64 {
    records.iter().filter(|record| is(record)).count() as u64
}
