//! Scripted world on a private bus, and a daemon process in it.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use shm_bus::{Bus, ControlClient, FreshBus, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::{
    ControlOp, ControlReply, ControlRequest, Hand, HandFrame, JointCommand, JointState, Layout,
    Mode, Stamp, Status, Text, service,
};
use tempfile::TempDir;

/// Time limit of waiting, long enough for any machine.
pub(crate) const TIMEOUT: Duration = Duration::from_secs(30);

/// Configuration for tests on a busy machine: tolerates late frames.
pub(crate) const TOLERANT: &str =
    "intake.hold_age_s = 0.3\nintake.reject_age_s = 5.0\nsafety.stall_s = 1.0\n";

/// Daemon process. Killed on drop; its log is printed if the test failed.
pub(crate) struct Daemon {
    child: Child,
    folder: TempDir,
}

impl Daemon {
    pub(crate) fn start(bus: &FreshBus, flags: &[&str]) -> Self {
        Self::start_with(bus, "", flags, |_| ())
    }

    /// Starts with a configuration, flags and further process settings.
    pub(crate) fn start_with(
        bus: &FreshBus,
        config: &str,
        flags: &[&str],
        more: impl FnOnce(&mut Command),
    ) -> Self {
        Self::start_under(&[], bus, config, flags, more)
    }

    /// Starts through another program that executes the daemon.
    pub(crate) fn start_under(
        wrapper: &[&str],
        bus: &FreshBus,
        config: &str,
        flags: &[&str],
        more: impl FnOnce(&mut Command),
    ) -> Self {
        let folder = TempDir::new().expect("a temporary folder");
        fs::write(folder.path().join("atas.toml"), config).expect("writable");
        let log = File::create(folder.path().join("log")).expect("writable");
        let words = [wrapper, &[env!("CARGO_BIN_EXE_atasd")]].concat();
        let mut command = Command::new(words[0]);
        command
            .args(&words[1..])
            .arg("--bus")
            .arg(bus.as_str())
            .arg("--config")
            .arg(folder.path().join("atas.toml"));
        command.args(flags).stderr(log).env_remove("NOTIFY_SOCKET");
        more(&mut command);
        Self {
            child: command.spawn().expect("atasd starts"),
            folder,
        }
    }

    pub(crate) fn pid(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn config_file(&self) -> PathBuf {
        self.folder.path().join("atas.toml")
    }

    pub(crate) fn log(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).expect("readable")
    }

    pub(crate) fn signal(&self, signal: rustix::process::Signal) {
        let pid = rustix::process::Pid::from_child(&self.child);
        rustix::process::kill_process(pid, signal).expect("the daemon lives");
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.child.try_wait().expect("waitable").is_none()
    }

    pub(crate) fn wait(&mut self) -> ExitStatus {
        wait_for("the daemon to end", || {
            self.child.try_wait().expect("waitable")
        })
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _already_dead = self.child.kill();
        let _reaped = self.child.wait();
        if std::thread::panicking() {
            let _ = writeln!(std::io::stderr(), "log of the daemon:\n{}", self.log());
        }
    }
}

