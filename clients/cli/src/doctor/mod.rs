//! `atas doctor`: checks computer, bus and daemon, and recommends fixes.
//!
//! ```text
//!  probe (kernel, files, bus) ─▶ checks (pure: facts ─▶ Finding) ─┬▶ table or JSON, exit code
//!  --fix: stale files, governors ─▶ fix ─▶ Fix ───────────────────┘
//! ```
//!
//! * **Invariants:** each finding other than `ok` recommends a fix and states the cost of leaving
//!   it. The checks change nothing; real-time scheduling is tested in a short-lived thread. The
//!   fixes come first; the findings show the state after them.
//! * **Not included:** timing measurements, see `atas latency`.

mod checks;
mod finding;
mod fix;
mod probe;
mod root;
mod stale;

use atas_console::arguments::Doctor;
use atas_console::{Exit, ExitError, Output, table};
use serde_json::{Value, json};

use finding::{Finding, Verdict};
use fix::Fix;
use root::Root;

pub(crate) fn doctor(arguments: &Doctor, output: &mut Output) -> anyhow::Result<()> {
    let root = Root::new("/");
    let fixes = arguments.fix.then(|| fix::run(&root, arguments.dry_run));
    let mut findings = probe::machine(&root);
    findings.extend(probe::bus(&root, &arguments.bus.bus));
    print(&findings, fixes.as_deref(), output)?;
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

/// Prints all findings. `fixes`: fixes that were run or planned; `None` without `--fix`.
fn print(findings: &[Finding], fixes: Option<&[Fix]>, output: &mut Output) -> anyhow::Result<()> {
    if output.is_json() {
        let findings = findings.iter().map(|finding| as_json(finding, fixes));
        return output.json(&findings.collect::<Vec<_>>());
    }
    let mut rows = table(&["verdict", "probe", "finding, fix and cost"]);
    for finding in findings {
        rows.add_row([
            output.rated_cell(finding.verdict.name(), finding.verdict.rating()),
            finding.probe.into(),
            text(finding, fixes.unwrap_or_default()).into(),
        ]);
    }
    output.table(rows)
}

fn text(finding: &Finding, fixes: &[Fix]) -> String {
    let fixes = fixes.iter().filter(|fix| fix.probe == finding.probe);
    fixes.fold(finding.text(), |text, fix| {
        format!("{text}\n{}", fix.text())
    })
}

fn as_json(finding: &Finding, fixes: Option<&[Fix]>) -> Value {
    let mut value = finding.as_json();
    if let Some(fixes) = fixes {
        let fixes = fixes.iter().filter(|fix| fix.probe == finding.probe);
        value["fixes"] = json!(fixes.map(Fix::as_json).collect::<Vec<_>>());
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use fix::Outcome;

    #[test]
    fn fixes_are_listed_with_their_finding() {
        let findings = [
            Finding::ok(checks::GOVERNOR, "fast"),
            Finding::ok("clock", "tsc"),
        ];
        let fixes = [Fix {
            probe: checks::GOVERNOR,
            action: "set it".to_owned(),
            outcome: Outcome::Done,
        }];
        assert_eq!(text(&findings[0], &fixes), "fast\ndone: set it");
        assert_eq!(text(&findings[1], &fixes), "tsc");
        let json = findings.each_ref().map(|f| as_json(f, Some(&fixes)));
        assert_eq!(json[0]["fixes"][0]["result"], "done");
        assert_eq!(json[1]["fixes"], json!([]));
        assert!(as_json(&findings[0], None).get("fixes").is_none());
    }
}
