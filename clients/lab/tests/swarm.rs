//! `atas demo swarm` as a process.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output};

fn demo(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas-lab"));
    command.args(["demo", "swarm"]).args(arguments);
    command.output().expect("it starts")
}

/// Returns true if the required programs are next to this one, that is, have been built.
fn neighbours_are_built() -> bool {
    let folder = Path::new(env!("CARGO_BIN_EXE_atas-lab")).parent();
    let built = ["atas-sim", "ebts"]
        .iter()
        .all(|name| folder.is_some_and(|folder| folder.join(name).is_file()));
    if !built {
        let why = "atas-sim and ebts are not built; use `cargo test --workspace`";
        // Written directly, as the test harness captures the output of passing tests.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the swarm's demo: {why}");
    }
    built
}

#[test]
fn built_in_table_gives_evolved_points_on_bus() {
    if !neighbours_are_built() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let page = folder.path().join("swarm.html");
    let replay = page.to_str().expect("UTF-8");
    let output = demo(&["--lockstep", "--format", "json", "--replay", replay]);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(value["as_evolved"], true, "{value}");
    assert_eq!(value["missed_frames"], 0);
    let goals = value["goals"].as_array().expect("a list");
    let carried = goals.iter().filter(|goal| goal["carried"] == true).count();
    assert_eq!((goals.len(), carried), (8, 6), "{value}");
    let html = std::fs::read_to_string(page).expect("the animation");
    assert!(html.contains("<html") && html.contains("frames"));
}

#[test]
fn a_table_that_cannot_be_used_is_wrong_usage() {
    let folder = tempfile::tempdir().expect("a folder");
    let spoilt = folder.path().join("spoilt.toml");
    std::fs::write(&spoilt, "format = 1").expect("writable");
    for (table, part) in [
        (spoilt.to_str().expect("UTF-8"), "spoilt.toml"),
        ("no-such-table", "r3-two-agents"),
    ] {
        let output = demo(&["--table", table]);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(part), "{stderr}");
    }
}
