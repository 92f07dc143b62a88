//! `atas doctor`: checks computer, bus and daemon, and recommends fixes.
//!
//! ```text
//!  probe (kernel, files, bus) ─▶ checks (pure: facts ─▶ Finding) ─▶ table or JSON, exit code
//! ```
//!
//! * **Invariants:** each finding other than `ok` recommends a fix. The checks change nothing;
//!   real-time scheduling is tested in a short-lived thread.
//! * **Not included:** timing measurements, see `atas latency`.

mod checks;
mod probe;

use atas_console::{Exit, ExitError, Output, Rating, table};
use serde_json::json;
use shm_bus::BusName;

/// Result of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// Works as intended.
    Ok,
    /// Works with reduced performance.
    Warn,
    /// The daemon cannot run or cannot keep its tick rate.
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

    fn rating(self) -> Rating {
        match self {
            Self::Ok => Rating::Good,
            Self::Warn => Rating::Warning,
            Self::Fail => Rating::Bad,
        }
    }
}

/// Result of one check, with its fix.
#[derive(Clone, Debug, PartialEq)]
struct Finding {
    probe: &'static str,
    verdict: Verdict,
    found: String,
    /// Recommended fix; empty if none is needed.
    fix: String,
}

impl Finding {
    fn ok(probe: &'static str, found: impl Into<String>) -> Self {
        Self {
            probe,
            verdict: Verdict::Ok,
            found: found.into(),
            fix: String::new(),
        }
    }

    fn warn(probe: &'static str, found: impl Into<String>, cure: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Warn,
            fix: cure.into(),
            ..Self::ok(probe, found)
        }
    }

    fn fail(probe: &'static str, found: impl Into<String>, cure: impl Into<String>) -> Self {
        Self {
            verdict: Verdict::Fail,
            fix: cure.into(),
            ..Self::ok(probe, found)
        }
    }
}

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
    let sentence = format!("checks failed: {}", failed.join(", "));
    Err(ExitError::with_code(Exit::Failed, sentence))
}

fn print(findings: &[Finding], output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        return output.json(&findings.iter().map(as_json).collect::<Vec<_>>());
    }
    let mut rows = table(&["verdict", "probe", "finding and fix"]);
    for finding in findings {
        let text = if finding.fix.is_empty() {
            finding.found.clone()
        } else {
            format!("{}\n→ {}", finding.found, finding.fix)
        };
        rows.add_row([
            output.rated_cell(finding.verdict.name(), finding.verdict.rating()),
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
        "what_to_do": finding.fix,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdicts_map_to_ratings() {
        let moods = [Verdict::Ok, Verdict::Warn, Verdict::Fail].map(Verdict::rating);
        assert_eq!(moods, [Rating::Good, Rating::Warning, Rating::Bad]);
    }
}
