//! `atas-sim` as a process, with a stand-in daemon that holds the joints.

use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use shm_bus::{Bus, BusName, FreshBus, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::layout::{FNV_OFFSET, fnv1a};
use shm_schemas::{HandFrame, JointCommand, JointState, WorldTruth, service};
use zerocopy::IntoBytes;

/// Time limit of every wait.
const TIMEOUT: Duration = Duration::from_secs(20);

fn atas_sim(arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_atas-sim"));
    command
        .args(arguments.split_whitespace())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// Running simulator; killed if a test fails.
struct Simulator(Option<Child>);

impl Simulator {
    fn start(bus: &BusName, arguments: &str) -> Self {
        let child = atas_sim(&format!("run --bus {bus} {arguments}"))
            .spawn()
            .expect("atas-sim starts");
        Self(Some(child))
    }

    fn signal(&self, signal: Signal) {
        let id = self.0.as_ref().map(Child::id).unwrap_or_default();
        let pid = Pid::from_raw(id.cast_signed()).expect("valid process id");
        kill_process(pid, signal).expect("the simulator is running");
    }

    fn wait(mut self) -> Output {
        self.0
            .take()
            .expect("the simulator is running")
            .wait_with_output()
            .expect("the simulator exits")
    }
}

impl Drop for Simulator {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Stand-in daemon: receives frames, joint states and ground truth, sends commands.
struct Daemon {
    frames: [Subscriber<HandFrame>; 2],
    joints: Subscriber<JointState>,
    truth: Subscriber<WorldTruth>,
    commands: Publisher<JointCommand>,
    state: JointState,
    sequence: u64,
}

impl Daemon {
    fn join(bus: &Bus) -> Self {
        let frames =
            service::HAND_FRAME.map(|name| bus.subscriber(name).expect("frame subscriber"));
        Self {
            frames,
            joints: bus
                .subscriber(service::JOINT_STATE)
                .expect("joint state subscriber"),
            truth: bus
                .subscriber(service::WORLD_TRUTH)
                .expect("ground truth subscriber"),
            commands: bus
                .publisher(service::JOINT_COMMAND)
                .expect("command publisher"),
            state: JointState::default(),
            sequence: 0,
        }
    }

    fn next_state(&mut self) -> &JointState {
        let begin = Instant::now();
        while !self.joints.newest(&mut self.state).expect("the bus works") {
            assert!(
                begin.elapsed() < TIMEOUT,
                "no joint state after {}",
                self.state.stamp.sequence
            );
            std::thread::yield_now();
        }
        &self.state
    }

    /// Returns the frames since the last call, left then right.
    fn frames(&mut self) -> Vec<HandFrame> {
        let mut frames = Vec::new();
        for subscriber in &mut self.frames {
            subscriber
                .drain(64, |frame| frames.push(*frame))
                .expect("the bus works");
        }
        frames
    }

    /// Answers the last joint state with a command that holds all joints.
    fn hold(&mut self) {
        let mut command = JointCommand {
            answers_sequence: self.state.stamp.sequence,
            valid_until_ns: self.state.stamp.captured_ns + 5_000_000,
            joint_count: self.state.joint_count,
            position: self.state.position,
            ..JointCommand::default()
        };
        command.stamp.sequence = self.sequence;
        self.sequence += 1;
        command.seal();
        self.commands.send(&command).expect("the bus works");
    }

    fn newest_truth(&mut self) -> WorldTruth {
        let (mut truth, begin) = (WorldTruth::default(), Instant::now());
        while !self.truth.newest(&mut truth).expect("the bus works") {
            assert!(begin.elapsed() < TIMEOUT, "no ground truth");
        }
        truth
    }
}

/// Returns the hash of all sensor data of 200 lock-step ticks.
fn lockstep_hash(arguments: &str) -> u64 {
    let name = FreshBus::new("simlock");
    let bus = Bus::open(&name, "daemon", Realtime::No).expect("open bus");
    let mut daemon = Daemon::join(&bus);
    let simulator = Simulator::start(&name, &format!("--lockstep --duration 0.2 {arguments}"));
    let mut hash = FNV_OFFSET;
    for tick in 0..200 {
        let state = *daemon.next_state();
        assert_eq!(state.stamp.sequence, tick);
        let frames = daemon.frames();
        assert_eq!(frames.len(), 2, "both frames arrive before the joint state");
        assert_eq!(
            daemon.newest_truth().stamp.captured_ns,
            state.stamp.captured_ns
        );
        hash = frames
            .iter()
            .fold(fnv1a(hash, state.as_bytes()), |hash, frame| {
                fnv1a(hash, frame.as_bytes())
            });
        daemon.hold();
    }
    let output = simulator.wait();
    assert!(output.status.success(), "{output:?}");
    hash
}

#[test]
fn lockstep_repeats_bit_for_bit() {
    let first = lockstep_hash("--object bottle --seed 7");
    assert_eq!(first, lockstep_hash("--object bottle --seed 7"));
    assert_ne!(first, lockstep_hash("--object bottle --seed 8"));
}

/// A lock-step simulator waits for a daemon that starts later, and delivers the waiting tick.
#[test]
fn lockstep_waits_for_daemon_and_exits_on_sigterm() {
    let name = FreshBus::new("simlate");
    let simulator = Simulator::start(&name, "--lockstep --object wood");
    let bus = Bus::open(&name, "daemon", Realtime::No).expect("open bus");
    let begin = Instant::now();
    while bus.peers().expect("peer list").len() < 2 {
        assert!(
            begin.elapsed() < TIMEOUT,
            "the simulator does not join the bus"
        );
    }
    let mut daemon = Daemon::join(&bus);
    for tick in 0..3 {
        assert_eq!(daemon.next_state().stamp.sequence, tick);
        daemon.hold();
    }
    assert_eq!(daemon.next_state().stamp.sequence, 3);
    simulator.signal(Signal::TERM);
    let output = simulator.wait();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let log = String::from_utf8_lossy(&output.stderr).into_owned();
    let begun = log.lines().find(|line| line.contains("simulating"));
    let version = concat!("version=\"", env!("CARGO_PKG_VERSION"), '"');
    assert!(begun.is_some_and(|line| line.contains(version)), "{log}");
}

#[test]
fn free_running_follows_the_clock() {
    let name = FreshBus::new("simfree");
    let bus = Bus::open(&name, "daemon", Realtime::No).expect("open bus");
    let mut daemon = Daemon::join(&bus);
    let before_ns = now_ns();
    let simulator = Simulator::start(&name, "--duration 0.3 --object sponge@0.3,0.1");
    let (mut last_ns, mut frames) = (before_ns, 0);
    let begin = Instant::now();
    while frames < 100 {
        for frame in daemon
            .frames()
            .iter()
            .filter(|frame| frame.hand == shm_schemas::Hand::RIGHT)
        {
            assert!(frame.is_intact());
            let step_ns = frame.stamp.captured_ns - last_ns;
            assert!(
                frames == 0 || step_ns.is_multiple_of(1_000_000),
                "the phase is constant: {step_ns} ns"
            );
            last_ns = frame.stamp.captured_ns;
            frames += 1;
        }
        assert!(begin.elapsed() < TIMEOUT, "only {frames} frames");
    }
    assert!(
        last_ns <= now_ns() + 1_000_000,
        "stamps use CLOCK_MONOTONIC"
    );
    let truth = daemon.newest_truth();
    assert_eq!(
        (truth.object_count, truth.objects[0].name.as_str()),
        (1, "sponge")
    );
    assert!(simulator.wait().status.success());
}

#[test]
fn faults_reach_the_bus() {
    let name = FreshBus::new("simfault");
    let bus = Bus::open(&name, "daemon", Realtime::No).expect("open bus");
    let mut daemon = Daemon::join(&bus);
    let faults =
        "--fault drop@0.005+0.005:right --fault drop@0.010+0.005:joints --fault corrupt@0.015:left";
    let simulator = Simulator::start(&name, &format!("--lockstep --duration 0.03 {faults}"));
    let mut sequences = Vec::new();
    for _ in 0..25 {
        sequences.push(daemon.next_state().stamp.sequence);
        for frame in daemon.frames() {
            let (left, tick) = (frame.hand == shm_schemas::Hand::LEFT, frame.stamp.sequence);
            assert!(left || !(5..10).contains(&tick), "a dropped frame arrived");
            assert_eq!(frame.is_intact(), !left || tick < 15, "tick {tick}");
        }
        daemon.hold();
    }
    let expected: Vec<u64> = (0..10).chain(15..30).collect();
    assert_eq!(sequences, expected);
    assert!(simulator.wait().status.success());
}

#[test]
fn invalid_arguments_are_rejected() {
    let name = FreshBus::new("simtwice");
    let bus = Bus::open(&name, "daemon", Realtime::No).expect("open bus");
    let mut daemon = Daemon::join(&bus);
    let _first = Simulator::start(&name, "--lockstep");
    daemon.next_state();
    let check = |arguments: String, code: i32, part: &str| {
        let output = atas_sim(&arguments).output().expect("atas-sim starts");
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {message}");
        assert!(message.contains(part), "{arguments}: {message}");
    };
    check(format!("run --bus {}", &*name), 8, "atas-sim (process");
    check("run --object wod".into(), 2, "did you mean \"wood\"?");
    check(
        "run --noise NaN".into(),
        2,
        "the noise factor is NaN, needs 0 to 100",
    );
    check(
        "run --rate-hz 2000".into(),
        2,
        "the sensor rate in hertz is 2000, needs 1 to 1000",
    );
    check("run --errors moon".into(), 2, "unknown error kind \"moon\"");
    check(
        "run --sensor-model moon".into(),
        2,
        "unknown sensor model: \"moon\"",
    );
    check("sensors moon".into(), 2, "needs one of design");
    check(
        "run --errors crosstalk=90".into(),
        2,
        "the crosstalk is 0.9",
    );
    check("run --fault melt@1".into(), 2, "needs one of drop");
    check("run --robot /no/such.urdf".into(), 2, "/no/such.urdf");
    check("fly".into(), 2, "unrecognized subcommand");
    check("objects --fast --format json".into(), 2, "\"exit\":2");
}

#[test]
fn lists_are_printed() {
    let listed = |what: &str| {
        let output = atas_sim(what).output().expect("atas-sim starts");
        assert!(output.status.success());
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let objects = listed("objects");
    assert!(
        sim_backend::Object::names().all(|name| objects.contains(name)),
        "{objects}"
    );
    assert!(listed("faults").contains("payloads are lost with this probability"));
    let errors = listed("errors");
    let kinds = sim_backend::Errors::KINDS.iter();
    let kinds = kinds.chain(&sim_backend::Errors::SENSOR_KINDS);
    for kind in kinds.chain(&sim_backend::Errors::DRIVE_KINDS) {
        assert!(
            errors.contains(kind.name) && errors.contains(kind.about),
            "{errors}"
        );
    }
    let (sensors, json) = (listed("sensors"), listed("sensors --format json"));
    for name in sim_backend::SensorModel::names() {
        assert!(sensors.contains(name) && json.contains(name), "{sensors}");
        let text = listed(&format!("sensors {name}"));
        assert_eq!(sim_backend::SensorModel::built_in_text(name), Some(&*text));
    }
    assert!(listed("completions bash").contains("--format"));
    let rows: Vec<serde_json::Value> = listed("objects --format json")
        .lines()
        .map(|line| serde_json::from_str(line).expect("one JSON object per line"))
        .collect();
    let help = listed("objects --help");
    let mut keys = rows
        .iter()
        .flat_map(|row| row.as_object().expect("JSON object").keys());
    assert!(keys.all(|key| help.contains(key)), "{help}");
    let wood = rows
        .iter()
        .find(|row| row["name"] == "wood")
        .expect("wood is listed");
    let shape = sim_backend::Object::built_in("wood")
        .expect("built-in object")
        .shape;
    assert_eq!(wood["width_m"].as_f64(), Some(shape.width_m()));
    assert!(wood.get("crush_n").is_none(), "wood cannot be crushed");
}

#[test]
fn every_command_has_a_manual_page_and_an_example() {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().display().to_string();
    let output = atas_sim(&format!("man {path}"))
        .output()
        .expect("atas-sim starts");
    assert!(output.status.success(), "{output:?}");
    let output = atas_sim("--help").output().expect("atas-sim starts");
    let help = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(help.contains("Examples:"), "{help}");
    for command in [
        "run",
        "field",
        "objects",
        "faults",
        "errors",
        "sensors",
        "completions",
        "man",
    ] {
        let page = folder.path().join(format!("atas-sim-{command}.1"));
        assert!(page.exists(), "{page:?}");
        let output = atas_sim(&format!("{command} --help"))
            .output()
            .expect("atas-sim starts");
        let help = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(help.contains("Example"), "{command}: {help}");
    }
}

/// Regression: a list that did not fit on the disk exited with code 0.
#[test]
fn full_disk_exits_with_code_one() {
    let printing = [
        "objects",
        "faults",
        "errors",
        "sensors",
        "completions bash",
        "--help",
        "run --help",
    ];
    for what in printing {
        let full = std::fs::File::options().write(true).open("/dev/full");
        let output = atas_sim(what)
            .stdout(full.expect("/dev/full exists"))
            .output()
            .expect("atas-sim starts");
        let printed = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{what}: {printed}");
        assert!(
            printed.contains("could not write to standard output"),
            "{printed}"
        );
    }
}

/// As with `atas-sim faults | head -1`.
#[test]
fn closed_pipe_exits_successfully() {
    for what in ["objects", "faults", "completions zsh", "--help"] {
        let mut child = atas_sim(what).spawn().expect("atas-sim starts");
        drop(child.stdout.take());
        let output = child.wait_with_output().expect("atas-sim exits");
        assert!(output.status.success(), "{what}: {output:?}");
    }
}
