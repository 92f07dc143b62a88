//! A robot with one hand of three fingers, told to nobody but its daemon: whoever looks on shows this robot, and every finger.

use std::path::Path;
use std::process::Command;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::FreshBus;
use system_tests::browser::request;
use system_tests::terminal::Terminal;
use system_tests::{Process, alone, binary, wait_for};

use crate::dashboard::{address, serve};

/// A robot in lock-step, its daemon, perhaps a recorder.
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

    /// What `atas status` prints.
    fn status(&self) -> Option<String> {
        let output = atas(&["status", "--bus", self.bus]);
        (output.0 == Some(0)).then_some(output.1)
    }

    fn end(mut self) {
        self.daemon.signal(Signal::TERM);
        self.daemon.wait();
    }
}

/// Exit code and standard output.
fn atas(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(binary("atas")).args(arguments).output();
    let output = output.expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (output.status.code(), text)
}

/// The robot that a page draws, its fingers, and what it says of it.
fn scene(port: u16) -> (Value, Value, String) {
    let (_, body) = request(port, "GET", "/scene.json", &[]).expect("an answer");
    let scene: Value = serde_json::from_str(&body).expect("JSON");
    let note = scene["note"].as_str().unwrap_or_default().to_owned();
    (scene["robot"].clone(), scene["fingers"].clone(), note)
}

#[test]
fn whoever_looks_on_shows_the_robot_that_runs_with_every_finger() {
    let _alone = alone();
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
        "three of each: {status}"
    );
    let mut top = Command::new(binary("atas"));
    top.args(["top", "--bus", name])
        .env("TERM", "xterm-256color");
    let terminal = Terminal::with(top);
    terminal.wait_for("3 F_n");
    terminal.wait_for("three-finger");
    rig.end();
    // Its successor runs another one.
    let rig = Rig::start(name, "test-bench", "wood");
    let (_, fingers, _) = waited("test-bench");
    assert_eq!(fingers, serde_json::json!([0, 2]));
    terminal.wait_for("test-bench");
    terminal.quit();
    rig.end();
}

#[test]
fn every_goal_of_a_recording_can_be_told_with_every_finger() {
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
    let told: Vec<_> = goals
        .iter()
        .map(|goal| (&goal["goal"], &goal["task"]))
        .collect();
    let expected = [
        (&Value::from(1), &Value::from("grasp")),
        (&Value::from(2), &Value::from("release")),
    ];
    assert_eq!(told, expected);
    let of = |words: &[&str]| json(&[&["explain", &run][..], words].concat())["task"].clone();
    assert_eq!(of(&[]), "grasp", "a release is no task");
    assert_eq!(of(&["--goal", "-1"]), "release");
    assert_eq!(of(&["--goal", "release"]), "release");
    assert_eq!(of(&["--goal", "1"]), "grasp");
    assert_eq!(atas(&["explain", &run, "--goal", "3"]).0, Some(1));
    let (_, told) = atas(&["explain", &run]);
    let three = told.lines().any(|line| {
        line.contains("F_n ") && line.matches(" and ").count() > 0 && line.contains(", ")
    });
    assert!(told.starts_with("goal 1, grasp: ") && three, "{told}");
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

/// Records a grasp and the release after it.
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
