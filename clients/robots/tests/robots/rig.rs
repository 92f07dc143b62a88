//! Test rig: two chains of emulated servos, the real program, and a private bus with the test as
//! daemon.

use std::fs::File;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use atas_robots::emulator::{Chain, PlannedServo};
use atas_robots::joints;
use atas_robots::map::file::{MapFile, PortEntry, ServoEntry};
use rustix::process::{Pid, Signal, kill_process};
use shm_bus::{Bus, FreshBus, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::service::{JOINT_COMMAND, JOINT_STATE};
use shm_schemas::{JointCommand, JointState};
use tempfile::TempDir;

/// Timeout of waits.
const PATIENCE: Duration = Duration::from_secs(60);
/// Joints of one hand, one servo each: left Dynamixel, right Feetech.
pub(crate) const HAND: usize = 11;
/// Maximum validity of a command, ns.
pub(crate) const VALID_NS: u64 = 100_000_000;
/// Encoder step, rad.
pub(crate) const STEP_RAD: f64 = core::f64::consts::TAU / 4096.0;

/// Returns the initial positions, rad: the middle of each joint's travel.
pub(crate) fn middle_rad() -> Vec<f64> {
    let joints = joints::load("two-hand-arm").unwrap();
    let middle = joints.iter().map(|joint| 0.5 * (joint.lower + joint.upper));
    middle.collect()
}

/// Returns a map of the two-hand arm; every second shaft turns against its joint.
pub(crate) fn two_hands() -> MapFile {
    let joints = joints::load("two-hand-arm").unwrap();
    let servo = |(index, joint): (usize, &joints::Joint)| {
        let is_left = index < HAND;
        ServoEntry {
            joint: joint.name.clone(),
            id: (index % HAND) as u8 + 1,
            model: if is_left { "xm430-w350" } else { "sts3215" }.to_owned(),
            direction: if index.is_multiple_of(2) { 1 } else { -1 },
            zero_rad: core::f64::consts::PI,
            gear: 1.0,
            current_limit_a: is_left.then_some(0.8),
            torque_limit_percent: (!is_left).then_some(30.0),
            torque_per_current_n_m_a: Some(1.5),
            temperature_limit_c: None,
        }
    };
    let servos: Vec<ServoEntry> = joints.iter().enumerate().map(servo).collect();
    let port = |driver: &str, servos: &[ServoEntry]| PortEntry {
        device: format!("/dev/{driver}"),
        driver: driver.to_owned(),
        baud: 1_000_000,
        rate_hz: 500.0,
        // Long timeout: a busy machine may delay the emulated servos.
        answer_within_ms: 500.0,
        servos: servos.to_vec(),
    };
    MapFile {
        robot: "two-hand-arm".to_owned(),
        ports: vec![
            port("dynamixel", &servos[..HAND]),
            port("feetech", &servos[HAND..]),
        ],
    }
}

/// Returns the shaft angle for a joint angle, in that map.
pub(crate) fn shaft_rad(joint: usize, joint_rad: f64) -> f64 {
    let direction = if joint.is_multiple_of(2) { 1.0 } else { -1.0 };
    core::f64::consts::PI + direction * joint_rad
}

/// Starts emulated servos at the given positions and writes their terminals to the map.
pub(crate) fn start_chains(map: &mut MapFile, standing_rad: &[f64]) -> Vec<Chain> {
    let mut joint = 0;
    let chains = map.ports.iter_mut().map(|port| {
        let planned: Vec<PlannedServo> = port
            .servos
            .iter()
            .map(|servo| {
                joint += 1;
                PlannedServo {
                    id: servo.id,
                    model: servo.model.clone(),
                    position: shaft_rad(joint - 1, standing_rad[joint - 1]),
                }
            })
            .collect();
        let chain = Chain::start(&port.driver, &planned, None).unwrap();
        port.device = chain.path().display().to_string();
        chain
    });
    chains.collect()
}

/// A running `atas-robot`, killed on drop. Its log is printed if the test failed.
pub(crate) struct Program {
    child: Child,
    folder: TempDir,
}

impl Program {
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let folder = TempDir::new().unwrap();
        let output = |name: &str| File::create(folder.path().join(name)).unwrap();
        let child = Command::new(env!("CARGO_BIN_EXE_atas-robot"))
            .args(arguments)
            .env_remove("ATAS_BUS")
            .env("RUST_LOG", "info")
            .stdin(Stdio::piped())
            .stdout(output("out"))
            .stderr(output("log"))
            .spawn()
            .unwrap();
        Self { child, folder }
    }

    pub(crate) fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).unwrap();
    }

    /// Presses Enter.
    pub(crate) fn enter(&mut self) {
        self.child.stdin.as_mut().unwrap().write_all(b"\n").unwrap();
    }

    /// Closes the input and waits; returns the exit code.
    pub(crate) fn finish(&mut self) -> Option<i32> {
        drop(self.child.stdin.take());
        let mut status = None;
        wait_until("the end of the program", || {
            status = self.child.try_wait().unwrap();
            status.is_some()
        });
        status.unwrap().code()
    }

    /// Returns standard error so far.
    pub(crate) fn log(&self) -> String {
        self.read("log")
    }

    /// Returns standard output so far.
    pub(crate) fn printed(&self) -> String {
        self.read("out")
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.folder.path().join(name)).unwrap()
    }

    pub(crate) fn wait_for(&self, words: &str) {
        wait_until(words, || self.log().contains(words));
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // Both calls fail harmlessly if the process has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            let _ = writeln!(std::io::stderr(), "log of atas-robot:\n{}", self.log());
        }
    }
}

