//! The READMEs' own commands and claims.

use std::path::Path;
use std::process::Command;
use system_tests::{binary, in_virtual_time};

fn readmes() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let read = |path| std::fs::read_to_string(root.join(path)).expect("readable");
    let files = [
        "README.md",
        "clients/robots/README.md",
        "clients/swarm/README.md",
    ];
    files.map(read).concat()
}

#[test]
fn every_command_of_the_readme_is_known_to_its_program() {
    let mut seen = 0;
    for line in readmes().lines() {
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
            assert!(
                text.contains(flag),
                "{line}: the program does not know {flag}"
            );
        }
        seen += 1;
    }
    assert!(seen > 5, "the README shows its commands with their paths");
}

#[test]
fn every_test_that_the_readme_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let text = readmes();
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
    assert!(named > 5, "the README names the tests of its invariants");
}

/// Every row that a demo prints is one of the README's, to the last digit: lock-step is the same everywhere.
#[test]
fn the_demos_come_out_as_the_readme_shows_them() {
    let _shared = in_virtual_time();
    let readme = readmes();
    let shown: Vec<Vec<&str>> = readme.lines().map(words).collect();
    let check = |demo: &str, rows: usize| {
        let output = Command::new(binary("atas"))
            .arg("demo")
            .args(words(demo))
            .arg("--lockstep")
            .output()
            .expect("it starts");
        let printed = String::from_utf8(output.stdout).expect("UTF-8");
        // Below the rule; what is too long for a line goes on below an empty first column.
        let below = printed.lines().skip_while(|line| !line.starts_with('─'));
        let table: Vec<Vec<&str>> = below
            .skip(1)
            .filter(|line| !line.starts_with(' ') && line.contains("  "))
            .map(words)
            .collect();
        assert_eq!(table.len(), rows, "{printed}");
        for row in table {
            let is_shown = shown.iter().any(|line| line.starts_with(&row));
            assert!(is_shown, "demo {demo}: the README has no {row:?}");
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
