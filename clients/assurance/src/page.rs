//! Page of the guide, in Markdown.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use anyhow::Context;

use crate::assessment::{AssessedClaim, AssessedEvidence, Assessment, Problem};

/// Widest line of prose and of commands, columns.
const COLUMNS: usize = 100;
/// Most fault rows of a claim that its table lists; more are summed up in one row. Design choice:
/// each of them appears below another claim.
const ROWS: usize = 20;

/// Returns the page of an assessment.
#[must_use]
pub fn page(assessment: &Assessment) -> String {
    let mut page = String::new();
    head(&mut page, assessment);
    outline(&mut page, assessment);
    summary(&mut page, assessment);
    for strategy in &assessment.strategies {
        let _ = writeln!(page, "\n## {}: {}", strategy.id, strategy.text);
        let claims = assessment.claims.iter();
        for claim in claims.filter(|claim| claim.strategy == strategy.id) {
            section(&mut page, claim);
        }
    }
    not_claimed(&mut page, assessment);
    page
}

/// Compares the stored page with the generated one. A difference becomes a problem.
///
/// # Errors
/// The page exists but cannot be read.
pub fn compare_page(assessment: &mut Assessment, path: &Path) -> anyhow::Result<()> {
    let stored = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
        Err(error) => {
            return Err(error).with_context(|| format!("could not read {}", path.display()));
        }
    };
    let generated = page(assessment);
    if stored == generated {
        return Ok(());
    }
    let lines = stored.lines().zip(generated.lines());
    let equal = lines.take_while(|(stored, generated)| stored == generated);
    let line = equal.count() + 1;
    let path = path.display();
    assessment.problems.push(Problem {
        subject: "page".to_owned(),
        text: format!("{path}:{line} is not up to date; run `atas assure --out {path}`"),
    });
    assessment.is_shown = false;
    Ok(())
}

fn head(page: &mut String, assessment: &Assessment) {
    page.push_str("# Assurance case\n\n");
    wrapped(
        page,
        "",
        "`atas assure` generates this page from `clients/assurance/case.toml` and the stored \
         results of real runs. It states the claims about safety, the argument and the evidence of \
         each claim, and its last result. `atas assure --check` fails if a claim has no passed \
         evidence, if evidence does not exist or is stale, or if this page differs.",
    );
    page.push('\n');
    wrapped(
        page,
        "",
        "Read the [safety concept](safety.md) first. **ATAS is not a certified safety function.**",
    );
    let shown = assessment.claims.iter().filter(|claim| claim.is_shown);
    let _ = write!(
        page,
        "\n| version | claims shown | cores of the machine |\n|---|---|---|\n| {} | {} of {} | {} |\n",
        assessment.version,
        shown.count(),
        assessment.claims.len(),
        cores(assessment),
    );
    let extent = assessment.extent;
    page.push_str("\n## Extent of the evidence\n\n");
    page.push_str("| evidence | extent at least | command |\n|---|---|---|\n");
    let rows = [
        (
            "faults in virtual time",
            format!("{} of each task, in each phase", seeds(extent.seeds)),
            "`atas fault run`",
        ),
        (
            "faults of processes",
            format!(
                "{} of each task, in one random phase",
                seeds(extent.process_seeds)
            ),
            "`atas fault run`",
        ),
        (
            "random runs",
            format!("{} ticks", grouped(extent.ticks)),
            "`atas soak`",
        ),
        (
            "stops under load",
            format!("{} stops", grouped(extent.stops)),
            "`atas bench stop`",
        ),
        ("tests", "one run of each".to_owned(), "`cargo test`"),
    ];
    for (evidence, extent, command) in rows {
        let _ = writeln!(page, "| {evidence} | {extent} | {command} |");
    }
    page.push('\n');
    wrapped(
        page,
        "",
        "`atas assure --run --scale 20` collects twenty times this extent on your machine.",
    );
    page.push_str("\nConditions of the last results:\n\n");
    for (evidence, conditions) in conditions(assessment) {
        wrapped(page, "- ", &format!("{evidence}: {conditions}"));
    }
}

/// Returns the conditions of the last results, each once, with the kind of evidence.
fn conditions(assessment: &Assessment) -> BTreeSet<(&'static str, &str)> {
    let evidence = assessment.claims.iter().flat_map(|claim| &claim.evidence);
    let conditions = evidence.filter_map(|item| {
        let last = item
            .last
            .as_ref()
            .filter(|last| !last.conditions.is_empty())?;
        let kind = match item.trial {
            "runs" => "faults",
            "ticks" => "random runs",
            _ => "stops",
        };
        Some((kind, last.conditions.as_str()))
    });
    conditions.collect()
}

fn seeds(count: u64) -> String {
    match count {
        1 => "1 seed".to_owned(),
        _ => format!("{count} seeds"),
    }
}

