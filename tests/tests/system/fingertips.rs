//! Tests with a three-fingertip robot that only the daemon and the simulator are configured for:
//! all clients show this robot and every fingertip.

use std::path::Path;
use std::process::Command;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::FreshBus;
use system_tests::browser::request;
use system_tests::terminal::Terminal;
use system_tests::{Process, binary, lock_exclusive, wait_for};

use crate::dashboard::{address, serve};

/// A robot in lock-step and its daemon.
struct Rig<'a> {
    bus: &'a str,
    _robot: Process,
    daemon: Process,
}

impl<'a> Rig<'a> {
    fn start(bus: &'a str, robot: &str, object: &str) -> Self {
        let simulate = [
            "run",
            "--lockstep",
            "--robot",
            robot,
            "--object",
            object,
            "--bus",
            bus,
        ];
        let control = [
            "--lockstep",
            "--config",
            "/dev/null",
            "--robot",
            robot,
            "--bus",
            bus,
        ];
        let rig = Self {
            bus,
            _robot: Process::start("atas-sim", &simulate),
            daemon: Process::start("atasd", &control),
        };
        wait_for("the daemon", || rig.status().map(|_| ()));
        rig
    }

    /// Returns the output of `atas status`.
    fn status(&self) -> Option<String> {
        let output = atas(&["status", "--bus", self.bus]);
        (output.0 == Some(0)).then_some(output.1)
    }

    fn end(mut self) {
        self.daemon.signal(Signal::TERM);
        self.daemon.wait();
    }
}

/// Runs `atas`; returns the exit code and standard output.
fn atas(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(binary("atas")).args(arguments).output();
    let output = output.expect("atas starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), text)
}

/// Returns the robot that the page draws, its fingertip counts and its note.
fn scene(port: u16) -> (Value, Value, String) {
    let (_, body) = request(port, "GET", "/scene.json", &[]).expect("an answer");
    let scene: Value = serde_json::from_str(&body).expect("JSON");
    let note = scene["note"].as_str().unwrap_or_default().to_owned();
    (scene["robot"].clone(), scene["fingers"].clone(), note)
}

#[test]
fn clients_show_running_robot_and_all_fingertips() {
    let _alone = lock_exclusive();
    let bus = FreshBus::new("fingers");
    let name = bus.as_str();
    let server = serve(&["--bus", name]);
    let (_, port, _) = address(&server);
    let (robot, _, note) = scene(port);
    assert!(
        robot.is_null() && note.contains("no daemon"),
        "{robot} {note}"
    );
    let rig = Rig::start(name, "three-finger", "wood");
    let waited = |robot: &str| {
        wait_for(&format!("{robot} on the page"), || {
            let found = scene(port);
            (found.0 == robot).then_some(found)
        })
    };
    let (_, fingers, note) = waited("three-finger");
    assert_eq!((fingers, note.as_str()), (serde_json::json!([0, 3]), ""));
    let status = rig.status().expect("a daemon");
    let right = status.lines().find(|line| line.starts_with("right"));
    let forces = right.expect(&status).matches('.').count();
    assert!(
        !status.contains("left") && forces >= 6,
        "three normal and three tangential forces: {status}"
    );
    let mut top = Command::new(binary("atas"));
    top.args(["top", "--bus", name])
        .env("TERM", "xterm-256color");
    let terminal = Terminal::from_command(top);
    terminal.wait_for("3 F_n");
    terminal.wait_for("three-finger");
    rig.end();
    // The next daemon runs another robot.
    let rig = Rig::start(name, "test-bench", "wood");
    let (_, fingers, _) = waited("test-bench");
    assert_eq!(fingers, serde_json::json!([0, 2]));
    terminal.wait_for("test-bench");
    terminal.quit();
    rig.end();
}

#[test]
fn explain_covers_all_goals_and_fingertips() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let run = file("run.mcap");
    record(&run);
    let json = |words: &[&str]| -> Value {
        let (code, text) = atas(&[words, &["--format", "json"]].concat());
        assert_eq!(code, Some(0), "{words:?}");
        serde_json::from_str(&text).expect("JSON")
    };
    let listed = json(&["explain", &run, "--list"]);
    let goals = listed["goals"].as_array().expect("a list");
    let printed: Vec<_> = goals
        .iter()
        .map(|goal| (&goal["goal"], &goal["task"]))
        .collect();
    let expected = [
        (&Value::from(1), &Value::from("grasp")),
        (&Value::from(2), &Value::from("release")),
    ];
    assert_eq!(printed, expected);
    let of = |words: &[&str]| json(&[&["explain", &run][..], words].concat())["task"].clone();
    assert_eq!(of(&[]), "grasp", "`release` is not the default goal");
    assert_eq!(of(&["--goal", "-1"]), "release");
    assert_eq!(of(&["--goal", "release"]), "release");
    assert_eq!(of(&["--goal", "1"]), "grasp");
    assert_eq!(atas(&["explain", &run, "--goal", "3"]).0, Some(1));
    let (_, printed) = atas(&["explain", &run]);
    let three = printed.lines().any(|line| {
        line.contains("F_n ") && line.matches(" and ").count() > 0 && line.contains(", ")
    });
    assert!(printed.starts_with("goal 1, grasp: ") && three, "{printed}");
    let figure = file("run.svg");
    assert_eq!(atas(&["plot", &run, "--out", &figure]).0, Some(0));
    let figure = std::fs::read_to_string(figure).expect("a figure");
    assert!(figure.contains("F_n finger 3"));
    assert_eq!(atas(&["export", &run, "--to", "csv"]).0, Some(0));
    let table = std::fs::read_to_string(folder.path().join("run.csv")).expect("a table");
    let names = table.lines().next().expect("names");
    assert!(
        names.contains(",right_finger3_normal_n,") && !names.contains("left_"),
        "{names}"
    );
}

/// Records a grasp and a release.
fn record(file: &str) {
    let bus = FreshBus::new("fingersrec");
    let name = bus.as_str();
    let mut recorder = Process::start("atas", &["record", "--bus", name, "--out", file]);
    wait_for("the recorder", || Path::new(file).exists().then_some(()));
    let rig = Rig::start(name, "three-finger", "wood");
    let goal = "grasp --at 0.299,0,0.0345 --width 50 --yaw 90 --lift 10 --hold 0.05 --bus";
    let goal: Vec<&str> = goal.split(' ').chain([name]).collect();
    assert_eq!(atas(&goal).0, Some(0));
    assert_eq!(atas(&["release", "--bus", name]).0, Some(0));
    rig.end();
    recorder.signal(Signal::INT);
    recorder.wait();
}
