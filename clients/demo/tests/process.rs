//! Demos as processes: exit codes, messages, and clean-up.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn atas(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas-demo"));
    command
        .args(arguments)
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null());
    command
}

fn run(arguments: &[&str]) -> (i32, String, String) {
    let Output {
        status,
        stdout,
        stderr,
    } = atas(arguments).output().expect("it starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (status.code().expect("a code"), text(stdout), text(stderr))
}

#[test]
fn wrong_usage_has_its_own_code() {
    let check = |arguments: &[&str], part: &str| {
        let (code, _, stderr) = run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    };
    check(&["demo", "grasp", "--object", "no/such.toml"], "no/such");
    check(
        &["demo", "pick-place", "--object", "no/such.toml"],
        "no/such",
    );
    check(&["demo", "screw", "--cap", "wood"], "has no thread");
    check(
        &["demo", "assembly", "--cap", "cup"],
        "did you mean \"cap\"?",
    );
    check(&["demo", "swarm"], "run `atas` instead");
    check(&["status"], "run `atas` instead");
}

#[test]
fn missing_programs_are_reported_with_build_command() {
    // Linked, not copied: a file that another thread's child holds open for writing cannot be
    // executed.
    let program = Path::new(env!("CARGO_BIN_EXE_atas-demo"));
    let folder = tempfile::tempdir_in(program.parent().expect("a folder")).expect("a folder");
    let alone = folder.path().join("atas-demo");
    std::fs::hard_link(program, &alone).expect("linked");
    let output = Command::new(&alone)
        .args(["demo", "grasp"])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cargo build --workspace"), "{stderr}");
}

/// Returns true if daemon and simulator are next to this program, that is, have been built.
fn neighbours_are_built() -> bool {
    let folder = Path::new(env!("CARGO_BIN_EXE_atas-demo")).parent();
    let built = ["atasd", "atas-sim"]
        .iter()
        .all(|name| folder.is_some_and(|folder| folder.join(name).is_file()));
    if !built {
        let why = "atasd and atas-sim are not built; use `cargo test --workspace`";
        // Written directly, as the test harness captures the output of passing tests.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the demos' tests: {why}");
    }
    built
}

#[test]
fn interrupted_demo_leaves_no_processes_or_files() {
    if !neighbours_are_built() {
        return;
    }
    let scratch = tempfile::tempdir().expect("a folder");
    // Separate folder for logs and bus of this demo.
    let demo = atas(&["demo", "grasp", "--object", "wood"])
        .env("TMPDIR", scratch.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let id = demo.id();
    let bus = format!("fdemo-{id}-0");
    let begin = Instant::now();
    while children_of(id).len() < 2 && begin.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(5));
    }
    let children = children_of(id);
    assert_eq!(children.len(), 2, "simulator and daemon");
    let pid = rustix::process::Pid::from_child(&demo);
    rustix::process::kill_process(pid, rustix::process::Signal::INT).expect("it runs");
    let output = demo.wait_with_output().expect("it ends");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{stderr}");
    for child in children {
        assert!(!Path::new(&format!("/proc/{child}")).exists(), "{child}");
    }
    let shared = std::fs::read_dir("/dev/shm").expect("shared memory");
    let left = shared
        .flatten()
        .filter(|entry| entry.file_name().to_string_lossy().starts_with(&bus));
    assert_eq!(left.count(), 0, "shared memory of {bus}");
    let logs = std::fs::read_dir(scratch.path()).expect("the folder");
    assert_eq!(logs.count(), 0, "logs");
}

/// Process ids of a process's children.
fn children_of(id: u32) -> Vec<u32> {
    let text = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children"));
    let text = text.unwrap_or_default();
    text.split_whitespace()
        .filter_map(|id| id.parse().ok())
        .collect()
}

/// Uses the default width, as the output is not a terminal.
#[test]
fn tables_fit_eighty_columns() {
    if !neighbours_are_built() {
        return;
    }
    // Lines from `below` on are text of any length.
    let check = |line: &str, below: &str, parts: &[&str]| {
        let words: Vec<&str> = line.split(' ').collect();
        let (code, stdout, stderr) = run(&words);
        assert_eq!(code, 0, "{line}: {stderr}");
        for part in parts {
            assert!(stdout.contains(part), "{part:?} is not in: {stdout}");
        }
        for row in stdout.lines().take_while(|row| !row.starts_with(below)) {
            assert!(row.chars().count() <= 80, "{row}");
            assert!(!row.trim_end().ends_with(" to"), "{stdout}");
            assert!(!row.contains("reason"), "{stdout}");
        }
    };
    let demo = |task: &str, parts: &[&str]| {
        check(&format!("demo {task} --lockstep"), "heavy-block: ", parts);
    };
    demo("grasp --object wood", &["lifted mm", "held"]);
    demo(
        "grasp --object heavy-block",
        &[
            "refused:",
            "too heavy ",
            "\nheavy-block: lift: ",
            "object too heavy: not held with ",
        ],
    );
    demo("pick-place --object wood", &["took", "placed"]);
    demo("screw", &["took s", "tight"]);
}
