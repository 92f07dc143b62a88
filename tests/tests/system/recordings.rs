//! Tests that recordings replay bit for bit: every task, faults, and user interventions, whether
//! the goal succeeds or fails.
//!
//! Also tests recorders that a full disk or `kill -9` ends: flushed data are recovered and the
//! daemon continues. Runs in lock-step over the real bus with the real recorder.

use std::path::{Path, PathBuf};
use std::process::Command;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Status, service};
use system_tests::{Process, binary, lock_exclusive, wait_for};

/// A short grasp of the object in front of the right hand.
const GRASP: &str = "grasp --at 0.32,-0.15,0.0345 --width 50 --lift 10 --hold 0.05";
/// A grasp of the same object, held for an hour.
const HOLD: &str = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 3600";

/// Runs `atas`; returns the exit code, the last line of standard output as JSON, and standard
/// error.
fn atas(arguments: &str) -> (i32, Value, String) {
    let output = Command::new(binary("atas"))
        .args(arguments.split_whitespace())
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
        .output()
        .expect("atas starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let value = text.lines().last().unwrap_or_default();
    (
        output.status.code().expect("a code"),
        serde_json::from_str(value).unwrap_or(Value::Null),
        String::from_utf8_lossy(&output.stderr).into_owned(),
    )
}

/// A recorder, which starts first, a simulator and a daemon. The bus is dropped last.
struct Rig {
    recorder: Process,
    daemon: Process,
    _simulator: Process,
    file: PathBuf,
    bus: FreshBus,
    _folder: tempfile::TempDir,
}

impl Rig {
    /// Starts the processes. `recorder` starts the recorder with the given arguments.
    fn with_recorder(
        scene: &str,
        control: &str,
        recorder: impl FnOnce(&[&str]) -> Process,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("run.mcap");
        let bus = FreshBus::new("tape");
        let name = bus.as_str();
        let out = file.to_str().expect("UTF-8");
        let recorder = recorder(&["record", "--format", "json", "--bus", name, "--out", out]);
        // The recorder creates the file after it has opened its ports.
        wait_for("the recorder", || file.exists().then_some(()));
        let simulate = words("run --lockstep --bus", &[name], scene);
        let simulator = Process::start("atas-sim", &simulate);
        let daemon = words(
            "--lockstep --record-stream --config /dev/null --bus",
            &[name],
            control,
        );
        let daemon = Process::start("atasd", &daemon);
        let rig = Self {
            recorder,
            daemon,
            _simulator: simulator,
            file,
            bus,
            _folder: folder,
        };
        wait_for("the daemon", || (rig.ask("status").0 == 0).then_some(()));
        rig
    }

    fn new(scene: &str, control: &str) -> Self {
        Self::with_recorder(scene, control, |words| Process::start("atas", words))
    }

    fn ask(&self, command: &str) -> (i32, Value, String) {
        atas(&format!(
            "{command} --format json --bus {}",
            self.bus.as_str()
        ))
    }

    /// Starts a command that runs in parallel with the test.
    fn start_client(&self, command: &str) -> Process {
        Process::start("atas", &words(command, &["--bus", self.bus.as_str()], ""))
    }

    /// Waits for this number of daemon ticks.
    fn wait_ticks(&self, ticks: u64) {
        let bus = Bus::open(&self.bus, "watch", Realtime::No).expect("a bus");
        let mut statuses = bus.subscriber(service::STATUS).expect("a subscriber");
        let mut status = Status::default();
        let mut begin = None;
        wait_for("ticks", || {
            statuses
                .newest(&mut status)
                .expect("readable")
                .then_some(())?;
            let begin = *begin.get_or_insert(status.ticks);
            (status.ticks >= begin + ticks).then_some(())
        });
    }

    /// Ends daemon and recorder in order; returns the file.
    fn end(&mut self) -> &Path {
        self.daemon.signal(Signal::TERM);
        assert_eq!(self.daemon.wait().code(), Some(0), "the daemon");
        self.recorder.signal(Signal::INT);
        let code = self.recorder.wait().code();
        assert_eq!(code, Some(0), "the recorder: {}", self.recorder.log());
        &self.file
    }
}

fn words<'a>(before: &'a str, middle: &[&'a str], after: &'a str) -> Vec<&'a str> {
    let mut words: Vec<&str> = before.split_whitespace().collect();
    words.extend(middle);
    words.extend(after.split_whitespace());
    words
}

