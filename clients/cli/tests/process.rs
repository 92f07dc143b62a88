//! Process tests: exit codes, messages, and leftovers.
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use shm_bus::{Bus, FreshBus, Realtime, now_ns};
use shm_schemas::{Mode, Status, service};

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
fn commands_without_daemon_exit_with_3() {
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
fn status_fails_on_frozen_ticks() {
    let name = FreshBus::new("frozen");
    let bus = Bus::open(&name, "atasd", Realtime::No).expect("the bus opens");
    let statuses = bus
        .publisher::<Status>(service::STATUS)
        .expect("a publisher");
    let check = |captured_ns: u64, expected_code, part: &str| {
        let mut status = Status {
            mode: Mode::READY,
            ..Status::default()
        };
        status.stamp.captured_ns = captured_ns;
        let asked = std::thread::spawn({
            let bus = name.as_str().to_owned();
            move || run(&["status", "--bus", &bus])
        });
        while !asked.is_finished() {
            statuses.send(&status).expect("sent");
            std::thread::sleep(Duration::from_millis(5));
        }
        let (code, stdout, stderr) = asked.join().expect("it ran");
        assert_eq!(code, expected_code, "{stdout}{stderr}");
        assert!(stdout.contains(part), "{stdout}{stderr}");
    };
    check(now_ns().saturating_sub(2_500_000_000), 1, "stood still for");
    // A future timestamp is fresh even if the program starts slowly.
    check(u64::MAX, 0, "mode ready");
}

#[test]
fn invalid_usage_exits_with_2() {
    let check = |arguments: &[&str], part: &str| {
        let (code, _, stderr) = run(arguments);
        assert_eq!(code, 2, "{arguments:?}: {stderr}");
        assert!(stderr.contains(part), "{arguments:?}: {stderr}");
    };
    check(&["fly"], "unrecognized");
    check(&["status", "--bus", "UPPER"], "use 1 to 24 characters");
}

#[test]
fn help_lists_exit_codes() {
    let (code, stdout, _) = run(&["--help"]);
    assert_eq!(code, 0);
    assert!(
        stdout.contains("3   no daemon answers on the bus"),
        "{stdout}"
    );
}

#[test]
fn completions_and_manual_pages_are_written() {
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
fn doctor_fails_only_on_failed_checks() {
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
fn doctor_findings_state_fix_and_cost() {
    let bus = FreshBus::new("costs");
    let (_, stdout, _) = run(&["doctor", "--format", "json", "--bus", bus.as_str()]);
    let findings: Vec<serde_json::Value> = serde_json::from_str(&stdout).expect("JSON");
    for finding in &findings {
        let is_ok = finding["verdict"] == "ok";
        assert_eq!(finding["what_to_do"] == "", is_ok, "{finding}");
        assert_eq!(finding["cost"] == "", is_ok, "{finding}");
        assert!(finding.get("fixes").is_none(), "{finding}");
    }
    for probe in ["interrupts", "power mode", "container", "versions"] {
        let found = findings.iter().any(|finding| finding["probe"] == probe);
        assert!(found, "{probe}: {stdout}");
    }
}

#[test]
fn doctor_dry_run_keeps_stale_files() {
    let bus = FreshBus::new("dryrun");
    let file = format!("/dev/shm/{}_0123456789abcdef_x.data", bus.as_str());
    std::fs::write(&file, [1; 100_000]).expect("written");
    let (_, stdout, _) = run(&["doctor", "--fix", "--dry-run", "--format", "json"]);
    let still_there = Path::new(&file).exists();
    std::fs::remove_file(&file).expect("removed");
    assert!(still_there);
    let findings: Vec<serde_json::Value> = serde_json::from_str(&stdout).expect("JSON");
    let leftovers = findings.iter().find(|f| f["probe"] == "leftovers");
    let fixes = leftovers.expect("a finding")["fixes"].as_array().cloned();
    let action = format!("bus {},", bus.as_str());
    let planned = fixes.unwrap_or_default().into_iter().find(|fix| {
        let text = fix["action"].as_str().unwrap_or_default();
        text.contains(&action)
    });
    let result = planned.expect("a fix")["result"].clone();
    // In a container, or with a process that hides its memory, the fix is refused.
    assert!(result == "planned" || result == "refused", "{result}");
}

#[test]
fn dry_run_without_fix_is_rejected() {
    let (code, _, stderr) = run(&["doctor", "--dry-run"]);
    assert!(code == 2 && stderr.contains("--fix"), "{stderr}");
}

#[test]
fn help_includes_lab_commands() {
    let (code, stdout, _) = run(&["help"]);
    assert_eq!(code, 0);
    for command in ["demo", "eval", "plot", "bench", "replay", "status", "grasp"] {
        let line = format!("\n  {command} ");
        assert!(stdout.contains(&line), "{command}: {stdout}");
    }
    let (code, stdout, _) = run(&["help", "eval"]);
    assert!(code == 0 && stdout.contains("pick-place"), "{stdout}");
    let (code, _, stderr) = run(&["eval", "grsp"]);
    assert!(code == 2 && stderr.contains("'grasp'"), "{stderr}");
}

#[test]
fn missing_demo_program_explains_the_build() {
    // A hard link: a copy held open for writing by a child of another thread cannot be executed.
    let program = Path::new(env!("CARGO_BIN_EXE_atas"));
    let folder = tempfile::tempdir_in(program.parent().expect("a folder")).expect("a folder");
    let alone = folder.path().join("atas");
    std::fs::hard_link(program, &alone).expect("linked");
    let output = Command::new(&alone)
        .args(["demo", "grasp"])
        .env("PATH", folder.path())
        .output()
        .expect("it starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(
        stderr.contains("atas-demo") && stderr.contains("cargo build --workspace"),
        "{stderr}"
    );
}

/// The program that stops a robot links neither controller nor simulator, not even indirectly.
#[test]
fn atas_links_neither_controller_nor_simulator() {
    let bytes = std::fs::read(env!("CARGO_BIN_EXE_atas")).expect("readable");
    let holds = |name: &str| {
        bytes
            .windows(name.len())
            .any(|part| part == name.as_bytes())
    };
    assert!(holds("atas_client"), "symbols are present");
    for name in ["atas_core", "sim_backend", "atas_evaluation"] {
        assert!(!holds(name), "{name} is linked");
    }
}

#[test]
fn json_format_applies_to_errors() {
    let bus = FreshBus::new("jsonerr");
    let check = |arguments: &[&str], exit: i32, part: &str| {
        let (code, stdout, stderr) = run(arguments);
        assert_eq!(code, exit, "{arguments:?}: {stderr}");
        assert!(stdout.is_empty(), "{stdout}");
        let error: serde_json::Value = serde_json::from_str(&stderr).expect("JSON");
        assert_eq!(error["exit"], exit, "{error}");
        let sentence = error["error"].as_str().unwrap_or_default();
        assert!(sentence.contains(part), "{error}");
    };
    let name = bus.as_str();
    check(&["status", "--format", "json", "--bus", name], 3, "atasd");
    check(&["fly", "--format=json"], 2, "unrecognized");
    check(&["grasp", "--format", "json"], 2, "--at");
}

#[test]
fn mistyped_bus_leaves_no_files() {
    let bus = FreshBus::new("mistyped");
    let left = || {
        let files = std::fs::read_dir("/dev/shm")
            .expect("shared memory")
            .flatten();
        let of_bus = |name: &str| name.starts_with(&format!("{}_", bus.as_str()));
        files
            .filter(|file| of_bus(&file.file_name().to_string_lossy()))
            .count()
    };
    for command in [
        "status", "events", "estop", "latency", "cancel", "screw", "doctor",
    ] {
        run(&[command, "--bus", bus.as_str()]);
        assert_eq!(left(), 0, "{command} left shared memory behind");
    }
    let (_, stdout, _) = run(&["doctor", "--format", "json", "--bus", bus.as_str()]);
    assert!(stdout.contains("is not there"), "{stdout}");
}

#[test]
fn full_disk_and_closed_pipe_do_not_panic() {
    let printing = [
        &["completions", "bash"][..],
        &["help"],
        &["--help"],
        &["plot", "--help"],
        &["--version"],
        &["doctor"],
    ];
    for arguments in printing {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
        let mut command = atas(arguments);
        command.stdout(Stdio::from(full.expect("Linux has it")));
        let output = command.stderr(Stdio::piped()).output().expect("it starts");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {stderr}");
        assert!(
            stderr.starts_with("atas: could not write to standard output"),
            "{arguments:?}: {stderr}"
        );
    }
    for arguments in [&["completions", "bash"][..], &["--help"]] {
        let mut child = atas(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("it ends");
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success() && stderr.is_empty(), "{stderr}");
    }
}

#[test]
fn wrong_output_suffix_is_rejected() {
    let check = |arguments: &[&str], suffix: &str| {
        let (code, _, stderr) = run(arguments);
        assert!(
            code == 2 && stderr.contains(suffix),
            "{arguments:?}: {stderr}"
        );
    };
    check(&["plot", "grasp", "--out", "grasp.bmp"], ".svg");
    check(&["record", "--out", "run.bag"], ".mcap");
    check(&["demo", "swarm", "--replay", "swarm.gif"], ".html");
    let export = ["export", "run.mcap", "--to", "csv", "--out", "run.parquet"];
    check(&export, "use --to parquet");
}