/// Returns the numbers of cores in the results.
fn cores(assessment: &Assessment) -> String {
    let evidence = assessment.claims.iter().flat_map(|claim| &claim.evidence);
    let mut cores: Vec<usize> = evidence
        .filter_map(|item| item.last.as_ref())
        .map(|last| last.cores)
        .collect();
    cores.sort_unstable();
    cores.dedup();
    let cores: Vec<String> = cores.iter().map(usize::to_string).collect();
    cores.join(", ")
}

/// Goal structure as a tree of text.
fn outline(page: &mut String, assessment: &Assessment) {
    page.push_str("\n## Goal structure\n\n");
    wrapped(
        page,
        "",
        "Goal structuring notation as text: G are goals (claims), S strategies, Sn solutions \
         (evidence).",
    );
    let _ = write!(page, "\n```text\nG00 {}\n", assessment.goal.text);
    let last = assessment.strategies.len().saturating_sub(1);
    for (index, strategy) in assessment.strategies.iter().enumerate() {
        let (branch, stem) = branch(index == last);
        let _ = writeln!(page, "{branch}{} {}", strategy.id, strategy.text);
        let claims: Vec<&AssessedClaim> = assessment
            .claims
            .iter()
            .filter(|claim| claim.strategy == strategy.id)
            .collect();
        for (index, claim) in claims.iter().enumerate() {
            let (branch, inner) = self::branch(index + 1 == claims.len());
            let _ = writeln!(page, "{stem}{branch}{} {}", claim.id, claim.text);
            let _ = writeln!(page, "{stem}{inner}└─ Sn: {}", solutions(claim));
        }
    }
    page.push_str("```\n\nContext of the goal:\n\n");
    for text in &assessment.goal.context {
        wrapped(page, "- ", text);
    }
}

fn branch(is_last: bool) -> (&'static str, &'static str) {
    if is_last {
        ("└─ ", "   ")
    } else {
        ("├─ ", "│  ")
    }
}

/// Lists the evidence of a claim by kind.
fn solutions(claim: &AssessedClaim) -> String {
    let count = |trial: &str| {
        let items = claim.evidence.iter();
        items.filter(|item| item.trial == trial).count()
    };
    let plural = |count: usize, word: &str| match count {
        0 => None,
        1 => Some(format!("1 {word}")),
        _ => Some(format!("{count} {word}s")),
    };
    let parts = [
        plural(count("runs"), "fault"),
        (count("ticks") > 0).then(|| "random runs".to_owned()),
        (count("stops") > 0).then(|| "stops under load".to_owned()),
        plural(count("test"), "test"),
    ];
    Vec::from_iter(parts.into_iter().flatten()).join(", ")
}

fn summary(page: &mut String, assessment: &Assessment) {
    page.push_str("\n## Results\n\n");
    page.push_str("| claim | tried | passed | worst of bound | state |\n|---|---|---|---|---|\n");
    for claim in &assessment.claims {
        let _ = writeln!(
            page,
            "| {} {} | {} | {} | {} | {} |",
            claim.id,
            claim.name,
            trials(claim, |item| item
                .last
                .as_ref()
                .map_or(0, |last| last.tried)),
            trials(claim, |item| item
                .last
                .as_ref()
                .map_or(0, |last| last.passed)),
            worst(claim),
            state(claim.is_shown),
        );
    }
}

fn state(is_shown: bool) -> &'static str {
    if is_shown { "shown" } else { "**not shown**" }
}

/// Sums up the trials of a claim by their unit.
fn trials(claim: &AssessedClaim, of: impl Fn(&AssessedEvidence) -> u64) -> String {
    let sum = |trial: &str| -> (bool, u64) {
        let items = claim.evidence.iter().filter(|item| item.trial == trial);
        let values: Vec<u64> = items.map(&of).collect();
        (!values.is_empty(), values.iter().sum())
    };
    let parts = ["runs", "ticks", "stops", "test"]
        .into_iter()
        .filter_map(|trial| {
            let (is_there, count) = sum(trial);
            let unit = if trial == "test" && count != 1 {
                "tests"
            } else {
                trial
            };
            is_there.then(|| format!("{} {unit}", grouped(count)))
        });
    parts.collect::<Vec<_>>().join(", ")
}

/// Returns the worst value with the largest share of its bound.
fn worst(claim: &AssessedClaim) -> String {
    let values = claim.evidence.iter().filter_map(|item| {
        let last = item.last.as_ref()?;
        let (worst, bound) = (last.worst?, last.bound?);
        Some((worst as f64 / bound.max(1) as f64, worst, bound, item))
    });
    let largest = values.max_by(|one, other| one.0.total_cmp(&other.0));
    largest.map_or_else(String::new, |(_, worst, bound, item)| {
        let name = item.title.split(' ').next().unwrap_or_default();
        let name = if item.trial == "runs" {
            name
        } else {
            &item.title
        };
        format!("{worst} of {bound} {} ({name})", item.unit)
    })
}

