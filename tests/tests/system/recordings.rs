//! Recordings of every task, of faults and of what users do in between: each replays bit for bit, whatever became of the
//! run. And recorders that are ended by a full disk or by `kill -9`: what was flushed is recovered, the daemon goes on.
//!
//! In lock-step, over the real bus, with the real recorder.

use std::path::{Path, PathBuf};
use std::process::Command;

use rustix::process::Signal;
use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Status, service};
use system_tests::{Process, alone, binary, wait_for};

/// A grasp of what stands before the right hand, held only for a moment.
const GRASP: &str = "grasp --at 0.32,-0.15,0.0345 --width 50 --lift 10 --hold 0.05";
/// The same for as long as anybody watches.
const HOLD: &str = "grasp --at 0.32,-0.15,0.0345 --width 50 --hold 3600";

/// Exit code, last line of standard output as JSON, and standard error.
fn atas(arguments: &str) -> (i32, Value, String) {
    let output = Command::new(binary("atas"))
        .args(arguments.split_whitespace())
        .env_remove("ATAS_BUS")
        .env_remove("RUST_LOG")
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

/// A recorder that was there first, a simulator, a daemon. The bus goes last.
struct Rig {
    recorder: Process,
    daemon: Process,
    _simulator: Process,
    file: PathBuf,
    bus: FreshBus,
    _folder: tempfile::TempDir,
}

impl Rig {
    /// `recorder` is given the words of a recorder into this file, and starts it.
    fn with(scene: &str, control: &str, recorder: impl FnOnce(&[&str]) -> Process) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("run.mcap");
        let bus = FreshBus::new("tape");
        let name = bus.as_str();
        let out = file.to_str().expect("UTF-8");
        let recorder = recorder(&["record", "--format", "json", "--bus", name, "--out", out]);
        // The file is made after the ports are open.
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
        Self::with(scene, control, |words| Process::start("atas", words))
    }

    fn ask(&self, command: &str) -> (i32, Value, String) {
        atas(&format!(
            "{command} --format json --bus {}",
            self.bus.as_str()
        ))
    }

    /// A command that goes on beside the test.
    fn begin(&self, command: &str) -> Process {
        Process::start("atas", &words(command, &["--bus", self.bus.as_str()], ""))
    }

    /// Lets the daemon tick so often from now on.
    fn let_pass(&self, ticks: u64) {
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

    /// Ends daemon and recorder in order; the file.
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

/// Ticks that replayed, every one to the bit.
fn replayed(what: &str, file: &Path) -> u64 {
    let (code, told, stderr) = atas(&format!("replay {} --format json", file.display()));
    assert_eq!(
        (code, &told["different"]),
        (0, &0.into()),
        "{what}: {told} {stderr}"
    );
    told["ticks"].as_u64().expect("a count")
}

/// One recording: the simulator's words, the daemon's, and what users do.
type Case = (&'static str, &'static str, &'static str, fn(&Rig));

/// Runs a command to its end, whatever that is: refused and failed goals are recorded as well.
fn run(rig: &Rig, command: &str) {
    let (code, _, stderr) = rig.ask(command);
    assert!(matches!(code, 0 | 4), "{command}: {code} {stderr}");
}

fn grasp(rig: &Rig) {
    run(rig, GRASP);
}

fn grasp_in_doubt(rig: &Rig) {
    // Doubt pauses the goal, and fails it when it stays.
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
    ("a goal that is refused", "--object wood", "", |rig| {
        run(rig, "pick-place --to 0.9,0");
        run(rig, GRASP);
    }),
    ("a goal that is cancelled", "--object wood", "", |rig| {
        let mut goal = rig.begin(HOLD);
        rig.let_pass(3000);
        goal.signal(Signal::INT);
        goal.wait();
        run(rig, "release");
    }),
    ("a client that is killed", "--object wood", "", |rig| {
        let mut goal = rig.begin(&format!("{HOLD} --attached"));
        rig.let_pass(2000);
        goal.signal(Signal::KILL);
        goal.wait();
        run(rig, "release");
    }),
    ("parameters that change", "--object wood", "", |rig| {
        let mut goal = rig.begin(HOLD);
        rig.let_pass(500);
        for (name, value) in [
            ("grasp.approach_m_s", "0.003"),
            ("grasp.dr_n", "0.07"),
            ("perception.touch_on_n", "0.06"),
        ] {
            run(rig, &format!("param set {name} {value}"));
            rig.let_pass(300);
        }
        goal.signal(Signal::INT);
        goal.wait();
    }),
    (
        "settings of its own",
        "--object wood",
        "--set grasp.approach_m_s=0.004 --set grasp.dr_n=0.06",
        grasp,
    ),
    ("a stop and a recovery", "--object wood", "", |rig| {
        let mut goal = rig.begin(HOLD);
        rig.let_pass(1500);
        run(rig, "estop");
        goal.wait();
        run(rig, "recover");
        run(rig, "release");
    }),
    (
        "a short silence",
        "--object wood --fault drop=1@3+0.004:right",
        "",
        grasp,
    ),
    (
        "a gap",
        "--object wood --fault drop=1@3+0.02:right",
        "",
        grasp_in_doubt,
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
        grasp_in_doubt,
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
        grasp_in_doubt,
    ),
];

#[test]
fn every_recording_replays_to_the_bit() {
    let _alone = alone();
    let mut ticks = 0;
    for (name, scene, control, script) in CASES {
        let mut rig = Rig::new(scene, control);
        script(&rig);
        let count = replayed(name, rig.end());
        assert!(count > 100, "{name}: {count} ticks");
        ticks += count;
    }
    assert!(
        CASES.len() >= 20 && ticks > 50_000,
        "{ticks} ticks of {} recordings",
        CASES.len()
    );
}

/// Checks what a recorder that ended suddenly left behind, repairs it, and replays what was saved.
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
    let (code, told, stderr) = atas(&format!("record check {} --format json", whole.display()));
    assert_eq!((code, &told["lost"]), (0, &0.into()), "{told} {stderr}");
    replayed("repaired", &whole)
}

#[test]
fn every_file_of_a_run_replays_by_itself() {
    let _alone = alone();
    let mut rig = Rig::with("--object wood", "", |record| {
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
    assert!(!files.contains(&rig.file), "the run's beginning is gone");
    for file in files {
        let ticks = replayed("a file of a run", &file);
        assert!(ticks > 0, "{}", file.display());
    }
}

#[test]
fn what_a_killed_recorder_flushed_is_recovered() {
    let _alone = alone();
    let mut rig = Rig::new("--object wood", "");
    let _goal = rig.begin(HOLD);
    // More than is ever held back.
    rig.let_pass(3000);
    wait_for("a flush", || {
        (std::fs::metadata(&rig.file).ok()?.len() > 64 << 10).then_some(())
    });
    rig.recorder.signal(Signal::KILL);
    rig.recorder.wait();
    let saved = recover(&rig.file);
    assert!(saved > 500, "{saved} ticks");
    // The daemon does not notice.
    rig.let_pass(500);
}

#[test]
fn a_full_disk_ends_the_recorder_with_a_word_and_nothing_else() {
    let _alone = alone();
    // A bound on the size of files, whose signal is ignored, is told to a program like a disk that is full.
    let bounded = |words: &[&str]| {
        let program = binary("atas");
        let script = "trap '' XFSZ; ulimit -f 1024; exec \"$@\"";
        let program = program.to_str().expect("UTF-8");
        let arguments = [&["-c", script, "sh", program], words].concat();
        Process::start_program(Path::new("sh"), &arguments)
    };
    let mut rig = Rig::with("--object wood", "", bounded);
    let _goal = rig.begin(HOLD);
    let code = rig.recorder.wait().code();
    let said = rig.recorder.log();
    assert!(
        code == Some(1) && said.contains("could not write"),
        "{code:?} {said}"
    );
    assert!(recover(&rig.file) > 10, "{said}");
    rig.let_pass(500);
}