/// Polls until there is an answer.
pub(crate) fn wait_for<T>(what: &str, mut ask: impl FnMut() -> Option<T>) -> T {
    let begin = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(begin.elapsed() < TIMEOUT, "timed out waiting for {what}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Scripted sensors and joints: no contact, and the joints follow the commands.
pub(crate) struct World {
    pub(crate) bus: Bus,
    frames: [Publisher<HandFrame>; 2],
    joints: Publisher<JointState>,
    commands: Subscriber<JointCommand>,
    status: Subscriber<Status>,
    control: Option<ControlClient>,
    pub(crate) command: JointCommand,
    pub(crate) newest: Status,
    pub(crate) sends_frames: bool,
    /// Published in place of the first joint's position.
    pub(crate) injected_position: Option<f64>,
    position: [f64; shm_schemas::capacity::JOINTS],
    sequence: u64,
}

impl World {
    pub(crate) fn open(name: &FreshBus) -> Self {
        let bus = Bus::open(name, "world", Realtime::No).expect("the bus opens");
        let robot = robot_model::RobotModel::two_hand_arm().expect("the built-in robot loads");
        let mut position = [0.0; shm_schemas::capacity::JOINTS];
        for side in robot_model::HandSide::BOTH {
            position[robot.joint_range(side)].copy_from_slice(robot.hand(side).reference());
            // Straight ahead, the fingers of both hands would cross.
            position[robot.joint_range(side).start] += 0.4 * side.y_sign();
        }
        Self {
            frames: service::HAND_FRAME.map(|name| bus.publisher(name).expect("sole publisher")),
            joints: bus.publisher(service::JOINT_STATE).expect("sole publisher"),
            commands: bus
                .subscriber(service::JOINT_COMMAND)
                .expect("there is room"),
            status: bus.subscriber(service::STATUS).expect("there is room"),
            control: None,
            command: JointCommand::default(),
            newest: Status::default(),
            sends_frames: true,
            injected_position: None,
            position,
            sequence: 0,
            bus,
        }
    }

    pub(crate) fn publish(&mut self, captured_ns: u64) {
        let stamp = Stamp {
            sequence: self.sequence,
            captured_ns,
            writer_epoch: 7,
        };
        self.sequence += 1;
        if self.sends_frames {
            for (publisher, hand) in self.frames.iter().zip(Hand::BOTH) {
                publisher.send(&frame(stamp, hand)).expect("sent");
            }
        }
        let mut state = JointState {
            stamp,
            joint_count: 22,
            position: self.position,
            ..JointState::default()
        };
        if let Some(odd_rad) = self.injected_position {
            state.position[0] = odd_rad;
        }
        state.seal();
        self.joints.send(&state).expect("sent");
    }

    /// Delivers the last tick to a daemon that has joined since.
    pub(crate) fn connect_readers(&self) {
        self.frames
            .iter()
            .for_each(|publisher| publisher.connect_readers().expect("sent"));
        self.joints.connect_readers().expect("sent");
    }

    pub(crate) fn receive(&mut self) {
        if self.commands.newest(&mut self.command).expect("readable")
            && self.command.joint_count > 0
        {
            assert!(self.command.is_intact());
            self.position = self.command.position;
        }
        self.status.newest(&mut self.newest).expect("readable");
    }

    /// Publishes in real time until the status matches, and returns it.
    pub(crate) fn until(&mut self, what: &str, wanted: impl Fn(&Status) -> bool) -> Status {
        wait_for(what, || {
            self.publish(now_ns());
            self.receive();
            wanted(&self.newest).then_some(self.newest)
        })
    }

    pub(crate) fn until_mode(&mut self, mode: Mode) -> Status {
        self.until(mode.name(), |status| status.mode == mode)
    }

    pub(crate) fn control(&mut self, op: ControlOp, name: &str, value: f64) -> ControlReply {
        let request = ControlRequest {
            op,
            name: Text::new(name),
            value,
            ..ControlRequest::default()
        };
        let client = self
            .control
            .get_or_insert_with(|| self.bus.control_client().expect("there is room"));
        client.call(&request, TIMEOUT).expect("the daemon answers")
    }
}

/// Frame with noise only, on two fingertips.
fn frame(stamp: Stamp, hand: Hand) -> HandFrame {
    let layout = Layout::dome_41();
    let mut frame = HandFrame {
        stamp,
        layout_hash: layout.hash(),
        hand,
        finger_count: 2,
        ..HandFrame::default()
    };
    let noise_n = 1e-4 * (stamp.sequence % 7) as f32;
    for finger in 0..2 {
        frame.valid_mask[finger] = (1 << layout.count) - 1;
        frame.force_n[finger][..layout.count].fill([noise_n, 0.0, 0.0]);
    }
    frame.seal();
    frame
}
