//! Tests of other robots than the two-hand arm, on the command line and on the bus: each robot
//! performs the tasks that it can, and other tasks are rejected. User robot files work like the
//! built-in ones, and their recordings replay.

use std::path::Path;
use std::process::{Command, Stdio};

use robot_model::SHIPPED;
use serde_json::Value;
use shm_bus::FreshBus;
use system_tests::{Process, binary, lock_shared, wait_for};

/// Runs `atas`; returns the exit code, the last line of standard output as JSON, and standard
/// error.
fn atas(arguments: &str) -> (i32, Value, String) {
    let output = Command::new(binary("atas"))
        .args(arguments.split_whitespace())
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null())
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let value = text.lines().last().unwrap_or_default();
    (
        output.status.code().expect("a code"),
        serde_json::from_str(value).unwrap_or(Value::Null),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

fn listed() -> Vec<Value> {
    let (code, list, error) = atas("robot list --format json");
    assert_eq!(code, 0, "{error}");
    list["robots"].as_array().expect("robots").clone()
}

#[test]
fn built_in_robots_are_listed_with_tasks() {
    let robots = listed();
    let names: Vec<&str> = robots
        .iter()
        .filter_map(|robot| robot["name"].as_str())
        .collect();
    assert_eq!(names, SHIPPED.map(|files| files.name.to_string()));
    let tasks = |index: usize| robots[index]["tasks"].as_array().map_or(0, Vec::len);
    assert_eq!([0, 1, 2, 3].map(tasks), [4, 3, 2, 1], "{robots:?}");
}

#[test]
fn demos_succeed_for_supported_tasks() {
    let _shared = lock_shared();
    for robot in listed().iter().skip(1) {
        for task in robot["tasks"].as_array().expect("tasks") {
            let (task, name) = (
                task.as_str().expect("a name"),
                robot["name"].as_str().expect("a name"),
            );
            let (code, printed, error) = atas(&format!(
                "demo {task} --robot {name} --lockstep --format json"
            ));
            assert_eq!(
                (code, &printed["as_expected"]),
                (0, &Value::Bool(true)),
                "{task} {name}: {printed} {error}"
            );
        }
    }
}

#[test]
fn unsupported_task_is_rejected_by_name() {
    let check = |arguments: &str, part: &str| {
        let (code, _, error) = atas(arguments);
        assert_eq!(code, 2, "{arguments}: {error}");
        assert!(error.contains(part), "{arguments}: {error}");
    };
    check(
        "demo pick-place --robot test-bench",
        "could not run pick-place: the robot's hand cannot do this task",
    );
    check("demo screw --robot three-finger", "could not run screw");
    check(
        "demo grasp --robot no-such",
        "needs one of two-hand-arm, arm7-gripper, three-finger, test-bench",
    );
    check(
        "robot check arm.urdf",
        "needs a robot file (.toml) that names this URDF",
    );
}

/// Copies the test bench to a folder as a user robot, with another URDF name; returns the robot
/// file.
fn own_robot(folder: &Path) -> String {
    let bench = SHIPPED
        .into_iter()
        .find(|files| files.name == "test-bench")
        .expect("the robot is built in");
    std::fs::write(folder.join("drawing.urdf"), bench.urdf.as_bytes()).expect("written");
    let file = folder.join("mine.toml");
    let text = format!("urdf = \"drawing.urdf\"\n{}", bench.robot_file);
    std::fs::write(&file, text).expect("written");
    file.to_str().expect("UTF-8").to_owned()
}

#[test]
fn user_robot_file_is_checked_and_drawn() {
    let folder = tempfile::tempdir().expect("a folder");
    let (file, picture) = (own_robot(folder.path()), folder.path().join("mine.svg"));
    let (code, printed, error) = atas(&format!(
        "robot check {file} --out {} --format json",
        picture.display()
    ));
    assert_eq!(code, 0, "{error}");
    assert_eq!(printed["tasks"], serde_json::json!(["grasp"]), "{printed}");
    let trial = &printed["trials"][0];
    assert_eq!(
        (&trial["task"], &trial["outcome"]),
        (&Value::from("grasp"), &Value::from("held")),
        "{printed}"
    );
    assert!(
        printed["hands"][0]["workspace"]["z_m"][1].as_f64() > Some(0.1),
        "{printed}"
    );
    let svg = std::fs::read_to_string(picture).expect("a picture");
    for view in ["front", "side", "above"] {
        assert!(svg.contains(view), "the picture has no {view} view");
    }
    // All errors are reported at once, each with its location.
    let text = std::fs::read_to_string(&file).expect("readable");
    let spoilt = text
        .replace("\"left_tip\"", "\"no_tip\"")
        .replace("stage = {", "no_stage = {")
        .replace("stiffness = 20000", "stiffness = -1");
    std::fs::write(&file, spoilt).expect("written");
    let (code, _, error) = atas(&format!("robot check {file}"));
    assert_eq!(code, 2);
    assert!(
        error.contains("link `no_tip` was missing")
            && error.contains("joint `no_stage` was missing")
            && error.contains("the stiffness of joint `left_jaw` was -1"),
        "{error}"
    );
}

/// The picture in each built-in robot's folder equals the current output of the command.
#[test]
fn built_in_robot_pictures_are_current() {
    let folder = tempfile::tempdir().expect("a folder");
    for files in SHIPPED {
        let (name, drawn) = (&files.name, folder.path().join("robot.svg"));
        let out = drawn.display();
        let (code, _, error) = atas(&format!("robot check {name} --out {out} --format json"));
        assert_eq!(code, 0, "{error}");
        let kept = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../daemon/robot/robots")
            .join(&**name)
            .join("robot.svg");
        let [drawn, kept] = [&drawn, &kept].map(|path| std::fs::read(path).expect("readable"));
        assert!(
            drawn == kept,
            "robot.svg of {name} is outdated; run `atas robot check {name} --out` to draw it again"
        );
    }
}

/// A robot with only a left hand acts with the left hand.
#[test]
fn robot_with_only_left_hand_grasps() {
    let _shared = lock_shared();
    let folder = tempfile::tempdir().expect("a folder");
    let file = own_robot(folder.path());
    let text = std::fs::read_to_string(&file).expect("readable");
    std::fs::write(&file, text.replace("[hands.right]", "[hands.left]")).expect("written");
    let (code, printed, error) = atas(&format!(
        "demo grasp --robot {file} --lockstep --format json"
    ));
    let wanted = (0, &Value::Bool(true));
    assert_eq!((code, &printed["as_expected"]), wanted, "{printed} {error}");
}

/// Runs daemon and simulator with a user robot and records a grasp; goals for a missing hand are
/// rejected.
#[test]
fn recording_of_user_robot_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    let (robot, out) = (own_robot(folder.path()), folder.path().join("run.mcap"));
    let out_text = out.to_str().expect("UTF-8");
    let bus = FreshBus::new("robot");
    let name = bus.as_str();
    let mut recorder = Process::start("atas", &["record", "--bus", name, "--out", out_text]);
    wait_for("the recorder", || out.exists().then_some(()));
    let _simulator = Process::start(
        "atas-sim",
        &[
            "run",
            "--bus",
            name,
            "--lockstep",
            "--object",
            "wood",
            "--robot",
            &robot,
        ],
    );
    let mut daemon = Process::start(
        "atasd",
        &[
            "--bus",
            name,
            "--lockstep",
            "--record-stream",
            "--config",
            "/dev/null",
            "--robot",
            &robot,
        ],
    );
    wait_for("the daemon", || {
        (atas(&format!("status --bus {name} --format json")).0 == 0).then_some(())
    });
    let goal = "--at 0.3,0,0.0345 --width 50 --lift 10 --hold 0.05 --format json";
    let (code, printed, error) = atas(&format!("grasp --bus {name} {goal}"));
    assert_eq!(
        (code, &printed["state"]),
        (0, &Value::from("succeeded")),
        "{printed} {error}"
    );
    let (code, printed, _) = atas(&format!("grasp --bus {name} --hand left {goal}"));
    assert!(
        code != 0 && printed["reason"].to_string().contains("no left hand"),
        "{printed}"
    );
    daemon.signal(rustix::process::Signal::TERM);
    daemon.wait();
    recorder.signal(rustix::process::Signal::INT);
    assert!(recorder.wait().success(), "{}", recorder.log());
    // The recording contains the robot, so it replays without the robot's files.
    std::fs::remove_file(&robot).expect("removed");
    let (code, _, error) = atas(&format!("replay {out_text}"));
    assert_eq!(code, 0, "{error}");
}
