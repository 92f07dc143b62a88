//! Tests of the paper's tasks on the command line, as commands in the simulator's scenes and as
//! demos, and of user interventions.

use std::path::Path;
use std::process::{Command, Output, Stdio};

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{ObjectTruth, WorldTruth, service};
use system_tests::{Process, binary, lock_exclusive, lock_shared, wait_for};

fn atas(arguments: &str) -> Command {
    let mut command = Command::new(binary("atas"));
    command
        .args(arguments.split_whitespace())
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .stdin(Stdio::null());
    command
}

/// Returns the exit code, the last line of standard output as JSON, and standard error.
fn exit_json_and_stderr(output: &Output) -> (i32, Value, String) {
    let text = String::from_utf8_lossy(&output.stdout);
    let value = text.lines().last().unwrap_or_default();
    (
        output.status.code().expect("a code"),
        serde_json::from_str(value).unwrap_or(Value::Null),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

fn run(arguments: &str) -> (i32, Value, String) {
    exit_json_and_stderr(&atas(arguments).output().expect("it starts"))
}

/// A simulator and a daemon in lock-step on a private bus.
struct Rig {
    _simulator: Process,
    _daemon: Process,
    bus: FreshBus,
}

impl Rig {
    fn new(scene: &str, config: &Path) -> Self {
        let bus = FreshBus::new("tasks");
        let name = bus.as_str();
        let mut simulate = vec!["run", "--bus", name, "--lockstep", "--scene"];
        simulate.extend(scene.split_whitespace());
        let config = config.to_str().expect("UTF-8");
        let control = ["--bus", name, "--config", config, "--lockstep"];
        let rig = Self {
            _simulator: Process::start("atas-sim", &simulate),
            _daemon: Process::start("atasd", &control),
            bus,
        };
        wait_for("the daemon", || (rig.ask("status").0 == 0).then_some(()));
        rig
    }

    fn plain(scene: &str) -> Self {
        Self::new(scene, Path::new("/dev/null"))
    }

    fn ask(&self, arguments: &str) -> (i32, Value, String) {
        run(&format!(
            "{arguments} --format json --bus {}",
            self.bus.as_str()
        ))
    }

    /// Returns the ground truth of the scene's objects.
    fn objects(&self) -> [ObjectTruth; 4] {
        let bus = Bus::open(&self.bus, "judge", Realtime::No).expect("a bus");
        let mut truths = bus
            .subscriber::<WorldTruth>(service::WORLD_TRUTH)
            .expect("a subscriber");
        let mut truth = WorldTruth::default();
        wait_for("the ground truth", || {
            truths.newest(&mut truth).expect("readable").then_some(())
        });
        truth.objects
    }
}

#[test]
fn default_commands_succeed_in_default_scenes() {
    let _shared = lock_shared();
    let check = |scene, command, is_done: fn(&[ObjectTruth; 4]) -> bool| {
        let rig = Rig::plain(scene);
        let (code, story, stderr) = rig.ask(command);
        assert_eq!(
            (code, &story["state"]),
            (0, &"succeeded".into()),
            "{command}: {stderr}"
        );
        let objects = rig.objects();
        assert!(is_done(&objects), "{command}: {objects:?}");
    };
    check("pick-place", "pick-place", |[wood, ..]| {
        wood.landed_ns > 0 && (wood.position_m[1] + 0.27).abs() < 0.005
    });
    check(
        "pick-place --hand left",
        "pick-place --hand left",
        |[wood, ..]| wood.landed_ns > 0 && (wood.position_m[1] - 0.27).abs() < 0.005,
    );
    check("screw", "screw", |[cap, ..]| cap.cap_closed != 0);
    check("assembly", "assemble", |[cap, bottle, ..]| {
        cap.cap_closed != 0 && bottle.table_n > 0.0 && bottle.tipped + bottle.spilt == 0
    });
}

#[test]
fn infeasible_goals_are_rejected_before_motion() {
    let _shared = lock_shared();
    let rig = Rig::plain("pick-place");
    let check = |command: &str, part: &str| {
        let (code, story, stderr) = rig.ask(command);
        assert_eq!(
            (code, &story["state"]),
            (4, &"rejected".into()),
            "{command}: {stderr}"
        );
        assert!(stderr.contains(part), "{command}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{command}: {stderr}");
    };
    check("pick-place --to 0.9,0", "to x is 0.9000");
    check("pick-place --from 0.32,0.2", "from y is 0.2000");
    check("pick-place --width 300", "width is 300.0 mm");
    check("pick-place --to 0.32,-0.27,0.2", "lift less");
    check("screw --at 0.34,-0.12,0.5", "from z is 0.5000");
    check("assemble --bottle-width 500", "helper width");
    check(
        "task polish",
        "polish: the daemon's configuration has no task of this name",
    );
    assert_eq!(rig.objects()[0].lifted_m, 0.0);
}

#[test]
fn lockstep_events_use_virtual_time() {
    let _shared = lock_shared();
    let rig = Rig::plain("pick-place");
    let (code, _, stderr) = rig.ask("pick-place");
    assert_eq!(code, 0, "{stderr}");
    let say = |arguments: &str| {
        let output = atas(&format!("{arguments} --bus {}", rig.bus.as_str())).output();
        String::from_utf8(output.expect("it starts").stdout).expect("UTF-8")
    };
    let events = say("events --last-goal");
    let at_s = |line: &str| line.split_whitespace().next()?.parse::<f64>().ok();
    let times_s: Vec<f64> = events.lines().filter_map(at_s).collect();
    assert!(times_s.len() > 5 && times_s.is_sorted(), "{events}");
    let (began_s, took_s) = (times_s[0], times_s[times_s.len() - 1] - times_s[0]);
    assert!((0.0..2.0).contains(&began_s) && took_s > 10.0, "{events}");
    let status = say("status");
    let (_, up) = status.split_once(", up ").expect("an uptime");
    let (up_s, _) = up
        .split_once(" s of virtual time")
        .expect("an uptime in virtual time");
    let up_s: f64 = up_s.parse().expect("a number");
    assert!((took_s.floor()..60.0).contains(&up_s), "{status}");
}

#[test]
fn user_task_runs_by_name() {
    let _shared = lock_shared();
    let printed = Command::new(binary("atasd")).arg("--print-tasks").output();
    let folder = tempfile::tempdir().expect("a folder");
    let config = folder.path().join("atas.toml");
    std::fs::write(&config, printed.expect("it starts").stdout).expect("writable");
    let rig = Rig::new("screw", &config);
    let cap = "--from 0.34,-0.12,0.12 --width 30";
    let (code, story, stderr) = rig.ask(&format!("task my-screw {cap}"));
    assert_eq!(
        (code, &story["state"]),
        (0, &"succeeded".into()),
        "{stderr}"
    );
    assert!(stderr.starts_with("my-screw: "), "{stderr}");
    assert_eq!(rig.objects()[0].cap_closed, 1);
}

#[test]
fn lockstep_demos_are_evaluated_by_ground_truth() {
    let _shared = lock_shared();
    let check = |demo: &str, outcome: &str, figures: &[(&str, [f64; 2])]| {
        let (code, result, stderr) = run(&format!("demo {demo} --lockstep --format json"));
        assert_eq!(code, 0, "{demo}: {stderr}");
        let object = &result["objects"][0];
        assert_eq!(result["as_expected"], true, "{result}");
        assert_eq!(
            (&object["outcome"], &object["missed_ticks"]),
            (&outcome.into(), &0.into()),
            "{result}"
        );
        for (key, [least, most]) in figures {
            let value = object[key].as_f64().unwrap_or(f64::NAN);
            assert!(
                value >= *least && value <= *most,
                "{demo}: {key} in {result}"
            );
        }
    };
    check(
        "grasp",
        "held",
        &[("lifted_mm", [35.0, 45.0]), ("slip_mm", [0.0, 1.0])],
    );
    check(
        "pick-place",
        "placed",
        &[
            ("off_mm", [0.0, 5.0]),
            ("released_after_ms", [0.0, 20.0]),
            ("released_above_mm", [0.0, 2.0]),
        ],
    );
    check("pick-place --object heavy-block", "refused", &[]);
    check(
        "screw --vary --seed 3",
        "tight",
        &[("tight_over_thread", [1.3, 2.5]), ("turns", [1.0, 20.0])],
    );
    check(
        "assembly",
        "closed, standing",
        &[
            ("bottle_tilt_deg", [-2.0, 2.0]),
            ("turned_deg", [240.0, 260.0]),
        ],
    );
}

#[test]
fn demo_is_deterministic() {
    let _shared = lock_shared();
    let once = || {
        let (code, result, stderr) = run("demo screw --lockstep --format json");
        assert_eq!(code, 0, "{stderr}");
        ["turned_deg", "tight_over_thread", "took_s"].map(|key| result["objects"][0][key].clone())
    };
    assert_eq!(once(), once());
}

/// Returns ids and names of a process's children.
fn children_of(id: u32) -> Vec<(u32, String)> {
    let text =
        std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap_or_default();
    let name =
        |child: &str| std::fs::read_to_string(format!("/proc/{child}/comm")).unwrap_or_default();
    text.split_whitespace()
        .filter_map(|child| Some((child.parse().ok()?, name(child).trim().to_owned())))
        .collect()
}

#[test]
fn demo_names_killed_process_and_cleans_up() {
    let _alone = lock_exclusive();
    for (victim, demo) in [("atasd", "screw"), ("atas-sim", "assembly")] {
        let scratch = tempfile::tempdir().expect("a folder");
        let running = atas(&format!("demo {demo}"))
            .env("TMPDIR", scratch.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("it starts");
        let id = running.id();
        let pid = wait_for("both processes", || {
            let children = children_of(id);
            let found = children.iter().find(|(_, name)| name == victim)?;
            (children.len() == 2)
                .then(|| Pid::from_raw(found.0.cast_signed()))
                .flatten()
        });
        kill_process(pid, Signal::KILL).expect("the process runs");
        let (code, _, stderr) = exit_json_and_stderr(&running.wait_with_output().expect("it ends"));
        assert_eq!(code, 1, "{stderr}");
        assert!(
            stderr.contains(&format!("{victim} ended unexpectedly")),
            "{stderr}"
        );
        let shared = std::fs::read_dir("/dev/shm")
            .expect("shared memory")
            .flatten();
        let bus = format!("fdemo-{id}-0");
        let left = shared.filter(|entry| entry.file_name().to_string_lossy().starts_with(&bus));
        assert_eq!(left.count(), 0, "shared memory of {bus}");
    }
}

/// Returns each line of standard output as JSON.
fn lines(arguments: &str) -> Vec<Value> {
    let output = atas(arguments).output().expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    text.lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect()
}

#[test]
fn failure_reason_and_events_remain_available() {
    let _shared = lock_shared();
    let rig = Rig::plain("pick-place --object heavy-block");
    let (code, end, stderr) = rig.ask("pick-place");
    assert_eq!((code, &end["state"]), (4, &"refused".into()), "{stderr}");
    // Progress precedes the error.
    let last = stderr.lines().last().unwrap_or_default();
    let error: Value = serde_json::from_str(last).expect("an error as JSON");
    assert_eq!(error["exit"], 4, "{error}");
    let (_, status, _) = rig.ask("status");
    assert_eq!(status["goal"]["state"], "refused", "{status}");
    assert_eq!(
        status["goal"]["reason"]["cause"], end["reason"]["cause"],
        "{status}"
    );
    let bus = rig.bus.as_str();
    let shown = atas(&format!("status --bus {bus}")).output();
    let shown = String::from_utf8_lossy(&shown.expect("it starts").stdout).into_owned();
    let sentence = end["reason"]["sentence"].as_str().expect("a reason text");
    assert!(shown.contains(sentence), "{shown}");

    let events = lines(&format!("events --last-goal --format json --bus {bus}"));
    let is = |event: &Value, kind: &str, text: &str| event["kind"] == kind && event["text"] == text;
    assert!(
        events
            .first()
            .is_some_and(|first| is(first, "goal", "running"))
    );
    assert!(events.iter().any(|event| is(event, "step", "lift")));
    assert!(events.iter().any(|event| is(event, "goal", "refused")));
    let steps = lines(&format!("events --kind step --format json --bus {bus}"));
    assert!(!steps.is_empty());
    for step in &steps {
        assert_eq!(step["kind"], "step");
        assert!(
            step.get("finger").is_none() && step.get("reason").is_none(),
            "{step}"
        );
    }
}

#[test]
fn any_client_can_cancel_a_goal() {
    let _shared = lock_shared();
    let rig = Rig::plain("pick-place");
    let (code, _, stderr) = rig.ask("cancel");
    assert!(
        code == 4 && stderr.contains("no goal to cancel"),
        "{stderr}"
    );
    let sent = format!("pick-place --format json --bus {}", rig.bus.as_str());
    let client = atas(&sent)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let client = client.expect("it starts");
    wait_for("a goal", || {
        (rig.ask("status").1["goal"]["state"] == "running").then_some(())
    });
    let (code, told_cancel, stderr) = rig.ask("cancel");
    assert_eq!(
        (code, &told_cancel["outcome"]),
        (0, &"done".into()),
        "{stderr}"
    );
    let (code, end, stderr) = exit_json_and_stderr(&client.wait_with_output().expect("it ends"));
    assert_eq!((code, &end["state"]), (4, &"cancelled".into()), "{stderr}");
}
