//! Arbitration: merges the proposals of all modules into one intent, by rules that do not depend on their order.
//!
//! 1. Fingers close at the highest speed that any module wants; if none wants to close, they open at the highest speed
//!    that any wants,
//! 2. but no faster than the lowest ceiling that any module sets; a negative ceiling opens.
//! 3. The hand goes where the carrying module wants it, at the lowest speed factor that any module tolerates.
//! 4. A refusal outweighs every other verdict, and the end of a step outweighs a stiffness.
//!
//! Speeds are slewed so that switching modules does not jerk the joints: slowly up, quickly down.

use crate::limits::{CARRY_SCALE_PER_S, CLOSING_SLOW_DOWN_M_S2, CLOSING_SPEED_UP_M_S2};
use crate::modules::{Finding, PoseCommand, Proposal, Verdict};
use robot_model::VIRTUAL_FINGERS;

/// What one hand shall do in this tick.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Intent {
    /// Where the hand shall be; `None` keeps it.
    pub pose: Option<PoseCommand>,
    /// Closing speed of each virtual finger, m/s, negative opens; not used while the path includes the fingers.
    pub closing_m_s: [f64; VIRTUAL_FINGERS],
    /// What the modules conclude.
    pub verdict: Verdict,
    /// What any of them has found out.
    pub finding: Finding,
}

/// The speeds of the tick before, which limit those of this one.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Arbiter {
    closing_m_s: [f64; VIRTUAL_FINGERS],
    carry_scale: f64,
}

impl Default for Arbiter {
    fn default() -> Self {
        Self {
            closing_m_s: [0.0; VIRTUAL_FINGERS],
            carry_scale: 1.0,
        }
    }
}

impl Arbiter {
    /// Merges the proposals.
    pub fn merge(&mut self, proposals: &[Proposal], step_s: f64) -> Intent {
        for finger in 0..VIRTUAL_FINGERS {
            let wishes = || proposals.iter().map(|p| p.closing_m_s[finger]);
            let closing = highest(wishes(), 0.0);
            let wanted = if closing > 0.0 {
                closing
            } else {
                lowest(wishes(), 0.0)
            };
            let ceiling = lowest(
                proposals.iter().map(|p| p.closing_ceiling_m_s[finger]),
                f64::INFINITY,
            );
            let target = if wanted < ceiling { wanted } else { ceiling };
            self.closing_m_s[finger] = slew_closing(self.closing_m_s[finger], target, step_s);
        }
        let tolerated = lowest(proposals.iter().map(|p| p.carry_ceiling), 1.0);
        self.carry_scale = approach(self.carry_scale, tolerated, CARRY_SCALE_PER_S * step_s);
        Intent {
            pose: proposals.iter().find_map(|p| p.pose),
            closing_m_s: self.closing_m_s,
            verdict: weightiest(proposals),
            finding: Finding {
                slides: proposals.iter().any(|p| p.finding.slides),
                hangs: proposals.iter().any(|p| p.finding.hangs),
                tries: proposals.iter().any(|p| p.finding.tries),
            },
        }
    }

    /// Factor on the hand's speed that the modules tolerate now.
    #[must_use]
    pub fn carry_scale(&self) -> f64 {
        self.carry_scale
    }

    /// Closing speed of each virtual finger, as merged last, m/s.
    #[must_use]
    pub fn closing_m_s(&self) -> [f64; VIRTUAL_FINGERS] {
        self.closing_m_s
    }

    /// Another task begins: the fingers stand still, and a path begins at rest by itself.
    pub fn rest(&mut self) {
        *self = Self::default();
    }

    /// The hand was stopped on its way: it takes up its speed from nothing.
    pub fn halt(&mut self) {
        *self = Self {
            closing_m_s: [0.0; VIRTUAL_FINGERS],
            carry_scale: 0.0,
        };
    }
}

/// Closing may only grow slowly; stopping and opening must come at once.
fn slew_closing(before: f64, target: f64, step_s: f64) -> f64 {
    if target > before && target > 0.0 {
        approach(before, target, CLOSING_SPEED_UP_M_S2 * step_s)
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

fn weightiest(proposals: &[Proposal]) -> Verdict {
    let mut weightiest = Verdict::None;
    for proposal in proposals {
        let rank = |verdict| (weight(verdict), content(verdict));
        if rank(&proposal.verdict) > rank(&weightiest) {
            weightiest = proposal.verdict;
        }
    }
    weightiest
}

/// What decides between two verdicts of equal weight: what they say, and not who was asked first.
fn content(verdict: &Verdict) -> [u64; 5] {
    match verdict {
        Verdict::None | Verdict::Done => [0; 5],
        Verdict::Stiffness(fit) => [fit.confidence.to_bits(), fit.object_n_m.to_bits(), 0, 0, 0],
        Verdict::Refuse(reason) => [
            reason.cause.0.into(),
            reason.module.0.into(),
            reason.value.to_bits(),
            reason.limit.to_bits(),
            reason.index.into(),
        ],
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
