//! `atas assure`, as a user starts it.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use system_tests::binary;

/// Runs `atas assure` on this source tree. `cargo`: the program that runs tests.
fn assure(words: &str, cargo: &Path) -> Output {
    let root = crate::architecture::root();
    Command::new(binary("atas"))
        .arg("assure")
        .args(words.split_whitespace())
        .args(["--format", "json", "--source"])
        .arg(root)
        .env("CARGO", cargo)
        .output()
        .expect("atas starts")
}

fn json(output: &Output) -> Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {errors}"))
}

/// Returns the claim with this number.
fn claim<'a>(report: &'a Value, id: &str) -> &'a Value {
    let claims = report["claims"].as_array().expect("claims");
    claims.iter().find(|claim| claim["id"] == id).expect(id)
}

/// Stored results, cited faults and tests, and the page of the guide agree.
#[test]
fn committed_case_passes_its_check() {
    let output = assure("--check", Path::new("cargo"));
    let report = json(&output);
    assert_eq!(report["problems"], Value::Array(Vec::new()), "{report}");
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(report["is_shown"], true);
}

#[test]
fn case_without_results_fails_its_check() {
    let folder = tempfile::tempdir().expect("a folder");
    let words = format!("--check --results {}", folder.path().display());
    let output = assure(&words, Path::new("cargo"));
    assert_eq!(output.status.code(), Some(1));
    let report = json(&output);
    let problems = report["problems"].as_array().expect("problems");
    let is_named = |subject: &str, text: &str| {
        problems.iter().any(|problem| {
            let named = problem["text"].as_str().expect("text");
            problem["subject"] == subject && named.contains(text)
        })
    };
    assert!(
        is_named(
            "G15 stop",
            "stops has no result; run `atas assure --run --missing G15`"
        ),
        "{problems:#?}"
    );
    assert!(
        is_named("page", "is not up to date; run `atas assure --out"),
        "{problems:#?}"
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(
        errors.contains("each problem above names its remedy"),
        "{errors}"
    );
    // Without --check the case is shown as it is.
    let words = words.replace("--check", "");
    assert_eq!(assure(&words, Path::new("cargo")).status.code(), Some(0));
}

#[test]
fn results_of_tests_are_collected_and_stored() {
    let folder = tempfile::tempdir().expect("a folder");
    let cargo = folder.path().join("cargo");
    let names = [
        "side_above_grip_ceiling_may_only_open ... ok",
        "module_3_stops_above_f2_then_opens ... ok",
        "probe_stops_at_force_ceiling_without_result ... FAILED",
    ];
    let script = |lines: &[&str]| {
        let lines: Vec<String> = lines
            .iter()
            .map(|line| format!("echo 'test a::{line}'"))
            .collect();
        std::fs::write(
            &cargo,
            format!("#!/bin/sh\n{}\nexit 101\n", lines.join("\n")),
        )
        .expect("writable");
        let mode = std::fs::Permissions::from_mode(0o755);
        std::fs::set_permissions(&cargo, mode).expect("permitted");
    };
    let results = folder.path().join("results");
    let run = |words: &str| {
        let words = format!("{words} --results {}", results.display());
        json(&assure(&words, &cargo))
    };
    script(&names);
    let report = run("--run grip-ceiling");
    let shown = |report: &Value| -> Vec<bool> {
        let evidence = claim(report, "G03")["evidence"]
            .as_array()
            .expect("evidence");
        let shown = evidence.iter().map(|item| item["is_shown"].as_bool());
        shown.map(|shown| shown.expect("a verdict")).collect()
    };
    assert_eq!(shown(&report), [true, true, false, false]);
    assert_eq!(claim(&report, "G03")["is_shown"], false);

    // Only the two others run again.
    script(&[
        "probe_stops_at_force_ceiling_without_result ... ok",
        "force_limit_is_reported_and_object_set_down ... ok",
    ]);
    let report = run("--run --missing G03");
    assert_eq!(shown(&report), [true; 4]);
    assert_eq!(claim(&report, "G03")["is_shown"], true);
    let stored = std::fs::read_to_string(results.join("tests.json")).expect("stored");
    assert!(
        !stored.contains(&*folder.path().to_string_lossy()),
        "{stored}"
    );
    assert!(stored.contains("\"cores\":"), "{stored}");
}

#[test]
fn printed_result_is_added() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("soak.json");
    let results = folder.path().join("results");
    let words = format!("--add {} --results {}", file.display(), results.display());
    let text = r#"{"ticks":9000000000,"violations":0,"episodes":5,"seed":7,"ticks_per_s":1.0}"#;
    std::fs::write(&file, text).expect("writable");
    let report = json(&assure(&words, Path::new("cargo")));
    let evidence = claim(&report, "G01")["evidence"]
        .as_array()
        .expect("evidence");
    let soak = evidence
        .iter()
        .find(|item| item["evidence"] == "soak")
        .expect("soak");
    assert_eq!(soak["last"]["tried"], 9_000_000_000_u64, "{soak}");
    assert_eq!(soak["is_shown"], true, "{soak}");

    std::fs::write(&file, "{}").expect("writable");
    let refused = assure(&words, Path::new("cargo"));
    assert_eq!(refused.status.code(), Some(7));
    let errors = String::from_utf8_lossy(&refused.stderr);
    assert!(errors.contains("could not add the result"), "{errors}");
}

#[test]
fn unknown_claim_and_folder_are_refused() {
    let refused = assure("--run no-claim", Path::new("cargo"));
    assert_eq!(refused.status.code(), Some(2));
    let errors = String::from_utf8_lossy(&refused.stderr);
    assert!(
        errors.contains("no-claim") && errors.contains("`atas assure` lists all"),
        "{errors}"
    );

    let folder = tempfile::tempdir().expect("a folder");
    let refused = Command::new(binary("atas"))
        .args(["assure", "--source"])
        .arg(folder.path())
        .output()
        .expect("atas starts");
    assert_eq!(refused.status.code(), Some(7));
    let errors = String::from_utf8_lossy(&refused.stderr);
    assert!(
        errors.contains("could not find the source tree of ATAS"),
        "{errors}"
    );
}
