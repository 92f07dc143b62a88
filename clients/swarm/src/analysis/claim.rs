//! Claims of the paper (III.c), each with the border that its estimate must exceed.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use super::findings::{Findings, Verdict};
use crate::stats::Estimate;

/// Border of [`Claim::KeepOut`]: share of solved four-agent trials in which redundant agents keep
/// out. Design choice: the paper shows two examples and gives no rate.
const KEEP_OUT_SHARE_MIN: f64 = 0.5;

/// A claim, in the order of the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Claim {
    /// Several agents reach more than five times the fitness of one: smallest median of several
    /// over the median of one.
    FiveTimes,
    /// The claim of [`Claim::FiveTimes`] between two random runs.
    FiveTimesRunByRun,
    /// Three beat four.
    ThreeBeatFour,
    /// Two beat four.
    TwoBeatFour,
    /// Three beat two: "three agents are optimum".
    ThreeBeatTwo,
    /// One agent stays trapped.
    Trapped,
    /// One agent circles (Fig. 15).
    Circles,
    /// Redundant agents keep out of solved trials (Fig. 17).
    KeepOut,
}

impl Claim {
    /// All claims in the order of the paper.
    pub const ALL: [Self; 8] = [
        Self::FiveTimes,
        Self::FiveTimesRunByRun,
        Self::ThreeBeatFour,
        Self::TwoBeatFour,
        Self::ThreeBeatTwo,
        Self::Trapped,
        Self::Circles,
        Self::KeepOut,
    ];

    /// Returns a description.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::FiveTimes => "several reach 5 x one: smallest/one median",
            Self::FiveTimesRunByRun => "P(a run of several >= 5 x a run of one)",
            Self::ThreeBeatFour => "three beat four: P(run of 3 > run of 4)",
            Self::TwoBeatFour => "two beat four: P(run of 2 > run of 4)",
            Self::ThreeBeatTwo => "three are optimal: P(run of 3 > run of 2)",
            Self::Trapped => "one agent stays trapped",
            Self::Circles => "one agent circles (frames 91 to 270)",
            Self::KeepOut => "redundant agents keep out of solved trials",
        }
    }

    /// Returns the estimate of the runs; `None` without runs of the required team sizes.
    #[must_use]
    pub fn estimate(self, findings: &Findings) -> Option<Estimate> {
        let Findings {
            ratio,
            order,
            single,
            redundancy,
            ..
        } = findings;
        match self {
            Self::FiveTimes => *ratio,
            Self::FiveTimesRunByRun => order.multi_ge_5x_single,
            Self::ThreeBeatFour => order.three_gt_four,
            Self::TwoBeatFour => order.two_gt_four,
            Self::ThreeBeatTwo => order.three_gt_two,
            Self::Trapped => single.as_ref().map(|single| single.trapped),
            Self::Circles => single.as_ref().map(|single| single.circling),
            Self::KeepOut => redundancy.as_ref().map(|redundancy| redundancy.keep_out),
        }
    }

    /// Returns the border that the estimate must exceed.
    #[must_use]
    pub fn border(self) -> f64 {
        match self {
            Self::FiveTimes => 5.0,
            Self::KeepOut => KEEP_OUT_SHARE_MIN,
            _ => 0.5,
        }
    }

    /// Returns the verdict at the 95 % level.
    #[must_use]
    pub fn verdict(self, findings: &Findings) -> Option<Verdict> {
        self.estimate(findings)
            .map(|estimate| Verdict::above(self.border(), estimate))
    }
}

impl fmt::Display for Claim {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::FiveTimes => "five-times",
            Self::FiveTimesRunByRun => "five-times-run-by-run",
            Self::ThreeBeatFour => "three-beat-four",
            Self::TwoBeatFour => "two-beat-four",
            Self::ThreeBeatTwo => "three-beat-two",
            Self::Trapped => "trapped",
            Self::Circles => "circles",
            Self::KeepOut => "keep-out",
        })
    }
}

impl FromStr for Claim {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names = || Self::ALL.map(|claim| claim.to_string()).join(", ");
        let named = |claim: &Self| claim.to_string() == text;
        let found = Self::ALL.into_iter().find(named);
        found.ok_or_else(|| format!("a finding is {text:?}, needs one of {}", names()))
    }
}
