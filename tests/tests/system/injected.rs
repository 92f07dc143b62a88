//! `atas fault run` with daemon processes, `atas bench restart` and `atas soak`, as a user starts
//! them.

use std::process::Command;

use serde_json::Value;
use system_tests::{binary, lock_shared};

/// Runs `atas` and returns its exit code and its JSON.
fn run(words: &str) -> (i32, Value) {
    let output = Command::new(binary("atas"))
        .args(words.split_whitespace())
        .args(["--format", "json"])
        .output()
        .expect("atas starts");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    let errors = String::from_utf8_lossy(&output.stderr);
    let json = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {errors}"));
    (output.status.code().expect("an exit code"), json)
}

/// Faults in lock-step: their verdict does not depend on the load of the machine.
#[test]
fn process_faults_pass_or_name_their_obstacle() {
    let _shared = lock_shared();
    let ids = "F21 F32 F35 F36 F39 F45 F47 F48 F52 F54 F58 F59 F61";
    let (code, report) = run(&format!("fault run {ids} --task grasp --at lift"));
    let rows = report["faults"].as_array().expect("rows");
    assert_eq!(rows.len(), ids.split(' ').count());
    for row in rows {
        let is_skipped = row["skipped"].is_string();
        let seeds = u64::from(!is_skipped);
        assert_eq!(row["seeds"], seeds, "{row}");
        assert_eq!(row["passed"], seeds, "{row}");
    }
    // These need no rights.
    for id in ["F32", "F35", "F36", "F39", "F54", "F58", "F59", "F61"] {
        let row = rows.iter().find(|row| row["id"] == id).expect("a row");
        assert_eq!(row["passed"], 1, "{row}");
    }
    assert_eq!((code, &report["unsafe_outputs"]), (0, &Value::from(0)));
}

/// A daemon that is killed: by the clock, so the machine must be free.
#[test]
fn killed_daemon_is_replaced_and_keeps_the_grip() {
    let _alone = system_tests::lock_exclusive();
    let (code, report) = run("fault run F25 --task grasp --at lift");
    let rows = report["faults"].as_array().expect("rows");
    let killed = rows.iter().find(|row| row["id"] == "F25b").expect("a row");
    assert_eq!((code, &killed["passed"]), (0, &Value::from(1)), "{killed}");
    assert!(killed["worst_ticks"].is_u64(), "{killed}");
}

/// Kills during the start, a goal and a grip.
#[test]
fn every_kill_of_the_daemon_is_recovered() {
    let _alone = system_tests::lock_exclusive();
    let (code, report) = run("bench restart --count 10");
    assert_eq!((code, &report["kills"]), (0, &Value::from(10)), "{report}");
    assert_eq!(report["recovered"], 10, "{report}");
    assert!(report["ready_ms"]["p50"].as_f64() > Some(0.0), "{report}");
}

#[test]
fn configuration_of_the_user_gives_robot_and_bounds() {
    let _shared = lock_shared();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("atas.toml");
    let text = "robot.model = \"arm7-gripper\"\nintake.hold_age_s = 0.02\n";
    std::fs::write(&file, text).expect("writable");
    let words = format!("fault run F01 F39 --task grasp --config {}", file.display());
    let (code, report) = run(&words);
    assert_eq!(report["robot"], "arm7-gripper");
    assert_eq!(report["faults"][0]["bound_ticks"], 21, "{report}");
    assert_eq!(
        (code, &report["faults"][1]["passed"]),
        (0, &Value::from(1)),
        "{report}"
    );

    std::fs::write(&file, "intake.hold_age_s = 99\n").expect("writable");
    let refused = Command::new(binary("atas"))
        .args(words.split_whitespace())
        .output()
        .expect("atas starts");
    let errors = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(7), "{errors}");
    assert!(
        errors.contains("atas.toml:1: intake.hold_age_s is 99"),
        "{errors}"
    );
}

#[test]
fn soak_is_independent_of_threads() {
    let _shared = lock_shared();
    let soak = |threads: u32| {
        let (code, mut report) = run(&format!("soak --ticks 90000 --seed 3 --threads {threads}"));
        assert_eq!(code, 0, "{report}");
        assert_eq!(report["ticks"], 90_000, "{report}");
        assert!(report["ticks_per_s"].take().as_f64() > Some(0.0));
        report
    };
    assert_eq!(soak(1), soak(2));
}
