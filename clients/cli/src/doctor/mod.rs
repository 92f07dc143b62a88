//! `atas doctor`: can this machine hold the tick, is the bus sound, is the daemon well, and if not, what to do.
//!
//! ```text
//!  probe (asks the kernel, the files, the bus) ─▶ judge (pure: facts ─▶ Finding) ─▶ a table or JSON, and the exit code
//! ```
//!
//! * **Invariants:** every finding that is not `ok` says what to do about it. Nothing is changed: what is tried (real-time
//!   scheduling) is tried in a thread of its own that ends at once.
//! * **Absent on purpose:** measurements of time, which are those of `atas latency`.

mod judge;
mod probe;

use atas_console::{Ended, Exit, Mood, Output, table};
use serde_json::json;
use shm_bus::BusName;

/// What a probe says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// Nothing to do.
    Ok,
    /// It works, less well than it could.
    Warn,
    /// The daemon cannot run here, or cannot hold its ticks.
    Fail,
}

impl Verdict {
    fn name(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warn => "warn",
            Self::Fail => "fail",
        }
    }

    fn mood(self) -> Mood {
        match self {
            Self::Ok => Mood::Good,
            Self::Warn => Mood::Warning,
            Self::Fail => Mood::Bad,
        }
    }
}

/// What one probe found.
#[derive(Clone, Debug, PartialEq)]
struct Finding {
    probe: &'static str,
    verdict: Verdict,
    found: String,
    /// What to do; empty if nothing.
    cure: String,
}

impl Finding {
    fn ok(probe: &'static str, found: impl Into<String>) -> Self {
        Self {
            probe,
            verdict: Verdict::Ok,
            found: found.into(),
            cure: String::new(),
        }
    }

    fn warn(probe: &'static str, found: impl Into<String>, cure: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Warn,
            cure: cure.into(),
            ..Self::ok(probe, found)
        }
    }

    fn fail(probe: &'static str, found: impl Into<String>, cure: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Fail,
            cure: cure.into(),
            ..Self::ok(probe, found)
        }
    }
}

/// `atas doctor`.
pub(crate) fn doctor(bus: &BusName, output: &mut Output) -> anyhow::Result<()> {
    let mut findings = probe::machine();
    findings.extend(probe::bus(bus));
    print(&findings, output)?;
    let failed: Vec<&str> = findings
        .iter()
        .filter(|finding| finding.verdict == Verdict::Fail)
        .map(|finding| finding.probe)
        .collect();
    if failed.is_empty() {
        return Ok(());
    }
    let sentence = format!("not in order: {}", failed.join(", "));
    Err(Ended::with(Exit::Failed, sentence))
}

fn print(findings: &[Finding], output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&findings.iter().map(as_json).collect::<Vec<_>>());
    }
    let mut rows = table(&["verdict", "probe", "found, and what to do"]);
    for finding in findings {
        let text = if finding.cure.is_empty() {
            finding.found.clone()
        } else {
            format!("{}\n→ {}", finding.found, finding.cure)
        };
        rows.add_row([
            output.verdict(finding.verdict.name(), finding.verdict.mood()),
            finding.probe.into(),
            text.into(),
        ]);
    }
    output.table(rows)
}

fn as_json(finding: &Finding) -> serde_json::Value {
    json!({
        "probe": finding.probe,
        "verdict": finding.verdict.name(),
        "found": finding.found,
        "what_to_do": finding.cure,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_is_told_as_one() {
        let moods = [Verdict::Ok, Verdict::Warn, Verdict::Fail].map(Verdict::mood);
        assert_eq!(moods, [Mood::Good, Mood::Warning, Mood::Bad]);
    }
}
