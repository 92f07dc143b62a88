//! A fresh controller fed with the recorded inputs gives the same commands bit for bit.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use atas_core::record::{Replay, ReplayError, read_origin};
use rustix::process::Signal;
use shm_bus::{Bus, BusName, FreshBus, GoalClient, Realtime, Subscriber};
use shm_schemas::{
    ControlOp, GoalKind, GoalPolicy, GoalRequest, GoalState, Hand, HandFrame, Mode, OrderKind,
    RunHeader, Text, TickInputs, service,
};

use crate::support::{Daemon, World, wait_for};

/// Recorder on its own thread, started before the daemon, so that it misses nothing.
struct Recorder {
    is_ending: Arc<AtomicBool>,
    /// Number of recorded parts, which may come later than a status.
    parts: Arc<AtomicUsize>,
    thread: JoinHandle<Recording>,
}

impl Recorder {
    fn start(bus: &FreshBus) -> Self {
        let (name, ends) = (BusName::clone(bus), Arc::new(AtomicBool::new(false)));
        let parts = Arc::new(AtomicUsize::new(0));
        let (is_there, there) = mpsc::channel();
        let thread = std::thread::spawn({
            let (ends, parts) = (Arc::clone(&ends), Arc::clone(&parts));
            move || {
                let bus = Bus::open(&name, "recorder", Realtime::No).expect("the bus opens");
                let mut headers = bus.subscriber(service::RUN_HEADER).expect("there is room");
                let mut inputs = bus.subscriber(service::TICK_INPUTS).expect("there is room");
                is_there.send(()).expect("the test waits");
                let mut recording = Recording::default();
                loop {
                    let last = ends.load(Ordering::Acquire);
                    recording.receive(&mut headers, &mut inputs);
                    parts.store(recording.parts.len(), Ordering::Release);
                    if last {
                        return recording;
                    }
                    std::thread::sleep(Duration::from_millis(1));
                }
            }
        });
        there.recv().expect("the recorder begins");
        Self {
            is_ending: ends,
            parts,
            thread,
        }
    }

    /// Ends the recorder and returns its recording.
    fn end(self) -> Recording {
        self.is_ending.store(true, Ordering::Release);
        self.thread.join().expect("the recorder ends")
    }
}

#[derive(Default)]
struct Recording {
    header: Box<RunHeader>,
    parts: Vec<TickInputs>,
}

impl Recording {
    fn receive(
        &mut self,
        headers: &mut Subscriber<RunHeader>,
        inputs: &mut Subscriber<TickInputs>,
    ) {
        headers.newest(&mut self.header).expect("readable");
        let parts = &mut self.parts;
        let keep = |part: &TickInputs| parts.push(*part);
        inputs.drain(usize::MAX, keep).expect("readable");
    }

    /// Replays from this part on; returns the number of ticks, or the error.
    fn replay(&self, from: usize) -> Result<usize, ReplayError> {
        let robot = robot_model::RobotModel::two_hand_arm().expect("the built-in robot loads");
        let controller = read_origin(&self.header, &robot).expect("of this version");
        let mut frames = [0, 1].map(|_| vec![HandFrame::default(); 64]);
        let mut replay = Replay::new(controller, frames.each_mut().map(|hand| &mut hand[..]));
        let mut ticks = 0;
        for part in &self.parts[from..] {
            if let Some(replayed) = replay.feed(part)? {
                assert!(
                    replayed.is_equal,
                    "tick {}: {:?}\nrecorded {:?}",
                    part.tick, replayed.outputs.command, part.command
                );
                ticks += 1;
            }
        }
        Ok(ticks)
    }

    fn has_order(&self, kind: OrderKind) -> bool {
        self.parts.iter().any(|part| part.order.kind == kind)
    }
}

fn grasp(goal_id: u64) -> GoalRequest {
    GoalRequest {
        goal_id,
        kind: GoalKind::GRASP,
        hand: Hand::RIGHT,
        policy: GoalPolicy::DETACHED,
        from_m: [0.3, -0.1, 0.08],
        width_m: 0.05,
        lift_m: 0.03,
        ..GoalRequest::default()
    }
}

/// Configuration of a loaded machine: tolerates late frames, and ticks slowly, so that a recorder
/// delayed by a second still has room for all parts.
const TOLERANT: &str = "realtime.rate_hz = 100\nsafety.valid_s = 0.03\nintake.hold_age_s = 0.3\nintake.reject_age_s = 5.0\nsafety.stall_s = 1.0\ngrasp.dr_n = 0.07\n\
     [tasks.nod]\nacting = [{ step = \"there\", motion = \"reach\", waypoint = \"above\", modules = [\"carry\"], transition = \"arrived\", \
     timeout_s = 20.0 }]\n";

/// Publishes for `millis`, or until a condition holds. Frames come in pairs, so that ticks have
/// several.
fn publish_for(world: &mut World, millis: u64, mut until: impl FnMut(&mut World) -> bool) {
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_millis(millis) && !until(world) {
        world.publish(shm_bus::now_ns());
        world.publish(shm_bus::now_ns());
        world.receive();
        std::thread::sleep(Duration::from_millis(15));
    }
}