fn section(page: &mut String, claim: &AssessedClaim) {
    let _ = writeln!(page, "\n### {} {}\n", claim.id, claim.name);
    wrapped(page, "", &format!("**{}**", claim.text));
    page.push('\n');
    wrapped(page, "- ", &format!("State: {}.", state(claim.is_shown)));
    wrapped(page, "- ", &format!("Context: {}", claim.context));
    wrapped(page, "- ", &format!("Argument: {}", claim.argument));
    for assumption in &claim.assumptions {
        wrapped(page, "- ", &format!("Assumption: {assumption}"));
    }
    injected(page, claim);
    let tests: Vec<_> = claim
        .evidence
        .iter()
        .filter(|item| item.trial == "test")
        .collect();
    if !tests.is_empty() {
        page.push_str("\nTests:\n\n");
    }
    for test in tests {
        let end = if test.is_shown {
            "passed"
        } else {
            "**no passed result**"
        };
        let _ = writeln!(page, "- `{}`: {end}", test.evidence);
    }
    page.push_str("\n```text\n");
    for command in &claim.commands {
        page.push_str(&continued(command));
    }
    page.push_str("```\n");
}

/// Table of the evidence that is not a test.
fn injected(page: &mut String, claim: &AssessedClaim) {
    let items: Vec<_> = claim
        .evidence
        .iter()
        .filter(|item| item.trial != "test")
        .collect();
    if items.is_empty() {
        return;
    }
    page.push_str("\n| evidence | required | tried | passed | worst | bound |\n");
    page.push_str("|---|---|---|---|---|---|\n");
    let faults: Vec<_> = items.iter().filter(|item| item.trial == "runs").collect();
    let is_summed = faults.len() > ROWS;
    if is_summed {
        let sum = |of: fn(&crate::Outcome) -> u64| -> u64 {
            let outcomes = faults.iter().filter_map(|item| item.last.as_ref());
            outcomes.map(of).sum()
        };
        let (count, tried, passed) = (faults.len(), sum(|o| o.tried), sum(|o| o.passed));
        let (tried, passed) = (grouped(tried), grouped(passed));
        let _ = writeln!(
            page,
            "| {count} faults | no violation of a limit | {tried} runs | {passed} | | |"
        );
    }
    for item in items
        .iter()
        .filter(|item| !is_summed || item.trial != "runs")
    {
        let last = item.last.as_ref();
        let number = |value: Option<u64>| {
            value.map_or_else(String::new, |value| {
                format!(" {} {}", grouped(value), item.unit)
            })
        };
        let _ = writeln!(
            page,
            "| {} | {} | {} | {} |{} |{} |",
            item.title,
            item.requirement,
            last.map_or_else(
                || "no result".to_owned(),
                |last| format!("{} {}", grouped(last.tried), item.trial)
            ),
            last.map_or_else(String::new, |last| grouped(last.passed)),
            number(last.and_then(|last| last.worst)),
            number(last.and_then(|last| last.bound)),
        );
    }
}

fn not_claimed(page: &mut String, assessment: &Assessment) {
    page.push_str("\n## Not claimed\n\n");
    for text in &assessment.limits {
        wrapped(page, "- ", text);
    }
    page.push_str("\nRows of the fault catalogue without claim:\n\n");
    for row in &assessment.not_claimed {
        wrapped(page, "- ", &format!("{}: {}", row.fault, row.reason));
    }
    page.push_str("\nEvery other row belongs to a claim above.\n");
    if !assessment.problems.is_empty() {
        page.push_str("\n## Problems\n\n");
    }
    let of_case = assessment
        .problems
        .iter()
        .filter(|problem| problem.subject != "page");
    for problem in of_case {
        wrapped(page, "- ", &problem.to_string());
    }
}

/// Appends a paragraph or an item of a list, wrapped.
fn wrapped(page: &mut String, mark: &str, text: &str) {
    let mut line = mark.to_owned();
    for word in text.split_whitespace() {
        let is_first = line.len() == mark.len();
        if !is_first && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            page.push_str(&line);
            page.push('\n');
            line = " ".repeat(mark.len()) + word;
        } else {
            if !is_first {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    page.push_str(&line);
    page.push('\n');
}

/// Returns a command, continued on further lines where it is long.
fn continued(command: &str) -> String {
    let (mut text, mut length) = (String::new(), 0);
    for word in command.split(' ') {
        // Two columns for the backslash.
        if length > 0 && length + 3 + word.len() > COLUMNS {
            text.push_str(" \\\n    ");
            length = 4;
        } else if length > 0 {
            text.push(' ');
            length += 1;
        }
        text.push_str(word);
        length += word.len();
    }
    text.push('\n');
    text
}

/// Formats a number with commas between thousands.
fn grouped(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}
