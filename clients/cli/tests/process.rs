//! The program as a process: exit codes, messages, and what it leaves behind.
#![expect(clippy::print_stdout, reason = "a test that cannot run here says so")]

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use shm_bus::FreshBus;

fn atas(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas"));
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
fn without_a_daemon_every_command_says_so_with_its_own_code() {
    let bus = FreshBus::new("nodaemon");
    let check = |arguments: &str| {
        let words: Vec<&str> = arguments
            .split_whitespace()
            .chain(["--bus", bus.as_str()])
            .collect();
        let (code, stdout, stderr) = run(&words);
        assert_eq!(code, 3, "{arguments}: {stderr}");
        assert!(stdout.is_empty(), "{arguments}: {stdout}");
        assert!(
            stderr.contains("atasd") && stderr.contains(bus.as_str()),
            "{arguments}: {stderr}"
        );
        assert_eq!(stderr.lines().count(), 1, "{arguments}: {stderr}");
    };
    check("status");
    check("status --watch");
    check("latency");
    check("latency --watch");
    check("events");
    check("events --follow");
    check("grasp --at 0.3,-0.1,0.05 --width 50");
    check("pick-place");
    check("screw");
    check("assemble");
    check("task polish");
    check("release");
    check("estop");
    check("recover");
    check("param list");
    check("param get grasp.dr_n");
    check("param set grasp.dr_n 0.1");
}

#[test]
fn wrong_usage_has_its_own_code() {
    let check = |arguments: &[&str], part: &str| {
        let (code, _, stderr) = run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    };
    check(&["fly"], "unrecognized");
    check(
        &["eval", "grasp", "--objects", "botle"],
        "did you mean \"bottle\"?",
    );
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
    check(&["status", "--bus", "UPPER"], "use 1 to 24 characters");
}

#[test]
fn help_tells_the_exit_codes() {
    let (code, stdout, _) = run(&["--help"]);
    assert_eq!(code, 0);
    assert!(
        stdout.contains("3  no daemon answers on the bus"),
        "{stdout}"
    );
}

#[test]
fn completions_and_manual_pages() {
    let (code, stdout, _) = run(&["completions", "bash"]);
    assert!(code == 0 && stdout.contains("_atas"), "{stdout}");
    assert!(
        stdout.contains("pick-place") && stdout.contains("assemble"),
        "{stdout}"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().to_str().expect("UTF-8");
    let (code, _, stderr) = run(&["man", path]);
    assert_eq!(code, 0, "{stderr}");
    for page in [
        "atas",
        "atas-pick-place",
        "atas-screw",
        "atas-assemble",
        "atas-task",
        "atas-demo-assembly",
    ] {
        assert!(folder.path().join(format!("{page}.1")).is_file(), "{page}");
    }
}

#[test]
fn the_doctor_fails_exactly_if_a_finding_does() {
    let bus = FreshBus::new("doctor");
    let (code, stdout, stderr) = run(&["doctor", "--format", "json", "--bus", bus.as_str()]);
    let findings: Vec<serde_json::Value> = serde_json::from_str(&stdout).expect("JSON");
    let verdicts = findings.iter().map(|finding| finding["verdict"].as_str());
    let fails = verdicts.filter(|verdict| *verdict == Some("fail")).count();
    assert_eq!(code, i32::from(fails > 0), "{stderr}");
    let daemon = findings.iter().find(|finding| finding["probe"] == "daemon");
    let daemon = daemon.expect("a finding");
    assert_eq!(daemon["verdict"], "warn", "{daemon}");
    let cure = daemon["what_to_do"].as_str();
    assert!(cure.is_some_and(|cure| cure.contains("atasd")), "{daemon}");
}

#[test]
fn eval_prints_one_json_line() {
    let (code, stdout, stderr) = run(&[
        "eval",
        "grasp",
        "--seeds",
        "1",
        "--objects",
        "sponge",
        "--format",
        "json",
    ]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(stdout.lines().count(), 1, "{stdout}");
    let value: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
    assert_eq!(value["trials"], 1);
}

#[test]
fn a_program_without_its_neighbours_says_how_to_build_them() {
    let folder = tempfile::tempdir().expect("a folder");
    let alone = folder.path().join("atas");
    std::fs::copy(env!("CARGO_BIN_EXE_atas"), &alone).expect("copied");
    let output = Command::new(&alone)
        .args(["demo", "grasp"])
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cargo build --workspace"), "{stderr}");
}

/// Whether daemon and simulator lie next to the program; if not, they were not built in this run.
fn neighbours_are_built() -> bool {
    let folder = Path::new(env!("CARGO_BIN_EXE_atas")).parent();
    let built = ["atasd", "atas-sim"]
        .iter()
        .all(|name| folder.is_some_and(|folder| folder.join(name).is_file()));
    if !built {
        println!("not tested: atasd and atas-sim are not built; use `cargo test --workspace`");
    }
    built
}

#[test]
fn an_interrupted_demo_leaves_nothing_behind() {
    if !neighbours_are_built() {
        return;
    }
    let scratch = tempfile::tempdir().expect("a folder");
    // Logs and bus of this demo, and of no other, in here.
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
