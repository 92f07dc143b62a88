//! Versions: files of earlier releases stay readable, programs of another ABI are refused, and all
//! programs print their version.
//!
//! `tests/fixtures/VERSION` holds a configuration with every key and a recording of each release.
//! The fixtures never change. A deliberate break changes the expectation here, the compatibility
//! page of the guide, and CHANGELOG.md. Recording of 0.1.0, 600 ticks of a grasp in lock-step:
//!
//! ```sh
//! atas record --out grasp.mcap --note object=wood &
//! atas-sim run --object wood --robot test-bench --rate-hz 200 --lockstep --duration 0.6 &
//! atasd --lockstep --record-stream --config /dev/null --robot test-bench \
//!     --set hands.right.rate_hz=200 &
//! atas grasp --at 0.30,0.0,0.0345 --width 50 --lift 5 --hold 0.05
//! ```

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use shm_bus::{Abi, Bus, FreshBus, Realtime};
use system_tests::{Process, binary, lock_shared, wait_for};

/// Every program of the workspace and the name that it prints.
const PROGRAMS: [[&str; 2]; 10] = [
    ["atas", "atas"],
    ["atasd", "atasd"],
    ["atas-sim", "atas-sim"],
    ["ebts", "ebts"],
    // Started by `atas`, whose command line they have.
    ["atas-demo", "atas"],
    ["atas-lab", "atas"],
    ["atas-live", "atas"],
    ["atas-sensor", "atas-sensor"],
    ["atas-robot", "atas-robot"],
    ["atas-gate", "atas-gate"],
];
/// Releases with fixtures, and the number of ticks of their recordings.
const RELEASES: [(&str, u64); 1] = [("0.1.0", 600)];
/// Version of another program, as it would write it to the folder of its bus.
const OTHER: &str = "atas 0.2.0 (ABI v9 0x0123456789abcdef)";
/// Exit code: the bus could not be opened.
const BUS: i32 = 9;

fn fixture(release: &str, file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures")
        .join(release)
        .join(file)
}

/// Runs a program to its end; returns exit code, standard output and standard error.
fn run(program: &str, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(binary(program))
        .args(arguments)
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

/// Runs `atas` on the recording of a release; returns exit code, result and standard error.
fn run_on_recording(release: &str, command: &[&str]) -> (Option<i32>, Value, String) {
    let file = fixture(release, "grasp.mcap");
    let file = file.to_str().expect("UTF-8");
    let arguments = [command, &["--format", "json", file]].concat();
    let (code, stdout, stderr) = run("atas", &arguments);
    let value = serde_json::from_str(&stdout).unwrap_or(Value::Null);
    (code, value, stderr)
}

#[test]
fn configurations_of_earlier_releases_are_accepted() {
    for (release, _) in RELEASES {
        let file = fixture(release, "atas.toml");
        let path = file.to_str().expect("UTF-8");
        let (code, effective, stderr) = run("atasd", &["--check-config", "--config", path]);
        assert_eq!(code, Some(0), "{release}: {stderr}");
        let written = std::fs::read_to_string(&file).expect("the fixture is readable");
        for line in written.lines().filter(|line| line.contains(" = ")) {
            assert!(
                effective.lines().any(|other| other == line),
                "{release}: {line:?} is not effective in:\n{effective}"
            );
        }
    }
}

#[test]
fn recordings_of_earlier_releases_are_readable() {
    for (release, ticks) in RELEASES {
        let (code, contents, stderr) = run_on_recording(release, &["record", "check"]);
        assert_eq!(code, Some(0), "{release}: {stderr}");
        assert_eq!(contents["parts"], ticks, "{release}: {contents}");
        assert_eq!(contents["lost"], 0, "{release}: {contents}");
        let (code, explained, stderr) = run_on_recording(release, &["explain", "--list"]);
        assert_eq!(code, Some(0), "{release}: {stderr}");
        let goals = explained["goals"].as_array().map_or(&[][..], Vec::as_slice);
        let tasks: Vec<&Value> = goals.iter().map(|goal| &goal["task"]).collect();
        assert_eq!(tasks, ["grasp"], "{release}: {explained}");
    }
}

/// A changed controller gives other commands, and a changed table of parameters refuses the replay.
/// Both are permitted in a minor version.
#[test]
fn earlier_recordings_replay_or_name_their_version() {
    for (release, ticks) in RELEASES {
        let (code, replayed, stderr) = run_on_recording(release, &["replay"]);
        match code {
            Some(0) => assert_eq!(replayed["different"], 0, "{release}: {replayed}"),
            _ if replayed.is_null() => {
                let refused = "version that recorded";
                assert!(stderr.contains(refused), "{release}: {stderr}");
                continue;
            }
            _ => {
                let reported = "the replay first differs from the recording";
                assert!(stderr.contains(reported), "{release}: {stderr}");
            }
        }
        assert_eq!(replayed["ticks"], ticks, "{release}: {replayed}");
    }
}

#[test]
fn programs_of_other_abi_are_refused() {
    let _shared = lock_shared();
    let bus = FreshBus::new("abi");
    let name = bus.as_str();
    let simulator = Process::start("atas-sim", &["run", "--lockstep", "--bus", name]);
    let folder = wait_for("the simulator", || {
        let joined = Bus::join(&bus, "watch", Realtime::No).ok()?;
        let peers = joined.peers().ok()?;
        let is_there = peers.iter().any(|peer| peer.pid == simulator.pid());
        is_there.then(|| joined.folder().to_owned())
    });
    std::fs::write(folder.join("version"), format!("{OTHER}\n")).expect("written");
    let program = format!(
        "atas {} (ABI {})",
        env!("CARGO_PKG_VERSION"),
        Abi::current()
    );
    let check = |code: Option<i32>, text: &str| {
        assert_eq!(code, Some(BUS), "{text}");
        for part in [OTHER, &program, "install the same version of both"] {
            assert!(text.contains(part), "{part:?} is missing in: {text}");
        }
    };
    let (code, _, stderr) = run("atas", &["status", "--bus", name]);
    check(code, &stderr);
    let mut daemon = Process::start("atasd", &["--config", "/dev/null", "--bus", name]);
    check(daemon.wait().code(), &daemon.log());
}

#[test]
fn every_program_prints_commit_and_abi() {
    for [program, name] in PROGRAMS {
        let (code, long, stderr) = run(program, &["--version"]);
        assert_eq!(code, Some(0), "{program}: {stderr}");
        let begin = format!("{name} {} (", env!("CARGO_PKG_VERSION"));
        let end = format!(", ABI {})\n", Abi::current());
        assert!(
            long.starts_with(&begin) && long.ends_with(&end),
            "{program}: {long}"
        );
        let build = &long[begin.len()..long.len() - end.len()];
        assert!(
            build == "development build" || build.starts_with("commit "),
            "{program}: {build}"
        );
        let (_, short, _) = run(program, &["-V"]);
        assert_eq!(short, format!("{name} {}\n", env!("CARGO_PKG_VERSION")));
    }
}
