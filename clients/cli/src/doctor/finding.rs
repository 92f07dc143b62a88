//! Result of one check: verdict, fix and cost.

use atas_console::Rating;
use serde_json::{Value, json};

/// Severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// Works as intended.
    Ok,
    /// Works with reduced performance.
    Warn,
    /// The daemon cannot run or cannot keep its tick rate.
    Fail,
}

impl Verdict {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }

    pub(super) fn rating(self) -> Rating {
        match self {
            Self::Ok => Rating::Good,
            Self::Warn => Rating::Warning,
            Self::Fail => Rating::Bad,
        }
    }
}

/// Result of one check, with its fix.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Finding {
    pub(super) probe: &'static str,
    pub(super) verdict: Verdict,
    pub(super) found: String,
    /// Recommended fix; empty if none is needed.
    pub(super) fix: String,
    /// Consequence of leaving the finding; empty if no fix is needed.
    pub(super) cost: String,
}

impl Finding {
    pub(super) fn ok(probe: &'static str, found: impl Into<String>) -> Self {
        Self {
            probe,
            verdict: Verdict::Ok,
            found: found.into(),
            fix: String::new(),
            cost: String::new(),
        }
    }

    pub(super) fn warn(
        probe: &'static str,
        found: impl Into<String>,
        fix: impl Into<String>,
        cost: impl Into<String>,
    ) -> Self {
        Self {
            verdict: Verdict::Warn,
            fix: fix.into(),
            cost: cost.into(),
            ..Self::ok(probe, found)
        }
    }

    pub(super) fn fail(
        probe: &'static str,
        found: impl Into<String>,
        fix: impl Into<String>,
        cost: impl Into<String>,
    ) -> Self {
        Self {
            verdict: Verdict::Fail,
            ..Self::warn(probe, found, fix, cost)
        }
    }

    /// Returns finding, fix and cost, one per line.
    pub(super) fn text(&self) -> String {
        let mut text = self.found.clone();
        if !self.fix.is_empty() {
            text += &format!("\n→ {}", self.fix);
        }
        if !self.cost.is_empty() {
            text += &format!("\ncost: {}", self.cost);
        }
        text
    }

    pub(super) fn as_json(&self) -> Value {
        json!({
            "probe": self.probe,
            "verdict": self.verdict.name(),
            "found": self.found,
            "what_to_do": self.fix,
            "cost": self.cost,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_map_to_ratings() {
        let ratings = [Verdict::Ok, Verdict::Warn, Verdict::Fail].map(Verdict::rating);
        assert_eq!(ratings, [Rating::Good, Rating::Warning, Rating::Bad]);
    }

    #[test]
    fn text_and_json_contain_the_cost() {
        let finding = Finding::warn("clock", "slow", "boot again", "late ticks");
        assert_eq!(finding.text(), "slow\n→ boot again\ncost: late ticks");
        assert_eq!(finding.as_json()["cost"], "late ticks");
        assert_eq!(finding.as_json()["what_to_do"], "boot again");
        assert_eq!(Finding::ok("clock", "fast").text(), "fast");
    }
}
