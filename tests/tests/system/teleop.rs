//! Tests of teleoperation with real processes: targets from a file, keys in a terminal, a client
//! that dies, a second writer, a stop.
//!
//! Runs in lock-step, so the result does not depend on the machine's speed.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{GoalState, Mode, Status, service};
use system_tests::{Process, binary, lock_exclusive, wait_for};

/// Targets: move to the wood object in front of the right hand, close below its width, lift, move
/// sideways.
const PICK: &str = "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m
0,right,0.32,-0.15,0.10,1.5708,0.07
3,right,0.32,-0.15,0.0345,1.5708,0.07
5,right,0.32,-0.15,0.0345,1.5708,0.04
10,right,0.32,-0.15,0.08,1.5708,0.04
13,right,0.32,-0.22,0.08,1.5708,0.04
15,right,0.32,-0.22,0.08,1.5708,0.04
";
/// Targets that hold the last pose of `PICK` for an hour.
const HOLD_LAST: &str =
    "0,right,0.32,-0.22,0.08,1.5708,0.04\n3600,right,0.32,-0.22,0.08,1.5708,0.04\n";

/// A simulator and a daemon on a private bus, and a folder for files.
struct Rig {
    daemon: Process,
    _simulator: Process,
    bus: FreshBus,
    folder: tempfile::TempDir,
}

impl Rig {
    fn new(control: &[&str]) -> Self {
        let bus = FreshBus::new("lead");
        let on = ["--lockstep", "--bus", bus.as_str()];
        let simulator = [&["run", "--object", "wood"], &on[..]].concat();
        let simulator = Process::start("atas-sim", &simulator);
        let daemon = [&on[..], &["--config", "/dev/null"], control].concat();
        let daemon = Process::start("atasd", &daemon);
        let rig = Self {
            daemon,
            _simulator: simulator,
            bus,
            folder: tempfile::tempdir().expect("a folder"),
        };
        wait_for("the daemon", || {
            rig.atas(&["status"]).status.success().then_some(())
        });
        rig
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        path
    }

    fn atas(&self, words: &[&str]) -> Output {
        let bus = ["--bus", self.bus.as_str()];
        let mut command = Command::new(binary("atas"));
        command.args(words).args(bus).env_remove("RUST_LOG");
        command.output().expect("it starts")
    }

    /// Starts a client that runs in parallel with the test.
    fn start_client(&self, words: &[&str]) -> Process {
        Process::start("atas", &[words, &["--bus", self.bus.as_str()]].concat())
    }

    /// Waits for the first status that fulfils a condition.
    fn status(&self, what: &str, is: impl Fn(&Status) -> bool) -> Status {
        let bus = Bus::open(&self.bus, "watch", Realtime::No).expect("a bus");
        let mut statuses = bus.subscriber(service::STATUS).expect("a subscriber");
        let mut status = Status::default();
        wait_for(what, || {
            let news = statuses.newest(&mut status).expect("readable");
            (news && is(&status)).then_some(status)
        })
    }
}

/// Returns the exit code and standard error.
fn exit_and_stderr(output: &Output) -> (i32, String) {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().expect("a code"), text)
}

fn is_carrying(status: &Status) -> bool {
    status.step.as_str() == "carry" && status.hands[1].normal_n[0] > 0.3
}

#[test]
fn teleop_from_file_replays_bit_exactly() {
    let _alone = lock_exclusive();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let out = file.to_str().expect("UTF-8");
    // The recorder starts first.
    let bus = FreshBus::new("leadtape");
    let name = bus.as_str();
    let recorder = Process::start("atas", &["record", "--bus", name, "--out", out]);
    wait_for("the recorder", || file.exists().then_some(()));
    let simulator = ["run", "--object", "wood", "--lockstep", "--bus", name];
    let _simulator = Process::start("atas-sim", &simulator);
    let control = [
        "--lockstep",
        "--record-stream",
        "--config",
        "/dev/null",
        "--bus",
        name,
    ];
    let mut daemon = Process::start("atasd", &control);
    let targets = folder.path().join("pick.csv");
    std::fs::write(&targets, PICK).expect("writable");
    let follow = || {
        let mut command = Command::new(binary("atas"));
        let path = targets.to_str().expect("UTF-8");
        command.args(["teleop", path, "--format", "json", "--bus", name]);
        command.output().expect("it starts")
    };
    let followed = wait_for("a daemon that accepts teleoperation", || {
        let output = follow();
        (output.status.code() != Some(3)).then_some(output)
    });
    let (code, stderr) = exit_and_stderr(&followed);
    assert_eq!(code, 0, "{stderr}");
    let printed: Value = serde_json::from_slice(&followed.stdout).expect("JSON");
    assert_eq!(printed["state"], "cancelled", "{printed}");
    let pressed = printed["figures"]["normal_n"][0].as_f64().expect("a force");
    let f2_n = printed["figures"]["f2_n"].as_f64().expect("a force");
    assert!(pressed > 0.5 && pressed < f2_n, "{printed}");
    assert!(
        printed["figures"]["lifted_m"].as_f64().expect("a distance") > 0.03,
        "{printed}"
    );
    daemon.signal(Signal::TERM);
    assert_eq!(daemon.wait().code(), Some(0));
    let mut recorder = recorder;
    recorder.signal(Signal::INT);
    assert_eq!(recorder.wait().code(), Some(0), "{}", recorder.log());
    let replay = Command::new(binary("atas"))
        .args(["replay", out, "--format", "json"])
        .output()
        .expect("it starts");
    let replayed: Value = serde_json::from_slice(&replay.stdout).expect("JSON");
    assert_eq!(replayed["different"], 0, "{replayed}");
    assert!(
        replayed["ticks"].as_u64().expect("a count") > 10_000,
        "{replayed}"
    );
}

