//! Arbitration: merges the proposals of all modules into one [`Intent`], independent of their
//! order.
//!
//! 1. Each grasp side closes at the highest proposed closing speed, or else opens at the highest
//!    proposed opening speed.
//! 2. The lowest closing ceiling limits that speed; a negative one opens.
//! 3. The hand moves to the carrying module's pose, at the lowest speed factor of all modules.
//! 4. A refusal outranks every other verdict; the end of a step outranks a stiffness.
//!
//! Speeds are slew-limited against jerks: slow increase, fast decrease.

use crate::held_object::LiftFinding;
use crate::limits::{
    CARRY_SCALE_PER_S, CLOSING_SLOW_DOWN_M_S2, CLOSING_SPEED_UP_M_S2, CLOSING_SPEED_UP_S,
};
use crate::modules::{PoseCommand, Proposal, Verdict};
use robot_model::{GraspSide, PerSide};
use shm_schemas::ReasonRecord;

/// Merged command for one hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Intent {
    /// Target pose; `None` keeps the current one.
    pub pose: Option<PoseCommand>,
    /// Closing speed per grasp side, m/s, negative opens; ignored while the path moves the fingers.
    pub closing_m_s: PerSide<f64>,
    /// Highest-ranked verdict.
    pub verdict: Verdict,
    /// Result of lift verification.
    pub finding: LiftFinding,
}

/// Merges proposals; keeps the previous speeds for the slew limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Arbiter {
    closing_m_s: PerSide<f64>,
    carry_scale: f64,
}

impl Default for Arbiter {
    fn default() -> Self {
        Self {
            closing_m_s: PerSide::repeat(0.0),
            carry_scale: 1.0,
        }
    }
}

impl Arbiter {
    /// Merges the proposals of one tick.
    ///
    /// ```
    /// use atas_core::arbitration::Arbiter;
    /// use atas_core::modules::Proposal;
    /// use robot_model::PerSide;
    ///
    /// // Both modules are active: the higher closing speed counts, in any order.
    /// let closing = |speed_m_s: f64| Proposal {
    ///     active: true,
    ///     closing_m_s: PerSide::repeat(speed_m_s),
    ///     ..Proposal::default()
    /// };
    /// let (gentle, firm) = (closing(0.001), closing(0.003));
    /// let mut arbiters = [Arbiter::default(), Arbiter::default()];
    /// let one = arbiters[0].merge(&[gentle, firm], 1e-3);
    /// let other = arbiters[1].merge(&[firm, gentle], 1e-3);
    /// assert_eq!(one, other);
    /// ```
    pub fn merge(&mut self, proposals: &[Proposal], step_s: f64) -> Intent {
        for side in GraspSide::BOTH {
            let wishes = || proposals.iter().map(|p| p.closing_m_s[side]);
            let closing = highest(wishes(), 0.0);
            let wanted = if closing > 0.0 {
                closing
            } else {
                lowest(wishes(), 0.0)
            };
            let ceiling = lowest(
                proposals.iter().map(|p| p.closing_ceiling_m_s[side]),
                f64::INFINITY,
            );
            let target = if wanted < ceiling { wanted } else { ceiling };
            self.closing_m_s[side] = slew_closing(self.closing_m_s[side], target, step_s);
        }
        let tolerated = lowest(proposals.iter().map(|p| p.carry_ceiling), 1.0);
        self.carry_scale = approach(self.carry_scale, tolerated, CARRY_SCALE_PER_S * step_s);
        Intent {
            pose: proposals.iter().find_map(|p| p.pose),
            closing_m_s: self.closing_m_s,
            verdict: highest_ranked(proposals),
            finding: proposals
                .iter()
                .map(|proposal| proposal.finding)
                .find(|finding| *finding != LiftFinding::None)
                .unwrap_or_default(),
        }
    }

    /// Returns the hand's speed factor, 0 to 1.
    #[must_use]
    pub fn carry_scale(&self) -> f64 {
        self.carry_scale
    }

    /// Returns the merged closing speed per grasp side, m/s.
    #[must_use]
    pub fn closing_m_s(&self) -> PerSide<f64> {
        self.closing_m_s
    }

    /// Resets for a new task: no closing, full hand speed, because its path starts at rest.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Resets after a stop on the way: the hand accelerates from rest.
    pub fn stop(&mut self) {
        *self = Self {
            closing_m_s: PerSide::repeat(0.0),
            carry_scale: 0.0,
        };
    }
}

fn slew_closing(before: f64, target: f64, step_s: f64) -> f64 {
    if target > before && target > 0.0 {
        let speed_up_m_s2 =
            (target / CLOSING_SPEED_UP_S).clamp(CLOSING_SPEED_UP_M_S2, CLOSING_SLOW_DOWN_M_S2);
        approach(before, target, speed_up_m_s2 * step_s)
    } else {
        approach(before, target, CLOSING_SLOW_DOWN_M_S2 * step_s)
    }
}

fn approach(before: f64, target: f64, largest_change: f64) -> f64 {
    let change = target - before;
    if change.abs() <= largest_change {
        target
    } else {
        before + largest_change.copysign(change)
    }
}

fn highest(values: impl Iterator<Item = f64>, start: f64) -> f64 {
    values.fold(start, |best, v| if v > best { v } else { best })
}

fn lowest(values: impl Iterator<Item = f64>, start: f64) -> f64 {
    values.fold(start, |best, v| if v < best { v } else { best })
}

fn highest_ranked(proposals: &[Proposal]) -> Verdict {
    let mut weightiest = Verdict::None;
    for proposal in proposals.iter().filter(|p| weight(&p.verdict) > 0) {
        let rank = |verdict| (weight(verdict), tie_breaker(verdict));
        if rank(&proposal.verdict) > rank(&weightiest) {
            weightiest = proposal.verdict;
        }
    }
    weightiest
}

/// Tie-breaker between verdicts of equal weight, so that order has no effect.
fn tie_breaker(verdict: &Verdict) -> [u64; 5] {
    match verdict {
        Verdict::None | Verdict::Done => [0; 5],
        Verdict::Stiffness(fit) => [fit.confidence.to_bits(), fit.object_n_m.to_bits(), 0, 0, 0],
        Verdict::Refuse(reason) => {
            let record = ReasonRecord::from(*reason);
            [
                record.cause.0.into(),
                record.module.0.into(),
                record.value.to_bits(),
                record.limit.to_bits(),
                record.index.into(),
            ]
        }
    }
}

fn weight(verdict: &Verdict) -> u32 {
    match verdict {
        Verdict::None => 0,
        Verdict::Stiffness(_) => 1,
        Verdict::Done => 2,
        Verdict::Refuse(_) => 3,
    }
}