/// Waits until a condition is true.
pub(crate) fn wait_until(what: &str, mut holds: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !holds() {
        assert!(Instant::now() < deadline, "timed out waiting for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Servos, program and bus; the test acts as daemon.
pub(crate) struct Rig {
    pub(crate) chains: Vec<Chain>,
    pub(crate) program: Program,
    pub(crate) state: JointState,
    pub(crate) command: JointCommand,
    pub(crate) map: PathBuf,
    bus: FreshBus,
    states: Subscriber<JointState>,
    commands: Publisher<JointCommand>,
    _folder: TempDir,
}

impl Rig {
    /// Starts everything, with the servos in the middle of their travel.
    pub(crate) fn start() -> Self {
        Self::start_with(|_| ())
    }

    /// Starts everything, after a change of the chains.
    pub(crate) fn start_with(prepare: impl Fn(&Chain)) -> Self {
        let (bus, folder) = (FreshBus::new("robot"), TempDir::new().unwrap());
        let node = Bus::open(&bus, "test", Realtime::No).unwrap();
        let mut map = two_hands();
        let chains = start_chains(&mut map, &middle_rad());
        chains.iter().for_each(prepare);
        let path = folder.path().join("robot.toml");
        std::fs::write(&path, toml::to_string(&map).unwrap()).unwrap();
        let mut rig = Self {
            program: Self::run(&path, &bus),
            states: node.subscriber(JOINT_STATE).unwrap(),
            commands: node.publisher(JOINT_COMMAND).unwrap(),
            state: JointState::default(),
            command: JointCommand::default(),
            map: path,
            chains,
            bus,
            _folder: folder,
        };
        rig.next_state();
        rig.begin_commands(7);
        rig
    }

    fn run(map: &std::path::Path, bus: &FreshBus) -> Program {
        Program::start(&["run", map.to_str().unwrap(), "--bus", bus.as_str()])
    }

    pub(crate) fn bus(&self) -> &str {
        self.bus.as_str()
    }

    /// Kills the program and starts it again.
    pub(crate) fn restart(&mut self) {
        self.program.signal(Signal::KILL);
        self.program.finish();
        self.program = Self::run(&self.map, &self.bus);
    }

    /// Starts a new command stream from the commanded positions.
    pub(crate) fn begin_commands(&mut self, writer_epoch: u64) {
        self.command = JointCommand {
            joint_count: self.state.joint_count,
            position: self.state.commanded_position,
            ..JointCommand::default()
        };
        self.command.stamp.writer_epoch = writer_epoch;
    }

    /// Returns whether a new state arrived.
    pub(crate) fn has_new_state(&mut self) -> bool {
        self.states.newest(&mut self.state).unwrap()
    }

    /// Waits for a new state.
    pub(crate) fn next_state(&mut self) {
        wait_until("a joint state", || {
            self.states.newest(&mut self.state).unwrap()
        });
        assert!(self.state.is_intact());
    }

    /// Sends the current command with new validity.
    pub(crate) fn send(&mut self) {
        self.command.stamp.sequence += 1;
        self.command.stamp.captured_ns = now_ns();
        self.command.valid_until_ns = now_ns() + VALID_NS - 1_000_000;
        self.command.seal();
        self.send_unchanged();
    }

    /// Sends the command without changes.
    pub(crate) fn send_unchanged(&self) {
        self.commands.send(&self.command).unwrap();
    }

    /// Moves a joint slowly to a position, rad, until its servo has this goal.
    pub(crate) fn move_to(&mut self, joint: usize, position: f64) {
        let from_rad = self.command.position[joint];
        for step in 1..=100 {
            let share = f64::from(step) / 100.0;
            self.command.position[joint] = from_rad + share * (position - from_rad);
            self.send();
            std::thread::sleep(Duration::from_millis(3));
        }
        let wanted = shaft_rad(joint, position);
        wait_until("the goal", || {
            self.send();
            (self.servo(joint, |servo| servo.goal_rad()) - wanted).abs() <= STEP_RAD
        });
    }

    /// Calls `act` with the servo of a joint.
    pub(crate) fn servo<T>(
        &self,
        joint: usize,
        act: impl FnOnce(&mut atas_robots::emulator::Servo) -> T,
    ) -> T {
        self.chains[joint / HAND].servo((joint % HAND) as u8 + 1, act)
    }

    /// Returns the goals of all servos, shaft rad.
    pub(crate) fn goals_rad(&self) -> Vec<f64> {
        (0..2 * HAND)
            .map(|joint| self.servo(joint, |servo| servo.goal_rad()))
            .collect()
    }

    /// Resets the maximum speeds of the servos.
    pub(crate) fn reset_speeds(&self) {
        (0..2 * HAND).for_each(|joint| {
            self.servo(joint, |servo| servo.fastest_rad_s());
        });
    }

    /// Returns the maximum speed of all servos since the reset, rad/s.
    pub(crate) fn fastest_rad_s(&self) -> f64 {
        (0..2 * HAND)
            .map(|joint| self.servo(joint, |servo| servo.fastest_rad_s()))
            .fold(0.0, f64::max)
    }
}