/// Replays a file, asserts that no tick differs, and returns the number of ticks.
fn replayed_ticks(what: &str, file: &Path) -> u64 {
    let (code, printed, stderr) = atas(&format!("replay {} --format json", file.display()));
    assert_eq!(
        (code, &printed["different"]),
        (0, &0.into()),
        "{what}: {printed} {stderr}"
    );
    printed["ticks"].as_u64().expect("a count")
}

/// One recording: name, simulator arguments, daemon arguments, user actions.
type Case = (&'static str, &'static str, &'static str, fn(&Rig));

/// Runs a command to its end. Rejected and failed goals are recorded as well.
fn run(rig: &Rig, command: &str) {
    let (code, _, stderr) = rig.ask(command);
    assert!(matches!(code, 0 | 4), "{command}: {code} {stderr}");
}

fn grasp(rig: &Rig) {
    run(rig, GRASP);
}

fn grasp_with_timeout(rig: &Rig) {
    // HOLD pauses the goal; if HOLD persists, the goal fails.
    run(rig, &format!("{GRASP} --timeout 5"));
}

const CASES: &[Case] = &[
    ("wood", "--object wood", "", grasp),
    ("slippery", "--object slippery-200 --seed 2", "", grasp),
    ("light and slippery", "--object slippery-50", "", grasp),
    ("paper box", "--object paper-box", "", grasp),
    ("sponge", "--object sponge --seed 3", "", grasp),
    ("bottle", "--object bottle", "", grasp),
    ("too heavy", "--object heavy-block", "", grasp),
    ("grasp and release", "--object wood", "", |rig| {
        run(rig, GRASP);
        run(rig, "release");
    }),
    ("left hand", "--scene pick-place --hand left", "", |rig| {
        run(rig, "pick-place --hand left");
    }),
    ("pick and place", "--scene pick-place", "", |rig| {
        run(rig, "pick-place")
    }),
    (
        "pick and place of a sponge",
        "--scene pick-place --object sponge",
        "",
        |rig| {
            run(rig, "pick-place");
        },
    ),
    ("screwing", "--scene screw", "", |rig| run(rig, "screw")),
    ("assembly", "--scene assembly", "", |rig| {
        run(rig, "assemble")
    }),
    ("a rejected goal", "--object wood", "", |rig| {
        run(rig, "pick-place --to 0.9,0");
        run(rig, GRASP);
    }),
    ("a cancelled goal", "--object wood", "", |rig| {
        let mut goal = rig.start_client(HOLD);
        rig.wait_ticks(3000);
        goal.signal(Signal::INT);
        goal.wait();
        run(rig, "release");
    }),
    ("a killed client", "--object wood", "", |rig| {
        let mut goal = rig.start_client(&format!("{HOLD} --attached"));
        rig.wait_ticks(2000);
        goal.signal(Signal::KILL);
        goal.wait();
        run(rig, "release");
    }),
    ("changed parameters", "--object wood", "", |rig| {
        let mut goal = rig.start_client(HOLD);
        rig.wait_ticks(500);
        for (name, value) in [
            ("grasp.approach_m_s", "0.003"),
            ("grasp.dr_n", "0.07"),
            ("perception.touch_on_n", "0.06"),
        ] {
            run(rig, &format!("param set {name} {value}"));
            rig.wait_ticks(300);
        }
        goal.signal(Signal::INT);
        goal.wait();
    }),
    (
        "non-default settings",
        "--object wood",
        "--set grasp.approach_m_s=0.004 --set grasp.dr_n=0.06",
        grasp,
    ),
    ("a stop and a recovery", "--object wood", "", |rig| {
        let mut goal = rig.start_client(HOLD);
        rig.wait_ticks(1500);
        run(rig, "estop");
        goal.wait();
        run(rig, "recover");
        run(rig, "release");
    }),
    (
        "a short frame loss",
        "--object wood --fault drop=1@3+0.004:right",
        "",
        grasp,
    ),
    (
        "a long frame loss",
        "--object wood --fault drop=1@3+0.02:right",
        "",
        grasp_with_timeout,
    ),
    (
        "duplicates",
        "--object wood --fault duplicate@2:right",
        "",
        grasp,
    ),
    (
        "reordered frames",
        "--object wood --fault reorder@2:right",
        "",
        grasp,
    ),
    (
        "bit flips",
        "--object wood --fault corrupt=0.1@2:right",
        "",
        grasp,
    ),
    ("a NaN", "--object wood --fault nan=1@2:right", "", grasp),
    (
        "many NaN",
        "--object wood --fault nan=20@3:right",
        "",
        grasp_with_timeout,
    ),
    (
        "a huge reading",
        "--object wood --fault huge@2:right",
        "",
        grasp,
    ),
    (
        "frozen frames",
        "--object wood --fault freeze@3:right",
        "",
        grasp_with_timeout,
    ),
];

#[test]
fn recordings_replay_bit_exactly() {
    let _alone = lock_exclusive();
    let mut ticks = 0;
    for (name, scene, control, script) in CASES {
        let mut rig = Rig::new(scene, control);
        script(&rig);
        let count = replayed_ticks(name, rig.end());
        assert!(count > 100, "{name}: {count} ticks");
        ticks += count;
    }
    assert!(
        CASES.len() >= 20 && ticks > 50_000,
        "{ticks} ticks of {} recordings",
        CASES.len()
    );
}

/// Checks the file of a recorder that was killed, repairs it, replays it, and returns the number of
/// ticks.
fn recover(file: &Path) -> u64 {
    let path = file.display();
    let (code, _, stderr) = atas(&format!("record check {path}"));
    assert!(
        code == 1 && stderr.contains("atas record repair"),
        "{code} {stderr}"
    );
    let whole = file.with_file_name("whole.mcap");
    let (code, _, stderr) = atas(&format!("record repair {path} --out {}", whole.display()));
    assert_eq!(code, 0, "{stderr}");
    let (code, printed, stderr) = atas(&format!("record check {} --format json", whole.display()));
    assert_eq!(
        (code, &printed["lost"]),
        (0, &0.into()),
        "{printed} {stderr}"
    );
    replayed_ticks("repaired", &whole)
}

#[test]
fn each_file_of_split_recording_replays() {
    let _alone = lock_exclusive();
    let mut rig = Rig::with_recorder("--object wood", "", |record| {
        let bounds = ["--max-size", "1M", "--max-files", "3"];
        Process::start("atas", &[record, &bounds[..]].concat())
    });
    grasp(&rig);
    let folder = rig.end().parent().expect("a folder").to_owned();
    let files: Vec<PathBuf> = std::fs::read_dir(&folder)
        .expect("readable")
        .map(|entry| entry.expect("readable").path())
        .collect();
    assert_eq!(files.len(), 3, "{files:?}");
    assert!(
        !files.contains(&rig.file),
        "the oldest file of the run is deleted"
    );
    for file in files {
        let ticks = replayed_ticks("a file of a run", &file);
        assert!(ticks > 0, "{}", file.display());
    }
}

#[test]
fn data_of_killed_recorder_is_recovered() {
    let _alone = lock_exclusive();
    let mut rig = Rig::new("--object wood", "");
    let _goal = rig.start_client(HOLD);
    // More than the recorder buffers.
    rig.wait_ticks(3000);
    wait_for("a flush", || {
        (std::fs::metadata(&rig.file).ok()?.len() > 64 << 10).then_some(())
    });
    rig.recorder.signal(Signal::KILL);
    rig.recorder.wait();
    let saved = recover(&rig.file);
    assert!(saved > 500, "{saved} ticks");
    // The daemon is unaffected.
    rig.wait_ticks(500);
}

#[test]
fn full_disk_ends_only_the_recorder() {
    let _alone = lock_exclusive();
    // A file size limit with its signal ignored looks like a full disk to the program.
    let bounded = |words: &[&str]| {
        let program = binary("atas");
        let script = "trap '' XFSZ; ulimit -f 1024; exec \"$@\"";
        let program = program.to_str().expect("UTF-8");
        let arguments = [&["-c", script, "sh", program], words].concat();
        Process::start_program(Path::new("sh"), &arguments)
    };
    let mut rig = Rig::with_recorder("--object wood", "", bounded);
    let _goal = rig.start_client(HOLD);
    let code = rig.recorder.wait().code();
    let message = rig.recorder.log();
    assert!(
        code == Some(1) && message.contains("could not write"),
        "{code:?} {message}"
    );
    assert!(recover(&rig.file) > 10, "{message}");
    rig.wait_ticks(500);
}
