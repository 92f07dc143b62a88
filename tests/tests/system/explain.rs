//! Tests of `atas explain`, `atas plot` and `atas export` on the recording of a refused grasp.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use system_tests::binary;

use crate::recorded;

/// Runs `atas`; returns the exit code and standard output as JSON.
fn atas(arguments: &[&str]) -> (Option<i32>, Value) {
    let output = Command::new(binary("atas"))
        .args(arguments)
        .args(["--format", "json"])
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (
        output.status.code(),
        serde_json::from_str(&text).unwrap_or_default(),
    )
}

#[test]
fn refused_grasp_is_explained_and_exported() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let name = file.to_str().expect("UTF-8");
    assert_eq!(
        recorded::grasp("heavy-block", name),
        Some(4),
        "the object is too heavy for the hand"
    );
    let (code, account) = atas(&["explain", name]);
    assert_eq!(
        (code, &account["state"]),
        (Some(0), &"refused".into()),
        "{account}"
    );
    assert_eq!(account["reason"]["cause"], "too-heavy");
    let (value, limit) = (
        account["reason"]["value"].as_f64(),
        account["reason"]["limit"].as_f64(),
    );
    assert!(value >= limit && limit == Some(8.0), "{account}");
    let of = |list: &str, key: &str| -> Vec<Value> {
        let entries = account[list].as_array().expect(list);
        entries.iter().map(|entry| entry[key].clone()).collect()
    };
    let steps = of("steps", "name");
    assert!(
        steps.contains(&"approach".into()) && steps.contains(&"lift".into()),
        "{steps:?}"
    );
    let kinds = of("moments", "kind");
    for kind in ["touch-on", "stiffness", "module-on", "goal"] {
        assert!(kinds.contains(&kind.into()), "no {kind} in {kinds:?}");
    }
    let evidence = of("moments", "evidence");
    let tells_slip = |measured: &Value| {
        measured
            .as_str()
            .is_some_and(|measured| measured.starts_with("S "))
    };
    assert!(evidence.iter().any(tells_slip), "{evidence:?}");
    for (kind, made) in [
        ("mcap", "run-ros2.mcap"),
        ("csv", "run.csv"),
        ("parquet", "run.parquet"),
    ] {
        let (code, exported) = atas(&["export", name, "--to", kind]);
        assert_eq!(code, Some(0), "{kind}");
        assert!(exported["ticks"].as_u64() > Some(1000), "{exported}");
        assert!(folder.path().join(made).exists(), "{made}");
    }
    check_figures(folder.path(), name, &steps);
    assert_eq!(atas(&["explain", "no/such.mcap"]).0, Some(1));
    assert_eq!(
        atas(&["export", name, "--to", "csv"]).0,
        Some(1),
        "export must not overwrite a file"
    );
}

/// Checks the figures: every step has its label, in SVG, PNG and PDF, for one and for two
/// recordings.
fn check_figures(folder: &Path, recording: &str, steps: &[Value]) {
    let file = |name: &str| folder.join(name).to_str().expect("UTF-8").to_owned();
    let svg = |name: &str| std::fs::read_to_string(file(name)).expect("a figure");
    let draw = |words: &[&str], out: &str| {
        let out = file(out);
        let words = [words, &["--out", &out]].concat();
        assert_eq!(atas(&words).0, Some(0), "{words:?}");
    };
    let is_there = |svg: &str, word: &str| svg.contains(&format!(">\n{word}\n<"));
    draw(&["explain", recording], "why.svg");
    draw(&["plot", recording], "run.svg");
    let other = file("wood.mcap");
    assert_eq!(
        recorded::grasp("wood", &other),
        Some(0),
        "the wood block is grasped"
    );
    draw(&["plot", recording, &other, "--from", "lift"], "both.svg");
    let both = svg("both.svg");
    for word in ["run", "wood", "lift", "leave", "Grip (N)"] {
        assert!(is_there(&both, word), "{word}");
    }
    draw(&["plot", recording], "run.png");
    draw(&["plot", recording], "run.pdf");
    let (why, run) = (svg("why.svg"), svg("run.svg"));
    for step in steps.iter().filter_map(Value::as_str) {
        assert!(is_there(&why, step) && is_there(&run, step), "{step}");
    }
    for word in [
        "F_1",
        "F_2",
        "F_n finger 1",
        "Slip S",
        "2 slip",
        "Height (mm)",
    ] {
        assert!(is_there(&run, word), "{word}");
    }
    assert!(
        why.contains("too heavy") && !run.contains("too heavy"),
        "only `explain` prints the summary"
    );
    assert!(!run.contains("NaN") && !run.contains("inf"));
    let png = std::fs::read(file("run.png")).expect("a picture");
    let pdf = std::fs::read(file("run.pdf")).expect("a page");
    let width = u32::from_be_bytes([png[16], png[17], png[18], png[19]]);
    assert!(png.starts_with(b"\x89PNG") && width == 1760 && png.len() > 20_000);
    let text = String::from_utf8_lossy(&pdf);
    assert!(
        text.starts_with("%PDF") && text.contains("/FontFile"),
        "the PDF contains text"
    );
    let far = ["plot", recording, "--from", "fly", "--out", &file("no.svg")];
    assert_eq!(atas(&far).0, Some(1), "no such step");
}
