//! Leading a hand with real processes: a file, keys in a terminal, a client that dies, another writer, a stop.
//!
//! In lock-step, so that nothing depends on the machine's pace.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use rustix::process::Signal;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{GoalState, Mode, Status, service};
use system_tests::{Process, alone, binary, wait_for};

/// To the wood before the right hand, around it, closed by far too much, lifted, aside.
const PICK: &str = "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m
0,right,0.32,-0.15,0.10,1.5708,0.07
3,right,0.32,-0.15,0.0345,1.5708,0.07
5,right,0.32,-0.15,0.0345,1.5708,0.04
10,right,0.32,-0.15,0.08,1.5708,0.04
13,right,0.32,-0.22,0.08,1.5708,0.04
15,right,0.32,-0.22,0.08,1.5708,0.04
";
/// The same for as long as anybody watches.
const STAY: &str = "0,right,0.32,-0.22,0.08,1.5708,0.04\n3600,right,0.32,-0.22,0.08,1.5708,0.04\n";

/// A simulator and a daemon on a bus of their own, with files.
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

    /// A client that goes on beside the test.
    fn begin(&self, words: &[&str]) -> Process {
        Process::start("atas", &[words, &["--bus", self.bus.as_str()]].concat())
    }

    /// The first status that fulfils this.
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

/// Exit code and what it said on standard error.
fn end(output: &Output) -> (i32, String) {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code().expect("a code"), text)
}

fn carries(status: &Status) -> bool {
    status.step.as_str() == "carry" && status.hands[1].normal_n[0] > 0.3
}

#[test]
fn a_file_leads_the_hand_and_the_recording_replays_to_the_bit() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("run.mcap");
    let out = file.to_str().expect("UTF-8");
    // The recorder was there first.
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
        command.args(["follow", path, "--format", "json", "--bus", name]);
        command.output().expect("it starts")
    };
    let followed = wait_for("a daemon that follows", || {
        let output = follow();
        (output.status.code() != Some(3)).then_some(output)
    });
    let (code, stderr) = end(&followed);
    assert_eq!(code, 0, "{stderr}");
    let told: Value = serde_json::from_slice(&followed.stdout).expect("JSON");
    assert_eq!(told["state"], "cancelled", "{told}");
    let pressed = told["figures"]["normal_n"][0].as_f64().expect("a force");
    let f2_n = told["figures"]["f2_n"].as_f64().expect("a force");
    assert!(pressed > 0.5 && pressed < f2_n, "{told}");
    assert!(
        told["figures"]["lifted_m"].as_f64().expect("a distance") > 0.03,
        "{told}"
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
fn goals_and_streams_and_second_writers_are_refused_by_name() {
    let _alone = alone();
    let rig = Rig::new(&[]);
    let file = rig.file(
        "stay.csv",
        &format!(
            "{}{STAY}",
            PICK.lines()
                .next()
                .map_or(String::new(), |head| format!("{head}\n"))
        ),
    );
    let path = file.to_str().expect("UTF-8");
    let mut client = rig.begin(&["follow", path]);
    rig.status("a stream", |status| status.step.as_str() == "follow");
    let (code, said) = end(&rig.atas(&["release"]));
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("the goal `follow` is active"), "{said}");
    let (code, said) = end(&rig.atas(&["follow", path]));
    assert_eq!(code, 1, "{said}");
    let pid = client.pid().to_string();
    assert!(
        said.contains(&pid) && said.contains("atas/v1/grasp-target"),
        "{said}"
    );
    client.signal(Signal::INT);
    assert_eq!(client.wait().code(), Some(5), "{}", client.log());
    assert!(client.log().contains("followed"), "{}", client.log());
    // And the other way round.
    let mut goal = rig.begin(&[
        "grasp",
        "--at",
        "0.32,-0.15,0.0345",
        "--width",
        "50",
        "--hold",
        "3600",
    ]);
    rig.status("a grasp", |status| status.step.as_str() == "hold");
    let (code, said) = end(&rig.atas(&["follow", path]));
    assert_eq!(code, 4, "{said}");
    assert!(said.contains("the goal `grasp` is active"), "{said}");
    goal.signal(Signal::INT);
    assert_eq!(goal.wait().code(), Some(5));
    let bad = rig.file(
        "bad.csv",
        "t_s,hand,x_m,y_m,z_m,yaw_rad,opening_m\n0,middle,a,1,1,1,hold\n",
    );
    let (code, said) = end(&rig.atas(&["follow", bad.to_str().expect("UTF-8")]));
    assert_eq!(code, 2, "{said}");
    assert!(
        said.contains("line 2: x_m") && said.contains("line 2: hand"),
        "{said}"
    );
}

#[test]
fn a_client_that_dies_or_is_stopped_leaves_the_grip_as_it_was() {
    let _alone = alone();
    let rig = Rig::new(&[]);
    let file = rig.file(
        "pick.csv",
        &format!("{PICK}{}", STAY.lines().last().expect("a line")),
    );
    let path = file.to_str().expect("UTF-8");
    let mut client = rig.begin(&["follow", path]);
    let held = rig.status("an object in the hand", carries);
    client.signal(Signal::KILL);
    client.wait();
    let after = rig.status("its end", |status| status.goal_state == GoalState::FAILED);
    assert_eq!(after.goal_reason.cause.name(), "client-gone");
    assert!(after.hands[1].normal_n[0] > 0.7 * held.hands[1].normal_n[0]);
    assert_eq!(end(&rig.atas(&["release"])).0, 0);
    let mut client = rig.begin(&["follow", path]);
    rig.status("a stream", |status| status.step.as_str() == "follow");
    assert_eq!(end(&rig.atas(&["estop"])).0, 0);
    assert_eq!(client.wait().code(), Some(4), "{}", client.log());
    assert!(client.log().contains("estop"), "{}", client.log());
    let stopped = rig.status("a stop", |status| status.mode == Mode::SAFE_STOP);
    assert_eq!(stopped.goal_state, GoalState::FAILED);
    drop(rig.daemon);
}

#[test]
fn keys_in_a_terminal_lead_a_hand() {
    let _alone = alone();
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
        .args(["follow", "--step", "10", "--bus", rig.bus.as_str()])
        .env("TERM", "xterm-256color")
        .stdin(again())
        .stdout(again())
        .stderr(again())
        .spawn()
        .expect("started");
    drop(slave);
    let mut master = File::from(master);
    rig.status("a stream", |status| status.step.as_str() == "follow");
    let begin = rig.status("a start", |_| true);
    // Twice up, once open.
    for key in ["\x1b[A", "\x1b[A", "o"] {
        master.write_all(key.as_bytes()).expect("typed");
    }
    rig.status("time", |status| status.ticks > begin.ticks + 3_000);
    master.write_all(b"q").expect("typed");
    let code = wait_for("its end", || program.try_wait().expect("waitable"));
    let mut said = Vec::new();
    let mut piece = [0; 4096];
    while let Ok(read @ 1..) = master.read(&mut piece) {
        said.extend_from_slice(&piece[..read]);
    }
    let said = String::from_utf8_lossy(&said).into_owned();
    assert_eq!(code.code(), Some(0), "{said}");
    assert!(
        said.contains("x 0.280") && said.contains("open 80 mm"),
        "{said}"
    );
    assert!(
        said.contains("followed") && said.contains("stays where it is"),
        "{said}"
    );
    let (code, refused) = end(&rig.atas(&["follow"]));
    assert_eq!(code, 2, "{refused}");
    assert!(refused.contains("no terminal"), "{refused}");
}