#[test]
fn live_run_with_all_requests_replays_bit_exactly() {
    let bus = FreshBus::new("replay");
    let mut world = World::open(&bus);
    let recorder = Recorder::start(&bus);
    let mut daemon = Daemon::start_with(&bus, TOLERANT, &["--record-stream"], |_| ());
    publish_for(&mut world, 30_000, |w| w.newest.mode == Mode::READY);
    let goals: GoalClient = world.bus.goal_client().expect("there is room");
    let mut goal = wait_for("the goal server", || goals.send(&grasp(1)).ok());
    publish_for(&mut world, 300, |_| false);
    world.control(ControlOp::PARAM_SET, "grasp.approach_m_s", 0.003);
    daemon.signal(Signal::HUP);
    publish_for(&mut world, 200, |_| false);
    goal.cancel();
    publish_for(&mut world, 30_000, |_| {
        let update = goal.next().expect("the daemon lives");
        update.is_some_and(|update| update.state == GoalState::CANCELLED)
    });
    let own = GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new("nod"),
        ..grasp(2)
    };
    let mut goal = goals.send(&own).expect("there is room");
    publish_for(&mut world, 30_000, |_| {
        let update = goal.next().expect("the daemon lives");
        update.is_some_and(|update| update.state == GoalState::SUCCEEDED)
    });
    // Zeroing needs mode ready.
    publish_for(&mut world, 30_000, |w| w.newest.mode == Mode::READY);
    world.control(ControlOp::BIAS, "", 1.0);
    world.injected_position = Some(f64::NAN);
    publish_for(&mut world, 30_000, |w| w.newest.mode == Mode::SAFE_STOP);
    world.injected_position = None;
    publish_for(&mut world, 100, |_| false);
    world.control(ControlOp::RECOVER, "", 0.0);
    publish_for(&mut world, 30_000, |w| w.newest.mode == Mode::READY);
    daemon.signal(Signal::TERM);
    assert!(daemon.wait().success());
    let recording = recorder.end();
    let last = recording.parts.last().expect("ticks");
    assert_eq!(last.command.mode, Mode::SAFE_STOP);
    world.receive();

    assert_eq!(
        recording.header.config_hash, world.newest.config_hash,
        "the recorded configuration is the reloaded one"
    );
    for kind in [
        OrderKind::START,
        OrderKind::CANCEL,
        OrderKind::SET_PARAMETER,
        OrderKind::CONFIGURE,
        OrderKind::BIAS,
        OrderKind::RECOVER,
        OrderKind::STOP,
    ] {
        assert!(recording.has_order(kind), "{kind}");
    }
    let starts = |name: &str| {
        let start = |part: &&TickInputs| part.order.kind == OrderKind::START;
        let mut starts = recording.parts.iter().filter(start);
        starts.any(|part| part.order.task.name.as_str() == name)
    };
    assert!(starts("grasp") && starts("nod"), "tasks are recorded");
    assert!(
        recording.parts.iter().any(|part| part.parts > 1),
        "ticks with several frames"
    );
    assert!(
        recording
            .parts
            .iter()
            .any(|part| part.command.mode == Mode::RUN)
    );
    let ticks = recording.replay(0).expect("complete");
    assert!(
        ticks as u64 >= world.newest.ticks,
        "{ticks}, {}",
        world.newest.ticks
    );
}

#[test]
fn replay_reports_missing_parts() {
    let bus = FreshBus::new("missed");
    let mut world = World::open(&bus);
    let recorder = Recorder::start(&bus);
    let _daemon = Daemon::start_with(&bus, TOLERANT, &["--record-stream"], |_| ());
    let parts = Arc::clone(&recorder.parts);
    publish_for(&mut world, 30_000, |w| {
        w.newest.mode == Mode::READY && parts.load(Ordering::Acquire) > 10
    });
    let mut recording = recorder.end();
    assert_eq!(
        recording.replay(3),
        Err(ReplayError::MissingStart { missing: 3 })
    );
    let lost = recording.parts.remove(5);
    let tick = recording.parts[5].tick;
    assert_eq!(
        recording.replay(0),
        Err(ReplayError::Gap { tick, missing: 1 })
    );
    recording.parts.insert(5, lost);
    recording.parts[7].command.mode = Mode::FAULT;
    let tick = recording.parts[7].tick;
    assert_eq!(recording.replay(0), Err(ReplayError::Panicked { tick }));
}

#[test]
fn without_recording_only_the_header_is_published() {
    let bus = FreshBus::new("norecord");
    let mut world = World::open(&bus);
    let recorder = Recorder::start(&bus);
    let _daemon = Daemon::start_with(&bus, TOLERANT, &[], |_| ());
    publish_for(&mut world, 30_000, |w| w.newest.mode == Mode::READY);
    let recording = recorder.end();
    assert!(recording.parts.is_empty(), "no inputs");
    assert_ne!(
        recording.header.config_hash, 0,
        "observers read the robot from the header"
    );
}
