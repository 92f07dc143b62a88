//! Trials apart by what physics allows: what can be held shall be, what cannot shall be refused.
//!
//! Twice: under the paper's rule, whose F_2 says what an object bears ([`Load::is_feasible`]), and by physics alone
//! ([`Load::is_physically_feasible`]), which is the fair measure of a policy that knows no F_2.
//!
//! [`Load::is_feasible`]: crate::judge::Load::is_feasible
//! [`Load::is_physically_feasible`]: crate::judge::Load::is_physically_feasible

use serde::Serialize;

use crate::statistics::{deviation, median, wilson};
use crate::tally::share;
use crate::trial::Record;

/// Trials by what physics allows.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Physics {
    /// Trials whose object can be held under the paper's rule.
    pub feasible: Feasible,
    /// All others.
    pub infeasible: Infeasible,
    /// The same by physics alone.
    pub by_physics: ByPhysics,
    /// How many lie so near to F_2 that either end would be right.
    pub borderline: u64,
    /// Median of the measured F_2 over the F_2 at the true stiffness.
    pub f2_ratio_median: Option<f64>,
    /// Standard deviation of the same.
    pub f2_ratio_deviation: Option<f64>,
}

/// Trials by physics alone: what holds it steady neither crushes it nor is more than the hand can press.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ByPhysics {
    /// Share of all trials that are a success.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// Trials whose object can be held.
    pub feasible: Feasible,
    /// All others.
    pub infeasible: Infeasible,
}

/// Trials whose object can be held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Feasible {
    /// How many there were.
    pub trials: u64,
    /// Lifted, in the hand after the hold as it was taken, neither crushed nor dropped; or placed as it should be.
    pub held: u64,
    /// Put back unharmed, although they could have been held.
    pub refused: u64,
    /// Crushed.
    pub crushed: u64,
    /// Dropped.
    pub dropped: u64,
    /// Share of those held.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
    /// Median over held trials of true normal force over needed force; `null` if none was held.
    pub over_grip_median: Option<f64>,
}

/// Trials whose object cannot be held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Infeasible {
    /// How many there were.
    pub trials: u64,
    /// Left unharmed, upright and where they were.
    pub refused: u64,
    /// Held or placed all the same.
    pub held: u64,
    /// Crushed.
    pub crushed: u64,
    /// Dropped.
    pub dropped: u64,
    /// Share of those refused.
    pub success: f64,
    /// Wilson score interval of `success`, 95 %.
    pub ci95: [f64; 2],
}

impl Physics {
    /// `None` unless there are objects to hold.
    pub(super) fn of(records: &[&Record]) -> Option<Self> {
        let loads: Vec<_> = records.iter().filter_map(|r| r.load).collect();
        if loads.is_empty() {
            return None;
        }
        let f2_ratios: Vec<f64> = records.iter().filter_map(|r| r.finding.f2_ratio).collect();
        let (feasible, infeasible) = apart(records, Record::feasible);
        Some(Self {
            feasible,
            infeasible,
            by_physics: ByPhysics::of(records),
            borderline: loads.iter().filter(|load| load.is_borderline()).count() as u64,
            f2_ratio_deviation: deviation(&f2_ratios),
            f2_ratio_median: median(f2_ratios),
        })
    }
}

impl ByPhysics {
    fn of(records: &[&Record]) -> Self {
        let (feasible, infeasible) = apart(records, Record::feasible_by_physics);
        let (successes, trials) = (feasible.held + infeasible.refused, records.len() as u64);
        Self {
            success: share(successes, trials),
            ci95: wilson(successes, trials),
            feasible,
            infeasible,
        }
    }
}

fn apart(records: &[&Record], is_feasible: fn(&Record) -> bool) -> (Feasible, Infeasible) {
    let (can, cannot): (Vec<&Record>, Vec<&Record>) =
        records.iter().copied().partition(|r| is_feasible(r));
    (feasible(&can), infeasible(&cannot))
}

fn feasible(records: &[&Record]) -> Feasible {
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

fn infeasible(records: &[&Record]) -> Infeasible {
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
