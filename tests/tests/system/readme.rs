//! Tests of the commands and claims in the READMEs, the architecture page and the results page.

use std::path::Path;
use std::process::Command;
use system_tests::{binary, lock_shared};

fn texts() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path| std::fs::read_to_string(root.join(path)).expect("readable");
    let files = [
        "README.md",
        "ARCHITECTURE.md",
        "clients/guide/src/results.md",
        "clients/robots/README.md",
        "clients/swarm/README.md",
    ];
    files.map(read).concat()
}

#[test]
fn readme_commands_have_known_options() {
    let mut seen = 0;
    for line in texts().lines() {
        let Some(command) = line.strip_prefix("target/debug/") else {
            continue;
        };
        let words: Vec<&str> = command
            .split_whitespace()
            .take_while(|w| !w.starts_with(['#', '|', '>', '&']))
            .collect();
        let program = binary(words[0]);
        let subcommands: Vec<&&str> = words[1..]
            .iter()
            .take_while(|w| {
                w.chars().all(|c| c.is_ascii_alphabetic() || c == '-') && !w.starts_with('-')
            })
            .take(2)
            .collect();
        let help = Command::new(program)
            .args(&subcommands)
            .arg("--help")
            .output()
            .expect("it starts");
        assert!(
            help.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&help.stderr)
        );
        let text = String::from_utf8_lossy(&help.stdout).into_owned();
        for flag in words.iter().filter(|w| w.starts_with("--")) {
            let flag = flag.split('=').next().unwrap_or(flag);
            assert!(text.contains(flag), "{line}: unknown option {flag}");
        }
        seen += 1;
    }
    assert!(seen > 5, "the README shows its commands with their paths");
}

#[test]
fn named_tests_exist() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let text = texts();
    let mut named = 0;
    for part in text.split('`').filter(|p| p.contains(".rs::")) {
        let (file, name) = part.split_once("::").expect("a file and a test");
        let code =
            std::fs::read_to_string(root.join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(
            code.contains(&format!("fn {name}")),
            "{file} has no test {name}"
        );
        named += 1;
    }
    assert!(
        named > 5,
        "ARCHITECTURE.md names the tests of the invariants"
    );
}

/// The README's success rates are those of the stored evaluations.
#[test]
fn readme_success_rates_match_stored_evaluations() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let readme = read("README.md");
    let check = |row: &str, file: &str, stored: &str| {
        let shown = line_from(&readme, &format!("| {row} |"));
        let golden = read(&format!("clients/evaluation/golden/{file}.md"));
        let measured = line_from(&golden, &format!("| {stored} |"));
        let shown = percentages(shown);
        assert!(!shown.is_empty(), "{row}: the README shows no percentage");
        for percentage in shown {
            assert!(
                percentages(measured).contains(&percentage),
                "{row}: the README shows {percentage} %, {file}.md {:?}",
                percentages(measured)
            );
        }
    };
    let steady = "noise × 1 to 2, 1000 Hz";
    check("grasp", "all", "grasp, noise × 1, 1000 Hz");
    check(
        "pick and place",
        "all",
        &format!("pick and place, {steady}"),
    );
    check("cap screwing", "all", &format!("screwing, {steady}"));
    check("two-hand assembly", "all", &format!("assembly, {steady}"));
    let errors = "grasp with all model errors at once, 24 trials";
    check(errors, "errors", "all errors together");
}

fn line_from<'a>(text: &'a str, begin: &str) -> &'a str {
    let line = text.lines().find(|line| line.starts_with(begin));
    line.unwrap_or_else(|| panic!("no line begins with {begin:?}"))
}

/// Returns the numbers before a percent sign.
fn percentages(line: &str) -> Vec<&str> {
    let before = line.split(" %").collect::<Vec<_>>();
    let numbers = before[..before.len() - 1].iter();
    numbers
        .map(|text| text.rsplit([' ', '*', '(', '|']).next().unwrap_or(text))
        .collect()
}

/// Every row that a demo prints is on the results page, to the last digit: lock-step results do not
/// depend on the machine.
#[test]
fn demo_results_match_results_page() {
    let _shared = lock_shared();
    let readme = texts();
    let shown: Vec<Vec<&str>> = readme.lines().map(words).collect();
    let check = |demo: &str, rows: usize| {
        let output = Command::new(binary("atas"))
            .arg("demo")
            .args(words(demo))
            .arg("--lockstep")
            .output()
            .expect("it starts");
        let printed = String::from_utf8(output.stdout).expect("UTF-8");
        // Rows below the rule. Continuation lines have an empty first column.
        let below = printed.lines().skip_while(|line| !line.starts_with('─'));
        let table: Vec<Vec<&str>> = below
            .skip(1)
            .filter(|line| !line.starts_with(' ') && line.contains("  "))
            .map(words)
            .collect();
        assert_eq!(table.len(), rows, "{printed}");
        for row in table {
            let is_shown = shown.iter().any(|line| line.starts_with(&row));
            assert!(is_shown, "demo {demo}: the results page has no {row:?}");
        }
    };
    check("grasp --all", 8);
    check("pick-place", 1);
    check("screw", 1);
    check("assembly", 1);
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}
