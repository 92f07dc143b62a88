//! Tests of `atas-robot` and the daemon with emulated servos, and of the emulator with the vendors'
//! clients.

mod vendor;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use atas_robots::emulator::{Chain, PlannedServo};
use robot_model::{HandSide, RobotModel};
use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Publisher, Realtime, Subscriber, now_ns};
use shm_schemas::{
    Hand, HandFrame, JointCommand, JointState, Layout, Mode, Stamp, Status, service,
};
use sim_backend::home;
use system_tests::{Process, lock_exclusive, wait_for};

/// Long timeouts: the servo bus is slow and the machine may be busy.
const CONFIG: &str = "
[intake]
hold_age_s = 0.4
reject_age_s = 5.0
[safety]
stall_s = 1.0
valid_s = 0.1
pause_s = 10.0
following_floor_rad = 0.5
";
/// Servos per hand, encoder step, and shaft angle at joint position 0.
const SERVOS_PER_HAND: usize = 11;
const STEP_RAD: f64 = core::f64::consts::TAU / 4096.0;
const ZERO_RAD: f64 = core::f64::consts::PI;

/// Starts the servos of both hands in the home posture; returns them and the path of their map.
fn servos(folder: &Path) -> (Vec<Chain>, String) {
    let robot = RobotModel::two_hand_arm().expect("a robot");
    let home = home(&robot).expect("the home posture is reachable");
    let mut map = String::new();
    let chains = HandSide::BOTH.map(|side| {
        let joints = robot.hand(side).joints().iter().zip(1..);
        let planned = joints.clone().map(|(_, id)| PlannedServo {
            id,
            model: "xm430-w350".to_owned(),
            position: ZERO_RAD + home[robot.joint_range(side).start + usize::from(id) - 1],
        });
        let chain = Chain::start("dynamixel", &planned.collect::<Vec<_>>(), None).expect("played");
        map += &format!(
            "[[port]]\ndevice = {:?}\ndriver = \"dynamixel\"\nbaud = 1000000\nanswer_within_ms = 300\n",
            chain.path()
        );
        for (joint, id) in joints {
            map += &format!(
                "[[port.servo]]\njoint = {:?}\nid = {id}\nmodel = \"xm430-w350\"\nzero_rad = {ZERO_RAD}\ncurrent_limit_a = 1.0\n",
                joint.name
            );
        }
        chain
    });
    let path = folder.join("robot.toml");
    std::fs::write(&path, map).expect("writable");
    (chains.into(), path.to_str().expect("UTF-8").to_owned())
}

/// Thread that publishes unloaded, noisy frames of both hands at about 1 kHz.
struct FrameSource {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl FrameSource {
    fn start(bus: &FreshBus) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (until, name) = (Arc::clone(&stop), (**bus).clone());
        let thread = std::thread::spawn(move || {
            let node = Bus::open(&name, "fingertips", Realtime::No).expect("a bus");
            let hands: [Publisher<HandFrame>; 2] =
                service::HAND_FRAME.map(|name| node.publisher(name).expect("a publisher"));
            for sequence in 0.. {
                if until.load(Ordering::Relaxed) {
                    return;
                }
                for (publisher, hand) in hands.iter().zip(Hand::BOTH) {
                    publisher.send(&frame(sequence, hand)).expect("sent");
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        Self {
            stop,
            thread: Some(thread),
        }
    }
}

impl Drop for FrameSource {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // If the thread panicked, the test has already failed without frames.
            let _ = thread.join();
        }
    }
}

fn frame(sequence: u64, hand: Hand) -> HandFrame {
    let layout = Layout::dome_41();
    let mut frame = HandFrame {
        stamp: Stamp {
            sequence,
            captured_ns: now_ns(),
            writer_epoch: 7,
        },
        layout_hash: layout.hash(),
        hand,
        finger_count: 2,
        ..HandFrame::default()
    };
    for finger in 0..2 {
        frame.valid_mask[finger] = (1 << layout.count) - 1;
        frame.force_n[finger][..layout.count].fill([1e-4 * (sequence % 7) as f32, 0.0, 0.0]);
    }
    frame.seal();
    frame
}

/// Latest status, joint state and command of the bus.
struct Observer {
    statuses: Subscriber<Status>,
    states: Subscriber<JointState>,
    commands: Subscriber<JointCommand>,
    status: Status,
    state: JointState,
    command: JointCommand,
}

impl Observer {
    fn new(bus: &FreshBus) -> Self {
        let node = Bus::open(bus, "observer", Realtime::No).expect("a bus");
        Self {
            statuses: node.subscriber(service::STATUS).expect("room"),
            states: node.subscriber(service::JOINT_STATE).expect("room"),
            commands: node.subscriber(service::JOINT_COMMAND).expect("room"),
            status: Status::default(),
            state: JointState::default(),
            command: JointCommand::default(),
        }
    }