#[test]
fn goal_stream_and_second_writer_are_rejected() {
    let _alone = lock_exclusive();
    let rig = Rig::new(&[]);
    let file = rig.file(
        "stay.csv",
        &format!(
            "{}{HOLD_LAST}",
            PICK.lines()
                .next()
                .map_or(String::new(), |head| format!("{head}\n"))
        ),
    );
    let path = file.to_str().expect("UTF-8");
    let mut client = rig.start_client(&["teleop", path]);
    rig.status("a stream", |status| status.step.as_str() == "teleop");
    let (code, message) = exit_and_stderr(&rig.atas(&["release"]));
    assert_eq!(code, 4, "{message}");
    assert!(message.contains("the goal `teleop` is active"), "{message}");
    let (code, message) = exit_and_stderr(&rig.atas(&["teleop", path]));
    assert_eq!(code, 8, "{message}");
    let pid = client.pid().to_string();
    assert!(
        message.contains(&pid) && message.contains("atas/v1/grasp-target"),
        "{message}"
    );
    client.signal(Signal::INT);
    assert_eq!(client.wait().code(), Some(5), "{}", client.log());
    assert!(client.log().contains("sent "), "{}", client.log());
    // The reverse: teleoperation is rejected while a goal is active.
    let mut goal = rig.start_client(&[
        "grasp",
        "--at",
        "0.32,-0.15,0.0345",
        "--width",
        "50",
        "--hold",
        "3600",
    ]);
    rig.status("a grasp", |status| status.step.as_str() == "hold");
    let (code, message) = exit_and_stderr(&rig.atas(&["teleop", path]));
    assert_eq!(code, 4, "{message}");
    assert!(message.contains("the goal `grasp` is active"), "{message}");
    goal.signal(Signal::INT);
    assert_eq!(goal.wait().code(), Some(5));
    let bad = rig.file(
        "bad.csv",
        "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m\n0,middle,a,1,1,1,hold\n",
    );
    let (code, message) = exit_and_stderr(&rig.atas(&["teleop", bad.to_str().expect("UTF-8")]));
    assert_eq!(code, 2, "{message}");
    assert!(
        message.contains("line 2: x_m") && message.contains("line 2: hand"),
        "{message}"
    );
}

#[test]
fn grip_persists_after_client_dies_or_stop() {
    let _alone = lock_exclusive();
    let rig = Rig::new(&[]);
    let file = rig.file(
        "pick.csv",
        &format!("{PICK}{}", HOLD_LAST.lines().last().expect("a line")),
    );
    let path = file.to_str().expect("UTF-8");
    let mut client = rig.start_client(&["teleop", path]);
    let held = rig.status("an object in the hand", is_carrying);
    client.signal(Signal::KILL);
    client.wait();
    let after = rig.status("the end of the goal", |status| {
        status.goal_state == GoalState::FAILED
    });
    assert_eq!(after.goal_reason.cause.name(), "client-gone");
    assert!(after.hands[1].normal_n[0] > 0.7 * held.hands[1].normal_n[0]);
    assert_eq!(exit_and_stderr(&rig.atas(&["release"])).0, 0);
    let mut client = rig.start_client(&["teleop", path]);
    rig.status("a stream", |status| status.step.as_str() == "teleop");
    assert_eq!(exit_and_stderr(&rig.atas(&["estop"])).0, 0);
    assert_eq!(client.wait().code(), Some(4), "{}", client.log());
    assert!(client.log().contains("estop"), "{}", client.log());
    let stopped = rig.status("a stop", |status| status.mode == Mode::SAFE_STOP);
    assert_eq!(stopped.goal_state, GoalState::FAILED);
    drop(rig.daemon);
}

#[test]
fn terminal_keys_move_the_hand() {
    let _alone = lock_exclusive();
    let rig = Rig::new(&[]);
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a terminal");
    grantpt(&master).expect("granted");
    unlockpt(&master).expect("unlocked");
    let name = ptsname(&master, Vec::new()).expect("a name");
    let slave = File::options()
        .read(true)
        .write(true)
        .open(name.to_str().expect("UTF-8"))
        .expect("opened");
    let again = || Stdio::from(slave.try_clone().expect("another handle"));
    let mut program = Command::new(binary("atas"))
        .args(["teleop", "--step", "10", "--bus", rig.bus.as_str()])
        .env("TERM", "xterm-256color")
        .stdin(again())
        .stdout(again())
        .stderr(again())
        .spawn()
        .expect("started");
    drop(slave);
    let mut master = File::from(master);
    rig.status("a stream", |status| status.step.as_str() == "teleop");
    let begin = rig.status("a start", |_| true);
    // Twice forward, once open.
    for key in ["\x1b[A", "\x1b[A", "o"] {
        master.write_all(key.as_bytes()).expect("typed");
    }
    rig.status("3,000 ticks", |status| status.ticks > begin.ticks + 3_000);
    master.write_all(b"q").expect("typed");
    let code = wait_for("the end of the program", || {
        program.try_wait().expect("waitable")
    });
    let mut message = Vec::new();
    let mut piece = [0; 4096];
    while let Ok(read @ 1..) = master.read(&mut piece) {
        message.extend_from_slice(&piece[..read]);
    }
    let message = String::from_utf8_lossy(&message).into_owned();
    assert_eq!(code.code(), Some(0), "{message}");
    assert!(
        message.contains("x 0.280") && message.contains("open 80 mm"),
        "{message}"
    );
    assert!(
        message.contains("sent ") && message.contains("stays where it is"),
        "{message}"
    );
    let (code, refused) = exit_and_stderr(&rig.atas(&["teleop"]));
    assert_eq!(code, 2, "{refused}");
    assert!(refused.contains("no terminal"), "{refused}");
}
