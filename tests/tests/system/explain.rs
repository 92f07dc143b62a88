//! Why a grasp did not succeed, and its recording as other programs read it.

use std::process::Command;

use serde_json::Value;
use system_tests::binary;

use crate::recorded;

/// Exit code, and standard output as JSON.
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
fn a_refused_grasp_is_explained_with_its_forces_and_limits_and_exported_whole() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let name = file.to_str().expect("UTF-8");
    assert_eq!(
        recorded::grasp("heavy-block", name),
        Some(4),
        "too heavy for the hand"
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
    let tells_slip = |felt: &Value| felt.as_str().is_some_and(|felt| felt.starts_with("S "));
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
    assert_eq!(atas(&["explain", "no/such.mcap"]).0, Some(1));
    assert_eq!(
        atas(&["export", name, "--to", "csv"]).0,
        Some(1),
        "nothing is overwritten"
    );
}