    fn poll(&mut self) {
        self.statuses.newest(&mut self.status).expect("readable");
        self.states.newest(&mut self.state).expect("readable");
        self.commands.newest(&mut self.command).expect("readable");
    }

    fn wait_until(&mut self, what: &str, holds: impl Fn(&Self) -> bool) {
        wait_for(what, || {
            self.poll();
            holds(self).then_some(())
        });
    }
}

/// Returns the positions of all shafts, rad.
fn positions(chains: &[Chain]) -> Vec<f64> {
    let ids = (0..2).flat_map(|chain| (1..=SERVOS_PER_HAND as u8).map(move |id| (chain, id)));
    ids.map(|(chain, id)| chains[chain].servo(id, |servo| servo.position()))
        .collect()
}

/// Returns the largest distance of a shaft from an earlier position, rad.
fn moved_rad(chains: &[Chain], from_rad: &[f64]) -> f64 {
    let pairs = positions(chains).into_iter().zip(from_rad);
    pairs
        .map(|(now, then)| (now - then).abs())
        .fold(0.0, f64::max)
}

/// Waits until no servo moves; returns the positions.
fn at_rest_rad(chains: &[Chain]) -> Vec<f64> {
    wait_for("the servos to rest", || {
        let before_rad = positions(chains);
        std::thread::sleep(Duration::from_millis(200));
        (moved_rad(chains, &before_rad) < 0.5 * STEP_RAD).then_some(before_rad)
    })
}

#[test]
fn servos_do_not_jump_after_daemon_restart() {
    let _alone = lock_exclusive();
    let (bus, folder) = (
        FreshBus::new("servos"),
        tempfile::TempDir::new().expect("a folder"),
    );
    let config = folder.path().join("atas.toml");
    std::fs::write(&config, CONFIG).expect("writable");
    let (chains, map) = servos(folder.path());
    let daemon = [
        "--bus",
        bus.as_str(),
        "--config",
        config.to_str().expect("UTF-8"),
    ];
    let _fingertips = FrameSource::start(&bus);
    let mut seen = Observer::new(&bus);
    let mut robot = Process::start("atas-robot", &["run", &map, "--bus", bus.as_str()]);
    let mut atasd = Process::start("atasd", &daemon);
    seen.wait_until("READY", |seen| seen.status.mode == Mode::READY);

    let home = positions(&chains);
    let goal = [
        "grasp",
        "--bus",
        bus.as_str(),
        "--hand",
        "right",
        "--at",
        "0.32,-0.15,0.0345",
        "--width",
        "50",
    ];
    let _goal = Process::start("atas", &goal);
    wait_for("the arm to move", || {
        (moved_rad(&chains, &home) > 0.1).then_some(())
    });

    atasd.signal(Signal::KILL);
    atasd.wait();
    let held = at_rest_rad(&chains);
    let ids = (0..2).flat_map(|chain| (1..=SERVOS_PER_HAND as u8).map(move |id| (chain, id)));
    for (chain, id) in ids {
        assert!(
            chains[chain].servo(id, |servo| servo.holds()),
            "servo {id} does not hold"
        );
    }
    seen.poll();
    let killed_epoch = seen.command.stamp.writer_epoch;

    let atasd = Process::start("atasd", &daemon);
    seen.wait_until("the next daemon", |seen| {
        let next = seen.command.stamp.writer_epoch;
        next != killed_epoch && seen.status.mode == Mode::READY && seen.state.command_epoch == next
    });
    assert!(
        moved_rad(&chains, &held) < 0.02,
        "{}",
        moved_rad(&chains, &held)
    );

    // Loss of a servo's power causes HOLD; no joint jumps after its return.
    chains[1].servo(4, |servo| servo.set_power(false));
    let silent = "servo 4 does not answer (right_wrist_pitch)";
    wait_for("the report of servo 4", || {
        robot.log().contains(silent).then_some(())
    });
    seen.wait_until("HOLD", |seen| seen.status.mode == Mode::HOLD);
    chains[1].servo(4, |servo| {
        let sagged_rad = servo.position() + 0.1;
        servo.turn_to(sagged_rad);
        servo.set_power(true);
    });
    let sagged_rad = positions(&chains);
    wait_for("the robot", || {
        robot.log().contains("hold again").then_some(())
    });
    seen.wait_until("READY again", |seen| seen.status.mode == Mode::READY);
    assert!(moved_rad(&chains, &sagged_rad) < 0.02, "{}", atasd.log());
    assert!(
        robot
            .log()
            .contains("servo 4 does not answer (right_wrist_pitch)")
    );

    robot.signal(Signal::TERM);
    assert_eq!(robot.wait().code(), Some(0));
    assert!(chains[1].servo(4, |servo| servo.holds()));
}
